"""Stiffness schedules for the actuator: pure data, checked against limits; ``build`` makes them from profiles."""

from __future__ import annotations

from emg2vsa.schedules.checks import check
from emg2vsa.schedules.schedule import CONDITIONS, Limits, Ramp, Schedule

__all__ = ["CONDITIONS", "Limits", "Ramp", "Schedule", "check"]
