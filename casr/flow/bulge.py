"""The motion of the pins of a region: affine, and where pins enough show it, stronger or weaker towards the border."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casr.flow.pin_affine import Affine, fit_affine
from casr.flow.region import Points, Region

CENTROID_SD_PX = 0.05
EDGE_SD_PX = 1.0


@dataclass(frozen=True, eq=False)
class Bulge:
    """x' - x = affine + strength * (depth^2 (x - centre) - its own affine part).

    affine : least-squares fit. region : whose depth and centre are meant. strength : no unit. affine_part : of the shape
    depth^2 (x - centre), so that ``affine`` is what it is without the bulge.
    """

    affine: Affine
    region: Region
    strength: float
    affine_part: Affine

    def displacement_px(self, points_px: Points) -> Points:
        """Motion (N, 2) of points (N, 2), px."""
        beyond = _shape(self.region, points_px) - self.affine_part.displacement_px(points_px)
        return self.affine.displacement_px(points_px) + self.strength * beyond


def fit_bulge(region: Region, before_px: Points, after_px: Points) -> Bulge:
    """Fit to pins (N, 2) -> (N, 2); NaN rows are left out.

    A skin that bulges everywhere grows least at the border of a region, where its area is decided; an affine fit to the
    pins inside then overstates the area's growth (by 4 % on a real flat press). The one added parameter is shrunk as if
    it were known to be within 1 px at the border, with centroids good to 0.05 px: three to seven pins at one distance from
    the centre say nothing of it, and the fit stays affine.

    Raises
    ------
    PinsError : fewer than three pins, or all close to one line.
    """
    affine = fit_affine(before_px, after_px)
    error = after_px - before_px - affine.displacement_px(before_px)
    # the fit leaves out mistaken pins, those furthest off; a lost pin's NaN sorts last
    kept = np.argsort(np.hypot(*error.T), kind="stable")[: affine.n]
    shape = _shape(region, before_px[kept])
    affine_part = fit_affine(before_px[kept], before_px[kept] + shape)
    beyond = shape - affine_part.displacement_px(before_px[kept])
    doubt = region.area_px2 / np.pi * (CENTROID_SD_PX / EDGE_SD_PX) ** 2
    strength = float((beyond * error[kept]).sum() / ((beyond**2).sum() + doubt))
    return Bulge(affine, region, strength, affine_part)


def _shape(region: Region, points_px: Points) -> Points:
    return np.asarray(region.depth(points_px)[:, None] ** 2 * (points_px - region.centre_px))
