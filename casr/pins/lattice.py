"""The lattice of pins: neighbours, pitch and one-to-one matches; its kind, its sites without a pin, pins beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.errors import PinsError
from casr.median import median

NEIGHBOURS = 6  # of a hexagonal lattice; of a square one, those at one pitch and two of the corners
BORDER_GAP_DEG = 150.0


def nearest_pins(points_px: NDArray[np.float64], k: int) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Distance (N, k) px and row number (N, k) of the ``k`` nearest other pins, nearest first, of two or
    more; k falls to N - 1."""
    k = min(k, len(points_px) - 1)
    squared = _squared_distance(points_px, points_px)
    np.fill_diagonal(squared, np.inf)
    near = np.argpartition(squared, k - 1, axis=1)[:, :k]
    near_squared = np.take_along_axis(squared, near, axis=1)
    order = np.argsort(near_squared, axis=1, kind="stable")
    return np.sqrt(np.take_along_axis(near_squared, order, axis=1)), np.take_along_axis(near, order, axis=1)


def at_border(points_px: NDArray[np.float64], beside: NDArray[np.intp]) -> NDArray[np.bool_]:
    """(N,) pins with none beside them over ``BORDER_GAP_DEG``, from the rows (N, k) of each pin's neighbours.

    In any lattice the neighbours of a pin inside stand all around it, also where one of them is missing.
    """
    towards = points_px[beside] - points_px[:, None]
    angle = np.sort(np.arctan2(towards[..., 1], towards[..., 0]), axis=1)
    gap = np.diff(angle, axis=1, append=angle[:, :1] + 2 * np.pi)
    return np.asarray(gap.max(axis=1) > np.deg2rad(BORDER_GAP_DEG))


def _squared_distance(a_px: NDArray[np.float64], b_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Squared distance (N, M) px² of every point of ``a_px`` (N, 2) to every point of ``b_px`` (M, 2)."""
    dx, dy = a_px[:, None, 0] - b_px[:, 0], a_px[:, None, 1] - b_px[:, 1]
    squared: NDArray[np.float64] = dx * dx + dy * dy
    return squared


def pin_pitch_px(centroids_px: NDArray[np.float64]) -> float:
    """Pin spacing: median distance to the nearest pin, px, of (N, 2) px; NaN rows are left out; NaN below two pins."""
    points = np.asarray(centroids_px, float)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 2:
        return float("nan")
    squared = _squared_distance(points, points)
    np.fill_diagonal(squared, np.inf)
    return float(median(np.sqrt(squared.min(axis=1))))


def match_pins(
    before_px: NDArray[np.float64], after_px: NDArray[np.float64], *, max_distance_px: float | NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of rows (i_before, i_after) that are each other's nearest pin and at most ``max_distance_px`` apart.

    Where two pins claim the same one, the nearer gets it and the other stays unmatched: a second choice would be
    a guess. Half the pitch is the largest sensible distance. Among equals the lower row wins. NaN rows match nothing.
    The paper's Algorithm 1 compares all pairs instead, which selects nearly every pin.

    before_px, after_px : (N, 2), (M, 2) centroids.
    max_distance_px : one distance, or one for each row of ``before_px``.
    """
    rows = np.flatnonzero(np.isfinite(before_px).all(axis=1))
    columns = np.flatnonzero(np.isfinite(after_px).all(axis=1))
    if not rows.size or not columns.size:
        return np.empty(0, np.intp), np.empty(0, np.intp)
    squared = _squared_distance(before_px[rows], after_px[columns])
    nearest = squared.argmin(axis=1)
    own = np.arange(rows.size)
    limit = np.broadcast_to(np.asarray(max_distance_px, float), (len(before_px),))[rows]
    mutual = (squared.argmin(axis=0)[nearest] == own) & (squared[own, nearest] <= limit**2)
    return rows[mutual], columns[nearest[mutual]]


Kind = Literal["hexagonal", "square"]
Points = NDArray[np.float64]

RING_PITCHES = 1.3  # the pins beside one, over the distance of the nearest: 1.41 is a corner of a square
TURN_DEG = {"hexagonal": 60.0, "square": 90.0}  # from one neighbour to the next
STEPS = {"hexagonal": ((1, 0), (0, 1), (1, -1)), "square": ((1, 0), (0, 1), (1, 1), (1, -1))}  # and back
WITHIN_PITCHES = 0.3  # how near a site a pin must be
LEARN_FROM = 18  # nearest pins that tell what the lattice is like around one
TRUST_BEFORE = 1.0  # steps' worth of what is taken over from the neighbour
FEWEST_FOR_LATTICE = 7
ON_LATTICE = 0.7  # share of the pins from which on there is a lattice
FAR_OFF = 0.25  # a count that differs by a larger share from the one expected is an error


def lattice_kind(points_px: Points) -> Kind:
    """Whether the pins (N, 2), at least seven and none NaN, stand on a hexagonal or a square lattice.

    By the directions from each to those beside it, which repeat after 60 or after 90 degrees, missing or not.
    """
    distance, row = nearest_pins(points_px, NEIGHBOURS)
    ways = points_px[row] - points_px[:, None]
    beside = distance <= RING_PITCHES * distance[:, :1]
    angle = np.arctan2(ways[..., 1], ways[..., 0])
    n = beside.sum(axis=1)
    six, four = (np.abs((np.exp(1j * fold * angle) * beside).sum(axis=1)) / n for fold in (6, 4))
    told = n > 1
    return "square" if told.any() and four[told].mean() > six[told].mean() else "hexagonal"


@dataclass(frozen=True)
class Sites:
    """What the lattice says of the pins: sites inside it that show none, and pins that stand on no site."""

    n_empty: int
    n_beside: int


def lattice_sites(points_px: Points) -> Sites:
    """Walk from a pin in the middle to its neighbours and on, with a pitch that may change slowly.

    Empty are the sites within the convex hull of those that have a pin: a corner of the array that is missing is not.

    points_px : (N, 2) of seven pins or more.
    """
    walk = _Walk(points_px, lattice_kind(points_px))
    while walk.goes_on(1) or walk.goes_on(2):
        pass
    sites = walk.sites.astype(np.int32)
    hull = cv2.convexHull(sites).astype(np.float32)
    low, high = sites.min(axis=0), sites.max(axis=0)
    box = np.stack(np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(low, high, strict=True))), axis=-1)
    free = set(map(tuple, box.reshape(-1, 2).tolist())) - set(map(tuple, sites.tolist()))
    empty = sum(cv2.pointPolygonTest(hull, (float(x), float(y)), False) >= 0 for x, y in free)
    return Sites(empty, len(points_px) - len(sites))


