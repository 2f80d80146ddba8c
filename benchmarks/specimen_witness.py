"""Which specimen lay there: does a press tell it by force over depth, and does it never say so of the right one?

``python -m benchmarks.specimen_witness [--clean 7] [--wrong 4] | python -m benchmarks.bench.record specimen_witness``:
8 minutes of a processor, 4 of two. Presses of the emulated rig without its camera; each has draws of its own.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal, NamedTuple

import numpy as np

from benchmarks.dynamixel_faults import built
from benchmarks.rig.fault_bench import Built
from benchmarks.rig.plans import SPEED_MM_PER_S, dynamixel_plan, modular_plan, rigid_plan
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
SPEEDS_MM_PER_S = 2.5, 5.0, 7.5
KAPPA = SPECIMENS | {"S_new": 10.9}
"With one that is stiffer than those of the paper by 43 %, N/mm."
APART = 0.3
"Of the stiffer, by which specimens differ that must be told apart."
PROCESSES = 2
STARTED = datetime(2026, 1, 5, 9, tzinfo=UTC)
_OF_WITNESS = "ok", "named", "doubtful", "ended"


class Case(NamedTuple):
    """One press of a plan for ``told``, and what lies ``on`` the bench."""

    actuator: Actuator
    told: str
    on: str
    angle_deg: float
    mounting: int
    speed_mm_per_s: float = SPEED_MM_PER_S


def _plan(case: Case) -> RunPlan:
    told, pressed = case.told, case.told if case.told in SPECIMENS else "S1"  # who has a schedule
    speed = {"ramp_mm_per_s": case.speed_mm_per_s}
    if case.actuator == "dynamixel":
        bench = built()
        assert bench.actuator is not None
        plan = dynamixel_plan(bench.actuator, bench.true.gear_mm_per_degree, 1, pressed, **speed)
    else:
        plan = (rigid_plan if case.actuator == "rigid" else modular_plan)(1, specimen=pressed, **speed)
    others = {name: kappa for name, kappa in KAPPA.items() if name != told}
    return replace(
        plan, specimen=told, schedule_from=None if pressed == told else pressed, angle_deg=case.angle_deg, pause_s=0.6,
        stiffness_n_per_mm=KAPPA[told], others_n_per_mm=others,
    )  # fmt: skip


def press(case: Case, folder: Path) -> Ended:
    """How the run ended."""
    bench = built() if case.actuator == "dynamixel" else Built(rigid=case.actuator == "rigid")
    clock, emulated = VirtualClock(), EmulatedSettings(stiffness_n_per_mm=KAPPA)
    world = EmulatedRig(
        emulated, case.on, case.angle_deg, bench.rigid, clock, rig=bench.true, run=str(case), mounting=case.mounting,
        actuator=bench.actuator,
    )  # fmt: skip
    devices = replace(world.devices(), camera=None)
    return execute(_plan(case), bench.true, devices, folder, clock, started=STARTED)


@dataclass(frozen=True)
class Weighed:
    """One press. off : kappa over the truth, less 1; NaN where the run ended first. held : its interval has the truth.

    said : ok; named, as the specimen that lies there; doubtful, as another or none; ended, by the guard; or how else.
    """

    off: float
    held: bool
    said: str
    largest_n: float


def weigh(case: Case) -> Weighed:
    """As `press`."""
    with TemporaryDirectory() as root:
        ended = press(case, folder := Path(root) / "run")
        (verdict, why), kappa = verdicts(folder).get(1, ("none", "")), weighed(folder).get(1)
    like = why.partition("presses like ")[2].partition(" (")[0]
    said = verdict if ended.how != "guard" else "ended" if ended.cause == "specimen" else ended.cause
    off, held = (
        (kappa.kappa / KAPPA[case.on] - 1, kappa.low <= KAPPA[case.on] <= kappa.high) if kappa else (np.nan, False)
    )
    return Weighed(off, held, "named" if like == case.on else said, ended.peak_force_n or 0.0)


def _all(cases: Iterable[Case]) -> dict[Case, Weighed]:
    with ProcessPoolExecutor(PROCESSES) as pool:
        listed = tuple(cases)
        return dict(zip(listed, pool.map(weigh, listed, chunksize=8), strict=True))


def _told(found: Iterable[Weighed], but: str = "") -> str:
    said = Counter(each.said for each in found if each.said != but)
    return ", ".join(f"{count} {name}" for name, count in said.most_common()) or "0"


def _right(mountings: int) -> Iterator[str]:
    clean = _all(
        Case(actuator, name, name, angle_deg, number + 1, speed)
        for actuator, angle_deg, speed in product(ACTUATORS, ANGLES_DEG, SPEEDS_MM_PER_S)
        for name in KAPPA for number in range(mountings)
    )  # fmt: skip
    yield f"\n## The right specimen, {mountings} mountings of each\n"
    yield "Error of kappa: mean and SD, percent. Held: 95 % intervals with the truth.\n"
    yield "| actuator | degrees | mm/s | presses | " + " | ".join(KAPPA) + " | held (%) | not ok |"
    yield "|---|---:|---:|---:|" + "---:|" * (len(KAPPA) + 2)
    for actuator, angle_deg, speed in product(ACTUATORS, ANGLES_DEG, SPEEDS_MM_PER_S):
        of_all = {
            case: each for case, each in clean.items()
            if (case.actuator, case.angle_deg, case.speed_mm_per_s) == (actuator, angle_deg, speed)
        }  # fmt: skip
        errors = [100 * np.array([each.off for case, each in of_all.items() if case.on == name]) for name in KAPPA]
        cells = [f"{np.nanmean(each):+.1f} ± {np.nanstd(each, ddof=1):.1f}" if np.isfinite(each).any() else "–"
                 for each in errors]  # fmt: skip
        held = 100 * np.mean([each.held for each in of_all.values()])
        yield (
            f"| {actuator} | {angle_deg:g} | {speed:g} | {len(of_all)} | {' | '.join(cells)} | {held:.0f} "
            f"| {_told(of_all.values(), but='ok')} |"
        )
    judged = {case: each for case, each in clean.items() if each.said in _OF_WITNESS}
    false = {case: each for case, each in judged.items() if each.said != "ok"}
    share = f"{len(false)} of {len(judged)} clean presses, {100 * len(false) / len(judged):.2f} %"
    yield f"\nFalse alarms of the witness: {share}{_listed(false)}."
    yield f"Other guards ended {len(clean) - len(judged)} presses."


def _wrong(mountings: int) -> Iterator[str]:
    found = _all(
        Case(actuator, told, on, angle_deg, number + 1)
        for actuator, told, on, angle_deg in product(ACTUATORS, KAPPA, KAPPA, ANGLES_DEG)
        for number in range(mountings)
    )
    angles = ", ".join(f"{each:g}" for each in ANGLES_DEG)
    yield f"\n## Another specimen, {mountings} mountings of each at {angles} degrees\n"
    yield "Rows: what the plan says; columns: what lies there. Of its presses, how many were doubtful and named it"
    yield "right (named), ended by the guard `specimen` (ended), were doubtful as another or none (doubtful), or passed"
    yield "(ok)."
    for actuator in ACTUATORS:
        bench = " | ".join(f"{on}, {kappa:g}" for on, kappa in KAPPA.items())
        yield f"\n### {actuator}\n\n| plan \\ bench | {bench} | largest felt (N) |"
        yield "|---|" + "---|" * len(KAPPA) + "---:|"
        for told in KAPPA:
            row = {case: each for case, each in found.items() if (case.actuator, case.told) == (actuator, told)}
            cells = [_told(each for case, each in row.items() if case.on == on) for on in KAPPA]
            largest_n = max(each.largest_n for each in row.values())
            yield f"| {told} | {' | '.join(cells)} | {largest_n:.1f} |"
    yield f"\n## Pairs that differ by {APART:.0%} of the stiffer or more\n"
    yield "| actuator | presses | told | ok | named | doubtful | ended |\n|---|---:|---:|---:|---:|---:|---:|"
    apart = {case: each for case, each in found.items() if _differ(case)}
    for name, actuators in {**{each: (each,) for each in ACTUATORS}, "all": ACTUATORS}.items():
        said = Counter(each.said for case, each in apart.items() if case.actuator in actuators)
        counts = " | ".join(str(said[each]) for each in _OF_WITNESS)
        share = sum(said[each] for each in _OF_WITNESS[1:]) / said.total()
        yield f"| {name} | {said.total()} | {100 * share:.2f} % | {counts} |"
    yield f"\nMissed{_listed({case: each for case, each in apart.items() if each.said == 'ok'}) or ': none'}."


def _differ(case: Case) -> bool:
    low, high = sorted((KAPPA[case.told], KAPPA[case.on]))
    return 1 - low / high >= APART - 0.005


def _listed(found: dict[Case, Weighed]) -> str:
    alike = Counter(
        f"{c.actuator}, plan {c.told}, bench {c.on}, {c.angle_deg:g} degrees, {c.speed_mm_per_s:g} mm/s: {each.said}"
        for c, each in found.items()
    )
    return f": {'; '.join(f'{case} ({count})' for case, count in alike.items())}" if found else ""


def page(clean: int, wrong: int) -> Iterator[str]:
    yield "# The specimen as a witness"
    yield from _right(clean)
    yield from _wrong(wrong)


def main() -> None:
    """Print the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clean", type=int, default=7, help="mountings of the right specimen")
    parser.add_argument("--wrong", type=int, default=4, help="mountings of others")
    asked = parser.parse_args()
    for line in page(asked.clean, asked.wrong):
        print(line, flush=True)


if __name__ == "__main__":
    main()
