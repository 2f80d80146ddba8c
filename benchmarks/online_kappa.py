"""kappa while the finger presses: how often a press stops early, and whether its interval holds kappa where it stops.

Every experiment calibrates anew on S1, S3 and S5 and presses two unknown specimens once each, in worlds that the law of
the estimator does not describe (``press_curves``). Coverage at the stop stands beside that of the same presses carried
to their end.

    python -m benchmarks.online_kappa            # writes benchmarks/results/online_kappa.json
    python -m benchmarks.online_kappa frames 3   # presses of the emulated rig, from frames: appended to it
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.bench.record import keep, markdown
from benchmarks.press_curves import DEFAULT, LOW, WORLDS, Bench, Scatter
from emg2vsa.calibration.online import (
    AREA,
    BOTH,
    NO_GAIN,
    WIDTH_REACHED,
    OnlineCalibration,
    OnlineEstimator,
    OnlineState,
)
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


def pressed(bench: Bench, calibration: OnlineCalibration, kappa: float, wanted: float | None, cues: str) -> Press:
    """One press of an unknown specimen in a mounting of its own, to its end."""
    if wanted is None:
        reach = float(calibration.expected_reach(np.array([kappa]), 1, cues)[-1, 0])
        wanted = SPARE * calibration.half_width(kappa, reach, cues)
    online, press = OnlineEstimator(calibration, wanted), bench.press(kappa, bench.mounting())
    stopped, row, state = None, 0, OnlineState()
    for force, area in zip(press.force_n, press.area_mm2, strict=True):
        while cues == BOTH and row < press.row_n.size and press.row_n[row] <= force:
            online.push_travel(press.row_n[row], press.travel_mm[row])
            row += 1
        state = online.push(force, area)
        if state.stop and stopped is None:
            stopped = state
    return Press(wanted, stopped, state, kappa)


def experiments(bench: Bench, setting: Setting, cues: str, kappa: float, count: int) -> list[Press]:
    found = []
    for _ in range(count):
        calibration = bench.calibration(setting.mountings, setting.presses, setting.settings)
        found.append(pressed(bench, calibration, kappa, setting.wanted, cues))
    return found


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
    cost = np.median([p.end.amplification for p in presses])
    return (
        f"| {name} | {np.median([p.wanted for p in presses]):.0%} | {len(early) / n:.0%} | "
        f"{by[WIDTH_REACHED] / n:.0%} | {by[NO_GAIN] / n:.0%} | {force:.1f} | {width:.0%} | {at_stop:.1%} | "
        f"{at_end:.1%} | {error:.1%} | {cost:.1f} |"
    )


def table(setting: Setting, count: int) -> Iterator[str]:
    yield f"## {setting.name}"
    yield ""
    yield (
        "| world, cue, unknown | asked for | stopped early | by width | by no gain | at, N (median) | half width "
        "there | coverage at the stop | the same presses, whole | error of κ, whole (median) | % of κ for 1 % of CASR |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|"
    pooled: dict[str, list[Press]] = {AREA: [], BOTH: []}
    for make in WORLDS:
        world = make()
        for cues in (AREA, BOTH) if world.travel_mm is not None else (AREA,):
            for name, kappa in UNKNOWN.items():
                bench = Bench(world, setting.scatter, np.random.default_rng([7, round(100 * kappa), len(cues)]))
                found = experiments(bench, setting, cues, kappa, count)
                pooled[cues] += found
                yield row(f"{world.name}; {cues}; {name}", found)
    for cues, found in pooled.items():
        yield row(f"**all worlds; {cues}**", found)
    yield ""


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


def from_frames(seed: int, folder: Path) -> dict[str, list[KappaRow]]:
    """Unknown specimen to the last row of each of its judged presses, by the commands of the how-to."""
    (folder / "rig.toml").write_text(RIG.format(seed=seed))
    (folder / "study.toml").write_text(STUDY)
    rig = ["rig", "run", str(folder / "rig.toml"), "--virtual", "--jobs", "2"]
    known = [word for name in ("S1", "S3", "S5") for word in ("--specimen", name)]
    assert cli([*rig, *known, "--mounting", "1"]) == 0
    assert cli(["run", str(folder / "study.toml")]) == 0
    own = folder / "reports" / "bench" / "calibrations" / "high-stiffness_0.json"
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
    for setting in SETTINGS:
        lines += table(setting, count)
        print("\n".join(lines[-20:]), flush=True)
    lines.append(f"Made in {time.perf_counter() - start:.0f} s.")
    keep(RESULTS, "\n".join(lines))


if __name__ == "__main__":
    if sys.argv[1:2] == ["frames"]:
        append_frames(*map(int, sys.argv[2:]))
    else:
        main(*map(int, sys.argv[1:]))
