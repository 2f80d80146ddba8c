"""Which specimen lay there: does a press tell it by force over depth, and does it never say so of the right one?

``python -m benchmarks.specimen_witness [--clean 6] [--wrong 4] | python -m benchmarks.bench.record specimen_witness``:
four minutes of one process. Presses of the emulated rig without its camera; each mounting has draws of its own.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import numpy as np

from benchmarks.dynamixel_faults import built
from benchmarks.rig.fault_bench import Built
from benchmarks.rig.plans import dynamixel_plan, modular_plan, rigid_plan
from casr.specimens import SPECIMENS
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.press_counts import verdicts, weighed
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.settings import EmulatedSettings

Actuator = Literal["qbmove", "rigid", "dynamixel"]
ACTUATORS: tuple[Actuator, ...] = ("qbmove", "rigid", "dynamixel")
ANGLES_DEG = 0.0, 30.0, 45.0
KAPPA = {"S0": 10.9} | SPECIMENS
"With one that is stiffer than those of the paper by 43 %, N/mm."
APART = 0.3
"Of the stiffer, by which specimens differ that must be told apart."
STARTED = datetime(2026, 1, 5, 9, tzinfo=UTC)


def _plan(actuator: Actuator, told: str, angle_deg: float) -> RunPlan:
    pressed = told if told in SPECIMENS else "S1"  # who has a schedule
    if actuator == "dynamixel":
        bench = built()
        assert bench.actuator is not None
        plan = dynamixel_plan(bench.actuator, bench.true.gear_mm_per_degree, 1, pressed)
    else:
        plan = (rigid_plan if actuator == "rigid" else modular_plan)(1, specimen=pressed)
    others = {name: kappa for name, kappa in KAPPA.items() if name != told}
    return replace(
        plan, specimen=told, schedule_from=None if pressed == told else pressed, angle_deg=angle_deg, pause_s=0.6,
        stiffness_n_per_mm=KAPPA[told], others_n_per_mm=others,
    )  # fmt: skip


def press(actuator: Actuator, told: str, on: str, angle_deg: float, mounting: int, folder: Path) -> Ended:
    """One press on specimen ``on``, where the plan says ``told``; how the run ended."""
    bench = built() if actuator == "dynamixel" else Built(rigid=actuator == "rigid")
    clock, emulated = VirtualClock(), EmulatedSettings(stiffness_n_per_mm=KAPPA)
    world = EmulatedRig(
        emulated, on, angle_deg, bench.rigid, clock, rig=bench.true, run=f"{actuator}, {on}", mounting=mounting,
        actuator=bench.actuator,
    )  # fmt: skip
    devices = replace(world.devices(), camera=None)
    return execute(_plan(actuator, told, angle_deg), bench.true, devices, folder, clock, started=STARTED)


@dataclass(frozen=True)
class Weighed:
    """One press. off : kappa over the truth, less 1; NaN where the run ended first. held : its interval has the truth.

    said : ok; the specimen that the press is like; or the guard that ended the run.
    """

    off: float
    held: bool
    said: str
    largest_n: float


def weigh(actuator: Actuator, told: str, on: str, angle_deg: float, mounting: int) -> Weighed:
    """As `press`."""
    with TemporaryDirectory() as root:
        ended = press(actuator, told, on, angle_deg, mounting, folder := Path(root) / "run")
        (verdict, why), kappa = verdicts(folder).get(1, ("none", "")), weighed(folder).get(1)
    like = why.partition("presses like ")[2].partition(" (")[0]
    said = ended.cause if ended.how == "guard" else like or verdict
    off, held = (kappa.kappa / KAPPA[on] - 1, kappa.low <= KAPPA[on] <= kappa.high) if kappa else (np.nan, False)
    return Weighed(off, held, said, ended.peak_force_n or 0.0)


def _right(mountings: int) -> Iterator[str]:
    yield f"\n## The right specimen, {mountings} mountings of each\n"
    yield "Error of kappa: mean and SD, percent. Held: 95 % intervals with the truth.\n"
    yield "| actuator | degrees | presses | " + " | ".join(KAPPA) + " | held (%) | not ok |"
    yield "|---|---:|---:|" + "---:|" * (len(KAPPA) + 2)
    for actuator, angle_deg in product(ACTUATORS, ANGLES_DEG):
        found = {
            name: [weigh(actuator, name, name, angle_deg, number + 1) for number in range(mountings)] for name in KAPPA
        }
        of_all = [each for some in found.values() for each in some]
        errors = [100 * np.array([each.off for each in some]) for some in found.values()]
        cells = [f"{np.nanmean(each):+.1f} ± {np.nanstd(each, ddof=1):.1f}" for each in errors]
        bad = Counter(each.said for each in of_all if each.said != "ok")
        told = ", ".join(f"{said}: {count}" for said, count in bad.items()) or "0"
        held = 100 * np.mean([each.held for each in of_all])
        yield f"| {actuator} | {angle_deg:g} | {len(of_all)} | {' | '.join(cells)} | {held:.0f} | {told} |"


def _wrong(mountings: int) -> Iterator[str]:
    yield f"\n## Another specimen, {mountings} mountings of each, at 0 and 45 degrees\n"
    yield "Rows: what the plan says. Of its presses: how many ended by the guard `specimen`, were doubtful by name, or"
    yield f"passed as ok. Pairs that differ by {APART:.0%} of the stiffer or more must be told."
    counts: Counter[str] = Counter()
    for actuator in ACTUATORS:
        yield f"\n### {actuator}\n\n| plan \\ bench | " + " | ".join(KAPPA) + " | largest felt (N) |"
        yield "|---|" + "---|" * (len(KAPPA) + 1)
        for told in KAPPA:
            cells, largest_n = [], 0.0
            for on in KAPPA:
                if on == told:
                    cells.append("")
                    continue
                found = [
                    weigh(actuator, told, on, angle_deg, 1 + number) for angle_deg in (0.0, 45.0)
                    for number in range(mountings)
                ]  # fmt: skip
                largest_n = max(largest_n, *(each.largest_n for each in found))
                said = Counter(each.said for each in found)
                cells.append(", ".join(f"{count} {name}" for name, count in said.most_common()))
                low, high = sorted((KAPPA[told], KAPPA[on]))
                if 1 - low / high >= APART - 0.005:
                    counts.update(["missed" if each.said == "ok" else "told" for each in found])
                    counts["misnamed"] += sum(each.said in KAPPA and each.said != on for each in found)
            yield f"| {told}, {KAPPA[told]:g} | {' | '.join(cells)} | {largest_n:.1f} |"
    yield f"\nOf such pairs: {counts['told']} told, {counts['missed']} missed, {counts['misnamed']} by another name."


def page(clean: int, wrong: int) -> Iterator[str]:
    yield "# The specimen as a witness"
    yield from _right(clean)
    yield from _wrong(wrong)


def main() -> None:
    """Print the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clean", type=int, default=6, help="mountings of the right specimen")
    parser.add_argument("--wrong", type=int, default=4, help="mountings of others")
    asked = parser.parse_args()
    for line in page(asked.clean, asked.wrong):
        print(line, flush=True)


if __name__ == "__main__":
    main()
