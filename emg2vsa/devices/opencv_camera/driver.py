"""The tactile camera behind OpenCV: twenty frames a second out of what it gives, and how many are missing."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.frame_files.pages import silence_opencv
from casr.images import as_grey
from emg2vsa.devices.clock import Clock, awaited
from emg2vsa.devices.device_settings import LOST_S, RATE_HZ, SHAPE
from emg2vsa.devices.opencv_camera import OpenCvSettings
from emg2vsa.devices.protocols import Frame
from emg2vsa.devices.registry import Around
from emg2vsa.errors import DeviceError

EARLY = 0.1
"Part of a period by which a frame may be early."
SHORT = 0.2
"A gap this part of a period short of two periods still means that a frame is missing."
CATCH_UP = 0.25
"After a late frame the next is due at least this part of a period later."


class FramePace:
    """Chooses frames by their time.

    A camera at the wanted rate keeps all its frames, however its clock drifts; a faster one is thinned out to the
    wanted rate on average.

    Parameters
    ----------
    rate_hz : wanted frames a second.
    """

    def __init__(self, rate_hz: float) -> None:
        self._period_s = 1 / rate_hz
        self._taken_s: float | None = None
        self._due_s = 0.0

    def take(self, time_s: float) -> int | None:
        """How many frames are missing before the one of ``time_s``, s; None when that one is not due."""
        if self._taken_s is None:
            self._taken_s, self._due_s = time_s, time_s + self._period_s
            return 0
        if time_s < self._due_s - EARLY * self._period_s:
            return None
        missing = max(0, int((time_s - self._taken_s) / self._period_s + SHORT) - 1)
        next_s = max(self._due_s + self._period_s, time_s + CATCH_UP * self._period_s)
        self._taken_s, self._due_s = time_s, min(next_s, time_s + self._period_s)
        return missing


_AUTO = {"exposure": cv2.CAP_PROP_AUTO_EXPOSURE, "white_balance_k": cv2.CAP_PROP_AUTO_WB}
_VALUE = {
    "exposure": cv2.CAP_PROP_EXPOSURE, "gain": cv2.CAP_PROP_GAIN, "white_balance_k": cv2.CAP_PROP_WB_TEMPERATURE,
}  # fmt: skip
_MANUAL_EXPOSURE = {cv2.CAP_V4L2: 1.0}
"""By hand, for V4L2; other backends take 0.25, or 0."""
WARM_UP_S = 1.0
"""A camera that chooses by itself has chosen after this time."""


def lock_settings(capture: Any, wanted: Mapping[str, float | None], name: str) -> dict[str, float | None]:
    """Switch off what a camera changes by itself; exposure, gain and white_balance_k as they then are.

    ``wanted`` : a value for each of them; None keeps the one that the camera has now. A camera that does not know one
    of them, as network cameras know none, has None in the answer.

    DeviceError : a value that the rig file gives is not taken.
    """
    now = {key: float(capture.get(number)) for key, number in _VALUE.items()}
    backend = int(capture.get(cv2.CAP_PROP_BACKEND))
    by_hand = {"exposure": _MANUAL_EXPOSURE.get(backend, 0.25), "white_balance_k": 0.0}
    locked: dict[str, float | None] = {}
    for key, number in _VALUE.items():
        asked = wanted[key]
        free = key not in _AUTO or bool(capture.set(_AUTO[key], by_hand[key]))
        taken = bool(capture.set(number, now[key] if asked is None else asked))
        locked[key] = float(capture.get(number)) if free and taken else None
        if asked is not None and not math.isclose(locked[key] or 0.0, asked, rel_tol=0.01, abs_tol=0.01):
            found = "a camera that does not take it" if locked[key] is None else f"{locked[key]:g}"
            do = "Choose a value that the camera has (v4l2-ctl --list-ctrls), or leave it out."
            raise DeviceError(f"{name}, {key}", wanted=f"{asked:g}, as the rig file says", found=found, do=do)
    return locked


FIRST_S = 5.0
"Time in which a started camera must bring its first frame; webcams set their exposure first."
_POLL_S = 5e-3


def open_capture(source: int | str) -> Any:
    """OpenCV's capture of a device number, path or URL."""
    return cv2.VideoCapture(source)


