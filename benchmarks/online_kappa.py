"""kappa while the finger presses: when a press stops, and whether its interval holds kappa there.

By the pins: trials of ``benchmarks.kappa``, each dome left out of the tables in turn. By the area, as without a camera
file: every experiment calibrates anew on S1, S3 and S5 and presses two unknown specimens once each, in worlds that the
law of the estimator does not describe (``press_curves``). Coverage at the stop stands beside that of the same presses
carried to their end.

    python -m benchmarks.online_kappa            # writes benchmarks/results/online_kappa.json
    python -m benchmarks.online_kappa frames 3   # presses of the emulated rig, from frames: appended to it
    python -m benchmarks.online_kappa pins 8     # prints the table by the pins alone, of every eighth trial
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.bench.record import keep, markdown
from benchmarks.kappa import CAMERA, FORCES_N, N_FRAMES, Trial, library_without, presses_of, trials
from benchmarks.press_curves import DEFAULT, LOW, WORLDS, Bench, Scatter
from casr.kappa.estimate import fitted, stated_errors
from casr.kappa.family import families
from casr.kappa.known import KnownSensor
from casr.kappa.presses import FEWEST_FRAMES
from emg2vsa.calibration.cut_presses import cut_forces
from emg2vsa.calibration.online import (
    NO_GAIN,
    WIDTH_REACHED,
    OnlineCalibration,
    OnlineEstimator,
    OnlineState,
)
from emg2vsa.calibration.online_pins import NEW, KnownPins
from emg2vsa.cli import main as cli
from emg2vsa.rig.kappa.live_kappa import KappaRow, last_rows
from emg2vsa.settings import CalibrationSettings

RESULTS = Path(__file__).parent / "results" / "online_kappa.json"
UNKNOWN = {"S2": 5.32, "2.2 N/mm": 2.2}
EXPERIMENTS = 60
SPARE = 1.2
"Times the width that is promised before the first press: what is asked for with default scatter."


@dataclass(frozen=True)
class Setting:
    """How a calibration is made, and which width is asked for (None: that which can be reached)."""

    name: str
    scatter: Scatter
    mountings: int
    presses: int
    settings: CalibrationSettings
    wanted: float | None


ASSUMED = CalibrationSettings(mounting_sd_percent=2.5)
"As much as mountings differ in these worlds."
SETTINGS = (
    Setting("low, 10 presses", LOW, 1, 10, CalibrationSettings(mounting_sd_percent=0.0), 0.05),
    Setting("default, 10 presses of one mounting", DEFAULT, 1, 10, ASSUMED, None),
    Setting("default, 3 mountings of 4 presses", DEFAULT, 3, 4, ASSUMED, None),
)


@dataclass(frozen=True)
class Press:
    """Of one press: the width asked for, the state where it stopped (None: it did not) and at the end, the truth."""

    wanted: float
    stopped: OnlineState | None
    end: OnlineState
    kappa: float

    def held(self, state: OnlineState) -> bool:
        return state.low <= self.kappa <= state.high


def pressed(bench: Bench, calibration: OnlineCalibration, kappa: float, wanted: float | None) -> Press:
    """One press of an unknown specimen in a mounting of its own, to its end."""
    if wanted is None:
        reach = float(calibration.expected_reach(np.array([kappa]))[-1, 0])
        wanted = SPARE * calibration.half_width(kappa, reach)
    online, press = OnlineEstimator(calibration, wanted), bench.press(kappa, bench.mounting())
    stopped, state = None, OnlineState()
    for force, area in zip(press.force_n, press.area_mm2, strict=True):
        state = online.push(force, area)
        if state.stop and stopped is None:
            stopped = state
    return Press(wanted, stopped, state, kappa)


def experiments(bench: Bench, setting: Setting, kappa: float, count: int) -> list[Press]:
    found = []
    for _ in range(count):
        calibration = bench.calibration(setting.mountings, setting.presses, setting.settings)
        found.append(pressed(bench, calibration, kappa, setting.wanted))
    return found


HEADINGS = (
    "| world, unknown | asked for | stopped early | by width | by no gain | at, N (median) | half width "
    "there | coverage at the stop | the same presses, whole | error of κ, whole (median) |"
)
RULE = "|---|---|---|---|---|---|---|---|---|---|"


def row(name: str, presses: list[Press]) -> str:
    stops = [p for p in presses if p.stopped is not None]
    early = [p for p in stops if p.stopped and p.stopped.force_n < p.end.force_n]
    by = {why: sum(p.stopped.stop == why for p in stops if p.stopped) for why in (WIDTH_REACHED, NO_GAIN)}
    n = len(presses)
    at_stop = np.mean([p.held(p.stopped) for p in stops if p.stopped]) if stops else np.nan
    at_end = np.mean([p.held(p.end) for p in presses])
    width = np.median([p.stopped.half_width for p in stops if p.stopped]) if stops else np.nan
    force = np.median([p.stopped.force_n for p in stops if p.stopped]) if stops else np.nan
    error = np.median([abs(p.end.kappa / p.kappa - 1) for p in presses])
    return (
        f"| {name} | {np.median([p.wanted for p in presses]):.0%} | {len(early) / n:.0%} | "
        f"{by[WIDTH_REACHED] / n:.0%} | {by[NO_GAIN] / n:.0%} | {force:.1f} | {width:.0%} | {at_stop:.1%} | "
        f"{at_end:.1%} | {error:.1%} |"
    )


def table(setting: Setting, count: int) -> Iterator[str]:
    yield f"## {setting.name}"
    yield ""
    yield HEADINGS
    yield RULE
    pooled: list[Press] = []
    for make in WORLDS:
        world = make()
        for name, kappa in UNKNOWN.items():
            bench = Bench(world, setting.scatter, np.random.default_rng([7, round(100 * kappa), 4]))
            found = experiments(bench, setting, kappa, count)
            pooled += found
            yield row(f"{world.name}; {name}", found)
    yield row("**all worlds**", pooled)
    yield ""


EVERY = 8
"Trials of which one is made."


def pressed_by_pins(trial: Trial, wanted: float = 0.0) -> Press:
    """One press of the unknown specimen, judged by two of each known one."""
    *known, press, _ = presses_of(trial)
    library = library_without(trial.dome)
    labels = fitted(known, CAMERA, families(library), stated_errors(CAMERA))
    kappa = np.array(trial.known)
    online = OnlineEstimator(
        OnlineCalibration(
            specimens=tuple(f"{each:g}" for each in kappa), kappa=kappa, kappa_se=np.zeros(3), quantity="front",
            area_unit="mm2", angle_deg=0.0, condition="bench", start_n=FORCES_N[0], forces_n=cut_forces(*FORCES_N),
            rates=np.empty((3, 2, 0)), mounting=np.ones((3, 2), dtype=np.int64),
            pins=KnownPins(KnownSensor.of(labels), CAMERA, labels.family.digest),
        ), wanted, library,
    )  # fmt: skip
    assert press.force_n is not None
    stopped, state = None, OnlineState()
    for n in range(FEWEST_FRAMES, N_FRAMES + 1):
        part = {"pins_px": press.pins_px[:n], "force_n": press.force_n[:n], "mounting": online.mounting}
        state = online.follow_pins(replace(press, specimen=NEW, **part))
        stopped = stopped or (state if state.stop else None)
    return Press(wanted, stopped, state, trial.unknown)


def pins_table(every: int) -> Iterator[str]:
    yield "## By the pins"
    yield ""
    yield f"Of {len(trials(1, 1))} trials each {every}th; presses may stop where further frames would narrow nothing."
    yield ""
    yield HEADINGS.replace("world, unknown", "scatter of mountings")
    yield RULE
    pooled: dict[str, list[Press]] = {}
    for trial in trials(1, 1)[::every]:
        pooled.setdefault(f"{100 * trial.scatter:g} % of CASR", []).append(pressed_by_pins(trial))
    for name, found in pooled.items():
        yield row(name, found)
    yield row("**all**", [press for found in pooled.values() for press in found])
    doubts = sum(bool(press.end.doubt) for found in pooled.values() for press in found)
    yield f"\nPresses in doubt at their end: {doubts}.\n"


FRAMES_TITLE = "## From frames"
FROM_FRAMES = {"S2": 5.32, "S4": 3.12}
RIG = """\
[force]
kind = "net-ft"
host = "192.168.1.1"

