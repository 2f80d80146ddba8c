"""What the study claims of the rig's presses: areas, spread rates, their order, and conditions.

All are on the scores of one algorithm, in percent of differences of mean ln score over mountings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from emg2vsa.claims import paper
from emg2vsa.claims.claim import UNKNOWN, Asserts, Claim, Found, largest, less, moved, size, smallest
from emg2vsa.discrimination.contrast import change_of
from emg2vsa.discrimination.mountings import Cell, CellSum, Mountings
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID, RunTable
from emg2vsa.discrimination.separation import closest_pair, gap_of, pressed_everywhere
from emg2vsa.settings import ClaimSettings
from emg2vsa.statistics.drift import Order

AREAS, RATES, CONDITIONS = "contact area", "spread rate of the contact", "rigid and human-like actuation"
CONSTANT = ("constant-min", "constant-mean", "constant-max")
ORDERS: dict[Order, str] = {
    "differs": "",
    "same": "Drift may look like a difference, as the order of mountings does not tell it.",
    "unknown": "Drift may look like a difference, as nobody knows the order of mountings.",
}
Design = tuple[str, float]
"Condition and angle."
_PERCENT = 100.0


def rig_claims(table: RunTable, mounting_sd: float, margins: ClaimSettings) -> Iterator[Claim]:
    """mounting_sd : of a score from mounting to mounting, as a share of it, where nothing was mounted twice."""
    yield from _area_claims(_Cells.of(table, table.start_area, mounting_sd), margins.area_percent)
    cells = _Cells.of(table, table.casr, mounting_sd)
    yield from _rate_claims(cells, margins.casr_percent)
    yield _contrast(cells, margins.contrast_percent)
    yield _levels(cells, margins.separation)


@dataclass(frozen=True)
class _Cells:
    """Designs and specimens by name, and the sums of their mountings."""

    table: RunTable
    mountings: Mountings

    @classmethod
    def of(cls, table: RunTable, scores: dict[str, np.ndarray], mounting_sd: float) -> _Cells:
        own = scores.get(table.algorithm)
        nothing = np.full(table.mounting.shape, np.nan)
        return cls(table, Mountings.of_table(table, nothing if own is None else own, mounting_sd))

    def places(self, designs: Iterable[Design]) -> list[int]:
        return [self.table.design(*design) for design in designs]

    def missing(self, designs: Iterable[Design], specimens: Sequence[int]) -> list[str]:
        """Cells that have no score: ``S1 modular 30°``, or a design as a whole."""
        found = []
        for (condition, angle), place in zip(designs, self.places(designs), strict=True):
            absent = [self.table.specimens[s] for s in specimens if place < 0 or not self.mountings.count[place, s]]
            names = "" if len(absent) == len(specimens) else f"{', '.join(absent)} "
            found += [f"{names}{condition} {angle:g}°"] if absent else []
        return found

    def sum(self, weights: dict[Cell, float], designs: Iterable[int] = ()) -> Found:
        return found_of(self.mountings.sum(weights, designs))

    def steps(self, designs: Sequence[Design], specimens: Sequence[int]) -> list[Found]:
        """ln score of each specimen less that of the next stiffer, in each design."""
        places = self.places(designs)
        return [
            self.sum({(place, soft): 1.0, (place, stiff): -1.0}, places)
            for place in places
            for stiff, soft in pairwise(specimens)
        ]

    def claim(
        self, key: str, question: str, says: str, estimand: str, asserts: Asserts, margin: float, section: str,
        designs: Sequence[Design], specimens: Sequence[int], found: Callable[[], Found], *, percent: bool = True,
    ) -> Claim:  # fmt: skip
        """The claim; without an estimate where one of its cells was not pressed."""
        if len(specimens) > 1:
            missing = self.missing(designs, specimens)
            why = f"No score: {', '.join(missing)}." if missing else ""
        else:
            why = "Fewer than two specimens to compare."
        known = UNKNOWN if why else found()
        why = why or (self._remarks(designs) if np.isfinite(known.interval(0.95)[0]) else "Nothing tells the scatter.")
        return Claim(
            key, question, says, estimand, asserts, moved(known, _share) if percent else known,
            margin / _PERCENT if percent else margin, "mounting", section, self.table.algorithm,
            _PERCENT if percent else 1.0, why, tuple(designs), tuple(self.table.specimens[s] for s in specimens),
        )  # fmt: skip

    def _remarks(self, designs: Iterable[Design]) -> str:
        once = bool((self.mountings.count[self.places(designs)] < 2).all())
        sd = 100 * self.mountings.assumed_sd
        assumed = f"Mounted once: true as far as mountings scatter by {sd:g} % (SD, assumed)." if once else ""
        return " ".join(filter(None, (assumed, ORDERS[self.mountings.drift.order])))


def _share(difference_of_logs: float) -> float:
    return float(np.expm1(difference_of_logs))


def found_of(of: CellSum) -> Found:
    """The estimate as claims have it."""
    return Found(of.estimate, of.ends)


def _area_claims(cells: _Cells, percent: float) -> Iterator[Claim]:
    known, angles = cells.table.known, list(paper.AREA_SPECIMENS_P)
    designs = [(RIGID, angle) for angle in angles]

    def specimens() -> Found:
        places = cells.places(designs)
        pairs = [(a, b) for i, a in enumerate(known) for b in known[i + 1 :]]
        return largest(
            size(cells.sum({(place, b): 1.0, (place, a): -1.0}, places)) for place in places for a, b in pairs
        )

    def by_angle() -> Found:
        share, places = 1 / len(known), cells.places(designs)
        pairs = [(a, b) for i, a in enumerate(places) for b in places[i + 1 :]]
        return smallest(
            size(cells.sum({(a, s): share for s in known} | {(b, s): -share for s in known}, places)) for a, b in pairs
        )

    yield cells.claim(
        "area_same_on_specimens", AREAS, "initial area is the same on all specimens, rigid motor",
        "largest difference between two specimens, %", "within", percent, "area", designs, known, specimens,
    )  # fmt: skip
    yield cells.claim(
        "area_changes_with_angle", AREAS, "initial area differs between all angles, rigid motor",
        "smallest difference between two angles on the mean of specimens, %", "more", percent, "area", designs, known,
        by_angle,
    )  # fmt: skip


def designs_of(*conditions: str) -> list[Design]:
    """Those that the paper reports, of some conditions."""
    return [design for design in paper.CASR_WORST_P if design[0] in conditions]


def _rate_claims(cells: _Cells, percent: float) -> Iterator[Claim]:
    table, new = cells.table, cells.table.specimens[cells.table.new] if cells.table.new >= 0 else "the new specimen"
    everyone = list(range(len(table.specimens)))

    def steps(key: str, says: str, designs: list[Design], specimens: list[int]) -> Claim:
        return cells.claim(
            key, RATES, says, "smallest step of CASR to the next softer specimen, %", "more", percent, "casr", designs,
            specimens, lambda: smallest(cells.steps(designs, specimens)),
        )  # fmt: skip

    named = (("rigid", "rigid motor", (RIGID,)), ("human_like", "human-like stiffness", (HUMAN_LIKE,)))
    for key, what, conditions in (*named, ("constant", "constant stiffness", CONSTANT)):
        yield steps(f"casr_{key}", f"CASR tells specimens apart, {what}", designs_of(*conditions), table.known)
    for figure, (_, what, conditions) in zip((10, 12), named, strict=True):
        says, designs = f"CASR rises with softness, {new} in its place, {what}", designs_of(*conditions)
        yield _of_new(table, steps(f"fig{figure}_order", says, designs, everyone), new)
    lies = [s for s in (table.new - 1, table.new, table.new + 1) if 0 <= s < len(everyone)] if table.new >= 0 else []
    least, *others = (design for level in CONSTANT for design in designs_of(level))
    says = f"mean and highest constant stiffness tell {new} from its neighbours"
    yield _of_new(table, steps("fig13_new_specimen", says, others, lies), new)
    stiffer = lies[:2] if table.new > 0 else []
    yield _of_new(table, cells.claim(
        "new_specimen_at_minimum", RATES, f"lowest constant stiffness does not tell {new} from its stiffer neighbour",
        "difference of CASR, %", "within", percent, "casr", [least], stiffer,
        lambda: largest(map(size, cells.steps([least], stiffer))),
    ), new)  # fmt: skip


def _of_new(table: RunTable, claim: Claim, new: str) -> Claim:
    """Not known where the new specimen was not pressed."""
    return claim if table.new >= 0 else replace(claim, found=UNKNOWN, why=f"No score: {new}.")


def _contrast(cells: _Cells, percent: float) -> Claim:
    table = cells.table
    shared = [float(table.angles_deg[d]) for d in table.of_condition(HUMAN_LIKE)]
    angle = min((a for a in shared if table.design(RIGID, a) >= 0), default=0.0)
    designs = [(HUMAN_LIKE, angle), (RIGID, angle)]
    used = pressed_everywhere(table.casr[table.algorithm]).tolist()
    ends = [used[0], used[-1]] if len(used) > 1 else []
    pair = f"{table.specimens[ends[1]]} : {table.specimens[ends[0]]}" if ends else "softest : stiffest"

    def change() -> Found:
        one, other = cells.places(designs)
        return found_of(change_of(cells.mountings, one, other, (ends[1], ends[0])))

    return cells.claim(
        "human_like_contrast", CONDITIONS, "human-like stiffness tells specimens apart better than the rigid motor",
        f"change of the ratio {pair} at {angle:g}°, %", "more", percent, "actuators", designs, ends, change,
    )  # fmt: skip


def _levels(cells: _Cells, margin: float) -> Claim:
    table, designs = cells.table, [(HUMAN_LIKE, 0.0), *((level, 0.0) for level in CONSTANT)]
    used = pressed_everywhere(table.casr[table.algorithm]).tolist()
    pair: tuple[int, ...] = closest_pair(table.stiffness_n_per_mm, used) if len(used) > 1 else ()
    names = " and ".join(table.specimens[s] for s in pair) or "two specimens"

    def gap(place: int) -> Found:
        stiff, soft = pair
        return Found(
            gap_of(cells.mountings, place, (stiff, soft), 0.95)[0],
            lambda confidence: gap_of(cells.mountings, place, (stiff, soft), confidence)[1:],
        )

    def change() -> Found:
        human, *levels = map(gap, cells.places(designs))
        return smallest(less(human, level) for level in levels)

    return cells.claim(
        "constant_levels", CONDITIONS, "the profile tells specimens apart better than one stiffness",
        f"smallest change of the distance of {names}, SDs of a press", "more", margin, "actuators", designs, pair,
        change, percent=False,
    )  # fmt: skip
