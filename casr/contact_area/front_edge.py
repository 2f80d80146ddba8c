"""The edge of a fitted contact against the pins: what lies inside, and where the camera sees it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.contact_area.front import LEAST_PINS
from casr.contact_area.front_fit import FrontFit
from casr.dome.library import Library
from casr.dome.view import INNER_RADIUS_MM, OUTER_RADIUS_MM

Array = NDArray[np.float64]

_OUTLINE = 90


class FrontEdge:
    """The edge by the best world, against the pins."""

    def __init__(self, fit: FrontFit, library: Library, rest_px: Array) -> None:
        self._fit, self._library = fit, library
        view, world = fit.view, int(fit.worlds[0])
        self._radius_mm = fit.radius_mm[0]
        outer_arc_mm = np.interp(self._radius_mm, library.radius_mm, library.edge_arc_mm[world])
        self._arc_mm = outer_arc_mm * INNER_RADIUS_MM / OUTER_RADIUS_MM
        directions = view.directions(rest_px)
        arc_mm = view.around(directions, fit.axis).arc_mm
        self.inside = arc_mm <= self._arc_mm[:, None]
        self.pins_inside = self.inside.sum(axis=1)
        near = directions[np.argsort(arc_mm)[: 2 * LEAST_PINS]]
        angles = np.arccos(np.clip(near @ near.T, -1, 1)) + 9 * np.eye(len(near))
        self.pitches = self._arc_mm / (INNER_RADIUS_MM * float(np.median(angles.min(axis=1))))

    def outline_px(self) -> Array:
        """(T, M, 2) where tips of pins on the edge would be seen."""
        fit, library = self._fit, self._library
        turn = np.linspace(0, 2 * np.pi, _OUTLINE, endpoint=False)
        across = np.linalg.svd(fit.axis[None])[2][1:]
        around = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
        angle = (self._arc_mm / INNER_RADIUS_MM)[:, None, None]
        directions = (np.cos(angle) * fit.axis + np.sin(angle) * around).reshape(-1, 3)
        row = np.interp(self._radius_mm, library.radius_mm, np.arange(library.radius_mm.size))
        low = np.minimum(row.astype(np.intp), library.radius_mm.size - 2)
        u = library.only(fit.worlds[:1]).motion_at(self._arc_mm)[..., 0].astype(np.float64)
        frames = np.arange(len(row))
        u = (1 - row + low) * u[:, frames, low] + (row - low) * u[:, frames, low + 1]
        moved_px = fit.view.around(directions, fit.axis).moved_px(*np.repeat(u, _OUTLINE, axis=1))
        return np.asarray((fit.view.rest_px(directions) + moved_px).reshape(len(row), _OUTLINE, 2))


def as_a_whole(rest_px: Array, pins_px: Array, inside: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Shear and torsion of a contact: (T, 2) mean motion, px, and (T,) turn, degrees, of the pins inside (T, N).

    Pins (T, N, 2) that were at (N, 2) at rest; NaN where none is seen inside, and for the turn fewer than three.
    """
    shear, torsion = np.full((len(pins_px), 2), np.nan), np.full(len(pins_px), np.nan)
    for t, (now, within) in enumerate(zip(pins_px, inside, strict=True)):
        rows = np.flatnonzero(within & np.isfinite(now[:, 0]))
        if rows.size:
            shear[t] = (now[rows] - rest_px[rows]).mean(axis=0)
        if rows.size >= 3:
            before, after = (points[rows] - points[rows].mean(axis=0) for points in (rest_px, now))
            cross = (before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]).sum()
            torsion[t] = np.rad2deg(np.arctan2(cross, (before * after).sum()))
    return shear, torsion