class _Walk:
    """Sites of pins, in steps along two neighbours of the first."""

    def __init__(self, points_px: Points, kind: Kind) -> None:
        self._points_px, n = points_px, len(points_px)
        steps = np.array(STEPS[kind])
        self._steps = np.concatenate([steps, -steps])
        self._near = nearest_pins(points_px, LEARN_FROM)[1]
        start = _best_surrounded(points_px, self._near, TURN_DEG[kind])
        self._known = np.zeros(n, bool)
        self._site = np.zeros((n, 2), np.intp)
        self._basis = np.zeros((n, 2, 2))
        self._known[start] = True
        self._basis[start] = _basis(points_px, start, self._near[start], TURN_DEG[kind])

    def goes_on(self, stride: int) -> bool:
        """Name the pins at the sites ``stride`` steps from those named; where several lead to a site, by their mean."""
        rows = np.flatnonzero(self._known)
        steps = stride * self._steps
        sites = (self._site[rows, None] + steps).reshape(-1, 2)
        places = (self._points_px[rows, None] + steps @ self._basis[rows]).reshape(-1, 2)
        bases = np.repeat(self._basis[rows], len(steps), axis=0)
        numbers, first, which, support = np.unique(
            self._number(sites), return_index=True, return_inverse=True, return_counts=True
        )
        unique, free = sites[first], ~np.isin(numbers, self._number(self._site[rows]))
        place, basis = (
            np.column_stack([np.bincount(which, each) for each in values.reshape(len(sites), -1).T]) / support[:, None]
            for values in (places, bases)
        )
        basis = basis.reshape(-1, 2, 2)
        within_px = WITHIN_PITCHES * np.hypot(*basis[:, 0].T)
        unnamed = np.flatnonzero(~self._known)
        for sites_told in (free & (support > 1), free):
            candidates = np.flatnonzero(sites_told)
            found, hits = match_pins(place[candidates], self._points_px[unnamed], max_distance_px=within_px[candidates])
            if found.size:
                self._name(unnamed[hits], unique[candidates[found]], basis[candidates[found]])
                return True
        return False

    def _name(self, rows: NDArray[np.intp], sites: NDArray[np.intp], bases: Points) -> None:
        self._known[rows], self._site[rows], self._basis[rows] = True, sites, bases
        self._learn(rows)

    def _learn(self, rows: NDArray[np.intp]) -> None:
        """The lattice around pins from those that have a site already."""
        near = self._near[rows]
        steps = (self._site[near] - self._site[rows, None]) * self._known[near][..., None]
        ways = self._points_px[near] - self._points_px[rows, None]
        inverse = np.linalg.inv(steps.transpose(0, 2, 1) @ steps + TRUST_BEFORE * np.eye(2))
        self._basis[rows] = inverse @ (steps.transpose(0, 2, 1) @ ways + TRUST_BEFORE * self._basis[rows])

    @property
    def sites(self) -> NDArray[np.intp]:
        """(n, 2) of those that have a pin."""
        return self._site[self._known]

    def _number(self, sites: NDArray[np.intp]) -> NDArray[np.intp]:
        """(n,) one number for each site (n, 2): none is farther from the first than there are pins."""
        reach = 4 * len(self._points_px)
        return np.asarray((sites + reach) @ (2 * reach, 1))


