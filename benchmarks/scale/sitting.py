"""A session of any length in one sitting: what a minute of it costs at its beginning and at its end, and its memory.

An emulated participant presses in virtual time, with its sensors within the process (EMG of two muscles at 1 926 Hz,
force at 1 kHz). Afterwards the session is finished: recordings in BIDS, presses judged once more.
"""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.scale.people import ROOT, environment
from benchmarks.small_study import SIMULATED_SESSION, small_study

PERSON = "P01"
PRESS_S = 7.5
"""A press takes longer, with its pause."""
PART_S = 600.0
PAUSE_S = 1.0


def measured(length_s: float) -> dict[str, Any]:
    """The figures of a session that lasts ``length_s`` at least, from a process of its own."""
    command = [sys.executable, "-m", "benchmarks.scale.sitting", str(length_s)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT, env=environment())
    if done.returncode:
        raise RuntimeError(f"a session of {length_s:g} s ended with {done.returncode}: {done.stderr[-2000:]}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def _hold(folder: Path, length_s: float) -> dict[str, Any]:
    from emg2vsa.devices.clock import VirtualClock
    from emg2vsa.session.open_session import open_session
    from emg2vsa.study_file import load_study
    from emg2vsa.worlds.people.pages import EmulatedOperator
    from emg2vsa.worlds.people.participant import EmulatedParticipant
    from emg2vsa.worlds.people.person import person_of
    from emg2vsa.worlds.people.sensors import simulated_emg, simulated_force

    each = math.ceil(length_s / PRESS_S / 2)
    tables = f"[session]\n{SIMULATED_SESSION}repetitions = {each}\npause_s = {PAUSE_S}\n"
    text = small_study(participants=[PERSON], specimens=["S1", "S3"], task="press", tables=tables)
    (folder / "study.toml").write_text(text)
    study, clock = load_study(folder / "study.toml"), VirtualClock()
    assert study.session is not None
    person = EmulatedParticipant(person_of(study, PERSON), range_n=study.session.force_n)
    emg = simulated_emg(person, tuple(person.person.muscle_share), 1925.93, clock)
    force = simulated_force(person, clock)
    spent: list[tuple[float, float]] = []
    begun_s = time.process_time()
    with open_session(study, PERSON, clock, (lambda: emg, lambda: force), at_once=True) as desk:
        person.watch(desk)
        operator = EmulatedOperator(desk, person.place)

        def turn(now_s: float) -> None:
            if now_s >= PART_S * len(spent):
                spent.append((now_s, time.process_time()))
            operator.turn(now_s)

        desk.run(clock, turn)
        lasted_s, cpu_s = clock.now_s(), time.process_time() - begun_s
    return {
        "length_s": lasted_s,
        "presses": 2 * each,
        "cpu_s": cpu_s,
        "first": _per_second(spent[:2]),
        "last": _per_second(spent[-2:]),
        "memory_mb": peak_mb(),
    }


def _per_second(marks: list[tuple[float, float]]) -> float:
    """CPU seconds of a second of the session between two marks."""
    (begun_s, before), (ended_s, after) = marks
    return (after - before) / (ended_s - begun_s)


def peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        print(json.dumps(_hold(Path(name), float(sys.argv[1]))))
