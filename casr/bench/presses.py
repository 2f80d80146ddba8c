"""``casr bench presses``: from frames to stiffness on simulated presses whose areas, growth and CASR are known."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.bench.calibration import unknown_error_percent
from casr.bench.metrics import percent_error
from casr.bench.press_scores import CHAINS, TRUE_AREA, Chain, PressScores, scored
from casr.bench.table import Cell, Table
from casr.contact_area import RULES
from casr.flow.estimate import ENGINES
from casr.synthetic.contact import SPECIMENS
from casr.synthetic.settings import PressSettings

CALIBRATION, UNKNOWN = ("S1", "S3", "S5"), "S2"
ANGLES_DEG = (0.0, 30.0, 45.0)
STIFFNESS_N_MM = np.array([SPECIMENS[name] for name in (*CALIBRATION, UNKNOWN)])
Scores = NDArray[np.float64]


def run_presses(n_repetitions: int, n_jobs: int) -> list[Table]:
    """Simulate and score all presses; initial areas, growth, then every chain from frames to stiffness."""
    return tables(score_all(n_repetitions, n_jobs))


def score_all(n_repetitions: int, n_jobs: int = 1) -> list[PressScores]:
    """Four specimens, three angles and so many repetitions, on ``n_jobs`` processes."""
    presses = [
        PressSettings(stiffness_n_per_mm=stiffness, angle_deg=angle, repetition=repetition)
        for angle in ANGLES_DEG
        for stiffness in STIFFNESS_N_MM.tolist()
        for repetition in range(n_repetitions)
    ]
    if n_jobs == 1:
        return [scored(press) for press in presses]
    with ProcessPoolExecutor(n_jobs) as pool:
        return list(pool.map(scored, presses, chunksize=4))


def tables(results: Sequence[PressScores]) -> list[Table]:
    """All tables of these presses."""
    failures = sorted({failure for result in results for failure in result.failures})
    return [area_table(results), growth_table(results), chain_table(results, failures)]


def area_table(results: Sequence[PressScores]) -> Table:
    """Error of the initial area by rule and angle."""
    rows: list[list[Cell]] = []
    for rule in RULES:
        errors = [[r.area_error_percent[rule] for r in results if r.angle_deg == angle] for angle in ANGLES_DEG]
        rows.append([rule, *[number for at in errors for number in median_sd(at)]])
    return Table(
        "press_initial_area", "Initial area A_c0: median error and standard deviation, %", _by_angle("rule"), rows
    )


def growth_table(results: Sequence[PressScores]) -> Table:
    """Error of the growth of area over the whole press, and run time, by engine."""
    rows: list[list[Cell]] = []
    for engine in ENGINES:
        errors = [[r.growth_error_percent[engine] for r in results if r.angle_deg == angle] for angle in ANGLES_DEG]
        seconds = float(np.nanmedian([r.time_s[engine] for r in results]))
        rows.append([engine, *[number for at in errors for number in median_sd(at)], seconds])
    title = "Growth of the contact ln(A_n / A_c0): median error and standard deviation, %; processor time per press"
    return Table("press_growth", title, (*_by_angle("engine"), ("s", ".3f")), rows)


def chain_table(results: Sequence[PressScores], failures: Sequence[str] = ()) -> Table:
    """Error of CASR and of the stiffness of the unknown specimen for every chain, best first; what to choose below."""
    exact = stiffness_errors(results, None)
    judged = sorted((judge(results, chain, exact[0]) for chain in CHAINS), key=lambda chain: worst(chain.kappa_percent))
    rows: list[list[Cell]] = [
        [
            *j.chain,
            *median_sd(j.casr_percent),
            *j.kappa_percent,
            worst(j.kappa_percent),
            j.added_percent,
            j.left_out_percent,
        ]
        for j in judged
    ]
    rows.append(["(exact CASR)", "", "", "slope", 0.0, 0.0, *exact[0], worst(exact[0]), 0.0, worst(exact[1])])
    columns = [("engine", ""), ("area", ""), ("law", ""), ("rate", ""), ("CASR %", "+.1f"), ("sd", ".1f")]
    columns += [(f"kappa {angle:g}° %", "+.1f") for angle in ANGLES_DEG]
    columns += [("worst", ".1f"), ("added", ".1f"), ("left out", ".1f")]
    notes = (
        "CASR: median error against the truth of the same rate rule over all presses, and its standard deviation.",
        f"kappa: error on {UNKNOWN} (5.32 N/mm) from the mean of its presses, calibrated on {', '.join(CALIBRATION)}.",
        "added: largest difference at any angle from the kappa that exact CASR (slope) gives with the same calibration,",
        "  because an exponential through three specimens of this simulated contact is itself wrong by the last line.",
        "left out: largest error at any angle when each specimen in turn is the unknown one (S1 and S5 extrapolate).",
        recommendation(judged),
        *failures,
    )
    return Table("press_chains", "From frames to stiffness", tuple(columns), rows, notes)


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


def _casr(results: Sequence[PressScores], chain: Chain | None, angle_deg: float) -> Scores:
    """(n_specimens, n_repetitions) CASR at one angle."""
    found = [
        [
            r.casr[chain] if chain else r.true_casr["slope"]
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


def worst(errors: Sequence[float]) -> float:
    """Largest size; infinite where a number is missing, so that a chain that fails is never the best."""
    sizes = np.abs(errors)
    return float("inf") if np.isnan(sizes).any() else float(sizes.max())


def median_sd(errors: Sequence[float]) -> tuple[float, float]:
    """Median and standard deviation (n - 1) of the numbers that are there."""
    known = np.array([error for error in errors if np.isfinite(error)])
    if not known.size:
        return float("nan"), float("nan")
    return float(np.median(known)), float(np.std(known, ddof=1)) if known.size > 1 else 0.0


def _by_angle(first: str) -> tuple[tuple[str, str], ...]:
    return ((first, ""), *[column for angle in ANGLES_DEG for column in ((f"{angle:g}°", "+.1f"), ("sd", ".1f"))])
