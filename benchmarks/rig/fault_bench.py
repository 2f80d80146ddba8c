"""The emulated rig on a virtual clock, ready to fail at a given moment: real executor, drivers and bytes."""

from __future__ import annotations

import errno
import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from unittest import mock

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.devices.protocols import Actuator, Devices
from emg2vsa.devices.qbmove.packets import Command, frame
from emg2vsa.errors import DeviceError
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.faults import put
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.far_ends.camera import CameraFaults
from emg2vsa.worlds.far_ends.dynamixel import table
from emg2vsa.worlds.far_ends.dynamixel.firmware import BOOT_S, DynamixelFirmware
from emg2vsa.worlds.far_ends.dynamixel.packets import Instruction, packet
from emg2vsa.worlds.far_ends.faults import FaultyWire, WireLine
from emg2vsa.worlds.far_ends.netft_faults import BoxFaults
from emg2vsa.worlds.far_ends.qbmove.far_end import DEVICE_ID

STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)
SPECIMEN = "S1"
"""The stiffest of the paper."""
WATCH_S = 0.005
GAP_MM, START_MM, START_PRESET, START_S = 2.0, 1.0, 0.2, 0.8
_OFF = (
    frame(DEVICE_ID, Command.ACTIVATE, b"\0"),
    packet(1, Instruction.WRITE, bytes((table.TORQUE_ENABLE, 0, 0))),
)
"""Which tells the motors of any of the actuators to go off."""


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


class Killed(BaseException):
    """The program is no more: nothing that it would do after this reaches a device or the disk."""


class BreakingLine(WireLine):
    """A line whose port can vanish, whose next word can be cut off by an error, or whose host is dead."""

    gone = dead = False
    error: BaseException | None = None
    off_s = math.inf
    "When the host first told the motors to go off."

    def __init__(self, wire: FaultyWire, bench: EmulatedRig, clock: VirtualClock) -> None:
        super().__init__("emulated bus", bench.answer, lambda: wire.due_s, clock)
        self._frames = wire.frames
        self.loses: frozenset[int] = frozenset()
        "Commands of which the next frame gets lost."
        self.later: tuple[int, Callable[[], None]] | None = None
        "What is to happen after so many frames."

    def write(self, data: bytes) -> None:
        if self.later:
            left, happen = self.later
            self.later = (left - 1, happen) if left else None
            if not left:
                happen()
        if self.error:
            error, self.error = self.error, None
            raise error
        if self.dead:
            return
        if self.gone:
            do = "Check the cable."
            raise DeviceError(self.name, wanted="a line that answers", found="[Errno 5] Input/output error", do=do)
        if self.loses and not self._frames.without(data, self.loses):
            self.loses = frozenset()
            return
        if data in _OFF:
            self.off_s = min(self.off_s, self._time.now_s())
        super().write(data)


@dataclass(frozen=True)
class Built:
    """How the bench is built, and what of it the program is told; ``told`` None is the truth."""

    rigid: bool = False
    actuator: DynamixelSettings | None = None
    "None is a qbmove."
    true: RigSettings = field(default_factory=RigSettings)
    told: RigSettings | None = None
    specimen: str = SPECIMEN


