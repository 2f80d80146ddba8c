"""Runs without a fault: does a guard speak, and how near does the largest force come to the one to expect?

Run with ``python -m benchmarks.clean_runs [--write FILE]``: every specimen, condition and angle with a fine force
sensor and with one whose readings come in steps of 1/16 N and never dither.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.bench.record import print_page
from benchmarks.rig.fault_case import read_log
from benchmarks.rig.plans import modular_plan, rigid_plan
from casr.specimens import SPECIMENS
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import Devices, ForceSample, ForceSensor
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.executor.plan_limits import largest_force_n
from emg2vsa.rig.plan import RIGID, Condition
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.settings import EmulatedSettings

STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)
TORQUE_STEP_NM = 1 / 752
"""Of a Mini45 SI-145-5, whose force comes in steps of 1/16 N."""


@dataclass(frozen=True)
class Clean:
    """How it ended, the largest force along the push axis, and the one to expect, N."""

    ended: Ended
    largest_n: float
    expected_n: float


class Coarse:
    """A force sensor whose readings come in steps, without any dither: at rest they never change."""

    def __init__(self, sensor: ForceSensor, step_n: float) -> None:
        self._sensor, self._step_n = sensor, step_n

    def __getattr__(self, name: str) -> Any:
        return getattr(self._sensor, name)

    def read(self) -> ForceSample:
        """The newest sample, rounded."""
        sample = self._sensor.read()
        steps = np.repeat([self._step_n, TORQUE_STEP_NM], 3)
        loads = np.round(np.array(sample.loads) / steps) * steps
        return ForceSample(sample.time_s, loads[:3], loads[3:], sample.status, sample.sequence)


def clean_run(
    specimen: str, condition: Condition, angle_deg: float, step_n: float, seed: int, folder: Path, presses: int = 2
) -> Clean:
    """Two presses up to 7 N with the rig of the default settings. ``step_n`` : of the force's readings; 0 is none."""
    rigid = condition == RIGID
    clock = VirtualClock()
    bench = EmulatedRig(EmulatedSettings(seed=seed), specimen, angle_deg, rigid, clock, run=condition)
    opened = bench.devices()
    force: Any = Coarse(opened.force, step_n) if step_n else opened.force
    make = rigid_plan if rigid else partial(modular_plan, condition=condition)
    plan = make(presses, specimen=specimen, angle_deg=angle_deg, pause_s=0.4)
    ended = execute(plan, RigSettings(), Devices(opened.actuator, force, None), folder, clock, started=STARTED)
    largest_n = max(row.force_n or 0.0 for row in read_log(folder / "log.csv"))
    return Clean(ended, largest_n, largest_force_n(plan, RigSettings()) or 0.0)


CONDITIONS: tuple[Condition, ...] = (RIGID, "modular", "constant-min", "constant-max")
ANGLES_DEG = (0.0, 30.0, 45.0)
STEPS_N = (0.0, 0.0625)


def main() -> None:
    """Print a table, and the sums."""
    print_page(__doc__, lambda: _page([(case, _carried_out(seed, *case)) for seed, case in enumerate(_cases())]))


def _cases() -> Iterator[tuple[str, Condition, float, float]]:
    return product(SPECIMENS, CONDITIONS, ANGLES_DEG, STEPS_N)


def _carried_out(seed: int, specimen: str, condition: Condition, angle_deg: float, step_n: float) -> Clean:
    with TemporaryDirectory() as folder:
        return clean_run(specimen, condition, angle_deg, step_n, seed, Path(folder) / "run")


def _page(found: list[tuple[tuple[str, Condition, float, float], Clean]]) -> Iterator[str]:
    shares = [clean.largest_n / clean.expected_n for _, clean in found]
    whole = sum(clean.ended.how == "completed" for _, clean in found)
    yield "# Runs without a fault on the emulated rig"
    yield ""
    yield f"`python -m benchmarks.clean_runs`: {whole} of {len(found)} completed, two presses each, all default guards."
    yield f"The largest force is {min(shares):.3f} to {max(shares):.3f} of the one that `rig dry-run` lets expect."
    yield ""
    yield "| specimen | condition | angle, degrees | steps of the force, N | ended | largest force, N | to expect, N |"
    yield "|---|---|---|---|---|---|---|"
    for (specimen, condition, angle_deg, step_n), clean in found:
        ended = " ".join((clean.ended.how, clean.ended.cause)).strip()
        yield (
            f"| {specimen} | {condition} | {angle_deg:g} | {step_n or 'none'} | {ended} | {clean.largest_n:.2f} "
            f"| {clean.expected_n:.2f} |"
        )


if __name__ == "__main__":
    main()
