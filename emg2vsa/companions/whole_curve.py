"""Does co-contraction differ between specimens at each force? The measured curves of people, without any law of force.

The curve of a person on a specimen is the mean of the presses in each force bin.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.companions.force_laws import rows_of_cells
from emg2vsa.fits import Fits
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
class WholeCurve:
    """participants, specimens : those that were compared; left_out : the other participants, then specimens.

    low_n, high_n (G,) : ends of the force bins that were compared. tests : in the unit of activity, by these bins.
    """

    participants: Names
    specimens: Names
    left_out: tuple[str, ...]
    low_n: Floats
    high_n: Floats
    tests: CurveTests

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Names of the pairs of specimens, in the order of the tests."""
        return list(zip(*(self.specimens[end].tolist() for end in (self.tests.first, self.tests.second)), strict=True))


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
    edges_n = cells[0].edges_n if cells else np.empty(1)
    place = [{name: i for i, name in enumerate(names.tolist())} for names in (people, specimens)]
    table = np.full((people.size, specimens.size, edges_n.size - 1), np.nan)
    for cell in cells:
        table[place[0][cell.participant], place[1][cell.specimen]] = cell.v
    tests = curve_tests(table, alpha)
    left_out = [np.delete(names, at) for names, at in ((people, tests.people), (specimens, tests.specimens))]
    return WholeCurve(
        participants=people[tests.people],
        specimens=specimens[tests.specimens],
        left_out=tuple(np.concatenate(left_out).tolist()),
        low_n=edges_n[tests.forces],
        high_n=edges_n[tests.forces + 1],
        tests=tests,
    )
