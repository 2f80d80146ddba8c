"""Does co-contraction differ between specimens at each force? The measured curves of people, without any law of force.

The curve of a person on a specimen is the mean of the presses in each force bin.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from itertools import pairwise

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.companions.force_laws import rows_of_cells
from emg2vsa.fits import Fits
from emg2vsa.shown import shown
from emg2vsa.statistics.clusters import Names, in_order
from emg2vsa.statistics.whole_curve import CurveTests, curve_tests


@dataclass(frozen=True, eq=False)
class CellCurve:
    """Mean activity v (B,) of a person's presses on a specimen in the bins between edges_n (B + 1,)."""

    participant: str
    specimen: str
    v: Floats
    edges_n: Floats


@dataclass(frozen=True, eq=False)
class CurveRows:
    """Rows (n,) of a table on ranges of force.

    pair : number of a pair of specimens, -1 for all specimens together; from the number of pairs on, of one specimen.
    value, low, high : difference of a pair, or mean of a specimen, with its simultaneous band; NaN for all together.
    """

    pair: Ints
    of: Names = field(metadata=shown("Of"))
    from_n: Floats = field(metadata=shown("From (N)"))
    to_n: Floats = field(metadata=shown("To (N)"))
    value: Floats
    low: Floats
    high: Floats
    statistic: Floats = field(metadata=shown("F or t"))
    p: Floats = field(metadata=shown("p"))


@dataclass(frozen=True, eq=False)
class WholeCurve:
    """participants, specimens : those that were compared; left_out : the other participants, then specimens.

    from_n, to_n (G,) : ends of the force bins that were compared. tests : in the unit of activity, by these bins.
    """

    participants: Names
    specimens: Names
    left_out: tuple[str, ...]
    from_n: Floats
    to_n: Floats
    tests: CurveTests

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Names of the pairs of specimens, in the order of the tests."""
        first, second = (self.specimens[end].tolist() for end in (self.tests.first, self.tests.second))
        return list(zip(first, second, strict=True))

    def neighbours(self, stiffness_n_per_mm: Mapping[str, float]) -> list[int]:
        """Numbers of the pairs of neighbours in stiffness, N/mm, the stiffest first; of names if fewer than 2 are
        known."""
        names = self.specimens.tolist()
        known = [name for name in names if name in stiffness_n_per_mm]
        ordered = sorted(known, key=stiffness_n_per_mm.__getitem__, reverse=True) if len(known) > 1 else names
        pairs = [set(pair) for pair in self.pairs]
        return [pairs.index(set(pair)) for pair in pairwise(ordered)]

    def by_force(self) -> CurveRows:
        """Everything at every force: all specimens together, pairs, then specimens."""
        n, tests = self.from_n.size, self.tests
        unknown = np.full((1, n), np.nan)
        no_test = np.full(tests.mean.shape, np.nan)
        value, half, statistic, p = (
            np.concatenate(each).ravel()
            for each in (
                (unknown, tests.pair_difference, tests.mean),
                (unknown, tests.pair_half_width, tests.half_width),
                (tests.f[None], tests.pair_t, no_test),
                (tests.p[None], tests.pair_p, no_test),
            )
        )
        names = ["all specimens", *map("–".join, self.pairs), *self.specimens.tolist()]
        return CurveRows(
            np.repeat(np.arange(len(names)) - 1, n), np.repeat(names, n), np.tile(self.from_n, len(names)),
            np.tile(self.to_n, len(names)), value, value - half, value + half, statistic, p,
        )  # fmt: skip

    def ranges(self) -> CurveRows:
        """Where all specimens, or a pair, differ; of the force with the largest F or t, but for its ends."""
        forces, every = self.tests.forces, self.by_force()
        found = [(each.pair, each.start, each.stop - 1, each.at) for each in self.tests.clusters()]
        pair, *places = np.array(found, dtype=np.int64).reshape(-1, 4).T
        start, last, at = (np.searchsorted(forces, place) for place in places)
        rows = {each.name: getattr(every, each.name)[(pair + 1) * forces.size + at] for each in fields(every)}
        return CurveRows(**rows | {"from_n": self.from_n[start], "to_n": self.to_n[last]})

    def differing(self) -> Floats:
        """(1 + pairs,) share of the forces compared at which all specimens, then those of each pair, differ."""
        found, whole_n = self.ranges(), np.sum(self.to_n - self.from_n)
        return np.bincount(found.pair + 1, found.to_n - found.from_n, len(self.pairs) + 1) / whole_n


def cell_curves(fits: Fits, use: str) -> list[CellCurve]:
    """Curve of every cell, from the presses that ``use`` admits; NaN in a bin that fewer than half of them reach."""
    found = []
    for (participant, specimen), own in rows_of_cells(fits, use).items():
        v = fits.bin_v[own]
        there = np.isfinite(v)
        n = np.count_nonzero(there, axis=0)
        mean = np.sum(v, axis=0, where=there) / np.maximum(n, 1)
        found.append(CellCurve(participant, specimen, np.where(2 * n >= len(own), mean, np.nan), fits.bin_edges_n))
    return found


def compare_curves(cells: Iterable[CellCurve], alpha: float = 0.05) -> WholeCurve:
    """The specimens over all cells, of which no two have the same names; alpha : of any false difference."""
    cells = list(cells)
    names = ([cell.participant for cell in cells], [cell.specimen for cell in cells])
    people, specimens = (in_order(np.array(each, dtype=np.str_)) for each in names)
    edges_n, bins = (cells[0].edges_n, cells[0].v.size) if cells else (np.empty(1), 0)
    place = [{name: i for i, name in enumerate(names.tolist())} for names in (people, specimens)]
    table = np.full((people.size, specimens.size, bins), np.nan)
    for cell in cells:
        table[place[0][cell.participant], place[1][cell.specimen]] = cell.v
    tests = curve_tests(table, alpha)
    left_out = [np.delete(names, at) for names, at in ((people, tests.people), (specimens, tests.specimens))]
    return WholeCurve(
        participants=people[tests.people],
        specimens=specimens[tests.specimens],
        left_out=tuple(np.concatenate(left_out).tolist()),
        from_n=edges_n[tests.forces],
        to_n=edges_n[tests.forces + 1],
        tests=tests,
    )
