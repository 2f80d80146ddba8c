"""The scores of all runs in one table: designs (a condition at an angle) by specimens by presses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.errors import DataError
from emg2vsa.run_scores import RunScores
from emg2vsa.statistics.clusters import in_order

CONDITIONS = ("high-stiffness", "modular", "constant-min", "constant-mean", "constant-max")
"""Rigid motor, whole human profile, and its constant levels, as runs name them (paper, section V)."""
RIGID, HUMAN_LIKE = CONDITIONS[:2]


@dataclass(frozen=True, eq=False)
class RunTable:
    """D designs of S specimens, stiffest first, of up to R presses.

    conditions, angles_deg : (D,), condition by condition and angle by angle. specimens, stiffness_n_per_mm : (S,).
    new : place of the new specimen, -1 where it was not pressed. algorithm : the one whose scores are tested.
    casr, start_area, a_c0 : algorithm to (D, S, R), as in ``RunScores``; NaN where there is no score. mounting :
    (D, S, R) number of the mounting, from 1; 0: no press. position : (D, S, R) place of that mounting in the order in
    which all were pressed, from 1, NaN without a press; None where nobody knows the order. true_a_c0 : (D, S, R), mm2,
    NaN unless simulated; empty where nobody asks.
    """

    conditions: tuple[str, ...]
    angles_deg: Floats
    specimens: tuple[str, ...]
    stiffness_n_per_mm: Floats
    new: int
    algorithm: str
    area_unit: str
    casr: dict[str, Floats]
    mounting: Ints
    position: Floats | None = None
    start_area: dict[str, Floats] = field(default_factory=dict)
    a_c0: dict[str, Floats] = field(default_factory=dict)
    true_a_c0: Floats = field(default_factory=lambda: np.empty((0, 0, 0)))

    @property
    def known(self) -> list[int]:
        """Places of the specimens other than the new one."""
        return [i for i in range(len(self.specimens)) if i != self.new]

    def design(self, condition: str, angle_deg: float) -> int:
        """Number of the design of this condition and angle, degrees; -1 where there is none."""
        designs = zip(self.conditions, self.angles_deg.tolist(), strict=True)
        return next((i for i, design in enumerate(designs) if design == (condition, angle_deg)), -1)

    def of_condition(self, condition: str) -> list[int]:
        """Numbers of the designs of a condition, by rising angle."""
        return [i for i, name in enumerate(self.conditions) if name == condition]

    def unscored(self, design: int, specimens: Sequence[str]) -> list[str]:
        """Those of ``specimens`` that have no press with a CASR in a design."""
        values = self.casr[self.algorithm][design]
        return [name for name in specimens if not np.isfinite(values[self.specimens.index(name)]).any()]


def run_table(runs: Sequence[RunScores], stiffness_n_per_mm: Mapping[str, float], new: str) -> RunTable:
    """Sort ``runs`` into a table; rejected presses have no score.

    DataError where there is no run, a run occurs twice, units of area differ, or a specimen's stiffness is unknown:
    without it nobody can say which of two specimens is the softer.
    """
    _check(runs, stiffness_n_per_mm)
    conditions = sorted({run.condition for run in runs}, key=_place)
    designs = [
        (condition, angle)
        for condition in conditions
        for angle in sorted({run.angle_deg for run in runs if run.condition == condition})
    ]
    names = in_order(np.array([run.specimen for run in runs])).tolist()
    specimens = tuple(sorted(names, key=lambda name: -stiffness_n_per_mm[name]))
    places = [(designs.index((run.condition, run.angle_deg)), specimens.index(run.specimen)) for run in runs]
    shape = (len(designs), len(specimens), max(run.repetitions.size for run in runs))
    algorithms = dict.fromkeys(name for run in runs for name in run.casr)

    def sorted_in(scores: Sequence[Floats | None]) -> Floats:
        table = np.full(shape, np.nan)
        for run, place, found in zip(runs, places, scores, strict=True):
            table[place][: run.repetitions.size] = _accepted(run, found)
        return table

    mounting = np.zeros(shape, dtype=np.int64)
    for run, place in zip(runs, places, strict=True):
        mounting[place][: run.repetitions.size] = run.mounting
    return RunTable(
        conditions=tuple(condition for condition, _ in designs),
        angles_deg=np.array([angle for _, angle in designs]),
        specimens=specimens,
        stiffness_n_per_mm=np.array([stiffness_n_per_mm[name] for name in specimens]),
        new=specimens.index(new) if new in specimens else -1,
        algorithm=runs[0].algorithm,
        area_unit=runs[0].area_unit,
        a_c0={name: sorted_in([run.a_c0.get(name) for run in runs]) for name in algorithms},
        start_area={name: sorted_in([run.start_area.get(name) for run in runs]) for name in algorithms},
        casr={name: sorted_in([run.casr.get(name) for run in runs]) for name in algorithms},
        true_a_c0=sorted_in([run.true_a_c0 if run.area_unit == "mm2" else None for run in runs]),
        mounting=mounting,
        position=_position(shape, runs, places),
    )


def _position(
    shape: tuple[int, int, int], runs: Sequence[RunScores], places: Sequence[tuple[int, int]]
) -> Floats | None:
    """Places of mountings, by the first press of each; None where not all mountings have a time of their own."""
    began = np.full(shape, np.nan)
    count = 0
    for run, place in zip(runs, places, strict=True):
        numbers, inverse = np.unique(run.mounting, return_inverse=True)
        first = np.array([np.min(run.pressed_at[run.mounting == number]) for number in numbers])
        began[place][: run.repetitions.size] = first[inverse]
        count += numbers.size
    times = np.unique(began[np.isfinite(began)])
    if times.size != count:
        return None
    return np.where(np.isfinite(began), np.searchsorted(times, began) + 1.0, np.nan)


def _accepted(run: RunScores, scores: Floats | None) -> Floats:
    accepted = np.array([verdict == "ok" for verdict in run.verdicts], dtype=np.bool_)
    return np.where(accepted, np.nan if scores is None else scores, np.nan)


def _place(condition: str) -> tuple[int, str]:
    return (CONDITIONS.index(condition) if condition in CONDITIONS else len(CONDITIONS)), condition


def _check(runs: Sequence[RunScores], stiffness_n_per_mm: Mapping[str, float]) -> None:
    if not runs:
        raise DataError("runs", wanted="scored runs", found="none", do="Run the rig, or import measured runs.")
    names = [run.name for run in runs]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DataError(
            "runs", wanted="every run once", found=f"{', '.join(twice)} more than once", do="Keep one folder of each."
        )
    units = sorted({run.area_unit for run in runs})
    if len(units) > 1:
        raise DataError(
            "runs, area", wanted="one unit of area", found=" and ".join(units), do="Give all runs a camera file."
        )
    algorithms = sorted({run.algorithm for run in runs})
    if len(algorithms) > 1:
        raise DataError(
            "runs, vision algorithm", wanted="one algorithm", found=" and ".join(algorithms), do="Score all runs alike."
        )
    unknown = sorted({run.specimen for run in runs} - set(stiffness_n_per_mm))
    if unknown:
        raise DataError(
            "runs, specimens", wanted="specimens of known stiffness", found=", ".join(unknown),
            do="State their stiffness in the study file; that of the new specimen is new_stiffness_n_per_mm.",
        )  # fmt: skip
