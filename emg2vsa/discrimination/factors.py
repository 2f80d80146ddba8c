"""What moves area and CASR: condition, angle, specimen, and do they act together (paper, section VI)?

The model is of logarithms: an angle or a condition multiplies the scores, and their scatter grows with their level.
Specimens are the known ones. Conditions that were pressed at some angles only leave cells empty (`stats.factorial`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.settings import DiscriminationSettings
from emg2vsa.statistics.factorial import Factorial, factorial


@dataclass(frozen=True)
class Factors:
    """area, casr : the models of ln(score), None where they cannot be fitted. not_positive : presses left out of each,
    whose score has no logarithm. constant : factors with one level only.
    """

    area: Factorial | None
    casr: Factorial | None
    not_positive: tuple[int, int]
    constant: tuple[str, ...]


def factors_of(table: RunTable, settings: DiscriminationSettings) -> Factors:
    """Scores of the algorithm of ``table``; the area is that at the force where loading begins."""
    area, casr = (scores[table.algorithm][:, table.known] for scores in (table.start_area, table.casr))
    d, s, r = area.shape
    specimens = np.array([table.specimens[i] for i in table.known])
    levels = {
        "condition": np.repeat(table.conditions, s * r),
        "angle": np.repeat([f"{angle:g}" for angle in table.angles_deg.tolist()], s * r),
        "specimen": np.tile(np.repeat(specimens, r), d),
    }
    varied = {name: names for name, names in levels.items() if np.unique(names).size > 1}
    models = [_model(scores.ravel(), varied, 1 - settings.alpha) for scores in (area, casr)]
    return Factors(
        area=models[0][0],
        casr=models[1][0],
        not_positive=(models[0][1], models[1][1]),
        constant=tuple(name for name in levels if name not in varied),
    )


def _model(scores: Floats, levels: dict[str, np.ndarray], confidence: float) -> tuple[Factorial | None, int]:
    """None where the scores that are left cover no two levels of every factor, or leave no scatter within cells."""
    with np.errstate(invalid="ignore"):
        positive = scores > 0
    left_out = int(np.count_nonzero(np.isfinite(scores) & ~positive))
    if any(np.unique(names[positive]).size < 2 for names in levels.values()):
        return None, left_out
    logs = np.log(scores[positive])
    found = factorial(logs, {name: names[positive].tolist() for name, names in levels.items()}, confidence)
    return (found if found.error_df > 0 else None), left_out
