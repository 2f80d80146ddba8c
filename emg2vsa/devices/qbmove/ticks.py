"""Ticks, in which a qbmove counts angles: in its packets, in logs and schedules of its runs, and in older rig files."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from emg2vsa.devices.protocols import LogColumns, Measurements

TICKS_PER_TURN = 32768
"""Wire ticks of a qbmove to a turn of its shaft, at the resolution 1 that is its default."""
DEG_PER_TICK = 360 / TICKS_PER_TURN
"""A fraction of a power of two: whole ticks to degrees and back lose nothing."""
_MOST = 1e15
"""What is no count of ticks stays as it is."""
Keys = Mapping[str, tuple[str, float, type]]
LOG_COLUMNS = LogColumns(
    ("position_ticks", "preset_ticks", "motor_1_ticks", "motor_2_ticks", "shaft_ticks", "current_1_ma", "current_2_ma"),
    per_degree=1 / DEG_PER_TICK,
    per_preset=1 / DEG_PER_TICK,
    per_ampere=1000.0,
    whole=True,
)
"""Columns of log.csv."""
RIG_KEYS: Keys = {
    "home_ticks": ("home_deg", DEG_PER_TICK, int),
    "position_ticks": ("position_deg", DEG_PER_TICK, int),
    "max_preset_ticks": ("full_preset", DEG_PER_TICK, int),
    "following_ticks": ("following_deg", DEG_PER_TICK, float),
    "following_ticks_per_s": ("following_deg_per_s", DEG_PER_TICK, float),
    "current_ma": ("current_a", 1e-3, float),
}
"""Key of a table [rig] or [rig.guards] in ticks or mA, as versions to 0.2.0 and plan.json of a qbmove have it: today's
key, how many of its units one is, and the type of the value."""
PROOF_KEYS: Keys = {
    "max_stiffness_ticks": ("full_preset", DEG_PER_TICK, int),
    "moved_before_ticks": ("moved_before_deg", DEG_PER_TICK, int),
    "moved_after_ticks": ("moved_after_deg", DEG_PER_TICK, int),
}
"""The same of the proof of a watchdog."""


class Ticks(NamedTuple):
    """Encoder readings."""

    motor_1: int
    motor_2: int
    shaft: int

    def measurements(self) -> Measurements:
        """The same in degrees."""
        motor_1, motor_2, shaft = self
        return Measurements((motor_1 * DEG_PER_TICK, motor_2 * DEG_PER_TICK), shaft * DEG_PER_TICK)


def to_ticks(angle_deg: float) -> int:
    """The nearest whole tick to an angle in degrees."""
    return round(angle_deg / DEG_PER_TICK)


def in_ticks(table: Mapping[str, Any], keys: Keys = RIG_KEYS) -> dict[str, Any]:
    """A table of plain values with the keys of a qbmove's plan.json."""
    own = {new: (old, 1 / unit, kind) for old, (new, unit, kind) in keys.items()}
    return {own.get(key, (key,))[0]: _scaled(key, value, own, in_ticks, keys) for key, value in table.items()}


def in_degrees(table: Mapping[str, Any], keys: Keys = RIG_KEYS) -> dict[str, Any]:
    """The reverse. Keys of today stay as they are, and so does what is no number, or none that a float
    holds: its reader refuses it."""
    own: Keys = {old: (new, unit, float) for old, (new, unit, _) in keys.items()}
    return {own.get(key, (key,))[0]: _scaled(key, value, own, in_degrees, keys) for key, value in table.items()}


def _scaled(key: str, value: Any, own: Keys, inner: Callable[[Mapping[str, Any], Keys], Any], keys: Keys) -> Any:
    if isinstance(value, Mapping):
        return inner(value, keys)
    if isinstance(value, (list, tuple)):
        return type(value)(_scaled(key, each, own, inner, keys) for each in value)
    if key not in own or not isinstance(value, (int, float)) or isinstance(value, bool):
        return value
    _, factor, kind = own[key]
    if abs(value) > (_MOST if kind is int else sys.float_info.max):
        return value
    return round(value * factor) if kind is int else round(value * factor, 12)
