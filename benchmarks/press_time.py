"""What a press costs: to score it, and to judge it frame by frame while the finger presses.

Presses of the emulated rig, as the how-to of unknown objects makes them. CPU time only: whole processes as the system
counts them, and within one process. Beside another revision, whose checkout is given, each measurement is made of both
in turn, so that whatever else the computer does meets both alike.

    python -m benchmarks.press_time --before CHECKOUT | python -m benchmarks.bench.record press_time
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

RUNS = ("S2_0_high-stiffness", "S4_0_high-stiffness", "S5_0_high-stiffness")
CALIBRATION = "reports/bench/calibrations/high-stiffness_0.json"
ROUNDS, SCORES = 4, 5
CONTACT_N, HOLD_S, LAG_S = 0.5, 0.0125, 0.05
QUANTITIES = {
    "command": "`casr score` of a press of {frames} loaded frames, whole process",
    "warm": "the same in a process that has scored one before",
    "late": "one of {late_frames} frames whose lag of {lag} ms is found and taken off",
    "frame": "a frame in contact, its answer, median",
    "frame_p95": "the same, 95 %",
    "settled": "what is left for the time between frames, median",
    "settled_p95": "the same, 95 %",
    "judged": "of that, where the press has reached a further force of the calibration, median",
    "answer": "from the exposure of a frame in contact to its answer, on a core of its own, median",
    "answer_p95": "the same, 95 %",
    "fit": "kappa of all {presses} presses at once (`estimate_kappa`)",
}


def measured(root: Path) -> dict[str, float]:
    """By the packages on this process's path; milliseconds of CPU, and counts."""
    import cv2

    from casr.frame_files import open_frames
    from casr.frame_files.camera_file import read_camera
    from casr.kappa.estimate import estimate_kappa
    from casr.kappa.presses import KappaPress
    from casr.scoring import score
    from emg2vsa.calibration_file import open_calibration
    from emg2vsa.rig.kappa.live_kappa import KappaPlan, LiveKappa

    cv2.setNumThreads(1)
    folders = [root / "runs-virtual" / name for name in RUNS]
    camera, calibration = read_camera(folders[0] / "camera.toml"), open_calibration(root / CALIBRATION)
    warm, late, frames, settled, judged, answers, presses, loaded = [], [], [], [], [], [], [], {}
    for path, lag_s, spent in ((folders[-1], 0.0, warm), (folders[1], LAG_S, late)):
        for _ in range(SCORES):
            sequence = open_frames(path / "press-001")
            stamped = replace(sequence.readings, frame_time_s=sequence.readings.frame_time_s + lag_s)
            sequence = replace(sequence, readings=stamped, force_n=stamped.at_frames())
            start = time.process_time()
            scored = score(sequence)
            spent.append(time.process_time() - start)
            loaded[path] = len(scored.frames)
    assert scored.camera_lag is not None
    assert scored.camera_lag.corrected_s > 0
    for folder in folders:
        kappa = LiveKappa(KappaPlan("known.json", calibration, camera, None))
        for number, path in enumerate(sorted(folder.glob("press-*")), 1):
            sequence = open_frames(path)
            presses.append(KappaPress.of_score(score(sequence), specimen=folder.name[:2], mounting=folder.name))
            read, told, until_s, free_s = sequence.readings, float("nan"), -np.inf, -np.inf
            for index in range(len(sequence)):
                image, time_s = np.asarray(sequence[index]), float(read.frame_time_s[index])
                new = (read.time_s > until_s) & (read.time_s <= time_s + HOLD_S)
                rows, until_s = list(zip(read.time_s[new], read.force_n[new], strict=True)), time_s + HOLD_S
                start = time.process_time()
                row = kappa.frame(number, time_s, image, rows)
                answered = time.process_time()
                kappa.settle()
                end = time.process_time()
                press = kappa._press
                answered_s = max(time_s + HOLD_S, free_s) + answered - start
                free_s = answered_s + end - answered
                if row.force_n >= CONTACT_N and press is not None and press.goes_on:
                    frames.append(answered - start)
                    settled.append(end - answered)
                    answers.append(answered_s - time_s)
                    judged += [end - answered] if press.state.judged_at_n != told else []
                    told = press.state.judged_at_n
            kappa.press_over()
    start = time.process_time()
    estimate_kappa(presses, camera)
    fit = time.process_time() - start
    found = {
        "warm": np.median(warm[1:]), "late": np.median(late), "frame": np.median(frames),
        "frame_p95": np.percentile(frames, 95), "settled": np.median(settled),
        "settled_p95": np.percentile(settled, 95), "judged": np.median(judged), "fit": fit,
        "answer": np.median(answers), "answer_p95": np.percentile(answers, 95),
    }  # fmt: skip
    counts = {"frames": loaded[folders[-1]], "late_frames": loaded[folders[1]], "presses": len(presses)}
    return {name: 1e3 * float(value) for name, value in found.items()} | counts


