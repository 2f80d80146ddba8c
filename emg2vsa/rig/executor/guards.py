"""Guards of a running rig: each compares one moment with one limit, and says what is wrong, or None."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from emg2vsa.rig.rig_settings import GuardSettings


@dataclass(frozen=True)
class Moment:
    """What the guards look at, once in each turn of the loop."""

    now_s: float
    late_s: float
    "How much after its due time the turn began."
    period_s: float
    force_n: float
    force_time_s: float
    force_before_n: float
    force_before_s: float
    faults: tuple[str, ...]
    "What the force sensor says against itself."
    frame_s: float | None
    "Time of the newest frame; None without a camera."
    depth_mm: float
    "Where the probe is about to be sent."
    travel_mm: float
    active: bool
    "Motors on, when last asked."


Check = Callable[[Moment, GuardSettings], str | None]


def force_limit(moment: Moment, limits: GuardSettings) -> str | None:
    """Pushed, or pulled, too hard."""
    return _above(abs(moment.force_n), limits.force_n, "N")


def force_rate(moment: Moment, limits: GuardSettings) -> str | None:
    """Force that jumps. Two samples may arrive close together, so their distance counts as a period at least."""
    between_s = max(moment.force_time_s - moment.force_before_s, moment.period_s)
    return _above(abs(moment.force_n - moment.force_before_n) / between_s, limits.force_rate_n_per_s, "N/s")


def travel(moment: Moment, limits: GuardSettings) -> str | None:
    """The ramp is over, and neither contact nor F_max has come."""
    return _above(moment.depth_mm, moment.travel_mm, "mm")


def untrusted_force(moment: Moment, limits: GuardSettings) -> str | None:
    """The sensor reports a fault, or no number."""
    if not math.isfinite(moment.force_n):
        return f"the force is {moment.force_n}"
    return "; ".join(moment.faults) or None


def stale_sensor(moment: Moment, limits: GuardSettings) -> str | None:
    """The newest sample is old."""
    return _above(moment.now_s - moment.force_time_s, limits.stale_s, "s without a sample")


def lost_camera(moment: Moment, limits: GuardSettings) -> str | None:
    """No frame for too long."""
    if moment.frame_s is None:
        return None
    return _above(moment.now_s - moment.frame_s, limits.camera_s, "s without a frame")


def lost_device(moment: Moment, limits: GuardSettings) -> str | None:
    """The actuator answers, but has switched its motors off."""
    return None if moment.active else "the motors are off: reset, or watchdog"


def overrun(moment: Moment, limits: GuardSettings) -> str | None:
    """The loop was held up."""
    return _above(moment.late_s, limits.late_s, "s late")


GUARDS: dict[str, Check] = {
    "force limit": force_limit,
    "untrusted force": untrusted_force,
    "force rate": force_rate,
    "travel": travel,
    "lost device": lost_device,
    "overrun": overrun,
    "stale sensor": stale_sensor,
    "lost camera": lost_camera,
}
"""The first that speaks names the cause: a loop held up makes samples and frames look old, so it comes before them."""


def tripped(moment: Moment, limits: GuardSettings) -> tuple[str, str] | None:
    """Name and words of the first guard that speaks."""
    for name, check in GUARDS.items():
        if found := check(moment, limits):
            return name, found
    return None


def _above(value: float, limit: float, unit: str) -> str | None:
    return f"{value:.6g} {unit}, limit {limit:g}" if value > limit else None
