"""The emulated rig of the benchmarks, part by part: on a virtual clock, or served in real time."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.synthetic import SPECIMENS, PressSettings, Scene
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.rig.clock import Clock
from emg2vsa.rig.emulated.camera import EmulatedCamera
from emg2vsa.rig.emulated.faults import FaultyWire
from emg2vsa.rig.emulated.qbmove_firmware import QbmoveFirmware
from emg2vsa.rig.emulated.qbmove_switches import MAKER_PRO
from emg2vsa.rig.emulated.rdt_box import BoxSettings, RdtBox
from emg2vsa.rig.emulated.world import World
from emg2vsa.rig.emulated.world_settings import WorldSettings
from emg2vsa.rig.plan import RunPlan
from emg2vsa.schedules import Schedule, build_schedules
from emg2vsa.settings import ScheduleSettings

SPECIMEN = "S3"
CONTACT_N, F_MAX_N = 0.5, 7.0


@dataclass(frozen=True)
class Parts:
    """Emulated devices on one world, up to their wires."""

    firmware: QbmoveFirmware
    wire: FaultyWire
    box: RdtBox
    camera: EmulatedCamera
    lock: threading.Lock
    "Held by whoever lets the actuator's time go on."


def emulated_parts(clock: Clock, gap_mm: float = 5.0) -> Parts:
    """A Maker Pro over a specimen of the paper's middle stiffness, on ``clock``."""
    stiffness = SPECIMENS[SPECIMEN]
    world = World(clock, WorldSettings(stiffness_n_per_mm=stiffness, gap_mm=gap_mm))
    firmware, lock = QbmoveFirmware(MAKER_PRO, world, clock), threading.Lock()

    def wrench(time_s: float) -> NDArray[np.float64]:
        with lock:
            firmware.advance()
        return np.append(world.force_n(time_s), np.zeros(3))

    camera = EmulatedCamera(Scene(PressSettings(stiffness_n_per_mm=stiffness)), world.normal_force_n, clock)
    return Parts(firmware, FaultyWire(firmware), RdtBox(wrench, BoxSettings()), camera, lock)


def modular_plan(repetitions: int, *, travel_mm: float = 15.0, pause_s: float = 2.0) -> RunPlan:
    """Presses to the paper's F_max under a schedule that grows with the logarithm of the force."""
    return RunPlan(
        specimen=SPECIMEN, angle_deg=0.0, condition="modular", repetitions=repetitions, schedule=_schedule(),
        f_max_n=F_MAX_N, travel_mm=travel_mm, pause_s=pause_s,
    )  # fmt: skip


def _schedule() -> Schedule:
    force = np.linspace(CONTACT_N, F_MAX_N, 100)
    v = 42e-6 + 20e-6 * np.log(force)
    rate = SPECIMENS[SPECIMEN]
    profile = Profile(SPECIMEN, rate, 42e-6, 20e-6, force, v, "measured", 10, np.full(100, np.nan))
    profiles = Profiles(
        profiles=(profile,), new=None, weight_alpha=math.nan, bracket=None, new_measured=None, new_error=None,
        leave_one_out=(), participant="", unit="V", notes=(),
    )  # fmt: skip
    settings = ScheduleSettings(conditions=("modular",))
    (schedule,) = build_schedules(profiles, settings, {"study": "palpation"})
    return schedule
