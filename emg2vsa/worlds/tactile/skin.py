"""The skin of a TacTip as its camera sees it at rest: pins on a hexagonal grid inside a round mask."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.errors import SettingError


@dataclass(frozen=True, kw_only=True)
class Skin:
    """Layout of the pins in the image, px.

    Parameters
    ----------
    rings : hexagonal rings around the central pin: 6 give 127 pins, 10 give 331.
    pitch_px : distance of neighbouring pins; 19.84 in frames of a real 127-pin sensor.
    pin_radius_px, edge_px : radius of a pin at half brightness, and the standard deviation of its blurred edge.
    mask_radius_px : beyond it the camera sees black.
    """

    rings: int = 6
    pitch_px: float = 20.0
    pin_radius_px: float = 4.5
    edge_px: float = 1.0
    mask_radius_px: float = 140.0

    def __post_init__(self) -> None:
        sizes = (self.pitch_px, self.pin_radius_px, self.edge_px, self.mask_radius_px)
        if self.rings < 1 or not all(math.isfinite(size) and size > 0 for size in sizes):
            raise SettingError("skin", wanted="sizes above 0, a ring or more", found=repr(self), do="Correct the skin.")
        if self.rings * self.pitch_px + self.pin_radius_px > self.mask_radius_px:
            raise SettingError(
                "skin.pitch_px",
                wanted=f"{self.rings} rings of pins inside the mask of {self.mask_radius_px:g} px",
                found=f"an outermost pin at {self.rings * self.pitch_px:g} px",
                do="Take a smaller pitch or a larger mask.",
            )

    @property
    def n_pins(self) -> int:
        """Number of pins."""
        return 1 + 3 * self.rings * (self.rings + 1)

    def pins_px(self, centre_px: tuple[float, float]) -> NDArray[np.float64]:
        """(n_pins, 2) positions at rest, row by row from the top, the central pin at ``centre_px``."""
        reach = range(-self.rings, self.rings + 1)
        grid = [(column + row / 2, row) for row in reach for column in reach if abs(row + column) <= self.rings]
        return np.array(grid) * (self.pitch_px, self.pitch_px * math.sqrt(3) / 2) + centre_px


TACTIP_127 = Skin()
"The sensor of the paper: 127 pins."
