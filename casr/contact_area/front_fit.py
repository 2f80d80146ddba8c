"""The contact front of every frame: the finite-element contact whose pins move as the pins of this press do.

A library holds how the skin of several domes moves when a contact of any radius lies on it. Per press one centre is
fitted, and for each world of the library the radius in every frame: least squares after the common shift, with an
amplitude that is free but drawn to 1. Force is not used: area over force and its rate follow afterwards.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.dome.library import Library, Rows
from casr.dome.view import OUTER_RADIUS_MM, DomeView, PinsAroundAxis

Array = NDArray[np.float64]
Array32 = NDArray[np.float32]
Mask = NDArray[np.bool_]

PULL = 0.05
"""Of the amplitude towards 1, as a share of the squared motion: the amplitude carries how flat the dome is pressed."""
_CHOICE_FRAMES = 12
_KEPT = (24, 12)
"Worlds left after the first and the second look at the press."
_CENTRED_BY = 4
_CENTRE_ROUNDS = 5
_CENTRE_STEP_RAD, _CENTRE_REACH_RAD, _CENTRE_FOUND_RAD = 0.02, 0.1, 1e-3


@dataclass(frozen=True, eq=False)
class FrontFit:
    """Contact radius of T frames by K worlds, best first.

    view : of the sensor. worlds : (K,) rows of the library. axis : (3,) direction of the contact's middle from the
    centre of the dome. radius_mm : (K, T). scatter : (K, T) standard error of ln radius for the scatter of pins.
    misfit_px2 : (K,) squared motion left over in all frames, of ``moved_px2`` in all. sheared : whether the contact
    might be pulled along the surface.
    """

    view: DomeView
    worlds: Rows
    axis: Array
    radius_mm: Array
    scatter: Array
    misfit_px2: Array
    moved_px2: float
    sheared: bool = False


def fit_front(
    view: DomeView,
    library: Library,
    rest_px: Array,
    pins_px: Array,
    like: FrontFit | None = None,
    near: FrontFit | None = None,
    looks: int = 2,
    *,
    sheared: bool = False,
) -> FrontFit:
    """Fit the places of pins.

    Parameters
    ----------
    rest_px : (N, 2) at rest, without distortion. pins_px : (T, N, 2) in contact; NaN where a pin is lost.
    like : take centre and worlds of this fit instead of finding them.
    near : find them, and begin at the centre of this fit.
    looks : at all worlds, 1 or 2: one is half the work, and enough where the centre is nearly known.
    sheared : the contact may also be pulled along the surface, by any way in any direction in each frame.
    """
    moved_px, seen = _moved(rest_px, pins_px)
    sheared = sheared or (like is not None and like.sheared)
    search = _Search(view, library, view.directions(rest_px), moved_px, seen, sheared=sheared)
    if like is not None:
        axis, worlds = view.directions(like.view.rest_px(like.axis[None]))[0], like.worlds
    else:
        some = np.unique(np.linspace(0, len(moved_px) - 1, _CHOICE_FRAMES).astype(np.intp))
        start = None if near is None else view.directions(near.view.rest_px(near.axis[None]))[0]
        axis, worlds = search.of(some).chosen(start, looks)
    radius, cost, bend = search.fit(axis, worlds, library)
    misfit = cost.sum(axis=1)
    order = np.argsort(misfit, kind="stable")
    freedom = 2 * max(int(seen.sum()), 1)
    scatter = np.sqrt(2 * misfit[:, None] / freedom / bend) / radius
    return FrontFit(
        view, worlds[order], axis, radius[order], scatter[order], misfit[order], float((moved_px**2).sum()), sheared
    )


def _moved(rest_px: Array, pins_px: Array) -> tuple[Array, Mask]:
    """(T, N, 2) displacement without the mean of the pins seen, 0 where one is lost; (T, N) which are seen."""
    moved = np.asarray(pins_px, dtype=np.float64) - rest_px
    seen = np.isfinite(moved[..., 0])
    moved = np.where(seen[..., None], moved, 0.0)
    mean = moved.sum(axis=1, keepdims=True) / np.maximum(seen.sum(axis=1), 1)[:, None, None]
    return np.where(seen[..., None], moved - mean, 0.0), seen


class _Search:
    """One press held against worlds."""

    def __init__(
        self, view: DomeView, library: Library, directions: Array, moved_px: Array, seen: Mask, *, sheared: bool
    ) -> None:
        self._view, self._library, self._directions = view, library, directions
        self._moved_px, self._seen, self._sheared = moved_px, seen, sheared
        self._power = (moved_px**2).sum(axis=(1, 2)).astype(np.float32)
        self._flat = np.ascontiguousarray(moved_px.reshape(len(moved_px), -1).T, dtype=np.float32)
        self._mask = np.ascontiguousarray(seen.T, dtype=np.float32)

    def of(self, frames: Rows) -> _Search:
        """The same press in fewer frames."""
        return _Search(
            self._view,
            self._library,
            self._directions,
            self._moved_px[frames],
            self._seen[frames],
            sheared=self._sheared,
        )

    def chosen(self, start: Array | None, looks: int) -> tuple[Array, Rows]:
        """(3,) direction of the contact's middle, and the worlds that explain the press best. start : where it nearly
        is; None where nobody knows."""
        weight = (self._moved_px[-1] ** 2).sum(axis=-1) ** 1.5 + 1e-12
        axis = _unit(weight @ self._directions) if start is None else start
        for kept in _KEPT[-looks:]:
            misfit = self.fit(axis, slice(None), self._library.coarse)[1].sum(axis=1)
            worlds = np.argsort(misfit, kind="stable")[:kept]
            axis = self._centred(axis, worlds[:_CENTRED_BY])
        return axis, worlds

    def fit(self, axis: Array, worlds: Rows | slice, library: Library) -> tuple[Array, Array, Array]:
        """(W, T) best radius in mm, least cost in px^2, and the cost's second derivative by the radius.

        The radius of the grid is found in single precision. Of a few worlds, cost beside it is in double precision:
        differences of single ones carry the processor's order of summation into the fifth digit of an area.
        """
        around = self._view.around(self._directions, axis)
        u_r, u_z, tilt = library.motion_at(around.arc_mm, worlds)
        by_pin = around.moved_px(u_r, u_z, tilt)
        motion = _by_contact(by_pin)
        shared, size = self._products(motion, by_pin.mean(axis=0))
        power, along = self._power, None
        if self._sheared:
            along = self._along(around, library.radius_mm)
            single = along.astype(np.float32)
            seen, own = single @ self._flat, np.einsum("wrn,rkn->wrk", motion, single)
            shared = shared - np.einsum("wrk,rkt->wrt", own, seen)
            size = np.maximum(size - (own**2).sum(axis=-1)[..., None], 1e-6)
            power = np.maximum(power - (seen**2).sum(axis=1), 0.0)
        cost = _cost(shared, size, power, PULL * self._power)
        radius = library.radius_mm
        step = radius[1] - radius[0]
        best = np.clip(np.argmin(cost, axis=1), 1, radius.size - 2)
        beside = best[:, None] + np.arange(-1, 2)[:, None]
        near = (
            np.take_along_axis(cost, beside, axis=1) if isinstance(worlds, slice) else self._near(motion, along, beside)
        )
        before, least, after = near[:, 0], near[:, 1], near[:, 2]
        bend = np.maximum(before - 2 * least + after, 1e-6)
        shift = np.clip((before - after) / (2 * bend), -1.0, 1.0)
        cost_there = np.maximum(least - bend * shift**2 / 2, 1e-6)
        return radius[0] + step * (best + shift), cost_there.astype(np.float64), bend.astype(np.float64) / step**2

    def _near(self, motion: Array32, along: Array | None, beside: Rows) -> Array:
        """(W, K, T) cost at the radii ``beside`` (W, K, T), in double precision."""
        n_worlds, _, n_frames = beside.shape
        rows = np.take_along_axis(motion, beside.reshape(n_worlds, -1, 1), axis=1).astype(np.float64)
        pins = rows.reshape(*beside.shape, -1, 2) * self._seen[..., None]
        pins -= pins.sum(axis=-2, keepdims=True) / np.maximum(self._seen.sum(axis=1), 1)[:, None, None]
        rows = (pins * self._seen[..., None]).reshape(*beside.shape, -1)
        moved = self._moved_px.reshape(n_frames, -1)
        shared, size = np.einsum("wktn,tn->wkt", rows, moved), np.einsum("wktn,wktn->wkt", rows, rows)
        power = full = (moved**2).sum(axis=1)
        if along is not None:
            pulled = along[beside]
            seen, own = np.einsum("wktcn,tn->wktc", pulled, moved), np.einsum("wktcn,wktn->wktc", pulled, rows)
            shared -= (own * seen).sum(axis=-1)
            size = np.maximum(size - (own**2).sum(axis=-1), 1e-6)
            power = np.maximum(full - (seen**2).sum(axis=-1), 0.0)
        cost: Array = _cost(shared, size, power, PULL * full)
        return cost

    def _products(self, motion: Array32, mean: Array32) -> tuple[Array32, Array32]:
        """(W, R, T) motion times what was seen, and (W, R, T or 1) its own square; both without the common shift.

        motion : (W, R, 2 N) of pins x, y, x, y and so on. mean : (2, W, R) of all pins.
        """
        shared = motion @ self._flat
        if self._seen.all():
            n_pins = motion.shape[-1] // 2
            size = np.einsum("wrn,wrn->wr", motion, motion) - n_pins * (mean**2).sum(axis=0)
            return shared, size[..., None]
        pins = motion.reshape(*motion.shape[:2], -1, 2)
        square = (pins**2).sum(axis=-1) @ self._mask
        sums = ((pins[..., k] @ self._mask) ** 2 for k in range(2))
        return shared, square - sum(sums) / np.maximum(self._mask.sum(axis=0), 1)

    def _along(self, around: PinsAroundAxis, radius_mm: Array) -> Array:
        """(R, 2, 2 N) unit motions of pins, without the common shift, whose contact of each radius is pulled along the
        surface in either direction; outside it the skin goes along as about a sheared disc (Johnson 1985, 3.7)."""
        view = self._view
        tips = view.tip_radius_mm * self._directions
        away = tips[:, 2:] + view.behind_mm
        across = np.linalg.svd(around.axis[None])[2][1:]
        moves = np.stack([view.focal_px * (e[:2] - tips[:, :2] * e[2] / away) / away for e in across])
        edge_rad = np.arcsin(np.clip(radius_mm / OUTER_RADIUS_MM, 0.0, 1.0))[:, None]
        share = 2 / np.pi * np.arcsin(np.minimum(edge_rad / np.maximum(around.angle, 1e-9), 1.0))
        pulled = share[:, None, :, None] * moves
        pulled = (pulled - pulled.mean(axis=2, keepdims=True)).reshape(radius_mm.size, 2, -1)
        return np.asarray(np.linalg.qr(pulled.transpose(0, 2, 1))[0].transpose(0, 2, 1), dtype=np.float64)

    def _centred(self, axis: Array, worlds: Rows) -> Array:
        """The direction of least cost near ``axis``, by Newton's method with numerical derivatives."""
        across = np.linalg.svd(axis[None])[2][1:]
        h = _CENTRE_STEP_RAD
        around = h * np.array([(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1)], dtype=np.float64)
        place = np.zeros(2)
        for _ in range(_CENTRE_ROUNDS):
            c = [self._cost(_unit(axis + (place + offset) @ across), worlds) for offset in around]
            gradient = np.array([c[1] - c[2], c[3] - c[4]]) / (2 * h)
            mixed = c[5] - c[1] - c[3] + c[0]
            curve = np.array([[c[1] - 2 * c[0] + c[2], mixed], [mixed, c[3] - 2 * c[0] + c[4]]]) / h**2
            if np.linalg.eigvalsh(curve)[0] <= 0:
                curve = np.diag(np.maximum(np.abs(np.diag(curve)), 1e-6))
            step = np.clip(-np.linalg.solve(curve, gradient), -_CENTRE_REACH_RAD, _CENTRE_REACH_RAD)
            place = place + step
            if np.abs(step).max() < _CENTRE_FOUND_RAD:
                break
        return _unit(axis + place @ across)

    def _cost(self, axis: Array, worlds: Rows) -> float:
        return float(self.fit(axis, worlds, self._library.coarse)[1].sum(axis=1).min())


def _cost(shared: Any, size: Any, power: Any, pull: Any) -> Any:
    """What is left of ``power`` by the best amplitude of a motion, which ``pull`` draws to 1."""
    amplitude = (shared + pull) / (size + pull)
    return power - 2 * amplitude * shared + amplitude**2 * size + pull * (amplitude - 1) ** 2


def _by_contact(by_pin: Array32) -> Array32:
    """(W, R, 2 N) of (N, 2, W, R)."""
    n_pins, _, n_worlds, n_radii = by_pin.shape
    turned = cv2.transpose(by_pin.reshape(2 * n_pins, -1))  # three times as fast as a copy by NumPy
    return np.asarray(turned.reshape(n_worlds, n_radii, -1), dtype=np.float32)


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
