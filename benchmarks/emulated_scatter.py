"""How much presses and mountings of the emulated rig differ, and how often the interval of kappa holds the truth.

Run with ``python -m benchmarks.emulated_scatter [--write FILE]``, about three minutes of a processor. Presses of the
default world are scored from their frames; true slopes of many more mountings come from the world alone. An experiment
of the second table has a mounting of each specimen: true slopes of its presses, each times what scoring made of such a
press, are calibrated as those of a study are.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.rig.plans import modular_plan, rigid_plan
from casr.specimens import SPECIMENS
from emg2vsa.arrays import Floats
from emg2vsa.calibration.runs_calibration import calibrate_runs
from emg2vsa.rig.clock import VirtualClock
from emg2vsa.rig.emulated.press_draws import PressDraws
from emg2vsa.rig.emulated.settings import EmulatedSettings
from emg2vsa.rig.emulated.truth import TrueLoading, read_truth
from emg2vsa.rig.emulated.virtual_run import run_virtual
from emg2vsa.rig.emulated.world import World
from emg2vsa.rig.plan import RIGID, Condition
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.run_folders.presses import read_presses
from emg2vsa.runs import RunScores
from emg2vsa.runs.measured import Measured
from emg2vsa.runs.score_run import score_run
from emg2vsa.settings import RunSettings

Cell = tuple[str, float, Condition]
CELLS: tuple[Cell, ...] = (
    ("S1", 0.0, RIGID),
    ("S1", 0.0, "modular"),
    ("S2", 0.0, "modular"),
    ("S3", 0.0, "modular"),
    ("S5", 0.0, "modular"),
    ("S1", 45.0, "modular"),
)
SCORED, TRUE = (4, 3), (24, 6)
"Mountings and presses of each: scored from frames, and of the world alone."
EXPERIMENTS, PRESSES = 150, 10
NEW, KNOWN = "S2", ("S1", "S3", "S5")
STARTED = datetime(2026, 1, 5, 9, tzinfo=UTC)
RIG, SETTINGS = RigSettings(), RunSettings()
_STEP_S, _SPEED_MM_PER_S = 0.005, 5.0


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", type=Path, metavar="FILE", help="the same as Markdown there")
    path = parser.parse_args().write
    scored = {}
    for cell in CELLS:
        scored[cell] = scored_cell(cell, *SCORED)
        print(*cell, flush=True)
    text = "\n".join(_page(scored))
    print(text)
    if path:
        path.write_text(f"{text}\n", encoding="utf-8")


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
                    np.array([loading.casr_mm2_per_n for loading in read_truth(folder)]),
                    whole,
                )
            )
    return found


def true_slopes(specimen: str, angle_deg: float, mountings: int, presses: int, **changes: object) -> Floats:
    """(M, P) true CASR of presses at an even speed, mm2/N, without devices, frames or files."""
    slopes = np.empty((mountings, presses))
    settings = EmulatedSettings(**changes)  # type: ignore[arg-type]
    for m in range(mountings):
        draws = PressDraws(settings, specimen, angle_deg, True, RIG, "scatter", mounting=m + 1)
        for press in range(presses):
            slopes[m, press] = _true_press(draws, press).casr_mm2_per_n
    return slopes


def _true_press(draws: PressDraws, press: int) -> TrueLoading:
    world, seen = World(VirtualClock(), draws.world(press)), draws.seen(press)
    rad_per_s, time_s = np.radians(_SPEED_MM_PER_S / RIG.gear_mm_per_degree), 0.0
    while not world.loadings[0] or world.loadings[0][-1][0] < 7.05:
        time_s += _STEP_S
        world.shaft_rad(time_s, (rad_per_s * time_s, rad_per_s * time_s))
    forces, touches = zip(*world.loadings[0], strict=True)
    return TrueLoading(np.array(forces), np.array([seen.area_mm2(touch) for touch in touches]))


def scatter_percent(values: Floats) -> tuple[float, float]:
    """CV of presses about their mounting, and of mountings beyond what presses make of them, of (M, P) values."""
    logs = np.log(values)
    within = logs.var(axis=1, ddof=1).mean()
    between = logs.mean(axis=1).var(ddof=1) - within / logs.shape[1]
    return 100 * float(np.sqrt(within)), 100 * float(np.sqrt(max(0.0, between)))


def covered(scored: dict[Cell, list[Mounting]], seed: int) -> tuple[Floats, Floats]:
    """(E,) whether the interval of kappa holds the truth, and its half width as a share of it."""
    rng = np.random.default_rng(seed)
    names = (*KNOWN, NEW)
    slopes = {name: true_slopes(name, 0.0, *TRUE) for name in names}
    runs = {name: scored[name, 0.0, "modular"] for name in names}
    held, width = np.empty(EXPERIMENTS), np.empty(EXPERIMENTS)
    for e in range(EXPERIMENTS):
        drawn = [_drawn(runs[name], slopes[name], rng) for name in names]
        found = calibrate_runs(drawn, SPECIMENS, NEW).conditions[0].algorithms[SETTINGS.algorithm].chosen
        held[e] = found.low <= SPECIMENS[NEW] <= found.high
        width[e] = (found.high - found.low) / 2 / SPECIMENS[NEW]
    return held, width


def ratios(runs: list[Mounting]) -> Floats:
    """What scoring made of each true slope."""
    each = np.concatenate([run.casr / run.true_casr for run in runs])
    return np.asarray(each[np.isfinite(each)], dtype=np.float64)


def _drawn(runs: list[Mounting], slopes: Floats, rng: np.random.Generator) -> RunScores:
    """Presses of one mounting: true slopes of the world, each with the error of scoring of one that was scored.

    What the camera of a mounting adds is drawn once, what else scoring adds press by press."""
    run = runs[0].whole
    assert run is not None
    own = [np.log(each.casr / each.true_casr) for each in runs]
    of_mounting = np.mean(own[rng.integers(len(own))])
    of_press = np.concatenate([each - each.mean() for each in own])
    mounting = slopes[rng.integers(len(slopes))]
    casr = rng.choice(mounting, PRESSES) * np.exp(of_mounting + rng.choice(of_press, PRESSES))
    repeated = {name: np.resize(values, PRESSES) for name, values in run.casr.items()} | {run.algorithm: casr}
    # of all else only the exponent of the curves counts, and that is the same for every experiment
    many: dict[str, Any] = {
        each.name: np.resize(getattr(run, each.name), PRESSES)
        for each in fields(run)
        if isinstance(getattr(run, each.name), np.ndarray) and getattr(run, each.name).shape == (1,)
    }
    return replace(run, **many, casr=repeated, curves=run.curves * PRESSES)


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
        many = true_slopes(specimen, angle_deg, *TRUE)
        numbers = (*scatter_percent(casr), *scatter_percent(true), *scatter_percent(many), scatter_percent(start)[0])
        everything.append(numbers[:2])
        cells = " | ".join(f"{number:.1f}" for number in numbers)
        yield f"| {specimen} | {angle_deg:g} | {condition} | {cells} | {np.median(ratios(runs)):.3f} |"
    press, mounting = np.sqrt(np.mean(np.square(everything), axis=0))
    yield ""
    yield f"CASR over all cells: {press:.1f} % a press, {mounting:.1f} % a mounting (root mean square)."
    held, width = covered(scored, 1)
    error = np.sqrt(held.mean() * (1 - held.mean()) / held.size)
    yield ""
    yield (
        f"Stiffness of {NEW} from {', '.join(KNOWN)}, one mounting of {PRESSES} presses each, 0 degrees, modular: the "
        f"95 % interval holds it in {100 * held.mean():.1f} % of {EXPERIMENTS} experiments (standard error "
        f"{100 * error:.1f} %; all draw from the same {TRUE[0]} mountings); half of its width is "
        f"{100 * np.median(width):.0f} % of the stiffness (median)."
    )


if __name__ == "__main__":
    main()
