"""``casr bench presses --world``: areas, CASR, intervals and kappa in worlds that the estimator does not come from."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context

import numpy as np

from benchmarks.tactile.flow_scores import percent_error, sample_sd
from benchmarks.tactile.numerics import ANGLES_DEG, CALIBRATION, UNKNOWN
from benchmarks.tactile.table import Cell, Table
from benchmarks.tactile.world_scores import FORCES_N, LEAST_PITCHES, Found, WorldScore, named, world_named, world_scored
from casr.doubts import unlike_others
from casr.specimens import SPECIMENS
from emg2vsa.calibration.laws import fit_law
from emg2vsa.worlds.tactile import PressSettings

NEAR_PERCENT = 8.0
UNLIKE = (
    ("stick-1", "stick-2"),
    ("stick-2", "stick-1"),
    ("tabulated", "tabulated-frictionless"),
    ("tabulated-frictionless", "tabulated"),
)
"Worlds of the specimens that are known, and of the one that is not."
Casr = Callable[[WorldScore], float]


def run_worlds(asked: Sequence[str], n_repetitions: int, n_jobs: int) -> list[Table]:
    """Simulate and score presses of four specimens at three angles in every world, and judge them."""
    names = named(asked)
    absent = {name: world_named(name).absent for name in names}
    presses = [
        (name, PressSettings(stiffness_n_per_mm=SPECIMENS[specimen], angle_deg=angle, repetition=repetition))
        for name, angle, specimen, repetition in product(
            (name for name in names if not absent[name]), ANGLES_DEG, (*CALIBRATION, UNKNOWN), range(n_repetitions)
        )
    ]
    results = list(_scored(presses, n_jobs))
    skipped = tuple(f"{name}: skipped, {why}" for name, why in absent.items() if why)
    return [world_table(results, skipped), kappa_table(results)]


def _scored(presses: Sequence[tuple[str, PressSettings]], n_jobs: int) -> Iterator[WorldScore]:
    columns = list(zip(*presses, strict=True)) or [(), ()]
    if n_jobs == 1:
        yield from _counted(map(world_scored, *columns), len(presses))
        return
    # OpenCV and numba have threads of their own, which a forked process would not
    with ProcessPoolExecutor(n_jobs, mp_context=get_context("spawn")) as pool:
        yield from _counted(pool.map(world_scored, *columns, chunksize=4), len(presses))


def _counted(results: Iterator[WorldScore], total: int) -> Iterator[WorldScore]:
    for done, result in enumerate(results, 1):
        if sys.stderr.isatty():
            print(f"\rbench: {done} of {total}", end="\n" if done == total else "", file=sys.stderr, flush=True)
        yield result


def world_table(results: Sequence[WorldScore], skipped: tuple[str, ...] = ()) -> Table:
    """Areas and CASR of each world, and of all of them."""
    names = list(dict.fromkeys(result.world for result in results))
    rows = [_row(name, [result for result in results if result.world == name]) for name in names]
    if len(names) > 1:
        rows.append(_row("(all)", list(results)))
    columns = [("world", ""), ("n", ".0f"), ("refused %", ".0f")]
    for force in FORCES_N:
        columns += [(f"A({force:g} N) %", "+.1f"), (f"within {NEAR_PERCENT:g} %", ".0f")]
    columns += [("front %", "+.1f"), ("sd", ".1f"), ("held %", ".0f"), ("half %", ".1f"), ("analytic %", ".0f")]
    columns += [("skin %", "+.1f"), ("sd", ".1f"), ("held %", ".0f"), ("half %", ".1f")]
    notes = (
        f"A(F): median error of the front's area, where the true radius is {LEAST_PITCHES:g} pitches or more.",
        "front, skin: mean error of CASR against that of the true area, and its standard deviation over presses.",
        "held: share of presses whose total 95 % interval holds the truth. half: median half width of that interval.",
        "analytic: share of presses in which the analytic model has a say. Refused presses count in that column alone.",
        *skipped,
    )
    return Table("press_worlds", "Areas and CASR by world", tuple(columns), rows, notes)


def _row(name: str, results: Sequence[WorldScore]) -> list[Cell]:
    told = [result for result in results if not result.refused]
    row: list[Cell] = [name, float(len(results)), _percent([bool(result.refused) for result in results])]
    for force in FORCES_N:
        errors = np.array([result.area_error_percent.get(force, np.nan) for result in told])
        errors = errors[np.isfinite(errors)]
        row += [float(np.median(errors)), _percent(np.abs(errors) <= NEAR_PERCENT)] if errors.size else [None, None]
    row += _judged(told, "front")
    row.append(_percent([result.model != "finite elements" for result in told]))
    return row + _judged(told, "skin")


def _judged(told: Sequence[WorldScore], quantity: str) -> list[Cell]:
    """Mean error, its standard deviation, coverage and median half width, percent."""
    found = [(getattr(result, quantity), result.true_casr) for result in told]
    errors = np.array([float(percent_error(each.value, truth)) for each, truth in found])
    errors = errors[np.isfinite(errors)]
    if not errors.size:
        return [None] * 4
    halves = [100 * (np.sqrt(each.high / each.low) - 1) for each, _ in found if np.isfinite(each.low)]
    half = float(np.median(halves)) if halves else None
    return [float(errors.mean()), sample_sd(errors), _percent([each.holds(truth) for each, truth in found]), half]


def _percent(those: Sequence[bool] | np.ndarray) -> float | None:
    return 100 * float(np.mean(those)) if len(those) else None


def kappa_table(results: Sequence[WorldScore]) -> Table:
    """Stiffness of the unknown specimen from one press of each, in one world and between worlds."""
    at = {(r.world, r.stiffness_n_mm, r.angle_deg, r.repetition): r for r in results}
    names = list(dict.fromkeys(result.world for result in results))
    pairs = [(name, name) for name in names] + [pair for pair in UNLIKE if set(pair) <= set(names)]
    rows: list[list[Cell]] = []
    for known_in, unknown_in in pairs:
        tries = [
            ([at[known_in, SPECIMENS[name], angle, n] for name in CALIBRATION], at[unknown_in, kappa, angle, n])
            for kappa in [SPECIMENS[UNKNOWN]]
            for angle, n in dict.fromkeys((r.angle_deg, r.repetition) for r in results)
        ]
        title = known_in if known_in == unknown_in else f"{known_in} -> {unknown_in}"
        row: list[Cell] = [title, float(len(tries))]
        for quantity in ("exact", "front", "skin"):
            row += _kappa_errors(tries, quantity)
        rows.append([*row, _percent([_unlike(known, unknown) for known, unknown in tries])])
    columns = [("calibrated in -> pressed in", ""), ("n", ".0f")]
    for quantity in ("exact", "front", "skin"):
        columns += [(f"{quantity} %", "+.1f"), ("5 %", "+.0f"), ("95 %", "+.0f")]
        columns += [("none %", ".0f"), ("held %", ".0f")] if quantity != "exact" else []
    columns.append(("told apart %", ".0f"))
    notes = (
        f"kappa of {UNKNOWN} ({SPECIMENS[UNKNOWN]:g} N/mm) from one press each of {', '.join(CALIBRATION)}, at each",
        "  angle, by 1/kappa = a + b CASR^1.5 (decision 16): median, 5 and 95 % points of the error. none: no kappa.",
        "exact: true CASR of the same presses. held: kappa at the ends of the unknown press's total interval holds the",
        "  truth. told apart: `casr score` of all four presses says to check the unknown one.",
    )
    return Table("press_worlds_kappa", "Stiffness by world", tuple(columns), rows, notes)


Try = tuple[list[WorldScore], WorldScore]


def _kappa_errors(tries: Sequence[Try], quantity: str) -> list[Cell]:
    errors, held = [], []
    for known, unknown in tries:
        told = quantity == "exact" or not any(result.refused for result in (*known, unknown))
        casr = [_value(result, quantity).value for result in (*known, unknown)] if told else [np.nan] * 4
        asked = _value(unknown, quantity)
        stiffness = np.array([result.stiffness_n_mm for result in known])
        law = fit_law("compliance", "casr", np.array([casr[:3]]), stiffness[None])
        kappa, soft, stiff = law.at(np.array([[asked.value, asked.high, asked.low]]))[0]
        errors.append(float(percent_error(kappa, unknown.stiffness_n_mm)) if told and not law.rises[0] else np.nan)
        # a law has no kappa beyond the stiffness of the sensor: that end is open
        held.append(soft <= unknown.stiffness_n_mm and not stiff < unknown.stiffness_n_mm)
    known_errors = np.array([error for error in errors if np.isfinite(error)])
    middle = np.percentile(known_errors, (50, 5, 95)).tolist() if known_errors.size else [None] * 3
    if quantity == "exact":
        return middle
    return [*middle, _percent(~np.isfinite(errors)), _percent(np.array(held)[np.isfinite(errors)])]


def _value(result: WorldScore, quantity: str) -> Found:
    if quantity == "exact":
        return Found(result.true_casr, result.true_casr, result.true_casr)
    found: Found = getattr(result, quantity)
    return found


def _unlike(known: Sequence[WorldScore], unknown: WorldScore) -> bool:
    """Whether ``casr score`` of all of them would say to check the unknown press."""
    stretches = {str(n): each.stretch for n, each in enumerate((*known, unknown)) if each.stretch is not None}
    return str(len(known)) in unlike_others(stretches)
