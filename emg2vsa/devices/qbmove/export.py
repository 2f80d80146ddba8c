"""Schedules for a qbmove state presets in its ticks."""

from __future__ import annotations

from emg2vsa.devices.joints import Export
from emg2vsa.devices.qbmove.springs import MOTOR_LIMIT_TICKS, SpringJoint
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK

EXPORT = Export(SpringJoint, "preset_ticks", "ticks", 1 / DEG_PER_TICK, whole=True, most=MOTOR_LIMIT_TICKS)
