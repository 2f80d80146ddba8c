"""The tactile camera: grey frames with their times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

RATE_HZ = 20.0
SHAPE = (300, 300)
"(height, width) of the paper's frames, px."
LOST_S = 0.5
"A camera that gives no frame for so long is lost."


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture.

    time_s : when it was taken, on the rig's clock.
    image : (H, W) grey levels.
    dropped : frames missing before it.
    """

    time_s: float
    image: NDArray[np.uint8]
    dropped: int = 0


class Camera(Protocol):
    """A camera that takes frames by itself once started.

    delay_s : from the exposure of a frame, which is its time, until it can be had.
    """

    name: str
    shape: tuple[int, int]
    delay_s: float

    def start(self) -> None:
        """Begin, and return once a first frame has come. DeviceError when none comes."""

    def frames(self) -> list[Frame]:
        """Frames since the last call, oldest first; never waits. DeviceError when the camera is lost."""

    def close(self) -> None:
        """Stop and give the device back."""
