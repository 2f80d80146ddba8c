"""The area of the first contact, A_c0, as every rule gives it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class InitialArea:
    """Area of the first contact.

    Parameters
    ----------
    area_mm2 : A_c0, mm^2; None without camera.
    area_px2 : the same in pixels of the undistorted image.
    rule : the rule that gave it.
    selected : (n,) rows of the rest frame's pins in the contact.
    polygon_px : (K, 2) outline of the contact in the first-contact frame. For hexagons it is their convex hull, whose
        area need not be A_c0.
    notes : what was left out, filled or fell back.
    relative_sd : standard deviation of the area for the noise of single pins, as a share of it; None where the rule
        does not tell.
    saturated : nearly all pins moved, so that the threshold shows the size of the array instead of the contact's.
    """

    area_mm2: float | None
    area_px2: float
    rule: str
    selected: NDArray[np.intp]
    polygon_px: NDArray[np.float64]
    notes: tuple[str, ...]
    relative_sd: float | None = None
    saturated: bool = False

    def __repr__(self) -> str:
        area = f"{self.area_px2:.4g} px2" if self.area_mm2 is None else f"{self.area_mm2:.4g} mm2"
        notes = f", {len(self.notes)} notes" if self.notes else ""
        return f"InitialArea({area} by rule {self.rule}, {self.selected.size} pins{notes})"
