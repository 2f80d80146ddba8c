"""A rig file with a Dynamixel, and its schedules for three specimens."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from casr.specimens import SPECIMENS
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.schedule_files import write_schedule
from emg2vsa.schedules import Schedule
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import ScheduleSettings
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W350

GAIN, GEAR = 800, 0.8
FULL = XM430_W350.stiffness_nm_per_rad(GAIN)
RIG = """\
[rig]
gear_mm_per_degree = 0.8
stiffness_percent = [20, 80]
max_mm_per_s = 20

[actuator]
kind = "dynamixel"
model = "xm430-w350"
full_gain = 800
d_gain = 1500
full_stiffness_nm_per_rad = {full}
goal_current_a = 0.4

[force]
kind = "net-ft"

[experiment]
specimens = ["S1", "S3", "S5"]
angles_deg = {{ modular = [0] }}
repetitions = 2
schedules = "schedules"

[emulated]
"""
Files = Callable[..., Path]


def make_schedules(actuator: str = "dynamixel", full: float = FULL) -> Sequence[Schedule]:
    """Of S1, S3 and S5, over one span of co-contraction."""
    force = np.linspace(0.5, 7, 100)
    profiles = tuple(
        Profile(name, SPECIMENS[name], a, b, force, a + b * np.log(force), "measured", 10, np.full(100, np.nan))
        for name, a, b in (("S1", 42e-6, 20e-6), ("S3", 28e-6, 13e-6), ("S5", 20e-6, 9e-6))
    )
    whole = Profiles(
        profiles=profiles, new=None, weight_alpha=math.nan, bracket=None, new_measured=None, new_error=None,
        leave_one_out=(), participant="", unit="V", notes=(),
    )  # fmt: skip
    gear = GEAR if actuator == "dynamixel" else 0.2
    settings = ScheduleSettings(
        conditions=("modular",), actuator=actuator, full_stiffness_nm_per_rad=full, gear_mm_per_degree=gear
    )
    return build_schedules(whole, settings, {"study": "palpation"})


@pytest.fixture
def rig_file(tmp_path: Path) -> Files:
    """Written with its schedules; ``changes`` are pieces of its text and what replaces them."""

    def write(*changes: tuple[str, str], schedules: Sequence[Schedule] | None = None) -> Path:
        for schedule in make_schedules() if schedules is None else schedules:
            write_schedule(tmp_path / "schedules", schedule)
        text = RIG.format(full=FULL)
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        (tmp_path / "rig.toml").write_text(text)
        return tmp_path / "rig.toml"

    return write
