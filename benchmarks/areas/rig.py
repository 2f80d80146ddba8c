"""The control loop on the emulated rig: processor time of its turns, and the beat it keeps."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench.case import Area, Case, NotHere, Size, Way
from benchmarks.experts import frames_of_wire

STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)
RATE_HZ = 200.0


def turns(size: Size) -> Iterator[Case]:
    """Presses on a clock of its own: executor, drivers and the far ends of their wires in one process."""
    from benchmarks.rig.plans import modular_plan
    from emg2vsa.rig.executor.plan_limits import largest_force_n
    from emg2vsa.rig.rig_settings import RigSettings
    from emg2vsa.worlds.bench.settings import EmulatedSettings
    from emg2vsa.worlds.bench.virtual_run import run_virtual

    presses = size.pick(1, 3)
    plan = modular_plan(presses, pause_s=0.4)

    def pressed(exact: bool) -> Any:
        with tempfile.TemporaryDirectory() as folder:
            return run_virtual(
                plan, RigSettings(), EmulatedSettings(exact=exact), Path(folder) / "run", started=STARTED
            )

    expected_n = largest_force_n(plan, RigSettings())
    rows = pressed(exact=False).rows
    ways = (
        Way("emg2vsa", "run_virtual", lambda: pressed(exact=False), "equal"),
        Way("emg2vsa", "run_virtual, every turn by the wires", lambda: pressed(exact=True), "equal"),
        Way("Python", "expert: packed frames through pipes", lambda: frames_of_wire.turns(rows), "as used", BARE),
    )
    yield Case(
        f"{presses} presses of an emulated run", rows, f"turns of the loop at {RATE_HZ:g} Hz", ways,
        lambda ended: _missing(ended, rows), "relative",
        f"a completed run of as many turns; the plan expects {expected_n:.3g} N at most",
    )  # fmt: skip


BARE = "bytes alone: no control, no guards, no log, no physics"


def _missing(ended: Any, rows: int) -> float:
    """Share of the turns that a run lacks, of an expert's table, too; infinite where it did not end as planned."""
    if isinstance(ended, np.ndarray):
        return abs(len(ended) / rows - 1)
    return abs(ended.rows / rows - 1) if ended.how == "completed" else float("inf")


def beat(size: Size) -> Iterator[Case]:
    """The loop in real time against emulators in another process, beside a loop with nothing to do."""
    if sys.platform != "linux":
        raise NotHere("beat of the loop: needs Linux")
    from benchmarks.rig.loop_run import bare_loop, run_loop
    from emg2vsa.devices.clock import undisturbed

    seconds = size.pick(2.0, 20.0)

    def bare() -> Any:
        with undisturbed(), bare_loop(RATE_HZ) as found:
            time.sleep(seconds)
        return found.timing

    ways = (
        Way("emg2vsa", "control loop", lambda: run_loop(seconds, 0, steady=True).loop, "equal"),
        Way("emg2vsa", "loop with nothing to do", bare, "as used", "what the machine itself misses"),
    )
    yield Case(
        f"{seconds:g} s of the control loop in real time", seconds * RATE_HZ, f"turns at {RATE_HZ:g} Hz", ways,
        lambda timing: 1e3 * timing.p999_s, "ms, period error of 99.9 % of turns", "the clock",
    )  # fmt: skip


AREA = Area(
    name="rig",
    question="What does a turn of the control loop cost, and how well does the loop keep its beat?",
    parts=(turns, beat),
    peers={},
    meaning=(
        "A run on a clock of its own shows the processor time of the protocol: by the wires, every turn is a "
        "conversation byte for byte. In real time the emulators run in a process of their own, whose time "
        "counts too. Both loops have real-time priority where the system grants it; the loop with nothing to do "
        "shows the period errors that no loop on this machine could avoid. No expert's loop does equal work: packed "
        "frames through pipes show what the bytes alone cost."
    ),
)
