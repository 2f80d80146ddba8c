"""The contact front of every frame: the finite-element contact whose pins move as the pins of this press do.

A library holds how the skin of several domes moves when a contact of any radius lies on it. Per press one centre is
fitted, on request the pole, where the axis of the dome meets the image, and for each world of the library the radius
in every frame: least squares after the common shift, with an amplitude that is free but drawn to 1. Force is not used:
area over force and its rate follow afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.dome.library import Library, Rows
from casr.dome.pull import pulled_px
from casr.dome.view import DomeView, PinsAroundAxis, Real

Array = NDArray[np.float64]
Array32 = NDArray[np.float32]
Mask = NDArray[np.bool_]

PULL = 0.05
"""Weight that draws the amplitude towards 1, as a share of the squared motion: the amplitude carries how flat the dome
is pressed.
"""
_CHOICE_FRAMES = 12
_KEPT = (24, 12)
"Worlds left after the first and the second look at the press."
_CENTRED_BY = 4
_BLOCK = 2**16
"Numbers of one array while pins are moved: so many stay in the processor's cache."
_CENTRE_ROUNDS = 5
_SMALL_RAD, _CENTRE_REACH_RAD, _CENTRE_FOUND_RAD = 1e-3, 0.1, 1e-3
POLE_SD_MM = 1.0
"""Standard error of the pole before a press is seen, about where the view has it: half a millimetre beside it leaves
over 1.5 % of the motion of a good press, which knows it to 0.05 mm.
"""
_POLE_MM_PER_RAD = 25.0
"Steps of the pole in mm are those of the centre in rad times this."


@dataclass(frozen=True, eq=False)
class FrontFit:
    """Contact radius of T frames by K worlds, best first.

    view : of the sensor, with the pole that was found. worlds : (K,) rows of the library. axis : (3,) direction of the
    contact's middle from the centre of the dome. radius_mm : (K, T). scatter : (K, T) standard error of ln radius for
    the scatter of pins. misfit_px2 : (K,) squared motion left over in all frames, of ``moved_px2`` in all. sheared :
    whether the contact might be pulled along the surface.
    """

    view: DomeView
    worlds: Rows
    axis: Array
    radius_mm: Array
    scatter: Array
    misfit_px2: Array
    moved_px2: float
    sheared: bool = False


class HeldFit:
    """Worlds about one centre in one view, held against the frames of a press as they come.

    view, axis, sheared : as of ``FrontFit``. worlds : (K,) rows of the library. rest_px : (N, 2) at rest, without
    distortion. radius_mm : (K, T) in the frames so far, in the order of the worlds.
    """

    def __init__(
        self, view: DomeView, library: Library, rest_px: Array, axis: Array, worlds: Rows, *, sheared: bool = False
    ) -> None:
        self.view, self.axis, self.worlds, self.sheared, self._rest_px = view, axis, worlds, sheared, rest_px
        none = np.empty((0, *rest_px.shape))
        search = _Search(view, library, rest_px, none, np.empty(none.shape[:2], np.bool_), sheared=sheared)
        self._held = _Held(search, axis[None], library.only(worlds))
        self.radius_mm, self._cost, self._bend = (np.empty((len(worlds), 0)) for _ in range(3))
        self._moved_px2, self._n_seen = 0.0, 0

    def add(self, pins_px: Array) -> HeldFit:
        """Fit further frames: (T, N, 2) places of pins in contact, NaN where one is lost. The same again."""
        moved_px, seen = _moved(self._rest_px, pins_px)
        new = (each[0] for each in self._held.fit(moved_px, seen))
        old = self.radius_mm, self._cost, self._bend
        self.radius_mm, self._cost, self._bend = (np.hstack(both) for both in zip(old, new, strict=True))
        self._moved_px2 += float((moved_px**2).sum())
        self._n_seen += int(seen.sum())
        return self

    @property
    def best(self) -> tuple[float, int]:
        """Squared motion that the best of the worlds leaves over, px^2, and which it is."""
        misfit = self._cost.sum(axis=1)
        return float(misfit.min()), int(np.argmin(misfit))

    @property
    def fit(self) -> FrontFit:
        """Fit of the frames so far."""
        misfit = self._cost.sum(axis=1)
        order = np.argsort(misfit, kind="stable")
        scatter = np.sqrt(2 * misfit[:, None] / (2 * max(self._n_seen, 1)) / self._bend) / self.radius_mm
        return FrontFit(
            self.view, self.worlds[order], self.axis, self.radius_mm[order], scatter[order], misfit[order],
            self._moved_px2, self.sheared,
        )  # fmt: skip

    def seen_by(self, view: DomeView, library: Library) -> HeldFit:
        """The best world about the same pin in another view, without frames."""
        axis, best = _through(self.view.rest_px(self.axis), view), self.best[1]
        return HeldFit(view, library, self._rest_px, axis, self.worlds[best : best + 1], sheared=self.sheared)


def fit_front(
    view: DomeView,
    library: Library,
    rest_px: Array,
    pins_px: Array,
    near: HeldFit | None = None,
    looks: int = 2,
    *,
    sheared: bool = False,
    free_pole: bool = False,
) -> HeldFit:
    """Find centre and worlds by the places of pins, and fit these frames.

    rest_px : (N, 2) at rest, without distortion. pins_px : (T, N, 2) in contact; NaN where a pin is lost.
    near : begin at centre and pole of this fit.
    looks : at all worlds, 1 or 2: one is half the work, and enough where the centre is nearly known.
    sheared : the contact may also be pulled along the surface, by any way in any direction in each frame.
    free_pole : the pole is found, too, drawn to that of the view with a standard error of ``POLE_SD_MM``.
    What a frame has of its own is taken out of the residuals by variable projection (Golub and Pereyra 1973).
    """
    moved_px, seen = _moved(rest_px, pins_px)
    some = np.unique(np.linspace(0, len(moved_px) - 1, _CHOICE_FRAMES).astype(np.intp))
    begun = _Search(view, library, rest_px, moved_px[some], seen[some], sheared=sheared)
    stated_px = np.array(view.pole_px) if free_pole else None
    if near is not None:
        begun = begun.seen_by(near.view)
    view, axis, worlds = begun.chosen(None if near is None else near.axis, looks, stated_px)
    return HeldFit(view, library, rest_px, axis, worlds, sheared=sheared).add(pins_px)


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
        self, view: DomeView, library: Library, rest_px: Array, moved_px: Array, seen: Mask, *, sheared: bool
    ) -> None:
        self._view, self._library, self._rest_px = view, library, rest_px
        self._directions = view.directions(rest_px)
        self._moved_px, self._seen, self.sheared = moved_px, seen, sheared
        self._power = (moved_px**2).sum(axis=(1, 2))

    def seen_by(self, view: DomeView) -> _Search:
        """The same press in another view."""
        return _Search(view, self._library, self._rest_px, self._moved_px, self._seen, sheared=self.sheared)

    def chosen(self, start: Array | None, looks: int, stated_px: Array | None) -> tuple[DomeView, Array, Rows]:
        """The view, (3,) direction of the contact's middle, and the worlds that explain the press best.

        start : where it nearly is; None where nobody knows. stated_px : of ``_posed``.
        """
        search = self
        weight = (self._moved_px[-1] ** 2).sum(axis=-1) ** 1.5 + 1e-12
        axis = _unit(weight @ self._directions) if start is None else start
        for kept in _KEPT[-looks:]:
            worlds = np.argsort(search._misfit_of_all(axis), kind="stable")[:kept]
            search, axis = search._posed(axis, worlds[:_CENTRED_BY], stated_px)
        return search._view, axis, worlds

    def _misfit_of_all(self, axis: Array) -> Array32:
        """(W,) squared motion that each world of the coarse library leaves over, in single precision."""
        library = self._library.coarse
        around, motion = self.motion(axis[None], library, np.float32)
        moved = self._moved_px.reshape(len(self._moved_px), -1).astype(np.float32)
        full = power = self._power.astype(np.float32)[:, None, None]
        flat = motion.reshape(motion.shape[1], -1)  # (2 N, R W)
        shared, size = (each.reshape(-1, *motion.shape[2:]) for each in (moved @ flat, self._sizes(flat)))
        if self.sheared:
            along = self.along(around, library.radius_mm)[0].astype(np.float32)
            own, seen = along @ motion[0].transpose(1, 0, 2), along @ moved.T  # (R, 2, W), (R, 2, T)
            shared -= (seen.transpose(0, 2, 1) @ own).transpose(1, 0, 2)
            size = np.maximum(size - (own**2).sum(axis=1), 1e-6)
            power = np.maximum(full - (seen**2).sum(axis=1).T[..., None], 0.0)
        misfit: Array32 = _least(_cost(shared, size, power, PULL * full), axis=1)[1].sum(axis=0)
        return misfit

    def _sizes(self, flat: Array32) -> Array32:
        """(T or 1, K) squares of motions (2 N, K) without the common shift, of the pins seen in each frame."""
        alike = _alike(self._seen)
        masks = np.array([pins for _, pins in alike], dtype=np.float32)
        shifts = (masks @ flat[k::2] for k in range(2))
        count = np.maximum(masks.sum(axis=1, keepdims=True), 1)
        size = np.repeat(masks, 2, axis=1) @ flat**2 - sum(shift**2 for shift in shifts) / count
        if len(masks) == 1:
            return np.asarray(size)
        of_frame = np.empty(len(self._seen), dtype=np.intp)
        for k, (frames, _) in enumerate(alike):
            of_frame[frames] = k
        return np.asarray(size[of_frame])

    def fit(self, axes: Array, library: Library) -> tuple[Array, Array, Array]:
        """``_Held.fit`` of the frames of this press."""
        return _Held(self, axes, library).fit(self._moved_px, self._seen)

    def motion(self, axes: Array, library: Library, kind: type[Real]) -> tuple[PinsAroundAxis, NDArray[Real]]:
        """All pins about each of the axes (A, 3), and how they move by a library, (A, 2 N, R, W) of x, y, x, y."""
        directions = np.tile(self._directions, (len(axes), 1))
        around = self._view.around(directions, np.repeat(axes, len(self._directions), axis=0))
        moved = np.empty((len(directions), 2, library.radius_mm.size, library.n_worlds), dtype=kind)
        n_pins = max(1, _BLOCK // moved[0, 0].size)
        low, share = library.nodes_at(around.arc_mm)
        for first in range(0, len(directions), n_pins):
            some = slice(first, first + n_pins)
            motion = library.between(low[some], share[some], kind)
            around.moved_px(*motion, pins=some, out=moved[some])
        return around, moved.reshape(len(axes), -1, *moved.shape[2:])

    def along(self, around: PinsAroundAxis, radius_mm: Array) -> Array:
        """(A, R, 2, 2 N) unit motions of pins, without the common shift, whose contact of each radius is pulled along
        the surface in either direction, as skin that sticks goes along (``share_pulled``)."""
        pulled = pulled_px(around, len(self._rest_px), radius_mm, float(self._library.arc_mm[-1]))
        pulled = pulled.reshape(*pulled.shape[:3], -1)
        one, other = (pulled[:, :, k, :] for k in range(2))
        one /= np.linalg.norm(one, axis=-1, keepdims=True)
        other -= (one * other).sum(axis=-1, keepdims=True) * one
        other /= np.linalg.norm(other, axis=-1, keepdims=True)
        return np.asarray(pulled)

    def _posed(self, axis: Array, worlds: Rows, stated_px: Array | None) -> tuple[_Search, Array]:
        """The direction of least cost near ``axis``, in the view with the pole of least cost near that of this one.

        stated_px : (2,) pole that others are drawn to; None keeps that of the view.
        """
        search, coarse = self, self._library.coarse.only(worlds)
        for _ in range(_CENTRE_ROUNDS):
            search, axis, moved_rad = search._nearer(axis, coarse, stated_px)
            if moved_rad < _CENTRE_FOUND_RAD:
                break
        return search, axis

    def _nearer(self, axis: Array, coarse: Library, stated_px: Array | None) -> tuple[_Search, Array, float]:
        """One step of ``_posed``, and its size: by Gauss and Newton, in the world of least cost, with what every frame
        has of its own taken out of the residuals (variable projection; Golub and Pereyra 1973)."""
        view, across = self._view, np.linalg.svd(axis[None])[2][1:]
        middle_px, px_per_mm = view.rest_px(axis), np.array(view.focal_px) / view.depth_mm
        radius, cost, _ = (each[0] for each in self.fit(axis[None], coarse))
        best = int(np.argmin(cost.sum(axis=1)))
        world = coarse.only(np.array([best]))
        drawn = np.sqrt(cost[best].sum() / (2 * max(int(self._seen.sum()), 1))) / POLE_SD_MM

        def at(place: Array) -> tuple[DomeView, Array]:
            """The middle of the contact stays where it is in the image when the pole moves."""
            if stated_px is None:
                return view, _unit(axis + place @ across)
            x, y = (view.pole_px + _POLE_MM_PER_RAD * place[2:] * px_per_mm).tolist()
            other = replace(view, pole_px=(x, y))
            return other, _unit(_through(middle_px, other) + place[:2] @ across)

        n_unknown = 2 if stated_px is None else 4
        places = np.concatenate([np.zeros((1, n_unknown)), _SMALL_RAD * np.eye(n_unknown)])
        views, axes = zip(*map(at, places), strict=True)
        left = self._left(views, axes, world, radius[best])
        if stated_px is not None:
            off_px = np.subtract([each.pole_px for each in views], stated_px)
            left = np.concatenate([left, drawn * off_px / px_per_mm], axis=1)
        here, slopes = left[0], (left[1:] - left[0]) / _SMALL_RAD
        move = -np.linalg.lstsq(slopes.T, here, rcond=None)[0].clip(-_CENTRE_REACH_RAD, _CENTRE_REACH_RAD)
        found, middle = at(move)
        return self.seen_by(found), middle, float(np.abs(move).max())

    def _left(self, views: Sequence[DomeView], axes: Sequence[Array], world: Library, radius_mm: Array) -> Array:
        """(V, ...) residuals of all frames near radii (T,) in views that differ in their pole, by the best radius,
        amplitude and pull of each frame."""
        n_views, n_pins = len(views), len(self._rest_px)
        every = replace(views[0], pole_px=np.repeat([each.pole_px for each in views], n_pins, axis=0))
        around = every.around(every.directions(np.tile(self._rest_px, (n_views, 1))), np.repeat(axes, n_pins, axis=0))
        step = world.radius_mm[1] - world.radius_mm[0]
        place = np.clip((radius_mm - world.radius_mm[0]) / step, 0, world.radius_mm.size - 1.000001)
        low = place.astype(np.intp)
        first = int(low.min())
        near = world.at_radii(slice(first, int(low.max()) + 2))
        motion = around.moved_px(*near.motion_at(around.arc_mm, np.float64))[..., 0]  # (V N, 2, R)
        share, low = place - low, low - first
        by_radius = motion[..., low + 1] - motion[..., low]
        columns = [motion[..., low] + share * by_radius, by_radius]
        if self.sheared:
            pulled = self.along(around, radius_mm).reshape(n_views, len(low), 2, n_pins, 2)
            columns += list(pulled.transpose(2, 0, 3, 4, 1).reshape(2, -1, 2, len(low)))
        seen = self._seen[..., None, None]
        basis = np.array(columns).reshape(len(columns), n_views, n_pins, 2, len(low)).transpose(1, 4, 2, 3, 0)
        basis = seen * (basis - (seen * basis).sum(axis=2, keepdims=True) / seen.sum(axis=1, keepdims=True))
        drawn = np.sqrt(PULL * self._power)[:, None]  # of the amplitude to 1
        pull = np.broadcast_to(drawn[..., None] * np.eye(len(columns))[:1], (n_views, len(low), 1, len(columns)))
        basis = np.concatenate([basis.reshape(n_views, len(low), -1, len(columns)), pull], axis=2)
        moved = np.concatenate([self._moved_px.reshape(len(low), -1), drawn], axis=1)[..., None]
        own = np.linalg.qr(basis)[0]
        return np.asarray((moved - own @ (own.swapaxes(2, 3) @ moved)).reshape(n_views, -1))


class _Held:
    """Pins about centres (A, 3) by the worlds of a library, once for all frames.

    In double precision: differences of single ones carry the processor's order of summation into the fifth digit of an
    area. So ``library`` should hold a few worlds.
    """

    def __init__(self, search: _Search, axes: Array, library: Library) -> None:
        around, self._motion = search.motion(axes, library, np.float64)
        self._radius_mm = library.radius_mm
        self._along = search.along(around, library.radius_mm) if search.sheared else None
        self._pins: Mask = np.empty(0, np.bool_)

    def fit(self, moved_px: Array, seen: Mask) -> tuple[Array, Array, Array]:
        """(A, W, T) best radius in mm, least cost in px^2, and the cost's second derivative by the radius, in T frames
        of ``_moved``."""
        cost = np.empty((len(self._motion), len(seen), *self._motion.shape[2:]))
        for frames, pins in _alike(seen):
            self._look_at(pins)
            cost[:, frames] = self._cost_of(moved_px[frames])
        place, least, bend = (each.transpose(0, 2, 1) for each in _least(cost, axis=2))
        step = self._radius_mm[1] - self._radius_mm[0]
        return self._radius_mm[0] + step * place, least, bend / step**2

    def _look_at(self, pins: Mask) -> None:
        """What is alike in all frames in which these pins are seen: as a rule those of the frame before."""
        if np.array_equal(pins, self._pins):
            return
        self._pins = pins
        n_axes, _, n_radii, n_worlds = self._motion.shape
        self._of_pins = slice(None) if pins.all() else np.repeat(pins, 2)
        rows = self._motion[:, self._of_pins].reshape(n_axes, -1, 2, n_radii, n_worlds)
        self._rows = (rows - rows.mean(axis=1, keepdims=True)).reshape(n_axes, -1, n_radii * n_worlds)
        self._size = (self._rows**2).sum(axis=1).reshape(n_axes, 1, n_radii, n_worlds)
        if self._along is not None:
            self._pulled = self._along[..., self._of_pins]  # (A, R, 2, 2 N)
            by_radius = self._rows.reshape(n_axes, -1, n_radii, n_worlds).transpose(0, 2, 1, 3)
            self._own = self._pulled @ by_radius  # (A, R, 2, W)
            self._size = np.maximum(self._size - (self._own**2).sum(axis=2)[:, None], 1e-6)

    def _cost_of(self, moved_px: Array) -> Array:
        """(A, T', R, W) cost in frames in which the pins are seen that were looked at."""
        n_axes, _, n_radii, n_worlds = self._motion.shape
        full = power = (moved_px**2).sum(axis=(1, 2))[:, None, None]
        moved = moved_px.reshape(len(moved_px), -1)[:, self._of_pins]
        shared = (moved @ self._rows).reshape(n_axes, -1, n_radii, n_worlds)
        if self._along is not None:
            seen = self._pulled @ moved.T
            shared -= (seen.swapaxes(2, 3) @ self._own).transpose(0, 2, 1, 3)
            power = np.maximum(full - (seen**2).sum(axis=2).transpose(0, 2, 1)[..., None], 0.0)
        cost: Array = _cost(shared, self._size, power, PULL * full)
        return cost


def _alike(seen: Mask) -> list[tuple[Rows, Mask]]:
    """Frames of (T, N) pins seen in which the same pins are seen, and which these are."""
    if seen.all():
        return [(np.arange(len(seen)), seen[0])]
    patterns, which = np.unique(seen, axis=0, return_inverse=True)
    return [(np.flatnonzero(which.ravel() == k), pins) for k, pins in enumerate(patterns)]


def _through(at_px: Array, view: DomeView) -> Array:
    """(3,) direction of the pin that is seen at a place (2,) at rest."""
    return np.asarray(view.directions(at_px[None])[0])


def _cost(shared: Any, size: Any, power: Any, pull: Any) -> Any:
    """What is left of ``power`` by the best amplitude of a motion, which ``pull`` draws to 1."""
    amplitude = (shared + pull) / (size + pull)
    return power - 2 * amplitude * shared + amplitude**2 * size + pull * (amplitude - 1) ** 2


def _least(cost: Any, axis: int) -> tuple[Any, Any, Any]:
    """Place of the least cost along ``axis`` in steps of it, the cost there and its second derivative, by a parabola
    through the three costs around the least."""
    best = np.expand_dims(np.clip(np.argmin(cost, axis=axis), 1, cost.shape[axis] - 2), axis)
    before, least, after = (np.take_along_axis(cost, best + k, axis=axis).squeeze(axis) for k in (-1, 0, 1))
    bend = np.maximum(before - 2 * least + after, 1e-6)
    shift = np.clip((before - after) / (2 * bend), -1.0, 1.0)
    return best.squeeze(axis) + shift, np.maximum(least - bend * shift**2 / 2, 1e-6), bend


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
