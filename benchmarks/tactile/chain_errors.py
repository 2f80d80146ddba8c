"""How far each chain of engine and rules is off: in CASR, and in the stiffness it leads to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.tactile.calibration import unknown_error_percent
from benchmarks.tactile.metrics import percent_error, worst
from benchmarks.tactile.press_scores import TRUE_AREA, Chain, PressScores
from casr.specimens import SPECIMENS

CALIBRATION, UNKNOWN = ("S1", "S3", "S5"), "S2"
ANGLES_DEG = (0.0, 30.0, 45.0)
STIFFNESS_N_MM = np.array([SPECIMENS[name] for name in (*CALIBRATION, UNKNOWN)])


@dataclass(frozen=True)
class Judged:
    """A chain and its errors, percent: CASR of each press; kappa at each angle; see the notes of the table."""

    chain: Chain
    casr_percent: list[float]
    kappa_percent: list[float]
    added_percent: float
    left_out_percent: float

    @property
    def typical_casr_percent(self) -> float:
        """Median size of the error of CASR; infinite where a press gave none."""
        sizes = np.abs(self.casr_percent)
        return float("inf") if np.isnan(sizes).any() else float(np.median(sizes))


def judge(results: Sequence[PressScores], chain: Chain, exact_percent: Sequence[float]) -> Judged:
    """Errors of one chain, beside the errors of kappa that exact CASR leaves."""
    kappa, left_out = stiffness_errors(results, chain)
    added = [float(percent_error(100 + k, 100 + exact)) for k, exact in zip(kappa, exact_percent, strict=True)]
    return Judged(chain, casr_errors(results, chain), kappa, worst(added), worst(left_out))


def casr_errors(results: Sequence[PressScores], chain: Chain) -> list[float]:
    """Error of CASR on each press, percent."""
    return [float(percent_error(r.casr[chain], r.true_casr[chain[3]])) for r in results]


def stiffness_errors(results: Sequence[PressScores], chain: Chain | None) -> tuple[list[float], list[float]]:
    """Error on the unknown specimen at each angle, and on each in turn, percent. Chain None is true CASR."""
    unknown, left_out = [], []
    for angle in ANGLES_DEG:
        casr = _casr(results, chain, angle)
        unknown.append(unknown_error_percent(casr, STIFFNESS_N_MM, SPECIMENS[UNKNOWN]))
        left_out += [unknown_error_percent(casr, STIFFNESS_N_MM, stiffness) for stiffness in STIFFNESS_N_MM.tolist()]
    return unknown, left_out


def _casr(results: Sequence[PressScores], chain: Chain | None, angle_deg: float) -> NDArray[np.float64]:
    """(n_specimens, n_repetitions) CASR at one angle."""
    found = [
        [
            r.casr[chain] if chain else r.true_casr["power"]
            for r in results
            if r.angle_deg == angle_deg and r.stiffness_n_mm == stiffness
        ]
        for stiffness in STIFFNESS_N_MM.tolist()
    ]
    return np.array(found)


def recommendation(judged: Sequence[Judged]) -> str:
    """The chains that come out best by each measure."""
    usable = [j for j in judged if j.chain[1] != TRUE_AREA]
    kappa = min(usable, key=lambda j: worst(j.kappa_percent))
    added = min(usable, key=lambda j: j.added_percent)
    casr = min(usable, key=lambda j: j.typical_casr_percent)
    return (
        f"Least error of kappa at its worst angle: {', '.join(kappa.chain)} ({worst(kappa.kappa_percent):.1f} %); "
        f"least added: {', '.join(added.chain)} ({added.added_percent:.1f} %); "
        f"least median error of CASR: {', '.join(casr.chain)} ({casr.typical_casr_percent:.1f} %)."
    )