[camera]
source = 0

[actuator]
port = "/dev/ttyUSB0"

[motor]
port = "/dev/ttyUSB1"

[experiment]
specimens = ["S1", "S3", "S5", "S2", "S4"]
angles_deg = {{ high-stiffness = [0] }}
repetitions = 3
mountings = 2
ramp_mm_per_s = 2
pause_s = 0.5
schedules = "schedules"

[emulated]
seed = {seed}
"""
STUDY = """\
[study]
name = "bench"

[[specimens]]
name = "S1"
stiffness_n_per_mm = 7.63

[[specimens]]
name = "S3"
stiffness_n_per_mm = 3.35

[[specimens]]
name = "S5"
stiffness_n_per_mm = 1.11

[runs]
root = "runs-virtual"
"""


def calibrated(seed: int, folder: Path) -> Path:
    """The calibration of S1, S3 and S5, by the commands of the how-to."""
    (folder / "rig.toml").write_text(RIG.format(seed=seed))
    (folder / "study.toml").write_text(STUDY)
    known = [word for name in ("S1", "S3", "S5") for word in ("--specimen", name)]
    assert cli(["rig", "run", str(folder / "rig.toml"), "--virtual", "--jobs", "2", *known, "--mounting", "1"]) == 0
    assert cli(["run", str(folder / "study.toml")]) == 0
    return folder / "reports" / "bench" / "calibrations" / "high-stiffness_0.json"


def from_frames(seed: int, folder: Path) -> dict[str, list[KappaRow]]:
    """Unknown specimen to the last row of each of its judged presses, by the commands of the how-to."""
    rig = ["rig", "run", str(folder / "rig.toml"), "--virtual", "--jobs", "2"]
    own = calibrated(seed, folder)
    new = [word for name in FROM_FRAMES for word in ("--specimen", name)]
    assert cli([*rig, *new, "--repetitions", "1", "--calibration", str(own), "--stop-at", "40"]) == 0
    runs = folder / "runs-virtual"
    return {
        name: [row for path in sorted(runs.glob(f"{name}_*/kappa.csv")) for row in last_rows(path)]
        for name in FROM_FRAMES
    }


def frames_section(seeds: int) -> list[str]:
    start, stopped, held, told = time.perf_counter(), 0, 0, 0
    lines = [
        FRAMES_TITLE,
        "",
        f"`python -m benchmarks.online_kappa frames {seeds}`: runs of the emulated rig with its default scatter, as",
        "docs/how-to/unknown-object.md makes them. For each seed S1, S3 and S5 are pressed three times in one",
        "mounting, and the unknown specimens once in each of two mountings, with `--stop-at 40`.",
        "",
        "| seed | unknown, N/mm | κ where it stopped, N/mm | interval | half width | at, N | cues | stopped | "
        "holds κ |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for seed in range(1, seeds + 1):
        with tempfile.TemporaryDirectory() as folder:
            found = from_frames(seed, Path(folder))
        for name, rows in found.items():
            for row in rows:
                holds = row.low_n_per_mm <= FROM_FRAMES[name] <= row.high_n_per_mm
                told, stopped, held = told + 1, stopped + bool(row.stop), held + bool(holds and row.stop)
                lines.append(
                    f"| {seed} | {name}, {FROM_FRAMES[name]} | {row.kappa_n_per_mm:.2f} | {row.low_n_per_mm:.2f} to "
                    f"{row.high_n_per_mm:.2f} | {row.half_width:.0%} | {row.judged_at_n:.1f} | {row.cues} | "
                    f"{row.stop or 'no'} | {'yes' if holds else 'no'} |"
                )
    lines += ["", f"{stopped} of {told} presses stopped; the interval held κ at {held} of these stops."]
    return [*lines, f"Made in {time.perf_counter() - start:.0f} s."]


def append_frames(seeds: int) -> None:
    before = markdown(json.loads(RESULTS.read_text())).split(f"\n{FRAMES_TITLE}")[0].rstrip("\n")
    keep(RESULTS, "\n".join([before, "", *frames_section(seeds)]))


def main(count: int = EXPERIMENTS) -> None:
    start = time.perf_counter()
    lines = [
        "# κ while the finger presses",
        "",
        f"`python -m benchmarks.online_kappa`: {count} experiments a row, each with a calibration of its own on S1, S3",
        "and S5 and one press of the unknown specimen in a mounting of its own. Presses are curves with the scatter of",
        "camera, force sensor, landing and mounting (no frames). Low scatter asks for 5 %; default scatter asks for",
        "1.2 times the half width that",
        "is promised before the first press. One standard error of a coverage of 95 % is 2 % in a row.",
        "",
    ]
    lines += pins_table(EVERY)
    for setting in SETTINGS:
        lines += table(setting, count)
        print("\n".join(lines[-20:]), flush=True)
    lines.append(f"Made in {time.perf_counter() - start:.0f} s.")
    keep(RESULTS, "\n".join(lines))


if __name__ == "__main__":
    if sys.argv[1:2] == ["frames"]:
        append_frames(*map(int, sys.argv[2:]))
    elif sys.argv[1:2] == ["pins"]:
        print("\n".join(pins_table(*map(int, sys.argv[2:]))))
    else:
        main(*map(int, sys.argv[1:]))
