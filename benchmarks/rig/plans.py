"""What the benchmarks of the rig press.

A calibration whose specimens are known exactly: areas by finite elements, presses that differ by 0.3 %.

The emulated rig in a process of its own: ``python -m benchmarks.rig.plans`` until its input ends.

The first line of output is JSON with where to find it, the last one the share of a processor that it took.
"""

from __future__ import annotations

import json
import math
import sys
import time
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from casr.specimens import SPECIMENS
from emg2vsa.calibration.cut_presses import cut_forces, cut_rates
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.rig.plan import RIGID, Condition, RunPlan
from emg2vsa.schedules import Schedule
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import CalibrationSettings, ScheduleSettings
from emg2vsa.worlds.bench.bench import EmulatedRig, EmulatedServers
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.tactile import TabulatedWorld

MOUNTING_SD_PERCENT = 2.5
"""The areas here are true ones, and those of a press that is judged come from its pins, which tell them to 2.5 %."""
KAPPA = {"A": 7.63, "B": 5.3, "C": 3.35, "D": 2.0, "E": 1.11}


def known_calibration(
    condition: str = "high-stiffness",
    angle_deg: float = 0.0,
    *,
    area_unit: str = "mm2",
    quantity: str = "front",
    simulated: bool = True,
) -> OnlineCalibration:
    """What presses of the elastic emulated rig are judged by."""
    world, forces, rng = TabulatedWorld(), cut_forces(0.5, 7.0), np.random.default_rng(0)
    force_n, kappa = np.linspace(0.5, 7.2, 30), np.array(list(KAPPA.values()))
    areas = [np.pi * world.radius_mm(force_n, each) ** 2 for each in kappa]
    rates = np.array(
        [
            [cut_rates(force_n, area * (1 + 0.003 * rng.standard_normal()), 0.5, forces) for _ in range(6)]
            for area in areas
        ]
    )
    return OnlineCalibration(
        specimens=tuple(KAPPA), kappa=kappa, kappa_se=np.zeros(kappa.size), quantity=quantity, area_unit=area_unit,
        angle_deg=angle_deg, condition=condition, start_n=0.5, forces_n=forces, rates=rates,
        mounting=np.ones(rates.shape[:2], dtype=np.int64),
        settings=CalibrationSettings(mounting_sd_percent=MOUNTING_SD_PERCENT), growth=0.65, simulated=simulated,
    )  # fmt: skip


def main() -> None:
    """Serve until standard input is closed."""
    # a thread that is to answer at once would else wait 5 ms for the one that draws a frame
    sys.setswitchinterval(2e-4)
    bench = EmulatedRig(EmulatedSettings(), SPECIMEN, 0.0, rigid=False, clock=WallClock())
    with EmulatedServers(bench) as servers:
        force = servers.force
        print(
            json.dumps(
                {
                    "port": servers.port, "host": force.host, "rdt_port": force.rdt_port, "http_port": force.http_port,
                    "camera": servers.camera_url,
                }
            ),
            flush=True,
        )  # fmt: skip
        started_s, before_s = time.perf_counter(), time.process_time()
        sys.stdin.read()
        used = (time.process_time() - before_s) / (time.perf_counter() - started_s)
        print(json.dumps({"cpu_share": used}), flush=True)


SPECIMEN = "S3"
CONTACT_N, F_MAX_N, SPEED_MM_PER_S = 0.5, 7.0, 5.0


def modular_plan(
    repetitions: int, *, specimen: str = SPECIMEN, condition: Condition = "modular", **changes: Any
) -> RunPlan:
    """Presses up to the paper's F_max, stiffer with every force step; ``changes`` to `RunPlan`."""
    return _plan(repetitions, specimen, condition, changes)


def rigid_plan(repetitions: int, *, specimen: str = SPECIMEN, **changes: Any) -> RunPlan:
    """The same under the rigid motor."""
    return _plan(repetitions, specimen, RIGID, changes)


def dynamixel_plan(
    actuator: DynamixelSettings, gear_mm_per_degree: float, repetitions: int, specimen: str, **changes: Any
) -> RunPlan:
    """As `modular_plan`, with this motor behind this gear."""
    assert actuator.full_stiffness_nm_per_rad
    settings = ScheduleSettings(
        conditions=("modular",), actuator="dynamixel", full_stiffness_nm_per_rad=actuator.full_stiffness_nm_per_rad,
        gear_mm_per_degree=gear_mm_per_degree, probe_speed_mm_per_s=changes.get("ramp_mm_per_s", SPEED_MM_PER_S),
    )  # fmt: skip
    plan = RunPlan(specimen, 0.0, "modular", repetitions, _built(specimen, settings), F_MAX_N)
    return replace(plan, stiffness_n_per_mm=SPECIMENS[specimen], **changes)


def _plan(repetitions: int, specimen: str, condition: Condition, changes: dict[str, Any]) -> RunPlan:
    speed_mm_per_s = changes.get("ramp_mm_per_s", SPEED_MM_PER_S)
    schedule = None if condition == RIGID else _schedule(specimen, condition, speed_mm_per_s)
    known = SPECIMENS[specimen]
    plan = RunPlan(specimen, 0.0, condition, repetitions, schedule, F_MAX_N, stiffness_n_per_mm=known)
    return replace(plan, **changes)


def _schedule(specimen: str, condition: Any, speed_mm_per_s: float) -> Schedule:
    return _built(specimen, ScheduleSettings(conditions=(condition,), probe_speed_mm_per_s=speed_mm_per_s))


@cache
def _built(specimen: str, settings: ScheduleSettings) -> Schedule:
    force = np.linspace(CONTACT_N, F_MAX_N, 100)
    v = 42e-6 + 20e-6 * np.log(force)
    rate = SPECIMENS[specimen]
    profile = Profile(specimen, rate, 42e-6, 20e-6, force, v, "measured", 10, np.full(100, np.nan))
    profiles = Profiles(
        profiles=(profile,), new=None, weight_alpha=math.nan, bracket=None, new_measured=None, new_error=None,
        leave_one_out=(), participant="", unit="V", notes=(),
    )  # fmt: skip
    (schedule,) = build_schedules(profiles, settings, {"study": "palpation"})
    return schedule


if __name__ == "__main__":
    main()