class FaultBench:
    """The rig, its probe left ``START_MM`` down by whoever used it before, and every switch that makes it fail.

    full : names of files that find no room any more. broken : names of files that cannot be written at all.
    stop : who asks to stop, from ``stop_s`` on SIGTERM. begun_s : when the last run began.
    """

    def __init__(self, built: Built | None = None) -> None:
        self.built, self.clock = built or Built(), WatchedClock()
        built = self.built
        self.rig = built.told or built.true
        self.emulated = EmulatedRig(
            EmulatedSettings(world="elastic", gap_mm=GAP_MM, force_rate_hz=500),
            built.specimen,
            0.0,
            rigid=built.rigid,
            clock=self.clock,
            rig=built.true,
            actuator=built.actuator,
        )
        self.line = BreakingLine(self.emulated.wire, self.emulated, self.clock)
        self.full: tuple[str, ...] = ()
        self.broken: tuple[str, ...] = ()
        self.stop: str | None = None
        self.stop_s, self.begun_s = math.inf, 0.0
        self._leave_probe_down()

    def run(self, plan: RunPlan, folder: Path) -> Ended | None:
        """One run, with devices opened for it; None of a program that was killed.

        SettingError, ScheduleError, DeviceError : it was refused."""
        devices = self._devices()
        self.begun_s = self.clock.now_s()
        with self._disk(), suppress(Killed):
            return execute(plan, self.rig, devices, folder, self.clock, started=STARTED, stop=self._asked)
        return None

    def kill(self) -> None:
        """The program ends here and now, as by kill -9."""
        self.line.dead = True
        raise Killed

    def heal(self) -> None:
        """No fault any more."""
        put(self.emulated, "off")
        line, wire, firmware = self.line, self.emulated.wire, self.emulated.firmware
        if isinstance(firmware, DynamixelFirmware) and firmware.table.values[table.HARDWARE_ERROR]:
            self.emulated.reset_actuator()  # as the error says
            self.clock.sleep_until(self.clock.now_s() + 2 * BOOT_S)
        wire.noisy = line.gone = line.dead = False
        self.emulated.box.faults, self.emulated.camera.faults = BoxFaults(), CameraFaults()
        line.off_s, line.later = math.inf, None
        self.full = self.broken = ()
        self.stop, self.stop_s = None, math.inf

    def tell_the_truth(self) -> None:
        """The rig file is put right."""
        self.rig = self.built.true

    def _asked(self) -> str | None:
        return "SIGTERM" if self.clock.now_s() >= self.stop_s else self.stop

    def probe_mm(self) -> float:
        """Depth of the probe by the encoders of the motors."""
        return self.built.true.depth_at(self._actuator().position_deg())

    def motors_on(self) -> bool:
        """As the device itself knows."""
        firmware: Any = self.emulated.firmware
        if isinstance(firmware, DynamixelFirmware):
            firmware.advance()
            return bool(firmware.table.values[table.TORQUE_ENABLE])
        return bool(firmware.state.on)

    def held(self) -> bool:
        """Torque on where a watchdog that has run out has stopped the motor: a Dynamixel goes no further."""
        firmware: Any = self.emulated.firmware
        if not isinstance(firmware, DynamixelFirmware):
            return False
        firmware.advance()
        ran_out = firmware.table.values[table.BUS_WATCHDOG] == table.WATCHDOG_ERROR
        return ran_out and not firmware.motor.faults.flag_only

    def true_force_n(self) -> float:
        """On the specimen, along the normal of its surface."""
        return self.emulated.world.normal_force_n(self.clock.now_s())

    def true_probe_mm(self) -> float:
        """Where the probe is, from where the shaft is at 0."""
        return self.emulated.world.probe_mm(self.clock.now_s())

    def _actuator(self) -> Actuator:
        bench = self.emulated
        return bench.end.driver(self.line, bench.firmware, bench.place, True).pressing()

    def _devices(self) -> Devices:
        started = self.emulated.devices()
        return Devices(self._actuator(), started.force, started.camera)

    def _leave_probe_down(self) -> None:
        actuator, position_deg = self._actuator(), self.built.true.position_at(START_MM)
        actuator.activate()
        actuator.command(position_deg, 0.0 if self.built.rigid else START_PRESET)
        for _ in range(round(START_S / 0.1)):
            actuator.is_active()
            self.clock.sleep_until(self.clock.now_s() + 0.1)
        actuator.deactivate()
        self.line.off_s = math.inf

    @contextmanager
    def _disk(self) -> Iterator[None]:
        """The disk as the program sees it: a full one takes part of a piece, a broken one refuses; a program that is
        dead writes nothing."""
        pwrite = os.pwrite

        def fail(file: int, piece: bytes, offset: int) -> int:
            if self.line.dead:
                return len(piece)
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