def of(checkout: Path, root: Path) -> dict[str, float]:
    """One round of a checkout, in processes of its own."""
    given = {**os.environ, "PYTHONPATH": str(checkout), "PYTHONPYCACHEPREFIX": str(root / "bytecode")}
    given.pop("PYTHONDONTWRITEBYTECODE", None)

    def run(*words: str) -> str:
        command = [sys.executable, *words]
        return subprocess.run(command, cwd=root, env=given, check=True, capture_output=True, text=True).stdout

    press = root / "runs-virtual" / RUNS[-1] / "press-001"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run("-m", "casr.cli", "score", str(press))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    found: dict[str, float] = json.loads(run("-P", str(Path(__file__).resolve()), "--measure", str(root)))
    return {"command": 1e3 * command, **found}


def page(checkouts: dict[str, Path], root: Path) -> Iterator[str]:
    """Markdown."""
    for checkout in checkouts.values():  # so that bytecode is there
        of(checkout, root)
    rounds = [{name: of(checkout, root) for name, checkout in checkouts.items()} for _ in range(ROUNDS)]
    names = list(checkouts)
    yield "# What a press costs"
    yield ""
    turns = f", in which {' and '.join(names)} took turns; ratio: median of the rounds' ratios, and their range"
    yield f"CPU time of one thread, ms: median of {ROUNDS} rounds{turns if len(names) > 1 else ''}."
    yield "Presses of the emulated rig, 20 frames a second, 127 pins; on line those of three specimens, by presses"
    yield f"of three known ones. An answer waits {1e3 * HOLD_S:g} ms for the readings that tell the force at its frame."
    yield f"Load average {os.getloadavg()[0]:.0f} on {os.cpu_count()} cores."
    yield ""
    yield f"| what | {' | '.join(names)} |" + (" ratio | range |" if len(names) > 1 else "")
    yield "|---|" + "---:|" * (len(names) + (2 if len(names) > 1 else 0))
    for key, text in QUANTITIES.items():
        values = {name: np.array([each[name][key] for each in rounds]) for name in names}
        cells = [f"{np.median(value):.3g}" for value in values.values()]
        if len(names) > 1:
            ratio = values[names[1]] / values[names[0]]
            cells += [f"{np.median(ratio):.2f}", f"{ratio.min():.2f} to {ratio.max():.2f}"]
        counts = {name: round(rounds[0][names[-1]][name]) for name in ("frames", "late_frames", "presses")}
        counts["lag"] = round(1e3 * LAG_S)
        yield f"| {text.format(**counts)} | {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--before", type=Path, help="checkout of another revision")
    parser.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        print(json.dumps(measured(arguments.measure)))
        return
    from benchmarks.online_kappa import calibrated
    from emg2vsa.cli import main as cli

    now = {"now": Path(__file__).resolve().parents[1]}
    checkouts = {"before": arguments.before.resolve(), **now} if arguments.before else now
    with tempfile.TemporaryDirectory() as folder, open(os.devnull, "w") as nowhere:
        root, out, sys.stdout = Path(folder), sys.stdout, nowhere
        calibrated(1, root)
        rig = ["rig", "run", str(root / "rig.toml"), "--virtual", "--jobs", "2"]
        assert cli([*rig, "--specimen", "S2", "--specimen", "S4", "--repetitions", "2"]) == 0
        sys.stdout = out
        print("\n".join(page(checkouts, root)))


if __name__ == "__main__":
    main()
