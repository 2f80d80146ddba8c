"""Pins of one press under the forward model: what they should do in a world, and how that changes with it.

Parameters of a press are those of ``SHARED`` (of the sensor, or of a mounting of it), those of ``OWN``, and the contact
radius in each frame. Left out are a shift of all pins in a frame, what friction on a slope moves by pulling the contact
along the surface, with its history (``casr.dome.pull``), and the noise that the rest frame gives to all frames alike
(``whitened``).
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from casr.dome.library import FAMILY
from casr.dome.pull import pulled_px
from casr.dome.view import DomeView, PinsAroundAxis
from casr.kappa.family import Family
from casr.kappa.presses import FEWEST_FRAMES, KappaPress
from casr.kappa.slopes import PinSlopes

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

MOST_FRAMES = 14

OF_VIEW = ("place", "pin_length_mm", "log_depth", "pole_x_px", "pole_y_px")
BENDS = tuple(f"bend_{k}" for k in range(len(FAMILY) - 2))
"Shares of the ways in which a dome may lie beside its family; those that a family does not have stay 0."
SHARED = (*OF_VIEW, *BENDS)
OWN = ("z", "stick", "across_1_rad", "across_2_rad")
_STEPS = {
    **{SHARED.index(name): 1e-4 for name in OF_VIEW[1:]}, len(SHARED) + 2: 1e-5, len(SHARED) + 3: 1e-5,
}  # fmt: skip
"Step of the difference quotient, by the number of a parameter of the view or of the axis."
_FITS = 4
LEAST_RADIUS_MM = 1.0


@dataclass(frozen=True, eq=False)
class State:
    """A point in the space of parameters. shared, own : values by the names above. radius_mm : (T,)."""

    shared: Array
    own: Array
    radius_mm: Array


_UNDISTURBED = State(np.zeros(len(SHARED)), np.array([0, 0.5, 0, 0]), np.empty(0))


@dataclass(frozen=True, eq=False)
class TableWorld:
    """A world of a family, of even friction, at R radii of the tables: the same for every press that begins there.

    radius_mm : (R,). motion : (3, R, S).
    """

    place: float
    z: float
    radius_mm: Array
    motion: Array

    @classmethod
    def of(cls, family: Family, place: float, z: float, least_mm: float = 0.0) -> TableWorld:
        """At the radii from about the least on."""
        radius_mm = family.radius_mm
        radius_mm = radius_mm[min(int(np.searchsorted(radius_mm, least_mm)), radius_mm.size - 1) :]
        weights = family.world(place, z, 0.5, 0.0, np.zeros(len(family.bends))).motion
        return cls(place, z, radius_mm, _at_radii(family, weights, radius_mm)[0])


class PressField:
    """One press held against the worlds of a family."""

    def __init__(self, press: KappaPress, view: DomeView, family: Family, frames: Rows | None = None) -> None:
        self.press, self._view, self.family = press, view, family
        good, pins = press.seen()
        self.last = np.inf
        self.frames = _spread(good) if frames is None else frames
        self._rest_px = press.rest_px[pins]
        moved = press.pins_px[self.frames][:, pins] - self._rest_px
        self._moved = moved - moved.mean(axis=1, keepdims=True)
        self.n_frames, self.n_pins = moved.shape[:2]
        self._rest_share = 1 - 1 / np.sqrt(1 + self.n_frames / press.rest_frames)
        weight = (self._moved[-1] ** 2).sum(axis=1) ** 1.5 + 1e-12
        axis = weight @ view.directions(self._rest_px)
        self._axis = axis / np.linalg.norm(axis)
        self._across = np.linalg.svd(self._axis[None])[2][1:]
        self.seen = self.whitened(self._moved)

    def within_tables(self, state: State, last: float = np.inf) -> tuple[PressField, State]:
        """The same press in frames whose contact was computed, not continued, in the tables of both frictions that make
        up the state's world; where they are few, in those of the smallest contacts. last : frame that may be one."""
        good, _ = self.press.seen()
        good = good[good <= last]
        limit_mm = self.family.computed_mm(self.family.world(state.shared[0], state.own[0], 0.5, 0.0))
        radius_mm = np.interp(good, self.frames, state.radius_mm)
        frames = good[radius_mm <= max(limit_mm, np.partition(radius_mm, FEWEST_FRAMES - 1)[FEWEST_FRAMES - 1])]
        last = last if frames.size == good.size else float(frames[-1])
        frames = _spread(frames)
        same = np.array_equal(frames, self.frames)
        field = copy(self) if same else PressField(self.press, self._view, self.family, frames)
        field.last = last
        return field, replace(state, radius_mm=np.interp(frames, self.frames, state.radius_mm))

    @property
    def moved_px(self) -> float:
        """Root mean square motion of the pins, px."""
        return float(np.sqrt((self._moved**2).mean()))

    def whitened(self, moved: Array) -> Array:
        """(T, N, 2) with errors that are alike and independent, for the noise of pins at rest and in contact."""
        return np.asarray(moved - self._rest_share * moved.mean(axis=0))

    def predicted(self, state: State, around: PinsAroundAxis | None = None) -> Array:
        """(T, N, 2) motion, px, without a common shift. around : ``_around`` of the state, where it is known."""
        z, stick = state.own[:2]
        bend = state.shared[len(OF_VIEW) :][: len(self.family.bends)]
        weights = self.family.world(state.shared[0], z, stick, 0.0, bend).motion
        motion = _at_radii(self.family, weights, state.radius_mm)[0]
        return self._moved_by(motion, self._around(state) if around is None else around)

    def _moved_by(self, motion: Array, around: PinsAroundAxis) -> Array:
        """(T, N, 2) px of the pins on a skin that moves by (3, T, S), without a common shift."""
        under, _ = self._under(around, motion)
        moved = around.moved_px(*under.transpose(0, 2, 1)).transpose(2, 0, 1)
        return np.asarray(moved - moved.mean(axis=1, keepdims=True))

    def left(self, state: State) -> Array:
        """(M,) residuals, px, in the order of frames, x and y, pins, without what a pull tells."""
        around = self._around(state)
        left = (self.seen - self.whitened(self.predicted(state, around))).swapaxes(1, 2)
        return np.asarray(self._without_pulls(left[None], around, state.radius_mm)[0])

    @property
    def n_of_frames(self) -> int:
        """Unknowns that frames have of their own: the radius, and a pull both ways."""
        return int(3 * self.n_frames)

    def _without_pulls(self, motions: Array, around: PinsAroundAxis, radius_mm: Array) -> Array:
        """(K, M) of whitened motions (K, T, 2, N): less what friction that pulls the contact along the surface, in each
        frame by itself, explains best."""
        n, share = self.n_frames, self._rest_share / self.n_frames
        ways = pulled_px(around, self.n_pins, radius_mm, float(self.family.arc_mm[-1]))[0]
        ways = ways.swapaxes(2, 3).reshape(n, 2, -1)
        seen = motions.reshape(len(motions), n, -1).swapaxes(0, 1)
        told = (seen - share * seen.sum(axis=0)) @ ways.swapaxes(1, 2)  # (T, K, 2)
        every = ways.reshape(2 * n, -1)
        squares = (self._rest_share - 2) * share * (every @ every.T)
        own = np.arange(2 * n).reshape(n, 2)
        squares[own[:, :, None], own[:, None]] += ways @ ways.swapaxes(1, 2)
        far = np.linalg.solve(squares, told.swapaxes(1, 2).reshape(2 * n, -1)).reshape(n, 2, -1)
        pulled = far.swapaxes(1, 2) @ ways
        return np.asarray(seen - pulled + share * pulled.sum(axis=0)).swapaxes(0, 1).reshape(len(motions), -1)

    def _view_at(self, shared: Array) -> DomeView:
        view = self._view
        return replace(
            view, pin_length_mm=view.pin_length_mm + shared[1], depth_mm=view.depth_mm * np.exp(shared[2]),
            pole_px=(view.pole_px[0] + shared[3], view.pole_px[1] + shared[4]),
        )  # fmt: skip

    def _around(self, state: State, directions: Array | None = None) -> PinsAroundAxis:
        """The pins about the contact's middle. directions : of the pins in the state's view, where they are known."""
        view = self._view_at(state.shared)
        axis = self._axis + state.own[-2:] @ self._across
        directions = view.directions(self._rest_px) if directions is None else directions
        return view.around(directions, axis / np.linalg.norm(axis))

    def _under(self, around: PinsAroundAxis, of_frames: Array) -> tuple[Array, Array]:
        """(..., T, N) of (..., T, S) under each pin, and its slope along the arc, per mm."""
        step_mm = self.family.arc_mm[1]
        row, share, per_mm = _between(around.arc_mm, 0.0, step_mm, self.family.arc_mm.size)
        low = of_frames.take(row, axis=-1)
        rise = of_frames.take(row + 1, axis=-1) - low
        return low + rise * share, rise * per_mm

    def linearised(self, state: State) -> tuple[Array, Array]:
        """(M,) residuals, px, and (M, 9 + T) their derivatives by shared and own parameters and radii."""
        n_shared, first, n_frames, bends = len(SHARED), len(OF_VIEW), self.n_frames, len(self.family.bends)
        z, stick = state.own[:2].tolist()
        weights = self.family.motion_slopes(state.shared[0], z, stick, state.shared[first : first + bends])
        around = self._around(state)
        in_frames, by_radius = _at_radii(self.family, weights, state.radius_mm)
        under, by_arc = self._under(around, np.concatenate([in_frames, by_radius[:, :1]], axis=1))
        pins = PinSlopes(around, under[:, 0], by_arc[:, 0])
        by_skin = pins.by_skin(under[:, 1:]).transpose(1, 2, 0, 3)
        n_values = n_shared + len(OWN)
        columns = np.zeros((n_values + n_frames, n_frames, 2, self.n_pins))
        of_world = [0, n_shared, n_shared + 1, *range(first, first + bends)]
        columns[of_world] = by_skin[:-1]
        for k, step in _STEPS.items():
            shared, own = state.shared.copy(), state.own.copy()
            if k < n_shared:
                shared[k] += step
            else:
                own[k - n_shared] += step
            # only another view sees a pin in another direction
            other = self._around(replace(state, shared=shared, own=own), None if k < n_shared else around.directions)
            columns[k] = pins.by_view(other, step).swapaxes(0, 1)
        columns[n_values + np.arange(n_frames), np.arange(n_frames)] = by_skin[-1]
        columns -= columns.mean(axis=-1, keepdims=True)
        columns -= self._rest_share * columns.mean(axis=1, keepdims=True)
        here = pins.moved_px.transpose(1, 2, 0)
        left = (self.seen - self.whitened(here - here.mean(axis=1, keepdims=True))).swapaxes(1, 2)
        every = self._without_pulls(np.concatenate([left[None], columns]), around, state.radius_mm)
        return every[0], every[1:].T

    def left_over_px(self, state: State, z: Array) -> Array:
        """(K,) root mean square left over, px, where z is held at each of K values and the rest of what one press alone
        knows is fitted again."""
        first = len(SHARED) + 1
        inverse = np.linalg.pinv(self.linearised(state)[1][:, first:])
        left = []
        for each in z:
            held = replace(state, own=np.append(each, state.own[1:]))
            for _ in range(_FITS):
                residual = self.left(held)
                step = inverse @ residual
                own, radius_mm = held.own[1:] + step[: len(OWN) - 1], held.radius_mm + step[len(OWN) - 1 :]
                held = State(state.shared, np.append(each, own), np.maximum(radius_mm, LEAST_RADIUS_MM))
            left.append(float(np.sqrt(residual @ residual / (residual.size - self.n_of_frames))))
        return np.array(left)

    @cached_property
    def _undisturbed(self) -> PinsAroundAxis:
        return self._around(_UNDISTURBED)

    def started(self, worlds: Sequence[TableWorld]) -> list[tuple[State, float]]:
        """For each of the worlds the state in which each frame has the radius that suits it best; cost, px^2."""
        seen, states = self._moved.reshape(self.n_frames, -1), []
        for world in worlds:
            every = self._moved_by(world.motion, self._undisturbed).reshape(world.radius_mm.size, -1)
            cost = (every**2).sum(axis=1) - 2 * seen @ every.T
            rising = np.maximum.accumulate(world.radius_mm[np.argmin(cost, axis=1)])
            shared, own = _UNDISTURBED.shared.copy(), _UNDISTURBED.own.copy()
            shared[0], own[0] = world.place, world.z
            states.append((State(shared, own, rising), float((cost.min(axis=1) + (seen**2).sum(axis=1)).sum())))
        return states


