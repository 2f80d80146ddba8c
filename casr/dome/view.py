"""A dome with pins seen by its camera: from a pin's pixel at rest to its place on the dome, to its pixel in contact."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Pole = tuple[float, float] | Points
Real = TypeVar("Real", np.float32, np.float64)

OUTER_RADIUS_MM, SKIN_MM = 20.0, 1.0
"Outer radius and skin of the finite-element domes."
INNER_RADIUS_MM = OUTER_RADIUS_MM - SKIN_MM
"Radius of the skin on which pins stand."
_ALL, _N_OF_PIN = slice(None), 14


@dataclass(frozen=True, kw_only=True)
class DomeView:
    """A spherical skin with pins of one length that point at its centre, seen along its axis by a pinhole camera.

    Millimetres are those of the sensor over ``scale``: a dome of another radius is the same dome in other units.

    focal_px : (2,) along x and y. pole_px : (2,) where the dome's axis meets the image, or (N, 2) for each pin.
    depth_mm : from the camera to the tip of a pin at the pole, at rest.
    pin_length_mm : from the skin's inside to the tip. inner_radius_mm : of the skin, where pins stand.
    """

    focal_px: tuple[float, float]
    pole_px: Pole
    depth_mm: float
    pin_length_mm: float
    inner_radius_mm: float = INNER_RADIUS_MM

    @property
    def tip_radius_mm(self) -> float:
        """Radius of the sphere that the tips lie on at rest, mm."""
        return self.inner_radius_mm - self.pin_length_mm

    @property
    def behind_mm(self) -> float:
        """Camera to the dome's centre."""
        return self.depth_mm - self.tip_radius_mm

    def directions(self, rest_px: Points) -> Points:
        """(N, 3) unit vectors from the dome's centre to pins that are at rest at (N, 2) px; z points at the pole.

        A pixel beyond the outline of the sphere of tips counts as on the outline.
        """
        x, y = ((rest_px - self.pole_px) / self.focal_px).T
        far = x**2 + y**2
        # |b + t ray| = r with ray (x, y, 1) from the camera, b the camera behind the centre; the far root is the skin
        r, c = self.tip_radius_mm, self.behind_mm
        root = np.sqrt(np.maximum(r**2 * (1 + far) - c**2 * far, 0.0))
        along = (c + root) / (1 + far)
        points = np.stack([x * along, y * along, along - c], axis=-1)
        return np.asarray(points / np.linalg.norm(points, axis=-1, keepdims=True))

    def rest_px(self, directions: Points) -> Points:
        """(..., 2) px of tips at rest."""
        return self.seen_px(self.tip_radius_mm * directions)

    def seen_px(self, points_mm: Points) -> Points:
        """(..., 2) px of (..., 3) points from the dome's centre."""
        away = points_mm[..., 2:] + self.behind_mm
        return np.asarray(points_mm[..., :2] / away * self.focal_px + self.pole_px)

    def around(self, directions: Points, axis: Points) -> PinsAroundAxis:
        """Pins as seen from the contact whose middle lies in the direction ``axis`` (3,), or (N, 3) for each pin."""
        cosine = np.clip((directions * axis).sum(axis=1), -1.0, 1.0)
        outward = directions - cosine[:, None] * axis
        sine = np.linalg.norm(outward, axis=1)
        outward /= np.maximum(sine, 1e-12)[:, None]
        return PinsAroundAxis(self, directions, axis, outward, np.arctan2(sine, cosine))


@dataclass(frozen=True, eq=False)
class PinsAroundAxis:
    """Pins of a view in polar coordinates about the middle of a contact.

    directions : (N, 3). axis : (3,), or (N, 3) for each pin. outward : (N, 3) unit vectors across the axis.
    angle : (N,) from the axis, rad.
    """

    view: DomeView
    directions: Points
    axis: Points
    outward: Points
    angle: Points

    @property
    def arc_mm(self) -> Points:
        """(N,) arc along the inside of the skin from the middle of the contact to the root of each pin."""
        return self.view.inner_radius_mm * self.angle

    def moved_px(
        self,
        u_r_mm: NDArray[Real],
        u_z_mm: NDArray[Real],
        tilt_rad: NDArray[Real],
        pulled_mm: NDArray[Real] | None = None,
        *,
        pins: slice = _ALL,
        out: NDArray[Real] | None = None,
    ) -> NDArray[Real]:
        """(N, 2, ...) px from rest, of displacements (N, ...) of the skin under the pins across and along the axis, mm,
        and its tilt there, rad.

        pulled_mm : (N, 3, ...) more that friction adds, mm. pins : some of the pins, n of the N. out : to write into.
        A pin is stiff and stands square on the skin, so its tip turns with it. An axis that is not the dome's own is an
        assumption: it takes the clamped base for as far away from that contact as from one at the pole.
        """
        kind = tilt_rad.dtype
        table = self._of_kind(kind)[:, pins].reshape(_N_OF_PIN, -1, *(1,) * (tilt_rad.ndim - 1))
        (angle, sine, cosine), tips, outward, axis, rest_px = table[:3], table[3:6], table[6:9], table[9:12], table[12:]
        length = kind.type(self.view.pin_length_mm)
        turned = angle - tilt_rad
        # each line changes its array in place: libraries of domes come here, and memory takes longer than the sums
        across, up = np.sin(turned), np.cos(turned)
        for along, at_rest, moved_mm in ((across, sine, u_r_mm), (up, cosine, u_z_mm)):
            along -= at_rest
            along *= -length
            along += moved_mm

        room, place = turned, np.empty_like(turned)

        def coordinate(k: int, place: NDArray[Real]) -> NDArray[Real]:
            np.multiply(across, outward[k], out=place)
            place += tips[k]
            place += np.multiply(up, axis[k], out=room)
            if pulled_mm is not None:
                place += pulled_mm[:, k]
            return place

        away = coordinate(2, np.empty_like(turned))
        away += kind.type(self.view.behind_mm)
        per_mm = np.divide(1, away, out=away)
        moved = np.empty((len(tilt_rad), 2, *tilt_rad.shape[1:]), dtype=kind) if out is None else out
        for k in range(2):
            coordinate(k, place)
            place *= kind.type(self.view.focal_px[k])
            place *= per_mm
            np.subtract(place, rest_px[k], out=moved[:, k])
        return moved

    def _of_kind(self, kind: np.dtype[Any]) -> NDArray[Any]:
        """(14, N) what ``moved_px`` needs of each pin, in this precision; made once."""
        if kind not in self._tables:
            angle, view = self.angle.astype(kind), self.view
            columns = (
                view.tip_radius_mm * self.directions, self.outward, np.broadcast_to(self.axis, self.directions.shape),
                view.rest_px(self.directions) - view.pole_px,
            )  # fmt: skip
            self._tables[kind] = np.concatenate(
                [np.stack([angle, np.sin(angle), np.cos(angle)]), np.hstack(columns).T.astype(kind)]
            )
        return self._tables[kind]

    @cached_property
    def _tables(self) -> dict[np.dtype[Any], NDArray[Any]]:
        return {}