class OpenCvCamera:
    """A `Camera` behind OpenCV: a device number, or the address of a network camera.

    A thread of its own waits for frames, so that the control loop never does. Frames are made grey, cut to the centre
    of the wanted proportions and shrunk to the wanted size; faster cameras are thinned out.

    Parameters
    ----------
    source : device number, path or URL.
    clock : the rig's time; a frame's is when it arrives, less ``delay_s``.
    shape : (height, width), px.
    rate_hz : frames a second.
    delay_s : from exposure to arrival.
    lost_s : without a frame for so long it is lost.
    lock : exposure, gain and white_balance_k to keep, None for what the camera has chosen; None leaves it alone.
    open_capture : what opens the source.
    """

    def __init__(
        self,
        source: int | str,
        clock: Clock,
        *,
        shape: tuple[int, int] = SHAPE,
        rate_hz: float = RATE_HZ,
        delay_s: float = 0.0,
        lost_s: float = LOST_S,
        lock: Mapping[str, float | None] | None = None,
        open_capture: Callable[[int | str], Any] = open_capture,
    ) -> None:
        self.name, self.shape, self.rate_hz = f"camera {source}", shape, rate_hz
        self.dropped, self.delay_s, self._lost_s = 0, delay_s, lost_s
        self._source, self._clock, self._open = source, clock, open_capture
        self._lock, self.locked = lock, dict[str, float | None]()
        "What stays as it is, in the camera's own units; None for what it does not know."
        self._pace = FramePace(rate_hz)
        self._waiting: deque[Frame] = deque()
        self._newest_s: float | None = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._capture: Any = None

    def start(self) -> None:
        """Open the camera, lock its settings and wait for a frame. DeviceError : it does not open, or gives none."""
        self._capture = self._open(self._source)
        if not self._capture.isOpened():
            raise self._lost("none that opens")
        self._capture.set(cv2.CAP_PROP_FPS, self.rate_hz)
        # one frame in the driver's queue: an older one would be taken for new
        self._capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        if self._lock is not None:
            self._warm_up()
            self.locked = lock_settings(self._capture, self._lock, self.name)
        self._thread.start()
        awaited(self._clock, FIRST_S, _POLL_S, lambda: self._waiting or not self._thread.is_alive())
        if not self._waiting:
            raise self._lost("no frame")

    def frames(self) -> list[Frame]:
        """Frames that have come since the last call. DeviceError : not started, or silent for ``lost_s``."""
        # asked before the frames are taken, or the last ones of a camera that ends would be lost
        alive = self._thread.is_alive()
        frames = [self._waiting.popleft() for _ in range(len(self._waiting))]
        if frames:
            self._newest_s = frames[-1].time_s + self.delay_s
            self.dropped += sum(frame.dropped for frame in frames)
            return frames
        if self._newest_s is None:
            raise self._lost("one that was not started")
        silent_s = self._clock.now_s() - self._newest_s
        if silent_s > self._lost_s or not alive:
            raise self._lost(f"no frame for {silent_s:.1f} s")
        return []

    def close(self) -> None:
        self._ended.set()
        if self._thread.is_alive():
            # a dead network camera keeps the thread waiting; it gives the device back when it comes to
            self._thread.join(LOST_S)

    def _warm_up(self) -> None:
        """Let the camera choose; one that does not choose by itself has nothing to wait for."""
        if any(self._capture.get(number) > 0 for number in _AUTO.values()):
            end_s = self._clock.now_s() + WARM_UP_S
            while self._clock.now_s() < end_s and self._capture.grab():
                pass

    def _watch(self) -> None:
        while not self._ended.is_set() and self._capture.grab():
            time_s = self._clock.now_s()
            dropped = self._pace.take(time_s)
            if dropped is not None:
                taken, image = self._capture.retrieve()
                if not taken:
                    break
                self._waiting.append(Frame(time_s - self.delay_s, fitted(image, self.shape), dropped))
        self._capture.release()

    def _lost(self, found: str) -> DeviceError:
        wanted = f"a camera that gives {self.rate_hz:g} frames a second"
        do = "Check its cable and number, and that no other program uses it."
        return DeviceError(self.name, wanted=wanted, found=found, do=do)


def open_camera(settings: OpenCvSettings, around: Around) -> OpenCvCamera:
    """The camera of [camera]."""
    silence_opencv()  # the driver says it in words
    values = {"exposure": settings.exposure, "gain": settings.gain, "white_balance_k": settings.white_balance_k}
    lock = values if settings.lock or any(value is not None for value in values.values()) else None
    return OpenCvCamera(
        settings.source, around.clock, shape=(settings.height, settings.width), rate_hz=settings.rate_hz,
        delay_s=settings.delay_s, lost_s=around.lost_s, lock=lock,
    )  # fmt: skip


def facts(camera: OpenCvCamera, settings: OpenCvSettings) -> dict[str, Any]:
    """Its settings, in the order of the runs before there were kinds, and what stays as it is."""
    known = asdict(settings)
    del known["kind"], known["serial_number"]
    return {"source": known.pop("source"), **known, "name": camera.name, "set": camera.locked}


def fitted(image: NDArray[Any], shape: tuple[int, int]) -> NDArray[np.uint8]:
    """(height, width) grey levels: the largest centred part of the image with these proportions, shrunk by areas."""
    height, width = shape
    grey: NDArray[Any] = as_grey(image)
    scale = min(grey.shape[0] / height, grey.shape[1] / width)
    rows, columns = round(height * scale), round(width * scale)
    top, left = (grey.shape[0] - rows) // 2, (grey.shape[1] - columns) // 2
    part = grey[top : top + rows, left : left + columns]
    if part.shape != shape:
        part = cv2.resize(part, (width, height), interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(part, dtype=np.uint8)
