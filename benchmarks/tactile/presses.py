"""``casr bench presses``: from frames to stiffness on simulated presses whose areas, growth and CASR are known."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from benchmarks.tactile.flow_scores import median_sd, worst
from benchmarks.tactile.numerics import (
    ANGLES_DEG,
    CALIBRATION,
    STIFFNESS_N_MM,
    UNKNOWN,
    judge,
    recommendation,
    stiffness_errors,
)
from benchmarks.tactile.press_scores import CHAINS, PressScores, scored
from benchmarks.tactile.table import Cell, Table
from casr.contact_area import RULES
from casr.flow.estimate import ENGINES
from emg2vsa.worlds.tactile import ContactWorld, PressSettings


def run_presses(n_repetitions: int, n_jobs: int) -> list[Table]:
    """Simulate and score all presses; initial areas, growth, then every chain from frames to stiffness."""
    return tables(score_all(n_repetitions, n_jobs))


def score_all(n_repetitions: int, n_jobs: int = 1) -> list[PressScores]:
    """Four specimens, three angles and so many repetitions, on ``n_jobs`` processes."""
    presses = [
        PressSettings(stiffness_n_per_mm=stiffness, angle_deg=angle, repetition=repetition, world=ContactWorld())
        for angle in ANGLES_DEG
        for stiffness in STIFFNESS_N_MM.tolist()
        for repetition in range(n_repetitions)
    ]
    if n_jobs == 1:
        return [scored(press) for press in presses]
    # OpenCV and numba have threads of their own, which a forked process would not
    with ProcessPoolExecutor(n_jobs, mp_context=get_context("spawn")) as pool:
        return list(pool.map(scored, presses, chunksize=4))


def tables(results: Sequence[PressScores]) -> list[Table]:
    """All tables of these presses."""
    return [area_table(results), growth_table(results), chain_table(results)]


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
        seconds = median_sd([r.time_s[engine] for r in results])[0]
        rows.append([engine, *[number for at in errors for number in median_sd(at)], seconds])
    title = "Growth of the contact ln(A_n / A_c0): median error and standard deviation, %; processor time per press"
    return Table("press_growth", title, (*_by_angle("engine"), ("s", ".3f")), rows)


def chain_table(results: Sequence[PressScores]) -> Table:
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
    rows.append(["(exact CASR)", "", "", "power", 0.0, 0.0, *exact[0], worst(exact[0]), 0.0, worst(exact[1])])
    columns = [("engine", ""), ("area", ""), ("law", ""), ("rate", ""), ("CASR %", "+.1f"), ("sd", ".1f")]
    columns += [(f"kappa {angle:g}° %", "+.1f") for angle in ANGLES_DEG]
    columns += [("worst", ".1f"), ("added", ".1f"), ("left out", ".1f")]
    notes = (
        "CASR: median error against the truth of the same rate rule over all presses, and its standard deviation.",
        f"kappa: error on {UNKNOWN} (5.32 N/mm) from the mean of its presses, calibrated on {', '.join(CALIBRATION)}.",
        "added: largest difference at any angle from the kappa that exact CASR (power) gives in the same way,",
        "  because an exponential through three specimens of this simulated contact is itself wrong by the last line.",
        "left out: largest error at any angle when each specimen in turn is the unknown one (S1 and S5 extrapolate).",
        recommendation(judged),
        *failures(results),
    )
    return Table("press_chains", "From frames to stiffness", tuple(columns), rows, notes)


def failures(results: Sequence[PressScores]) -> list[str]:
    """What could not be computed: on how many presses, and what was said the first time."""
    said: dict[str, list[str]] = {}
    for result in results:
        for what, message in result.failures.items():
            said.setdefault(what, []).append(message)
    return [
        f"{what} failed on {len(messages)} of {len(results)} presses: {messages[0]}" for what, messages in said.items()
    ]


def _by_angle(first: str) -> tuple[tuple[str, str], ...]:
    return ((first, ""), *[column for angle in ANGLES_DEG for column in ((f"{angle:g}°", "+.1f"), ("sd", ".1f"))])