def _best_surrounded(points_px: Points, near: NDArray[np.intp], turn_deg: float) -> int:
    """Row of the pin that has most of the pins around it that a lattice has; of several, the one nearest the middle."""
    ways = (points_px[near] - points_px[:, None]) @ (1, 1j)
    turns = np.exp(1j * np.deg2rad(np.arange(0, 360, turn_deg)))
    off = np.abs(ways[:, None, :] - (ways[:, :1] * turns)[..., None]).min(axis=2)
    around = (off < WITHIN_PITCHES * np.abs(ways[:, :1])).sum(axis=1)
    return int(np.lexsort((np.hypot(*(points_px - points_px.mean(axis=0)).T), -around))[0])


def _basis(points_px: Points, row: int, near: NDArray[np.intp], turn_deg: float) -> Points:
    """(2, 2) ways to the nearest pin and to the one that best stands a turn further round."""
    ways = points_px[near] - points_px[row]
    turn = np.deg2rad(turn_deg)
    turned = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    second = ways[0] @ turned
    return np.array([ways[0], ways[np.hypot(*(ways - second).T).argmin()]])


def on_lattice(points_px: Points) -> bool:
    """Whether most of the pins (N, 2) stand on a lattice; fewer than seven cannot tell and do not."""
    n = len(points_px)
    return n >= FEWEST_FOR_LATTICE and n - lattice_sites(points_px).n_beside >= ON_LATTICE * n


def pins_in_doubt(points_px: Points, expect_pins: int | None = None) -> tuple[str, ...]:
    """Notes on the pins (N, 2) of a frame at rest: sites without one, pins beside the lattice, another count.

    PinsError : the count is more than a quarter off the one expected.
    """
    n = len(points_px)
    notes: list[str] = []
    if expect_pins is not None and n != expect_pins:
        if abs(n - expect_pins) > FAR_OFF * expect_pins:
            raise PinsError(
                "rest frame", wanted=f"{expect_pins} pins (--expect-pins)", found=f"{n}",
                do="Help to find them with --pitch, --contrast, --min-area or --dark-pins, or correct the number.",
            )  # fmt: skip
        notes.append(f"{n} pins are found at rest, not {expect_pins}")
    if n < FEWEST_FOR_LATTICE:
        return tuple(notes)
    sites = lattice_sites(points_px)
    if n - sites.n_beside < ON_LATTICE * n:
        return (*notes, f"most of the {n} bright blobs stand on no lattice: are they pins? None can be told missing")
    if sites.n_empty:
        notes.append(f"{sites.n_empty} sites of the pin lattice show no pin")
    if sites.n_beside:
        notes.append(f"{sites.n_beside} of {n} pins stand beside the lattice: what else may they be?")
    return tuple(notes)
