"""All presses of a sensor under one dome: for each press z of its specimen by the pins, with the joint covariance.

Gauss-Newton with damping on all parameters at once. The contact radii, and what one press alone knows, are eliminated
press by press, so that the work grows with the number of presses only.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from casr.kappa.family import Family
from casr.kappa.field import BENDS, LEAST_RADIUS_MM, OWN, SHARED, PressField, State, TableWorld

Array = NDArray[np.float64]

DEPTH_SD_OF_SENSOR, DEPTH_SD_OF_MOUNTING = 0.01, 0.007
"Relative, of what camera.toml says, and of one mounting about it."
BEND_SD = 0.3
"SD of a share of ``Family.bends``: a dome that is left out differs by 1, with neighbours twice as far away."
_PLACE, PLACE_SD = 0.5, 0.6
_OWN, _OWN_SD = np.array([0.5, 0.5, 0.0, 0.0]), np.array([1.0, 0.5, 0.5, 0.5])
_PLACES, _ZS = (0.05, 0.25, 0.45, 0.65, 0.85), (0.08, 0.25, 0.5)
_ROUNDS, _FOUND = 12, 2e-3
_RESTLESS = 0.4549 * 6
"Median of a squared second difference of white noise, over its variance."


@dataclass(frozen=True)
class SensorErrors:
    """Standard errors of what is stated of a sensor. pin_length_mm. pole_px : of where the dome's axis meets the image.

    In millimetres of a dome of 20 mm.
    """

    pin_length_mm: float = 0.1
    pole_px: float = 1.0
    depth: float = DEPTH_SD_OF_SENSOR

    def prior(self, mountings: Sequence[str]) -> tuple[Array, Array]:
        """See ``Sensor``: (S + M,) and (S + M, S + M), diagonal."""
        sd = [PLACE_SD, self.pin_length_mm, self.depth, self.pole_px, self.pole_px, *[BEND_SD] * len(BENDS)]
        sd += [DEPTH_SD_OF_MOUNTING] * len(mountings)
        return np.append(_PLACE, np.zeros(len(sd) - 1)), np.diag(np.array(sd, dtype=np.float64) ** -2)


class Sensor(Protocol):
    """What is known of a sensor before its presses."""

    def prior(self, mountings: Sequence[str]) -> tuple[Array, Array]:
        """Mean (S + M,) and precision (S + M, S + M) of ``SHARED`` and of the depth of each of these M mountings."""


@dataclass(frozen=True, eq=False)
class Part:
    """One press of K parameters beside its radii: what the press adds to the precision (K, K) of them and pulls at them
    (K,), at noise of 1 px, and into (K, G) them from all parameters."""

    squares: Array
    pull: Array
    into: Array

    @property
    def precision(self) -> Array:
        """(G, G) of all parameters."""
        return np.asarray(self.into.T @ self.squares @ self.into)


@dataclass(frozen=True, eq=False)
class Labels:
    """P presses of a sensor under one dome.

    sensor : values of ``SHARED`` for the sensor. states : of each press. fields : of each press.
    mean, precision : (G,), (G, G) of all parameters but the radii: those of the sensor, depths of mountings, then
        ``OWN`` of each press. own_at : (P,) where those of each press begin. mountings : names of them.
    radius_by : of each press (T, G), derivative of its radii by these parameters.
    noise_px : white noise of a pin. misfit_px, moved_px : root mean square left over, noise in it, and of the motion.
    white_precision : (G, G) were white noise all that is left over.
    prior : mean and precision of all before the presses. parts : of each press what it adds, see ``Part``.
    """

    family: Family
    fields: tuple[PressField, ...]
    states: tuple[State, ...]
    mean: Array
    precision: Array
    own_at: NDArray[np.intp]
    mountings: tuple[str, ...]
    radius_by: tuple[Array, ...]
    noise_px: float
    misfit_px: float
    moved_px: float
    white_precision: Array
    prior: tuple[Array, Array]
    parts: tuple[Part, ...]

    def among(self, kept: Sequence[int]) -> Labels:
        """What some of the presses say alone, linearised where all of them are fitted."""
        mountings = tuple(name for name in self.mountings if name in {self.fields[k].press.mounting for k in kept})
        shared = [*range(len(SHARED)), *(len(SHARED) + self.mountings.index(name) for name in mountings)]
        at = np.concatenate([shared, *(self.own_at[k] + np.arange(len(OWN)) for k in kept)]).astype(np.intp)
        prior_mean, prior = self.prior[0][at], self.prior[1][np.ix_(at, at)]
        parts = [Part(each.squares, each.pull, each.into[:, at]) for each in (self.parts[k] for k in kept)]
        px, mean = self.misfit_px, self.mean[at]
        precision = prior + sum(each.precision for each in parts) / px**2
        pull = prior @ (prior_mean - mean) + sum(each.into.T @ each.pull for each in parts) / px**2
        step = np.linalg.solve(precision, pull)
        radius_by = tuple(self.radius_by[k][:, at] for k in kept)
        radii = [self.states[k].radius_mm + by @ step for k, by in zip(kept, radius_by, strict=True)]
        return replace(
            self, fields=tuple(self.fields[k] for k in kept), mean=mean + step, precision=precision,
            states=tuple(_state(each.into @ (mean + step), radius) for each, radius in zip(parts, radii, strict=True)),
            own_at=len(shared) + len(OWN) * np.arange(len(kept)), mountings=mountings, radius_by=radius_by,
            white_precision=prior + sum(each.precision for each in parts) / self.noise_px**2,
            prior=(prior_mean, prior), parts=tuple(parts),
        )  # fmt: skip

    @property
    def z(self) -> Array:
        """(P,) label of each press."""
        return np.asarray(self.mean[self.own_at])

    @property
    def misfit(self) -> float:
        """Share of the motion left over beyond noise."""
        return float(np.sqrt(max(self.misfit_px**2 - self.noise_px**2, 0.0))) / self.moved_px


def labelled(
    fields: Sequence[PressField],
    sensor: Sensor,
    *,
    thorough: bool = False,
    least_misfit_px: float = 0.0,
    start: Labels | None = None,
) -> Labels:
    """Fit all presses of a sensor by the worlds of one family.

    thorough : from several places of the family, of which the best fit is taken: where the sensor is hardly known.
    least_misfit_px : root mean square, px, that they are taken to leave over.
    start : of the same presses, with fewer frames perhaps.
    """
    starts = [(place,) for place in _PLACES] if thorough else [_PLACES]
    fits = [_Fit(fields, sensor, least_misfit_px).result(each, start) for each in starts]
    return min(fits, key=lambda each: each.misfit_px)


class _Fit:
    def __init__(self, fields: Sequence[PressField], sensor: Sensor, least_misfit_px: float) -> None:
        self._fields, self._family, self._least_px = fields, fields[0].family, least_misfit_px
        self._mountings = sorted({field.press.mounting for field in fields})
        n_sensor, n_mount = len(SHARED), len(self._mountings)
        self._own_at = n_sensor + n_mount + len(OWN) * np.arange(len(fields))
        mean, precision = sensor.prior(self._mountings)
        self._prior = np.append(mean, np.tile(_OWN, len(fields)))
        self._prior_precision = np.diag(np.append(np.zeros(mean.size), np.tile(_OWN_SD, len(fields)) ** -2))
        self._prior_precision[: mean.size, : mean.size] = precision
        self._maps = [self._map(k) for k in range(len(fields))]

    def _map(self, press: int) -> Array:
        """(9, G) from all parameters to those of ``SHARED`` and ``OWN`` of a press."""
        into = np.zeros((len(SHARED) + len(OWN), self._prior.size))
        into[np.arange(len(SHARED)), np.arange(len(SHARED))] = 1
        mounting = self._mountings.index(self._fields[press].press.mounting)
        into[SHARED.index("log_depth"), len(SHARED) + mounting] = 1
        rows = len(SHARED) + np.arange(len(OWN))
        into[rows, self._own_at[press] + np.arange(len(OWN))] = 1
        return into

    def _start(self, places: Sequence[float], labels: Labels | None) -> tuple[Array, list[Array]]:
        if labels is not None:
            before = zip(self._fields, labels.fields, labels.states, strict=True)
            return labels.mean, [_followed(new, old, state) for new, old, state in before]
        best = self._best_start(places)
        at = self._prior.copy()
        at[0] = best[0][0].shared[0]
        for where, (state, _) in zip(self._own_at, best, strict=True):
            at[where : where + len(OWN)] = state.own
        return at, [state.radius_mm for state, _ in best]

    def _best_start(self, places: Sequence[float]) -> list[tuple[State, float]]:
        """For each press the state and cost that it begins with, at the place where all presses together cost least.

        The next press is always tried at the place that is cheapest so far: a place that is the cheapest with all
        presses is so for good, as no press makes one cheaper.
        """
        worlds = [[TableWorld.of(self._family, place, z) for z in _ZS] for place in places]
        tried: list[list[tuple[State, float]]] = [[] for _ in places]
        cost = [0.0 for _ in places]
        while len(tried[cheapest := cost.index(min(cost))]) < len(self._fields):
            field = self._fields[len(tried[cheapest])]
            found = min(field.started(worlds[cheapest]), key=lambda each: each[1])
            tried[cheapest].append(found)
            cost[cheapest] += found[1]
        return tried[cheapest]

    def _states(self, at: Array, radii: Sequence[Array]) -> list[State]:
        return [_state(into @ at, radius_mm) for into, radius_mm in zip(self._maps, radii, strict=True)]

    def _cost(self, at: Array, left: Iterable[Array], noise_px: float) -> float:
        """left : residuals of each press, px."""
        squares = sum(float(residual @ residual) for residual in left)
        return squares / noise_px**2 + float((at - self._prior) @ self._prior_precision @ (at - self._prior))

    def result(self, places: Sequence[float], start: Labels | None) -> Labels:
        """Gauss-Newton from ``start``, or else from the best of these places."""
        at, radii = self._start(places, start)
        # frames that came and went with the state would let a press that goes on alternate between two answers
        last = [field.last for field in (start.fields if start else self._fields)]
        every = zip(self._fields, self._states(at, radii), last, strict=True)
        pairs = [field.within_tables(state, end) for field, state, end in every]
        self._fields, radii = [field for field, _ in pairs], [state.radius_mm for _, state in pairs]
        if start and all(np.array_equal(a.frames, b.frames) for a, b in zip(self._fields, start.fields, strict=True)):
            return start
        damping, noise_px = 1e-2, 0.1
        count = sum(field.seen.size for field in self._fields)
        for round_ in range(_ROUNDS):
            seen_from = at
            states = self._states(at, radii)
            lines = [field.linearised(state) for field, state in zip(self._fields, states, strict=True)]
            noise_px = max(float(np.sqrt(sum(float(r @ r) for r, _ in lines) / count)), self._least_px)
            sums = [_reduced(*line) for line in lines]
            before = self._cost(at, (residual for residual, _ in lines), noise_px)
            for _ in range(6):
                precision, gradient = self._normal(sums, at, noise_px)
                step = np.linalg.solve(precision + damping * np.diag(np.diag(precision)), gradient)
                new_at = self._bounded(at + step)
                new_radii = [
                    np.clip(radius + given + by @ into @ (new_at - at), LEAST_RADIUS_MM, self._family.radius_mm[-1])
                    for radius, (_, _, given, by), into in zip(radii, sums, self._maps, strict=True)
                ]
                states = self._states(new_at, new_radii)
                left = (field.left(state) for field, state in zip(self._fields, states, strict=True))
                after = self._cost(new_at, left, noise_px)
                if after <= before:
                    break
                damping *= 10
            else:
                break
            moved = float(np.abs(new_at - at)[[0, *self._own_at]].max())
            at, radii, damping = new_at, new_radii, max(damping / 10, 1e-7)
            if moved < _FOUND and round_ > (start is None):
                break
        return self._labels(at, radii, lines, sums, seen_from)

    def _bounded(self, at: Array) -> Array:
        at = at.copy()
        at[0] = np.clip(at[0], -0.25, 1.35)
        at[self._own_at] = np.clip(at[self._own_at], 1e-3, 0.97)
        at[self._own_at + 1] = np.clip(at[self._own_at + 1], 0.0, 1.0)
        return at

    def _normal(self, sums: Sequence[Reduced], at: Array, noise_px: float) -> tuple[Array, Array]:
        precision, gradient = self._prior_precision.copy(), self._prior_precision @ (self._prior - at)
        for (own, slope, _, _), into in zip(sums, self._maps, strict=True):
            precision += into.T @ own @ into / noise_px**2
            gradient += into.T @ slope / noise_px**2
        return precision, gradient

    def _labels(
        self,
        at: Array,
        radii: Sequence[Array],
        lines: Sequence[tuple[Array, Array]],
        sums: Sequence[Reduced],
        seen_from: Array,
    ) -> Labels:
        """lines : residuals and derivatives ``seen_from`` where or beside which the states were found; sums of them."""
        states = self._states(at, radii)
        squares = sum(float(r @ r) for r, _ in lines)
        count = sum(r.size - field.n_of_frames for (r, _), field in zip(lines, self._fields, strict=True))
        misfit_px = float(np.sqrt(squares / count))
        noise_px = min(_noise(lines, self._fields), misfit_px)
        precision, _ = self._normal(sums, at, max(misfit_px, self._least_px))
        moved = float(np.sqrt(np.mean([field.moved_px**2 for field in self._fields])))
        return Labels(
            family=self._family, fields=tuple(self._fields), states=tuple(states), mean=at, precision=precision,
            own_at=self._own_at, mountings=tuple(self._mountings),
            radius_by=tuple(by @ into for (_, _, _, by), into in zip(sums, self._maps, strict=True)),
            noise_px=noise_px, misfit_px=misfit_px, moved_px=moved,
            white_precision=self._normal(sums, at, noise_px)[0], prior=(self._prior, self._prior_precision),
            parts=tuple(
                Part(own, slope - own @ into @ (at - seen_from), into)
                for (own, slope, _, _), into in zip(sums, self._maps, strict=True)
            ),
        )  # fmt: skip


def _state(values: Array, radius_mm: Array) -> State:
    """values : of ``SHARED`` and ``OWN``."""
    return State(values[: len(SHARED)], values[len(SHARED) :], radius_mm)


def _followed(field: PressField, before: PressField, state: State) -> Array:
    """Radii of a press that has gone on since ``before``."""
    known, new = np.interp(field.frames, before.frames, state.radius_mm), field.frames > before.frames[-1]
    if new.any():
        world = TableWorld.of(field.family, float(state.shared[0]), float(state.own[0]), known[-1])
        ((begun, _),) = field.started([world])
        known[new] = begun.radius_mm[new]
    return known


Reduced = tuple[Array, Array, Array, Array]
"""One press of K parameters, its radii eliminated: (K, K) squares and (K,) products of derivatives; (T,) change of the
radii where the parameters stay, and (T, K) by the parameters.
"""


def _reduced(residual: Array, by: Array) -> Reduced:
    n = len(SHARED) + len(OWN)
    squares, products = by.T @ by, by.T @ residual
    of_radii = squares[n:, n:] + 1e-9 * np.trace(squares[n:, n:]) * np.eye(len(squares) - n)
    solved = np.linalg.solve(of_radii, np.column_stack([squares[n:, :n], products[n:]]))
    across, given = solved[:, :-1], solved[:, -1]
    return squares[:n, :n] - squares[:n, n:] @ across, products[:n] - squares[:n, n:] @ given, given, -across


def _noise(lines: Sequence[tuple[Array, Array]], fields: Sequence[PressField]) -> float:
    """White noise of a pin, px, by second differences of residuals from frame to frame."""
    bends = [
        np.diff(r.reshape(field.n_frames, -1), 2, axis=0).ravel() for (r, _), field in zip(lines, fields, strict=True)
    ]
    return float(np.sqrt(np.median(np.concatenate(bends) ** 2) / _RESTLESS))
