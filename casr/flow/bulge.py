"""The motion of a region by its pins: affine, and where pins enough show it, stronger or weaker towards the border."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.flow.pin_affine import Affine, fit_affine
from casr.flow.region import Points, Region

PIN_SCATTER_PX = 0.4
EDGE_SD_PX = 1.0


class BulgingRegion:
    """A region of the first frame and where its pins take it.

    A skin that bulges everywhere grows least at the border of a region, where its area is decided; an affine fit to the
    pins inside then overstates the area's growth (0.301 for 0.290 on a real flat press). So the displacement may also
    have a part depth^2 (x - centre), depth being 0 at the centre and 1 on the border. Its one parameter is shrunk as if
    it were known to be within 1 px at the border, and pins to scatter by 0.4 px (0.3 measured on that press): a few
    pins at one distance from the centre say nothing of it, and the motion stays affine.

    Parameters
    ----------
    region : in the first frame. pins_px : (N, 2) the pins it is followed by, there.
    """

    def __init__(self, region: Region, pins_px: Points) -> None:
        self._region, self._pins_px = region, pins_px
        self._pin_bulge, self._border_bulge = _bulge(region, pins_px), _bulge(region, region.polygon_px)
        self._doubt = region.area_px2 / np.pi * (PIN_SCATTER_PX / EDGE_SD_PX) ** 2
        self._seen: NDArray[np.intp] = np.empty(0, np.intp)

    def at(self, pins_px: Points) -> tuple[Region, Affine]:
        """The region when its pins are at (N, 2), NaN where one is lost; and the affine fit.

        Raises
        ------
        PinsError : fewer than three pins, or all close to one line.
        """
        affine = fit_affine(self._pins_px, pins_px)
        error = pins_px - self._pins_px - affine.displacement_px(self._pins_px)
        # the fit leaves out mistaken pins, those furthest off; a lost pin's NaN sorts last
        seen = np.sort(np.argsort((error**2).sum(axis=1), kind="stable")[: affine.n])
        self._use(seen)
        strength = float((self._beyond * error[seen]).sum()) / self._weight
        border_px = self._region.polygon_px
        return Region(border_px + affine.displacement_px(border_px) + strength * self._border_beyond), affine

    def _use(self, seen: NDArray[np.intp]) -> None:
        """What the bulge has beyond its own affine part, for these pins."""
        if np.array_equal(seen, self._seen):
            return
        self._seen, pins_px = seen, self._pins_px[seen]
        affine_part = fit_affine(pins_px, pins_px + self._pin_bulge[seen])
        self._beyond = self._pin_bulge[seen] - affine_part.displacement_px(pins_px)
        self._border_beyond = self._border_bulge - affine_part.displacement_px(self._region.polygon_px)
        self._weight = float((self._beyond**2).sum()) + self._doubt


def _bulge(region: Region, points_px: Points) -> Points:
    return np.asarray(region.depth(points_px)[:, None] ** 2 * (points_px - region.centre_px))
