"""A tactile camera that sees a rendered skin as the world presses it, whose frames arrive late, and which shows them as
motion JPEG over HTTP, which OpenCV opens like any other network camera."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from http.server import BaseHTTPRequestHandler

import cv2
import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.device_settings import LOST_S, RATE_HZ
from emg2vsa.devices.protocols import Frame
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.faults import amount, count, switch, thousandth
from emg2vsa.worlds.far_ends.ports import HOST, Page, Serving
from emg2vsa.worlds.tactile import ContactState, Scene

PATH = "/frames.mjpg"
JPEG_QUALITY = 100
_POLL_S = 2e-3


@dataclass
class CameraFaults:
    """What goes wrong, changed while the camera runs."""

    drop: int = count("drop", "the next N frames are lost")
    mute: bool = switch("dark", "the camera gives no frames")
    kept_of: int = amount("few-frames", "of N frames only the first comes", 2, 1, 1, 1000, int)
    late_s: float = amount("old-frames", "pictures show what was N ms before their time", 400, 0, 0, 10000, thousandth)


@dataclass(frozen=True)
class FrameTiming:
    """When frames arrive.

    mean_s : after their exposure, on average, which the rig knows. jitter_s : standard deviation of each. late_share :
    of the frames that are ``late_s`` later still. seed : of the draws.
    """

    mean_s: float = 0.0
    jitter_s: float = 0.0
    late_share: float = 0.0
    late_s: float = 0.0
    seed: int = 0


class DrawnFrame(Frame):
    """A frame that is drawn when its image is first looked at; what it shows is settled before.

    scene, pressed, number : what is seen, in which state of the contact, and which frame it is.
    """

    _drawn_from: tuple[Scene, float | ContactState, int]

    def __init__(self, time_s: float, dropped: int, scene: Scene, pressed: float | ContactState, number: int) -> None:
        # a frozen dataclass; the image is left to the property below
        self.__dict__.update(time_s=time_s, dropped=dropped, _drawn_from=(scene, pressed, number))

    @cached_property
    def image(self) -> NDArray[np.uint8]:  # type: ignore[override]
        """(H, W) grey levels."""
        scene, pressed, number = self._drawn_from
        return scene.image(pressed, number)


class EmulatedCamera:
    """Frames on the clock, drawn when they are looked at. A frame bears the time of its arrival less the mean latency.

    Parameters
    ----------
    scene : sensor and specimen.
    pressed : the contact at a time of exposure, s, or the force of one without friction or history; asked at times that
        never go back.
    clock : the rig's time.
    """

    def __init__(
        self,
        scene: Scene,
        pressed: Callable[[float], float | ContactState],
        clock: Clock,
        *,
        timing: FrameTiming | None = None,
    ) -> None:
        self.name = "emulated camera"
        self.shape = (scene.settings.camera.height_px, scene.settings.camera.width_px)
        self.faults = CameraFaults()
        self.dropped = 0
        self.scene = scene
        "What it sees; may be exchanged between two frames."
        self._pressed, self._clock = pressed, clock
        self._timing = timing or FrameTiming()
        self.delay_s = self._timing.mean_s
        self.latency_s = self._timing.mean_s
        "Mean time to the arrival of the frames now; may be changed between two frames."
        self._rng = np.random.default_rng(self._timing.seed)
        self._started_s = self._newest_s = 0.0
        self._exposed = self._missing = 0
        self._arrives_s: float | None = None
        self._next_s = 0.0
        "Before then no frame comes."

    def start(self) -> None:
        """Begin; the first frame is taken now."""
        self._started_s = self._newest_s = self._clock.now_s()
        self._exposed, self._missing, self._next_s = 0, 0, 0.0

    def frames(self) -> list[Frame]:
        """Frames since the last call, oldest first. DeviceError when there was none for too long."""
        frames = self.exposed()
        silent_s = self._clock.now_s() - self._newest_s
        if silent_s > LOST_S:
            raise DeviceError(
                self.name,
                wanted=f"a camera that gives {RATE_HZ:g} frames a second",
                found=f"no frame for {silent_s:.1f} s",
                do="End the fault of the camera.",
            )
        return frames

    def exposed(self) -> list[Frame]:
        """Frames since the last call, oldest first, if any."""
        by_s = self._clock.now_s() + 1e-9
        frames: list[Frame] = []
        while self._next_s <= by_s:
            time_s = self._started_s + self._exposed / RATE_HZ
            if time_s > by_s:
                self._next_s = time_s
                break
            if self._arrives_s is None:
                self._arrives_s = self._arrival_s(time_s)
            if (arrives_s := self._arrives_s) > by_s:
                self._next_s = arrives_s
                break
            if self._is_lost():
                self._missing += 1
            else:
                pressed = self._pressed(max(0.0, time_s - self.faults.late_s))
                frames.append(DrawnFrame(arrives_s - self.delay_s, self._missing, self.scene, pressed, self._exposed))
                self.dropped += self._missing
                self._newest_s, self._missing = arrives_s, 0
            self._exposed, self._arrives_s = self._exposed + 1, None
        return frames

    def _arrival_s(self, exposed_s: float) -> float:
        """Never before the exposure, and never before the frame that came last."""
        timing, jitter, late = self._timing, float(self._rng.standard_normal()), float(self._rng.random())
        latency_s = self.latency_s + timing.jitter_s * jitter + timing.late_s * (late < timing.late_share)
        return max(exposed_s + max(0.0, latency_s), self._newest_s)

    def close(self) -> None:
        """Nothing to give back."""

    def _is_lost(self) -> bool:
        if self.faults.drop:
            self.faults.drop -= 1
            return True
        return self.faults.mute or self._exposed % self.faults.kept_of != 0


class CameraServer(Serving):
    """Shows ``camera`` to one client after the other, in real time, within a with statement. url : what to open."""

    def __init__(self, camera: EmulatedCamera) -> None:
        self.camera = camera
        page = Page(0, PATH, self._show)
        self.url = f"http://{HOST}:{page.port}{PATH}"
        super().__init__(lambda: page.serve(self._ended), name="camera")

    def _show(self, client: BaseHTTPRequestHandler) -> None:
        client.send_response(200)
        client.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
        client.end_headers()
        self.camera.start()
        # a client that goes away ends its stream
        with contextlib.suppress(OSError):
            while not self._ended.wait(_POLL_S):
                for frame in self.camera.exposed():
                    picture = cv2.imencode(".jpg", frame.image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()
                    head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(picture)}\r\n\r\n"
                    client.wfile.write(head.encode() + picture + b"\r\n")
