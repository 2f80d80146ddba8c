"""How the pins of a press move, and how that changes a little with the skin beneath them and with the view of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.dome.view import PinsAroundAxis

Array = NDArray[np.float64]


class PinSlopes:
    """Derivatives of what ``PinsAroundAxis.moved_px`` computes. Coordinates come first, for speed.

    pins : N about the middle of a contact. skin : (3, T, N) motion of the skin beneath them in T frames, across and
    along the axis, mm, and rotation, rad. by_arc : (3, T, N) its slope along the arc, per mm.
    moved_px : (2, T, N) of these.
    """

    def __init__(self, pins: PinsAroundAxis, skin: Array, by_arc: Array) -> None:
        self._pins, self._by_arc, view = pins, by_arc, pins.view
        turned, length = pins.angle - skin[2], view.pin_length_mm
        self._sine, self._cosine = length * np.sin(turned), length * np.cos(turned)
        self._at_rest = length * np.sin(pins.angle), length * np.cos(pins.angle)
        self._tipped = self._sine - self._at_rest[0], self._cosine - self._at_rest[1]
        self._out, self._up = skin[0] - self._tipped[0], skin[1] - self._tipped[1]
        self._outward, self._axis = _first(pins.outward), _first(pins.axis[None])
        tips = view.tip_radius_mm * _first(pins.directions)
        place = self._out * self._outward + self._up * self._axis + tips
        per_mm = 1 / (place[2] + view.behind_mm)
        self._slant, self._scale = place[:2] * per_mm, np.reshape(view.focal_px, (2, 1, 1)) * per_mm
        self._rest_px = _rest_px(pins)
        self.moved_px = np.reshape(view.focal_px, (2, 1, 1)) * self._slant - self._rest_px
        self._across, self._along = self._seen(self._outward), self._seen(self._axis)

    def by_skin(self, change: Array) -> Array:
        """(2, C, T, N) px for C changes (3, C, T, N) of the motion of the skin."""
        out = change[0] + self._cosine * change[2]
        up = change[1] - self._sine * change[2]
        return np.asarray(out * self._across[:, None] + up * self._along[:, None])

    def by_view(self, other: PinsAroundAxis, step: float) -> Array:
        """(2, T, N) px per unit of what differs by ``step`` in another view or about another axis of the same pins."""
        pins, view, length = self._pins, self._pins.view, self._pins.view.pin_length_mm
        angle = (other.angle - pins.angle) / step
        longer = (other.view.pin_length_mm - length) / step / length
        skin = self._by_arc * (view.inner_radius_mm * angle)
        turned = angle - skin[2]
        out = skin[0] - longer * self._tipped[0] - self._cosine * turned + self._at_rest[1] * angle
        up = skin[1] - longer * self._tipped[1] + self._sine * turned - self._at_rest[0] * angle
        way = self._out * _first((other.outward - pins.outward) / step)
        way += self._up * _first((other.axis - pins.axis)[None] / step)
        way += _first((other.view.tip_radius_mm * other.directions - view.tip_radius_mm * pins.directions) / step)
        way[2] += (other.view.behind_mm - view.behind_mm) / step
        rest = (_rest_px(other) - self._rest_px) / step
        return np.asarray(out * self._across + up * self._along + self._seen(way) - rest)

    def _seen(self, way_mm: Array) -> Array:
        """(2, T, N) px for small ways (3, ...) of the tips."""
        return np.asarray(self._scale * (way_mm[:2] - self._slant * way_mm[2]))


def _first(points: Array) -> Array:
    """(K, 1, N) of points (N, K)."""
    return points.T[:, None]


def _rest_px(pins: PinsAroundAxis) -> Array:
    return _first(pins.view.rest_px(pins.directions) - pins.view.pole_px)