def _at_radii(family: Family, weights: Array, at_mm: Array) -> tuple[Array, Array]:
    """(3, ..., T, S) motion of worlds by weights (..., K) at radii (T,), and its slope, per mm."""
    radius_mm = family.radius_mm
    row, share, per_mm = _between(at_mm, radius_mm[0], radius_mm[1] - radius_mm[0], radius_mm.size)
    first = int(row.min())
    motion = family.motion(weights, first, int(row.max()) + 2)
    low, high = (np.ascontiguousarray(np.moveaxis(motion[..., row - first + k, :, :], -1, 0)) for k in (0, 1))
    return low + (high - low) * share[:, None], (high - low) * per_mm[:, None]


def _spread(frames: Rows) -> Rows:
    """Indices of the frames that are used, spread over all."""
    return np.unique(frames[np.linspace(0, len(frames) - 1, MOST_FRAMES).round().astype(np.intp)])


def _between(at: Array, first: float, step: float, count: int) -> tuple[NDArray[np.intp], Array, Array]:
    """Rows of an even grid at or below ``at``, the share of the way to the next, and its slope, 0 beyond the grid."""
    place = (at - first) / step
    inside = np.clip(place, 0, count - 1.000001)
    row = inside.astype(np.intp)
    return row, inside - row, np.where(place == inside, 1 / step, 0.0)
