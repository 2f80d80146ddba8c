"""A tactile camera that sees a rendered skin pressed with the world's force."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from casr.synthetic import Scene
from emg2vsa.errors import DeviceError
from emg2vsa.rig.clock import Clock
from emg2vsa.rig.device_settings import LOST_S, RATE_HZ
from emg2vsa.rig.devices import Frame


@dataclass
class CameraFaults:
    """What goes wrong, changed while the camera runs.

    drop : the next so many frames. mute : all from now on. kept_of : of so many frames only the first comes.
    late_s : pictures show what was so long before the time they bear.
    """

    drop: int = 0
    mute: bool = False
    kept_of: int = 1
    late_s: float = 0.0


class DrawnFrame(Frame):
    """A frame that is drawn when its image is first looked at; what it shows is settled before.

    scene, force_n, number : what is seen, under which normal force, and which frame it is.
    """

    _drawn_from: tuple[Scene, float, int]

    def __init__(self, time_s: float, dropped: int, scene: Scene, force_n: float, number: int) -> None:
        # a frozen dataclass; the image is left to the property below
        self.__dict__.update(time_s=time_s, dropped=dropped, _drawn_from=(scene, force_n, number))

    @cached_property
    def image(self) -> NDArray[np.uint8]:  # type: ignore[override]
        """(H, W) grey levels."""
        scene, force_n, number = self._drawn_from
        return scene.image(force_n, number)


class EmulatedCamera:
    """Frames on the clock, drawn when they are looked at.

    Parameters
    ----------
    scene : sensor and specimen.
    force_n : normal force on the skin at a time, s; asked at times that never go back.
    clock : the rig's time.
    """

    delay_s = 0.0

    def __init__(
        self, scene: Scene, force_n: Callable[[float], float], clock: Clock, *, rate_hz: float = RATE_HZ
    ) -> None:
        self.name = "emulated camera"
        self.shape = (scene.settings.camera.height_px, scene.settings.camera.width_px)
        self.faults = CameraFaults()
        self.dropped = 0
        self.scene = scene
        "What it sees; may be exchanged between two frames."
        self._force_n, self._clock, self._rate_hz = force_n, clock, rate_hz
        self._started_s = self._newest_s = 0.0
        self._exposed = self._missing = 0

    def start(self) -> None:
        """Begin; the first frame is taken now."""
        self._started_s = self._newest_s = self._clock.now_s()
        self._exposed = self._missing = 0

    @property
    def due_s(self) -> float:
        """Time of the next frame."""
        return self._started_s + self._exposed / self._rate_hz - 1e-9

    def frames(self) -> list[Frame]:
        """Frames since the last call, oldest first. DeviceError when there was none for too long."""
        frames = self.exposed()
        silent_s = self._clock.now_s() - self._newest_s
        if silent_s > LOST_S:
            raise DeviceError(
                self.name,
                wanted=f"a camera that gives {self._rate_hz:g} frames a second",
                found=f"no frame for {silent_s:.1f} s",
                do="End the fault of the camera.",
            )
        return frames

    def exposed(self) -> list[Frame]:
        """Frames since the last call, oldest first, if any."""
        now_s = self._clock.now_s()
        frames: list[Frame] = []
        while (time_s := self._started_s + self._exposed / self._rate_hz) <= now_s + 1e-9:
            if self._is_lost():
                self._missing += 1
            else:
                force_n = self._force_n(max(0.0, time_s - self.faults.late_s))
                frames.append(DrawnFrame(time_s, self._missing, self.scene, force_n, self._exposed))
                self.dropped += self._missing
                self._newest_s, self._missing = time_s, 0
            self._exposed += 1
        return frames

    def close(self) -> None:
        """Nothing to give back."""

    def _is_lost(self) -> bool:
        if self.faults.drop:
            self.faults.drop -= 1
            return True
        return self.faults.mute or self._exposed % self.faults.kept_of != 0
