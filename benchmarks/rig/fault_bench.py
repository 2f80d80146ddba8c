"""The emulated rig on a virtual clock, ready to fail at a given moment: real executor, drivers and bytes."""

from __future__ import annotations

import errno
import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from unittest import mock

from benchmarks.rig.plans import SPECIMEN
from emg2vsa.errors import DeviceError
from emg2vsa.rig.clock import VirtualClock
from emg2vsa.rig.devices import Devices
from emg2vsa.rig.emulated.bench import DEVICE_ID, EmulatedRig
from emg2vsa.rig.emulated.box_faults import BoxFaults
from emg2vsa.rig.emulated.camera import CameraFaults
from emg2vsa.rig.emulated.settings import EmulatedSettings
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.qbmove.driver import Qbmove
from emg2vsa.rig.qbmove.transport import LoopbackLine
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.rig_settings import RigSettings

STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)
WATCH_S = 0.005
GAP_MM, START_MM, START_PRESET, START_S = 2.0, 1.0, 600, 0.8


class WatchedClock(VirtualClock):
    """Calls ``strike`` once, at ``strike_s``, and ``watch`` every few milliseconds."""

    def __init__(self) -> None:
        super().__init__()
        self.strike_s, self.strike, self.watch = math.inf, _nothing, _nothing

    def sleep_until(self, time_s: float) -> None:
        while self.now_s() < time_s:
            super().sleep_until(min(time_s, self.now_s() + WATCH_S))
            self.watch()
            if self.now_s() >= self.strike_s:
                self.strike_s = math.inf
                self.strike()


class BreakingLine(LoopbackLine):
    """A line whose port can vanish, or whose next word can be cut off by an error."""

    gone = False
    error: BaseException | None = None

    def write(self, data: bytes) -> None:
        if self.error:
            error, self.error = self.error, None
            raise error
        if self.gone:
            do = "Check the cable."
            raise DeviceError(self.name, wanted="a line that answers", found="[Errno 5] Input/output error", do=do)
        super().write(data)


class FaultBench:
    """The rig, its probe left ``START_MM`` down by whoever used it before, and every switch that makes it fail.

    full : names of files that find no room any more. broken : names of files that cannot be written at all.
    stop : who asks to stop, from ``stop_s`` on SIGTERM. begun_s : when the last run began.
    """

    def __init__(self) -> None:
        self.clock = WatchedClock()
        self.emulated = EmulatedRig(
            EmulatedSettings(gap_mm=GAP_MM, force_rate_hz=500), SPECIMEN, 0.0, rigid=False, clock=self.clock
        )
        self.line = BreakingLine("emulated bus", self.emulated.answer, self.clock)
        self.full: tuple[str, ...] = ()
        self.broken: tuple[str, ...] = ()
        self.stop: str | None = None
        self.stop_s, self.begun_s = math.inf, 0.0
        self._leave_probe_down()

    def run(self, plan: RunPlan, folder: Path) -> Ended:
        """One run, with devices opened for it."""
        devices = self._devices()
        self.begun_s = self.clock.now_s()
        with self._disk():
            return execute(plan, RigSettings(), devices, folder, self.clock, started=STARTED, stop=self._asked)

    def heal(self) -> None:
        """No fault any more."""
        wire, line = self.emulated.wire, self.line
        wire.mute = wire.deaf = wire.noisy = line.gone = False
        self.emulated.box.faults, self.emulated.camera.faults = BoxFaults(), CameraFaults()
        self.full = self.broken = ()
        self.stop, self.stop_s = None, math.inf

    def _asked(self) -> str | None:
        return "SIGTERM" if self.clock.now_s() >= self.stop_s else self.stop

    def probe_mm(self) -> float:
        """Depth of the probe by the encoders of both motors."""
        return RigSettings().depth_at(self._actuator().position_ticks())

    def _actuator(self) -> Qbmove:
        return Qbmove(self.line, DEVICE_ID, clock=self.clock)

    def _devices(self) -> Devices:
        started = self.emulated.devices()
        return Devices(self._actuator(), started.force, started.camera)

    def _leave_probe_down(self) -> None:
        with self._actuator() as actuator:
            actuator.activate()
            actuator.set_position_stiffness(RigSettings().ticks_at(START_MM), START_PRESET)
            for _ in range(round(START_S / 0.1)):
                actuator.is_active()
                self.clock.sleep_until(self.clock.now_s() + 0.1)

    @contextmanager
    def _disk(self) -> Iterator[None]:
        """The disk as the program sees it: a full one takes part of a piece, a broken one refuses."""
        pwrite = os.pwrite

        def fail(file: int, piece: bytes, offset: int) -> int:
            if self.full or self.broken:
                name = os.path.basename(os.readlink(f"/proc/self/fd/{file}"))
                if name in self.broken:
                    raise OSError(errno.EIO, os.strerror(errno.EIO))
                if name in self.full and offset + len(piece) > os.fstat(file).st_size:
                    piece = piece[: len(piece) // 2]
            return pwrite(file, piece, offset)

        with mock.patch("os.pwrite", fail):
            yield


def _nothing() -> None:
    """The clock before anybody wants to know."""


Strike = Callable[[FaultBench], None]
