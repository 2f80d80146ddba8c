"""A camera behind OpenCV: table [camera] of a rig file."""

from __future__ import annotations

from typing import Annotated, Literal

from emg2vsa.devices.device_settings import CameraSettings, Text
from emg2vsa.devices.registry import Kind
from emg2vsa.settings import Ge
from emg2vsa.settings_class import settings_class


@settings_class
class OpenCvSettings(CameraSettings):
    """A camera that OpenCV opens."""

    kind: Literal["opencv"] = "opencv"
    source: Annotated[int, Ge(0)] | Text
    "Number of the camera (0 is the first), or the address of a network camera."
    lock: bool = True
    "Exposure, gain and white balance stay as they are when a run begins: what changes by itself looks like a touch."
    exposure: float | None = None
    "Exposure in the camera's own unit (V4L2: 0.1 ms; DirectShow: powers of 2 s); omitted: what it has now."
    gain: float | None = None
    "Gain in the camera's own unit; omitted: what it has now."
    white_balance_k: float | None = None
    "White balance, kelvin; omitted: what it has now."


OPENCV = Kind("camera", OpenCvSettings, open="opencv_camera.driver:open_camera", facts="opencv_camera.driver:facts")
