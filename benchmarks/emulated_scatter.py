"""How much presses and mountings of the emulated rig differ, and how often the interval of kappa holds the truth.

Run with ``python -m benchmarks.emulated_scatter [--write FILE]``, about a quarter of an hour of a processor. Presses of
the default world are scored from their frames; true rates of many more mountings come from the world alone, and so does
what each cause of scatter adds. An experiment of the last tables has a mounting of each specimen: true rates of its
presses, each times what scoring made of such a press, are calibrated as those of a study are.

A true rate is that of the rule of scores, a mean rate on a power law, through the true areas.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from datetime import UTC, datetime
from functools import cache
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.stats import f_oneway

from benchmarks.bench.record import print_page
from benchmarks.rig.plans import modular_plan, rigid_plan
from casr.specimens import SPECIMENS
from casr.spread import spread_rate
from emg2vsa.arrays import Floats
from emg2vsa.calibration.runs_calibration import calibrate_runs
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.rig.plan import RIGID, Condition
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.run_folders.presses import read_presses
from emg2vsa.run_scores import RunScores
from emg2vsa.run_scores.measured import Measured
from emg2vsa.run_scores.score_run import score_run
from emg2vsa.settings import CalibrationSettings, RunSettings
from emg2vsa.worlds.bench.press_draws import PressDraws
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.truth import TrueLoading, read_truth
from emg2vsa.worlds.bench.virtual_run import run_virtual
from emg2vsa.worlds.bench.world import World

Cell = tuple[str, float, Condition]
CELLS: tuple[Cell, ...] = (
    ("S1", 0.0, RIGID),
    ("S1", 0.0, "modular"),
    ("S2", 0.0, "modular"),
    ("S3", 0.0, "modular"),
    ("S5", 0.0, "modular"),
    ("S1", 45.0, "modular"),
)
SCORED, TRUE, TIMED = (3, 3), (24, 6), (16, 4)
"Mountings and presses of each: scored from frames, of the world alone, and of each cause of scatter."
EXPERIMENTS, PRESSES = 300, 10
DESIGNS = {"S2": ("S1", "S3", "S5"), "S3": ("S1", "S2", "S5")}
"New specimen to the known ones."
FRAME_HZ = 20.0
CAUSES: dict[str, tuple[str, ...]] = {
    "skin unevenness": ("area_sd",),
    "latency and jitter of the camera": (
        "camera_latency_s",
        "camera_latency_sd_s",
        "camera_jitter_s",
        "late_frames_share",
        "late_frames_s",
    ),
    "force zero": ("force_zero_sd_n",),
    "adhesion": ("adhesion_mj_per_m2", "adhesion_sd_mj_per_m2"),
    "state of the specimen": ("stiffness_sd",),
    "first press of a mounting": ("softening", "softening_sd"),
}
"To the keys of the emulated rig that make it; the others make nothing then."
MAKES_SCATTER = (
    "area_sd", "camera_latency_sd_s", "camera_jitter_s", "late_frames_share", "force_zero_sd_n",
    "adhesion_sd_mj_per_m2", "stiffness_sd", "softening", "softening_sd", "friction_sd", "angle_sd_deg",
    "depth_sd", "mounting_stiffness_sd", "sensor_modulus_sd", "landing_sd_mm",
)  # fmt: skip
STARTED = datetime(2026, 1, 5, 9, tzinfo=UTC)
RIG, SETTINGS = RigSettings(), RunSettings()
QUICK = CalibrationSettings(resamples=2)
"Bootstrap intervals are not looked at."
_STEP_S, _SPEED_MM_PER_S, _PEAK_N = 0.005, 5.0, 7.05


def main() -> None:
    """Print both tables."""
    print_page(__doc__, lambda: _page({cell: _scored(cell) for cell in CELLS}))


def _scored(cell: Cell) -> list[Mounting]:
    print(*cell, file=sys.stderr, flush=True)
    return scored_cell(cell, *SCORED)


@dataclass(frozen=True)
class Mounting:
    """(P,) CASR and area at 0.5 N as scored from frames, and true CASR, of presses of one mounting; ``whole`` : all
    that the stage of runs makes of the first press."""

    casr: Floats
    start_area: Floats
    true_casr: Floats
    whole: RunScores | None = None


def scored_cell(cell: Cell, mountings: int, presses: int) -> list[Mounting]:
    """Scores and truth of each mounting; the first one whole."""
    specimen, angle_deg, condition = cell
    plan = (
        rigid_plan(presses, specimen=specimen, angle_deg=angle_deg)
        if condition == RIGID
        else modular_plan(presses, specimen=specimen, condition=condition, angle_deg=angle_deg)
    )
    found = []
    for number in range(1, mountings + 1):
        with TemporaryDirectory() as name:
            folder = Path(name) / "run"
            run_virtual(replace(plan, mounting=number), RIG, EmulatedSettings(), folder, started=STARTED)
            scores = [
                Measured(press.frames, SETTINGS).numbers(SETTINGS.algorithm)
                for press in read_presses([folder])
                if press.frames is not None
            ]
            whole = None
            if number == 1:
                first = islice(read_presses([folder]), 1)
                whole = score_run(
                    first, SETTINGS, specimen=specimen, angle_deg=angle_deg, condition=condition, simulated=True
                )
            found.append(
                Mounting(
                    np.array([each.casr for each in scores]),
                    np.array([each.start_area for each in scores]),
                    np.array([true_rate(loading) for loading in read_truth(folder)]),
                    whole,
                )
            )
    return found


def true_rate(loading: TrueLoading) -> float:
    """CASR through true areas, mm2/N."""
    force_n = np.linspace(*SETTINGS.force_n, 40)
    return spread_rate(loading.area_at(force_n), force_n, rule="power").value


@cache
def true_rates(specimen: str, angle_deg: float, mountings: int, presses: int, **changes: Any) -> Floats:
    """(M, P) true CASR of presses at an even speed, mm2/N, without devices, frames or files."""
    return _by_mounting(specimen, angle_deg, mountings, presses, EmulatedSettings(**changes), timed=False)


def rates_in_time(specimen: str, settings: EmulatedSettings, mountings: int, presses: int) -> Floats:
    """(M, P) the same from true areas at the frames, over the forces at the times that the rig takes frames for."""
    return _by_mounting(specimen, 0.0, mountings, presses, settings, timed=True)


def _by_mounting(
    specimen: str, angle_deg: float, mountings: int, presses: int, settings: EmulatedSettings, *, timed: bool
) -> Floats:
    rates = np.empty((mountings, presses))
    for m in range(mountings):
        draws = PressDraws(settings, specimen, angle_deg, None, RIG, "scatter", mounting=m + 1)
        rng = np.random.default_rng((m, draws.sensor_seed))
        for press in range(presses):
            rates[m, press] = _in_time(draws, press, rng) if timed else true_rate(_true_press(draws, press))
    return rates


def _true_press(draws: PressDraws, press: int) -> TrueLoading:
    world, seen = World(VirtualClock(), draws.world(press)), draws.seen(press)
    for _ in _steps(world):
        pass
    forces, touches = zip(*world.loadings[0], strict=True)
    return TrueLoading(np.array(forces), np.array([seen.area_mm2(touch) for touch in touches]))


def _in_time(draws: PressDraws, press: int, rng: np.random.Generator) -> float:
    """Frames begin anywhere; their latency is that of the draws, of which the rig takes off the mean."""
    world, seen, timing = World(VirtualClock(), draws.world(press)), draws.seen(press), draws.frame_timing
    steps = [(time_s, float(world.force_n(time_s)[2]), world.touch(time_s)) for time_s in _steps(world)]
    times_s, forces, touches = (list(column) for column in zip(*steps, strict=True))
    exposed_s = np.arange(rng.random() / FRAME_HZ, times_s[-1], 1 / FRAME_HZ)
    late_s = timing.jitter_s * rng.standard_normal(exposed_s.size)
    late_s += timing.late_s * (rng.random(exposed_s.size) < timing.late_share)
    stamped_s = exposed_s + seen.latency_s + late_s - timing.mean_s
    felt_n = np.interp(stamped_s, times_s, forces) + draws.force_zero_n(press)
    low, high = SETTINGS.force_n
    used = np.flatnonzero((felt_n >= low) & (felt_n <= high) & (stamped_s <= times_s[-1]))
    shown = [touches[int(np.searchsorted(times_s, exposed_s[i]))] for i in used]
    return spread_rate(np.array([seen.area_mm2(touch) for touch in shown]), felt_n[used], rule="power").value


def _steps(world: World) -> Iterator[float]:
    """Times of a press at an even speed."""
    rad_per_s, time_s = np.radians(_SPEED_MM_PER_S / RIG.gear_mm_per_degree), 0.0
    while not world.loadings[0] or world.loadings[0][-1][0] < _PEAK_N:
        time_s += _STEP_S
        world.shaft_rad(time_s, (rad_per_s * time_s, rad_per_s * time_s))
        yield time_s


def scatter_percent(values: Floats) -> tuple[float, float]:
    """CV of presses about their mounting, and of mountings beyond what presses make of them, of (M, P) values."""
    logs = np.log(values)
    within = logs.var(axis=1, ddof=1).mean()
    between = logs.mean(axis=1).var(ddof=1) - within / logs.shape[1]
    return 100 * float(np.sqrt(within)), 100 * float(np.sqrt(max(0.0, between)))


@dataclass(frozen=True)
class Covered:
    """(E,) of experiments: whether kappa is determined, and whether there is any; whether the interval holds it; half
    of the interval as a share of it; |error| of kappa."""

    determined: Floats
    found: Floats
    held: Floats
    half: Floats
    error: Floats


def covered(scored: dict[Cell, list[Mounting]], new: str, mountings: int, seed: int) -> Covered:
    """Experiments in which each specimen is mounted so often, with ``PRESSES`` presses in all."""
    rng = np.random.default_rng(seed)
    names = (*DESIGNS[new], new)
    rates = {name: true_rates(name, 0.0, *TRUE) for name in names}
    errors = scoring_errors(scored)
    wholes = {name: scored[name, 0.0, "modular"][0].whole for name in names}
    found = []
    for _ in range(EXPERIMENTS):
        drawn = [_drawn(wholes[name], rates[name], errors, mountings, rng) for name in names]
        law = calibrate_runs(drawn, SPECIMENS, new, QUICK).conditions[0].algorithms[SETTINGS.algorithm].chosen
        found.append(
            (
                law.determined,
                np.isfinite(law.kappa),
                law.low <= SPECIMENS[new] <= law.high,
                (law.high - law.low) / 2 / SPECIMENS[new],
                abs(law.error),
            )
        )
    return Covered(*np.array(found, dtype=np.float64).T)


def scoring_errors(scored: dict[Cell, list[Mounting]]) -> list[Floats]:
    """(P,) ln of scored over true CASR of each mounting at 0 degrees, of all specimens."""
    return [
        np.log(run.casr / run.true_casr) for (_, angle_deg, _), runs in scored.items() if not angle_deg for run in runs
    ]


def alike_p(scored: dict[Cell, list[Mounting]]) -> float:
    """p of scoring doing the same to all specimens at 0 degrees: analysis of variance of the means of mountings."""
    groups = [
        [float(np.mean(np.log(run.casr / run.true_casr))) for run in runs]
        for (_, angle_deg, condition), runs in scored.items()
        if not angle_deg and condition != RIGID
    ]
    return float(f_oneway(*groups).pvalue)


def _drawn(
    run: RunScores | None, rates: Floats, errors: list[Floats], mountings: int, rng: np.random.Generator
) -> RunScores:
    """Presses of one specimen: true rates of mountings of the world, each with the error of scoring of one that was
    scored. What the camera of a mounting adds is drawn once, what else scoring adds press by press."""
    assert run is not None
    each = PRESSES // mountings
    of_press = np.concatenate([error - error.mean() for error in errors])
    of_press = of_press * np.sqrt(of_press.size / (of_press.size - len(errors)))
    casr = np.concatenate(
        [
            rng.choice(rates[rng.integers(len(rates))], each)
            * np.exp(errors[rng.integers(len(errors))].mean() + rng.choice(of_press, each))
            for _ in range(mountings)
        ]
    )
    repeated = {name: np.resize(values, casr.size) for name, values in run.casr.items()} | {run.algorithm: casr}
    # of all else only the exponent of the curves counts, and that is the same for every experiment
    many: dict[str, Any] = {
        each.name: np.resize(getattr(run, each.name), casr.size)
        for each in fields(run)
        if isinstance(getattr(run, each.name), np.ndarray) and getattr(run, each.name).shape == (1,)
    }
    many["mounting"] = np.repeat(np.arange(1, mountings + 1), each)
    return replace(run, **many, casr=repeated, curves=run.curves * casr.size)


def _page(scored: dict[Cell, list[Mounting]]) -> Iterator[str]:
    yield "# Scatter of presses and mountings on the emulated rig"
    yield ""
    yield f"`python -m benchmarks.emulated_scatter`: {SCORED[0]} mountings of {SCORED[1]} presses of each cell, scored"
    yield f"from their frames; {TRUE[0]} mountings of {TRUE[1]} presses of the world alone, at an even speed."
    yield "All but the last column are CV in percent."
    yield ""
    yield (
        "| specimen | angle, degrees | condition | CASR a press | CASR a mounting | true CASR a press | a mounting "
        "| true CASR, many: a press | a mounting | area at 0.5 N a press | measured over true CASR |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|"
    everything = []
    for (specimen, angle_deg, condition), runs in scored.items():
        casr, start, true = (
            np.array([getattr(run, name) for run in runs]) for name in ("casr", "start_area", "true_casr")
        )
        many = true_rates(specimen, angle_deg, *TRUE)
        numbers = (*scatter_percent(casr), *scatter_percent(true), *scatter_percent(many), scatter_percent(start)[0])
        everything.append(numbers[:2])
        cells = " | ".join(f"{number:.1f}" for number in numbers)
        yield f"| {specimen} | {angle_deg:g} | {condition} | {cells} | {np.exp(np.median(np.log(casr / true))):.3f} |"
    press, mounting = np.sqrt(np.mean(np.square(everything), axis=0))
    yield ""
    yield f"CASR over all cells: {press:.1f} % a press, {mounting:.1f} % a mounting (root mean square)."
    yield ""
    yield from _causes()
    yield ""
    yield from _coverage(scored)


def _causes() -> Iterator[str]:
    yield "What each cause makes of CASR a press, percent, by the world alone under the rigid motor at 5 mm/s and 0"
    yield f"degrees, with {FRAME_HZ:g} frames a second ({TIMED[0]} mountings of {TIMED[1]} presses):"
    yield ""
    yield "| cause | S1 | S5 |"
    yield "|---|---|---|"
    none: dict[str, Any] = dict.fromkeys(MAKES_SCATTER, 0.0)
    usual = EmulatedSettings()
    made = {"frames that fall anywhere, alone": replace(usual, **none), "all of them": usual}
    for cause, keys in CAUSES.items():
        made[cause] = replace(usual, **none | {key: getattr(usual, key) for key in keys})
    for cause, settings in made.items():
        both = [scatter_percent(rates_in_time(specimen, settings, *TIMED))[0] for specimen in ("S1", "S5")]
        yield f"| {cause} | {both[0]:.2f} | {both[1]:.2f} |"


def _coverage(scored: dict[Cell, list[Mounting]]) -> Iterator[str]:
    yield f"Stiffness at 0 degrees, modular, {PRESSES} presses of each specimen: {EXPERIMENTS} experiments a row, of"
    yield f"the same {TRUE[0]} mountings of the world. Errors of scoring are those of all specimens, which differ"
    yield f"in them by more than their mountings do at p = {alike_p(scored):.2g}. Half widths and errors are medians."
    yield ""
    yield (
        "| new | known | mountings of each | no kappa, % | not determined, % | determined, % | of these held, % "
        "| standard error, % | half width, % | error, % | held of all with a kappa, % |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|"
    for new, known in DESIGNS.items():
        for mountings in (1, 2, 5):
            got = covered(scored, new, mountings, 1)
            sure, any_found = got.determined > 0, got.found > 0
            held, of_all = np.mean(got.held[sure]), np.mean(got.held[any_found])
            numbers = (
                100 * np.mean(~any_found), 100 * np.mean(any_found & ~sure), 100 * np.mean(sure), 100 * held,
                100 * np.sqrt(held * (1 - held) / sure.sum()), 100 * np.median(got.half[sure]),
                100 * np.median(got.error[sure]), 100 * of_all,
            )  # fmt: skip
            cells = " | ".join(f"{number:.1f}" for number in numbers)
            yield f"| {new} | {', '.join(known)} | {mountings} | {cells} |"


if __name__ == "__main__":
    main()
