"""Pins of one press under the forward model: what they should do in a world, and how that changes with it.

Parameters of a press are those of ``SHARED`` (of the sensor, or of a mounting of it), those of ``OWN``, and the contact
radius in each frame. A shift of all pins in a frame is left out; so is the noise that the rest frame gives to all
frames alike (``whitened``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from casr.dome.library import FAMILY
from casr.dome.view import DomeView
from casr.kappa.family import Family
from casr.kappa.presses import FEWEST_FRAMES, KappaPress

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

MOST_FRAMES = 14

OF_VIEW = ("place", "pin_length_mm", "log_depth", "pole_x_px", "pole_y_px")
BENDS = tuple(f"bend_{k}" for k in range(len(FAMILY) - 2))
"Shares of the ways in which a dome may lie beside its family; those that a family does not have stay 0."
SHARED = (*OF_VIEW, *BENDS)
OWN = ("z", "stick", "across_1_rad", "across_2_rad")
_STEPS = {
    "place": 0.004, "pin_length_mm": 0.02, "log_depth": 0.003, "pole_x_px": 0.3, "pole_y_px": 0.3,
    **dict.fromkeys(BENDS, 0.05), "z": 0.002, "stick": 0.05, "across_1_rad": 0.003, "across_2_rad": 0.003,
}  # fmt: skip
_RADIUS_STEP_MM, _FITS = 0.05, 4
LEAST_RADIUS_MM = 1.0


@dataclass(frozen=True, eq=False)
class State:
    """A point in the space of parameters. shared, own : values by the names above. radius_mm : (T,)."""

    shared: Array
    own: Array
    radius_mm: Array


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
        field = PressField(self.press, self._view, self.family, frames)
        field.last = last
        return field, replace(state, radius_mm=np.interp(frames, self.frames, state.radius_mm))

    @property
    def moved_px(self) -> float:
        """Root mean square motion of the pins, px."""
        return float(np.sqrt((self._moved**2).mean()))

    def whitened(self, moved: Array) -> Array:
        """(T, N, 2) with errors that are alike and independent, for the noise of pins at rest and in contact."""
        return np.asarray(moved - self._rest_share * moved.mean(axis=0))

    def predicted(self, state: State) -> Array:
        """(T, N, 2) motion, px, without a common shift."""
        return self._motion_px(state, self._profile(state))

    def _profile(self, state: State) -> Array:
        z, stick = state.own[:2]
        bend = state.shared[len(OF_VIEW) :][: len(self.family.bends)]
        return self.family.motion(self.family.world(state.shared[0], z, stick, 0.0, bend).motion)

    def _view_at(self, shared: Array) -> DomeView:
        view = self._view
        return replace(
            view, pin_length_mm=view.pin_length_mm + shared[1], depth_mm=view.depth_mm * np.exp(shared[2]),
            pole_px=(view.pole_px[0] + shared[3], view.pole_px[1] + shared[4]),
        )  # fmt: skip

    def _motion_px(self, state: State, profile: Array) -> Array:
        view = self._view_at(state.shared)
        axis = self._axis + state.own[2:] @ self._across
        around = view.around(view.directions(self._rest_px), axis / np.linalg.norm(axis))
        arc_mm, radius_mm = self.family.arc_mm, self.family.radius_mm
        row, share = _between(state.radius_mm, radius_mm[0], radius_mm[1] - radius_mm[0], radius_mm.size)
        of_frames = profile[row] * (1 - share)[:, None, None] + profile[row + 1] * share[:, None, None]
        row, share = _between(around.arc_mm, 0.0, arc_mm[1], arc_mm.size)
        motion = of_frames[:, row] * (1 - share)[:, None] + of_frames[:, row + 1] * share[:, None]  # (T, N, 3)
        moved = around.moved_px(*motion.transpose(2, 1, 0)).transpose(2, 0, 1)
        return np.asarray(moved - moved.mean(axis=1, keepdims=True))

    def linearised(self, state: State) -> tuple[Array, Array]:
        """(M,) residuals, px, and (M, 9 + T) their derivatives by shared and own parameters and radii."""
        profile = self._profile(state)
        here = self._motion_px(state, profile)
        columns = np.empty((len(SHARED) + len(OWN) + self.n_frames, here.size))
        for k, name in enumerate((*SHARED, *OWN)):
            if name in BENDS[len(self.family.bends) :]:
                columns[k] = 0
                continue
            step, values = _STEPS[name], np.concatenate([state.shared, state.own])
            values[k] += step
            other = State(values[: len(SHARED)], values[len(SHARED) :], state.radius_mm)
            new = profile if name in OF_VIEW[1:] or name in OWN[2:] else self._profile(other)
            columns[k] = self.whitened((self._motion_px(other, new) - here) / step).ravel()
        wider = replace(state, radius_mm=state.radius_mm + _RADIUS_STEP_MM)
        by_radius = (self._motion_px(wider, profile) - here) / _RADIUS_STEP_MM
        of_frame = np.zeros((self.n_frames, *here.shape))
        of_frame -= self._rest_share * by_radius[:, None] / self.n_frames
        of_frame[np.arange(self.n_frames), np.arange(self.n_frames)] += by_radius
        columns[len(SHARED) + len(OWN) :] = of_frame.reshape(self.n_frames, -1)
        return (self.seen - self.whitened(here)).ravel(), columns.T

    def left_over_px(self, state: State, z: Array) -> Array:
        """(K,) root mean square left over, px, where z is held at each of K values and the rest of what one press alone
        knows is fitted again."""
        first = len(SHARED) + 1
        inverse = np.linalg.pinv(self.linearised(state)[1][:, first:])
        left = []
        for each in z:
            held = replace(state, own=np.append(each, state.own[1:]))
            for _ in range(_FITS):
                residual = (self.seen - self.whitened(self.predicted(held))).ravel()
                step = inverse @ residual
                own, radius_mm = held.own[1:] + step[: len(OWN) - 1], held.radius_mm + step[len(OWN) - 1 :]
                held = State(state.shared, np.append(each, own), np.maximum(radius_mm, LEAST_RADIUS_MM))
            left.append(float(np.sqrt(residual @ residual / (residual.size - self.n_frames))))
        return np.array(left)

    def started(self, place: float, z: float) -> tuple[State, float]:
        """The state in which each frame has the radius, out of those of the tables, that suits it best; cost, px^2."""
        state = State(np.append(place, np.zeros(len(SHARED) - 1)), np.array([z, 0.5, 0, 0]), self.family.radius_mm)
        every = self._motion_px(state, self._profile(state)).reshape(state.radius_mm.size, -1)
        seen = self._moved.reshape(self.n_frames, -1)
        cost = (every**2).sum(axis=1) - 2 * seen @ every.T
        best = np.argmin(cost, axis=1)
        rising = np.maximum.accumulate(state.radius_mm[best])
        return replace(state, radius_mm=rising), float((cost.min(axis=1) + (seen**2).sum(axis=1)).sum())


def _spread(frames: Rows) -> Rows:
    """As many of the frames as are used, spread over all."""
    return np.unique(frames[np.linspace(0, len(frames) - 1, MOST_FRAMES).round().astype(np.intp)])


def _between(at: Array, first: float, step: float, count: int) -> tuple[NDArray[np.intp], Array]:
    """Rows of an even grid at or below ``at``, and the share of the way to the next."""
    place = np.clip((at - first) / step, 0, count - 1.000001)
    row = place.astype(np.intp)
    return row, place - row
