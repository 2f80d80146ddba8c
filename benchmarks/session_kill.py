"""``kill -9`` in every state of a session: what was recorded stays, and the session goes on to its end.

A child runs a session of a small study (emulated participant and operator, six presses of which two are badly done,
faster than real time, with the judge in its own process, and the disk's thread and fsync as in a real one). It tells
every state that it comes to, and every verdict that its page shows. The parent waits for a state, kills the child a
random time after it, looks at what lies on the disk, and resumes it, 50 times in all; a session that is complete is
written as BIDS and begun anew with another order. Counted after every kill: verdicts that were shown and are not in the
journal, presses that are interrupted, which is at most the one under way; bytes that belong to no whole line or block;
files that cannot be read. Run: python -m benchmarks.session_kill
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import random
import shutil
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

from benchmarks.bench.record import keep
from benchmarks.small_study import SIMULATED_SESSION, small_study

PRESSES = 6
SPEED = 8.0
MISTAKES = "dips@2", "aborted@5"
AFTER_S = {
    "opening": 1.0, "measuring": 1.0, "placing": 0.1, "rest": 0.2, "start": 0.05, "press": 0.25, "stop": 0.05,
    "judging": 0.1, "writing": 0.005, "deciding": 0.03, "pause": 0.1,
}  # fmt: skip
"The states in which it is killed, and the longest time after their beginning, on the wall."
RESULT = Path(__file__).parent / "results" / "session_kill.json"


def child(study_file: Path, participant: str, resume: bool, measure: bool, out: int) -> None:
    """A sitting; one line to ``out`` for each state and each verdict that a page would show."""
    from emg2vsa.devices.clock import FastClock
    from emg2vsa.session.open_session import open_session
    from emg2vsa.session.views import Request
    from emg2vsa.study_file import load_study
    from emg2vsa.worlds.people.mistakes import parse_mistakes
    from emg2vsa.worlds.people.pages import EmulatedOperator
    from emg2vsa.worlds.people.sensors import simulate

    study = load_study(study_file)
    clock = FastClock(SPEED)
    assert study.session is not None
    planted = parse_mistakes(MISTAKES, {"EDC": 1.0, "FDS": 1.0})
    person, emg, force = simulate(study, study.session, participant, clock, planted)
    told: set[tuple[int, int]] = set()
    state = ""
    with open_session(study, participant, clock, (lambda: emg, lambda: force), resume=resume) as desk:
        told |= {(press.number, press.attempt) for press in desk.operator()[1].presses if press.verdict}
        person.watch(desk)
        operator = EmulatedOperator(desk, person.place)
        if not measure:
            desk.ask(Request("continue"))

        def beside(now_s: float) -> None:
            nonlocal state
            operator.turn(now_s)
            if state_of(desk.session) != state:
                state = state_of(desk.session)
                os.write(out, f"state {state}\n".encode())
            for press in desk.operator()[1].presses:
                if press.verdict and (press.number, press.attempt) not in told:
                    told.add((press.number, press.attempt))
                    os.write(out, f"verdict {press.number} {press.attempt}\n".encode())

        desk.run(clock, beside)
        os.write(out, f"ended {desk.session.state.ended.how if desk.session.state.ended else ''}\n".encode())


def state_of(session: Any) -> str:
    """One of those in which it is killed."""
    now, state = session.now(), session.state
    if now.measuring:
        return "measuring"
    if now.judging:
        return "writing" if now.writing else "judging"
    if state.presses.undecided is not None:
        return "deciding"
    if state.command in ("start", "press", "stop", "pause"):
        return str(state.command)
    return "rest" if state.placed else "placing"


def sitting(
    study_file: Path, participant: str, resume: bool, state: str, times: int, after_s: float
) -> tuple[list[str], bool]:
    """Lines that a child told, and whether it was killed: so long after it came to a state so many times."""
    far, near = os.pipe()
    how = (study_file, participant, resume, state == "measuring", near)
    process = multiprocessing.get_context("fork").Process(target=child, args=how)
    process.start()
    os.close(near)
    lines: list[str] = []
    killed = state == "opening"
    with os.fdopen(far, encoding="utf-8") as told:
        if killed:
            time.sleep(after_s)
            process.kill()
        for line in told:
            lines.append(line.strip())
            if not killed and lines.count(f"state {state}") == times:
                time.sleep(after_s)
                killed = True
                process.kill()
    process.join()
    return lines, killed and not (lines and lines[-1].startswith("ended"))


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

    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.judged_sessions import judge, of_participants
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
    study_file.write_text(
        small_study(
            name="kill", participants=people, specimens=["S1", "S3"], task="press", simulation="seed = 7\n",
            tables=f"[session]\n{SIMULATED_SESSION}repetitions = 3\npause_s = 1.0\n",
        ), encoding="utf-8",
    )  # fmt: skip
    study = load_study(study_file)
    sums: Counter[str] = Counter()
    moments: Counter[str] = Counter()
    ends: list[tuple[str, int]] = []
    person, resume, most_lost = 0, False, 0
    begun = time.perf_counter()
    states: list[str] = []
    while (killing := sums["kills"] < kills and time.perf_counter() - begun < longest_s) or resume:
        if not states:
            states = list(AFTER_S)
            rng.shuffle(states)
        state = states.pop() if killing else ""
        after_s = rng.uniform(0.0, AFTER_S.get(state, 0.0))
        lines, killed = sitting(study_file, people[person], resume, state, rng.choice((1, 2)), after_s)
        folder = folder_of(study, people[person])
        if not (folder / "plan.json").exists():
            sums["before"] += 1
            continue
        known = look(folder)
        shown = {tuple(map(int, line.split()[1:])) for line in lines if line.startswith("verdict")}
        lost = len(shown - known["judged"])
        sums["shown"] += len(shown)
        sums["lost"] += lost
        sums["unreadable"] += known["unreadable"]
        if not killed:
            ends.append(finished(study_file, people[person], folder))
            person, resume = person + 1, False
            continue
        told = [line.split()[1] for line in lines if line.startswith("state")]
        moments[told[-1] if told else "opening"] += 1
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
        ("the last state that it had told", when),
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
    arguments = parser.parse_args()
    text = run(arguments.kills, arguments.seed, arguments.seconds)
    keep(RESULT, text)
    print(text)


if __name__ == "__main__":
    main()
