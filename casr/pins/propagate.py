"""Match pins over motions beyond half a pitch: what the neighbours did tells which of two pins is the right one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from casr.pins.lattice import match_pins

SEED_REACH, GROWTH_REACH = 0.2, 0.35  # of the spacing: how close a pin must be to its guess, to its neighbours' motion
ENOUGH_NEIGHBOURS = 3
MOST_ISLANDS = 8
BINS_PER_PITCH = 8
FARTHEST_KNOCK = 4  # pitches that all pins may jump alike between two frames
MOST_SHIFTS = 8

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Where pins were, those of the next frame, and who is beside whom.

    before_px : (N, 2). after_px : (M, 2). beside : (N, k) rows of each pin's neighbours. spacing_px : (N,) distance to
    the nearest. shape : (height, width) of the frame.
    """

    before_px: Points
    after_px: Points
    beside: NDArray[np.intp]
    spacing_px: NDArray[np.float64]
    shape: tuple[int, ...]

    def followed(self, guesses_px: Iterable[Points]) -> NDArray[np.intp]:
        """Row of ``after_px`` for each pin, -1 where there is none; no row twice.

        Pins close to where they are expected are matched first; then the motion is handed on to those beside them, ring
        by ring, so that a motion that changes slowly over the skin may end up far above half a pitch. A lattice also
        fits itself one pitch further, all but its edge: of all ways to begin, each guess from every island of pins that
        fit, the one is kept, the first on a tie, that leaves fewest pins unexplained: pins that should be in view and
        are not found, and pins of the next frame that nobody claims.

        guesses_px : each (N, 2), where the pins may be now.
        """
        best = np.full(len(self.before_px), -1, np.intp)
        fewest = len(self.before_px) + len(self.after_px)
        for guess in guesses_px:
            pins, hits = match_pins(guess, self.after_px, max_distance_px=SEED_REACH * self.spacing_px)
            for island in _islands(pins, self._links):
                rows = np.full(len(self.before_px), -1, np.intp)
                rows[pins[island]] = hits[island]
                self._grow(rows)
                unexplained = self._unexplained(rows)
                if unexplained < fewest:
                    best, fewest = rows, unexplained
                if (best >= 0).all():
                    return best
        return best

    @cached_property
    def _links(self) -> NDArray[np.bool_]:
        """(N, N) whether a pin is beside another."""
        links = np.zeros((len(self.beside), len(self.beside)), np.bool_)
        np.put_along_axis(links, self.beside, True, axis=1)
        return links

    def _expected(self, rows: NDArray[np.intp]) -> Points:
        """Where each pin should be by the motion of those beside it that have a row."""
        known = rows >= 0
        move = np.where(known[:, None], self.after_px[rows] - self.before_px, 0.0)
        return np.asarray(self.before_px + neighbour_mean(move, known, self.beside))

    def _unexplained(self, rows: NDArray[np.intp]) -> int:
        """Pins that ought to be in view but have no row, and rows that no pin has."""
        found, expected = rows >= 0, self._expected(rows)
        margin = self.spacing_px[:, None] / 2
        in_view = ((expected > margin) & (expected < np.array(self.shape[1::-1]) - 1 - margin)).all(axis=1)
        return int((~found & in_view).sum()) + len(self.after_px) - int(found.sum())

    def _grow(self, rows: NDArray[np.intp]) -> None:
        """Fill in the rows (N,) of pins beside those that have one, until no more fit."""
        while True:
            known = rows >= 0
            support = np.where(known, 0, known[self.beside].sum(axis=1))
            if not support.any():
                return
            ready = np.flatnonzero(support >= min(ENOUGH_NEIGHBOURS, support.max()))
            taken = np.zeros(len(self.after_px), np.bool_)
            taken[rows[known]] = True
            free = np.flatnonzero(~taken)
            reach_px = GROWTH_REACH * self.spacing_px[ready]
            pins, hits = match_pins(self._expected(rows)[ready], self.after_px[free], max_distance_px=reach_px)
            if not pins.size:
                return
            rows[ready[pins]] = free[hits]


def _islands(pins: NDArray[np.intp], links: NDArray[np.bool_]) -> list[NDArray[np.bool_]]:
    """The largest sets of pins (as masks of ``pins``) in which each is beside another, largest first."""
    beside = links[np.ix_(pins, pins)]
    beside |= beside.T
    left = np.ones(len(pins), bool)
    islands = []
    while left.any():
        island = np.zeros(len(pins), bool)
        island[left.argmax()] = True
        while (grown := (island | (beside @ island)) & left).sum() > island.sum():
            island = grown
        islands.append(island)
        left &= ~island
    return sorted(islands, key=lambda island: -int(island.sum()))[:MOST_ISLANDS]


def neighbour_mean(move_px: Points, known: NDArray[np.bool_], beside: NDArray[np.intp]) -> Points:
    """Mean motion (N, 2) of the known neighbours of each pin, whose rows are (N, k); its own where none is known."""
    move = np.ascontiguousarray(move_px).view(np.complex128)[:, 0]  # x + iy: one sum for both
    if known.all():
        return _as_points(np.add.reduce(move[beside], axis=1) / beside.shape[1])
    count = np.add.reduce(known[beside], axis=1, dtype=np.intp)
    total = np.add.reduce((move * known)[beside], axis=1)
    return _as_points(np.where(count > 0, total / np.maximum(count, 1), move))


def _as_points(complex_px: NDArray[np.complex128]) -> Points:
    """(N, 2) x, y of (N,) x + iy."""
    return complex_px.view(np.float64).reshape(-1, 2)


def common_shifts_px(before_px: Points, after_px: Points, pitch_px: float) -> NDArray[np.float64]:
    """Shifts (k, 2) of up to four pitches that most pairs of pins agree on, most first: a vote over all pairs.

    A lattice agrees with itself again one pitch further, so there are several.
    """
    shift = (after_px[None, :] - before_px[:, None]).reshape(-1, 2)
    reach = FARTHEST_KNOCK * BINS_PER_PITCH
    n = 2 * reach + 1
    cell = np.rint(shift / pitch_px * BINS_PER_PITCH).astype(np.intp) + reach
    inside = ((cell >= 0) & (cell < n)).all(axis=1)
    shift, cell = shift[inside], cell[inside]
    votes = np.bincount(cell @ (n, 1), minlength=n * n).reshape(n, n)
    padded = np.pad(votes, 1)
    around = np.stack([padded[i : i + n, j : j + n] for i in range(3) for j in range(3)]).sum(axis=0)
    found: list[NDArray[np.float64]] = []
    while around.any() and len(found) < MOST_SHIFTS:
        best = np.array(np.unravel_index(around.argmax(), (n, n)))
        found.append(np.median(shift[(np.abs(cell - best) <= 1).all(axis=1)], axis=0))
        (y0, x0), (y1, x1) = np.maximum(best - BINS_PER_PITCH // 2, 0), best + BINS_PER_PITCH // 2 + 1
        around[y0:y1, x0:x1] = 0
    return np.array(found).reshape(-1, 2)
