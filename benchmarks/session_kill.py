"""``kill -9`` at random moments of a session: what was recorded stays, and the session goes on to its end.

A child runs a session of a small study (emulated participant and operator, six presses, faster than real time, with the
disk's thread and fsync as in a real one), and tells every verdict that its page shows. The parent kills it at a random
moment, looks at what lies on the disk, and resumes it, 50 times in all; a session that is complete is written as BIDS
and begun anew with another order. Counted after every kill: verdicts that were shown and are not in the journal,
presses that are interrupted, which is at most the one under way; bytes that belong to no whole line or block; files
that cannot be read. Run: python -m benchmarks.session_kill
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

STUDY = """\
[study]
name = "kill"
title = "A session that is killed"
[participants]
ids = [{ids}]
[[specimens]]
name = "S1"
[[specimens]]
name = "S3"
[recordings]
layout = "bids"
root = "data"
task = "press"
[channels.emg.EDC]
name = "EDC"
[channels.emg.FDS]
name = "FDS"
[channels.force]
name = "Fz"
[session]
emg.kind = "simulated"
force.kind = "simulated"
repetitions = 3
pause_s = 1.0
[simulation]
seed = 7
a_v = {{ S1 = 42e-6, S3 = 28e-6 }}
b_v = {{ S1 = 20e-6, S3 = 13e-6 }}
"""
PRESSES = 6
SPEED = 8.0
RESULT = Path(__file__).parent / "results" / "session_kill.md"


def child(study_file: Path, participant: str, resume: bool) -> None:
    """A sitting; one line on the standard output for each command and each verdict that a page would show."""
    from emg2vsa.rig.clock import FastClock
    from emg2vsa.session.emulated.operator import EmulatedOperator
    from emg2vsa.session.emulated.simulated import simulate
    from emg2vsa.session.open_session import open_session
    from emg2vsa.study_file import load_study

    study = load_study(study_file)
    clock = FastClock(SPEED)
    assert study.session is not None
    person, emg, force = simulate(study, study.session, participant, clock)
    told: set[tuple[int, int]] = set()
    command = ""
    with open_session(study, participant, clock, (lambda: emg, lambda: force), resume=resume) as desk:
        told |= {(press.number, press.attempt) for press in desk.operator()[1].presses if press.verdict}
        person.watch(desk)
        operator = EmulatedOperator(desk, person.place)

        def beside(now_s: float) -> None:
            nonlocal command
            operator.turn(now_s)
            if desk.force().command != command:
                command = desk.force().command
                os.write(1, f"command {command}\n".encode())
            for press in desk.operator()[1].presses:
                if press.verdict and (press.number, press.attempt) not in told:
                    told.add((press.number, press.attempt))
                    os.write(1, f"verdict {press.number} {press.attempt}\n".encode())

        desk.run(clock, beside)
        os.write(1, f"ended {desk.session.ended.how if desk.session.ended else ''}\n".encode())


def sitting(study_file: Path, participant: str, resume: bool, kill_after_s: float | None) -> tuple[list[str], float]:
    """Lines that a child told, and its seconds; killed so long after its first line, or left to its end."""
    words = [sys.executable, "-m", "benchmarks.session_kill", "--child", str(study_file), participant]
    process = subprocess.Popen([*words, *(["--resume"] if resume else [])], stdout=subprocess.PIPE)
    assert process.stdout is not None
    lines = [process.stdout.readline().decode().strip()]
    begun = time.perf_counter()
    try:
        rest, _ = process.communicate(timeout=kill_after_s)
    except subprocess.TimeoutExpired:
        process.kill()
        rest, _ = process.communicate()
    return [*lines, *rest.decode().splitlines()], time.perf_counter() - begun


def look(folder: Path) -> dict[str, Any]:
    """What lies on the disk."""
    from emg2vsa.errors import Emg2vsaError
    from emg2vsa.session.journal import JOURNAL_FILE, Interrupted, Judged, PressBegun, PressEnded, read_journal
    from emg2vsa.session.plan import PLAN_FILE, read_plan
    from emg2vsa.session.raw_files import SampleFile

    found: dict[str, Any] = {"unreadable": 0, "torn": 0, "judged": set(), "running": 0, "interrupted": 0}
    try:
        read_plan(folder / PLAN_FILE)
        path = folder / JOURNAL_FILE
        lines, whole = read_journal(path)
        found["torn"] += path.stat().st_size - whole
    except Emg2vsaError:
        return found | {"unreadable": 1}
    events = [line.event for line in lines]
    over = {(event.press, event.attempt) for event in events if isinstance(event, (PressEnded, Interrupted))}
    found["judged"] = {(event.press, event.attempt) for event in events if isinstance(event, Judged)}
    found["running"] = len({(e.press, e.attempt) for e in events if isinstance(e, PressBegun)} - over)
    found["interrupted"] = sum(isinstance(event, Interrupted) for event in events)
    for samples in folder.glob("*.samples"):
        try:
            file = SampleFile(samples)
            file.read(0, file.stop)
            found["torn"] += file.passed_over
        except Emg2vsaError:
            found["unreadable"] += samples.stat().st_size > 0
    return found


def finished(study_file: Path, participant: str, folder: Path) -> tuple[str, int]:
    """Verdict of check on the recordings of a session that went to its end, and its usable presses."""
    import dataclasses

    from emg2vsa.cli.check import judge, of_participants
    from emg2vsa.cli.progress import progress
    from emg2vsa.session.dataset import write_dataset
    from emg2vsa.study_file import load_study

    study = load_study(study_file)
    write_dataset(folder, study)
    study = load_study(study_file)
    (verdict,) = judge(of_participants(study, [participant]), study, 1, progress(quiet=True), None)
    return verdict.verdict, sum(dataclasses.replace(each).usable for each in verdict.specimens)


def run(kills: int, seed: int, longest_s: float) -> str:
    """The table, as Markdown; ``longest_s``: no further kill after so long."""
    from emg2vsa.session.open_session import folder_of
    from emg2vsa.study_file import load_study

    rng = random.Random(seed)
    work = Path(tempfile.mkdtemp())
    people = [f"P{n:02d}" for n in range(1, 60)]
    study_file = work / "study.toml"
    study_file.write_text(STUDY.format(ids=", ".join(f'"{p}"' for p in people)), encoding="utf-8")
    study = load_study(study_file)
    sums: Counter[str] = Counter()
    moments: Counter[str] = Counter()
    ends: list[tuple[str, int]] = []
    person, resume, most_lost = 0, False, 0
    begun = time.perf_counter()
    while (killing := sums["kills"] < kills and time.perf_counter() - begun < longest_s) or resume:
        lines, _ = sitting(study_file, people[person], resume, rng.uniform(0.0, 6.0) if killing else None)
        folder = folder_of(study, people[person])
        known = look(folder)
        shown = {tuple(map(int, line.split()[1:])) for line in lines if line.startswith("verdict")}
        lost = len(shown - known["judged"])
        sums["shown"] += len(shown)
        sums["lost"] += lost
        sums["unreadable"] += known["unreadable"]
        if lines[-1].startswith("ended"):
            ends.append(finished(study_file, people[person], folder))
            person, resume = person + 1, False
            continue
        commands = [line.split()[1] for line in lines if line.startswith("command")]
        moments[commands[-1] if commands else "opening"] += 1
        sums["kills"] += 1
        sums["torn"] += known["torn"] > 0
        sums["running"] += known["running"]
        most_lost = max(most_lost, known["running"] + lost)
        resume = True
    shutil.rmtree(work)
    return table(sums, moments, ends, most_lost, seed, time.perf_counter() - begun)


def table(
    sums: Counter[str], moments: Counter[str], ends: list[tuple[str, int]], most_lost: int, seed: int, seconds: float
) -> str:
    when = ", ".join(f"{name} {n}" for name, n in moments.most_common())
    verdicts = ", ".join(f"{verdict} with {usable} of {PRESSES} presses" for verdict, usable in ends)
    rows = [
        ("kills", str(sums["kills"])),
        ("what the participant was told at that moment", when),
        ("verdicts that were shown before a kill or an end", str(sums["shown"])),
        ("of these not in the journal afterwards, so that the press is repeated", str(sums["lost"])),
        ("kills that interrupted a press", str(sums["running"])),
        ("most presses that one kill cost, the one under way or the one shown last", str(most_lost)),
        ("kills that left an unfinished line or block, which was passed over", str(sums["torn"])),
        ("files that could not be read", str(sums["unreadable"])),
        ("sessions that went on to their end", str(len(ends))),
        ("their recordings, as emg2vsa check judges them", verdicts),
    ]
    body = "\n".join(f"| {name} | {value} |" for name, value in rows)
    head = " ".join((__doc__ or "").partition("Run:")[0].split())
    return f"# A session that is killed\n\n{head}\n\nSeed {seed}; {seconds:.0f} s.\n\n| | |\n|---|---|\n{body}\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=16)
    parser.add_argument("--seconds", type=float, default=3600.0, help="no further kill after so long")
    parser.add_argument("--child", nargs=2, metavar=("STUDY", "PARTICIPANT"))
    parser.add_argument("--resume", action="store_true")
    arguments = parser.parse_args()
    if arguments.child:
        child(Path(arguments.child[0]), arguments.child[1], arguments.resume)
        return
    text = run(arguments.kills, arguments.seed, arguments.seconds)
    RESULT.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
