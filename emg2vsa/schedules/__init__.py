"""Stiffness schedules for the actuator: pure data, made from co-contraction profiles and checked against limits."""

from __future__ import annotations

from emg2vsa.schedules.build import build_schedules, mean_over_steps
from emg2vsa.schedules.checks import check
from emg2vsa.schedules.schedule import CONDITIONS, Limits, Ramp, Schedule

__all__ = ["CONDITIONS", "Limits", "Ramp", "Schedule", "build_schedules", "check", "mean_over_steps"]
