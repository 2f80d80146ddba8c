"""Guards of a running rig: each compares one moment with one limit, and says what is wrong, or None.

They do not hang on one instrument: the springs judge the force sensor, the commands judge the motors, and the shaft's
encoder tells how deep the probe is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import lru_cache
from operator import gt

from emg2vsa.devices.protocols import ForceSample, Measurements, Rating
from emg2vsa.rig.executor.motion import Phase
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings

_GAP_AT_REST_N, _GAP_SHARE = 2.5, 0.3
"""Of a gap between springs and sensor while the probe goes in; without a fault it is at most 1.9 N and that share."""
_JUMP_DEG = 0.5
"""By which springs let the shaft go ahead or stay behind in one turn; without a fault two encoder steps, 0.18."""
_UNFELT_SHARE = 0.2
"""Of guards.current_a: 0.3 A, at which the emulated rigid motor presses with 5 N; in free motion it draws 0.05 A."""
UNFELT_N = 2.5
"""While less is felt, a rigid motor that draws so much presses with what the sensor does not feel."""
_UNMOVED_N = 2.0
"""One step of the encoder is far less on any specimen that a motor of such steps can press."""
_STEEPEST_RAD = math.radians(85)
_LOADS = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
_INWARDS = ("approach", "contact", "load")


@dataclass(slots=True)
class Seen:
    """What `Witnesses` make of several turns. None is what is not known, or not to be judged now."""

    at: Measurements | None = None
    "Encoders, when they were last read."
    at_before: Measurements | None = None
    "And the time before that."
    between_s: float = 0.0
    "From that reading to the last."
    still_mm: float = 0.0
    "How far the motors have pressed on while the readings of the force sensor stayed the same."
    still_s: float | None = None
    "How long they have stayed the same; None of a sensor whose readings often do."
    astray_deg: float = 0.0
    "How far a motor is outside of where it may be on the way to its command."
    unmoved_n: float = 0.0
    "How much the felt force has grown while the encoder of a motor that gives way itself has stayed the same."
    spring_n: float | None = None
    "Force on the probe by the springs, or by a rigid motor's current, when the motors were last read."
    lag_n: float = 0.0
    "What of that a motor that gives way itself seems to bear at the speed of the ramp, because it lags."
    told_by: str = "the springs"
    "Or the motor's current."
    starting: bool = False
    "The approach has just begun: inertia is part of that force."
    spring_rest_n: float | None = None
    "The same, with the probe retracted and at rest."
    felt_n: float = 0.0
    "Force along the push axis in the turn of that reading, or of the turns of that current."
    current_a: float = 0.0
    "Mean over the last turns, of the motor that draws more."
    unfelt_a: float | None = None
    "How much more than in free motion a rigid motor draws while little is felt."
    jumped_deg: float = 0.0
    "On the way in: how far the shaft went in the last turn beyond what the motors went."
    approach_mm: float | None = None
    "Depth of the shaft, before contact."
    past_contact_mm: float | None = None
    "How far the shaft has gone after contact."
    off_specimen: float | None = None
    "Stiffness of the contact over that of the named specimen, less 1."
    rise_n: float | None = None
    "On the way home: by how much the force has grown from its smallest there."


@dataclass(slots=True, kw_only=True)
class Moment:
    """What the guards look at, one of each turn of the loop."""

    now_s: float
    late_s: float
    "How much after its due time the turn began."
    period_s: float
    force: ForceSample
    before: ForceSample
    "Of the turn before."
    force_n: float
    "Along the push axis."
    force_before_n: float
    angle_deg: float
    "Between probe and surface, by the plan."
    phase: Phase
    rating: Rating | None
    "Of the force sensor."
    frame_s: float | None
    "Time of the newest frame; None without a camera."
    depth_mm: float
    "Where the probe is about to be sent."
    travel_mm: float
    active: bool
    "Motors on, when last asked."
    seen: Seen
    contact_n: float
    "The plan's force of contact."


Check = Callable[[Moment, GuardSettings], str | None]


def force_limit(moment: Moment, limits: GuardSettings) -> str | None:
    """Pushed, or pulled, too hard: along the push axis, or in any direction."""
    along = _above(abs(moment.force_n), limits.force_n, "N")
    whole_n = limits.force_n / math.cos(math.radians(moment.angle_deg))
    return along or _above(moment.force.size_n, whole_n, "N in all three axes")


def lateral_force(moment: Moment, limits: GuardSettings) -> str | None:
    """Force across the push axis on the way in, beyond angle and friction: a wrong push_axis or angle, or a crash."""
    if moment.phase not in _INWARDS:  # skin that slides back pulls nearly across
        return None
    across_n = math.sqrt(max(0.0, moment.force.size_n**2 - moment.force_n**2))
    by_angle_n = abs(moment.force_n) * _sliding(moment.angle_deg, limits.skin_friction)
    return _above(across_n, limits.lateral_n + by_angle_n, "N across push_axis")


@lru_cache
def _sliding(angle_deg: float, friction: float) -> float:
    """Force across the push axis over that along it, of a probe about to slide down the slope."""
    return math.tan(min(math.radians(angle_deg) + math.atan(friction), _STEEPEST_RAD))


def overload(moment: Moment, limits: GuardSettings) -> str | None:
    """More than the force sensor is made for."""
    if moment.rating is None:
        return None
    loads, ratings = moment.force.loads, moment.rating.force_n + moment.rating.torque_nm
    if True not in map(gt, map(abs, loads), ratings):
        return None
    each = zip(_LOADS, map(abs, loads), ratings, strict=True)
    return next(_above(load, most, f"{name}, the sensor's rating") for name, load, most in each if load > most)


def untrusted_force(moment: Moment, limits: GuardSettings) -> str | None:
    """The sensor reports a fault or no number, or the springs bear what it does not feel, or the reverse."""
    if not (math.isfinite(moment.force_n) and math.isfinite(moment.force.size_n)):
        return f"the force is {moment.force_n}"
    if moment.force.status.faults:
        return "; ".join(moment.force.status.faults)
    if moment.seen.spring_n is None:
        return None
    larger_n = max(abs(moment.seen.spring_n), abs(moment.seen.felt_n))
    limit_n = limits.spring_gap_n
    if moment.phase in _INWARDS and not moment.seen.starting:
        limit_n = min(limit_n, _GAP_AT_REST_N + _GAP_SHARE * larger_n)
    elif moment.phase not in _INWARDS:
        limit_n += abs(moment.seen.lag_n)  # it turns round with the motion
    # the skin's friction holds probe and shaft, and the sensor feels it
    limit_n += limits.skin_friction * larger_n * math.sin(math.radians(moment.angle_deg))
    gap_n = abs(moment.seen.spring_n - moment.seen.felt_n)
    if not gap_n > limit_n:
        return None
    text = f"N between {moment.seen.spring_n:.1f} N by {moment.seen.told_by} and {moment.seen.felt_n:.1f} N felt"
    return _above(gap_n, limit_n, text)


def spring_limit(moment: Moment, limits: GuardSettings) -> str | None:
    """The springs, or a rigid motor, press harder than any press does, whatever the force sensor says."""
    spring_n = _size(moment.seen.spring_n)
    return None if spring_n is None else _above(spring_n, limits.spring_n, f"N by {moment.seen.told_by}")


def frozen_force(moment: Moment, limits: GuardSettings) -> str | None:
    """The sensor goes on sending the same reading: no live one does while it is pressed, however coarse its steps."""
    pressed = _above(moment.seen.still_mm, limits.frozen_mm, "mm pressed with the same reading")
    if pressed or moment.seen.still_s is None:
        return pressed
    return _above(moment.seen.still_s, limits.frozen_s, "s with the same reading")


def following(moment: Moment, limits: GuardSettings) -> str | None:
    """A motor is not where its commands lead: jammed, without power or deaf, or its encoder is wrong. The encoder of
    one that gives way itself moves while it presses; a specimen too stiff to show that looks like a frozen one. A shaft
    behind springs goes as evenly as its motors."""
    unmoved = _above(moment.seen.unmoved_n, _UNMOVED_N, "N more while the shaft's encoder stays the same")
    most_deg = _JUMP_DEG * max(1.0, moment.seen.between_s / moment.period_s)
    jumped = _above(moment.seen.jumped_deg, most_deg, "degrees that the shaft jumped beyond its motors in one turn")
    astray = _above(moment.seen.astray_deg, limits.following_deg, "degrees off the way to its command")
    return unmoved or astray or jumped


def specimen(moment: Moment, limits: GuardSettings) -> str | None:
    """Force over depth is not that of the named specimen, or the force sensor or an encoder errs."""
    off = moment.seen.off_specimen
    if off is None or abs(off) <= limits.specimen_share:
        return None
    # on a short way no number says much
    times = "far stiffer than" if off > 8 else f"{1 + off:.2f} times as stiff as"
    said = f"the contact is {times} on the specimen of the plan, limit {limits.specimen_share:g} off"
    return f"{said}: look at the specimen, the force sensor, the gear and rig.dome_modulus_mpa"


def lost_device(moment: Moment, limits: GuardSettings) -> str | None:
    """The actuator answers, but has switched its motors off."""
    return None if moment.active else "the motors are off: reset, or watchdog"


def _most(unit: str, compared: Callable[[Moment, GuardSettings], tuple[float | None, float]]) -> Check:
    """A guard of one number and the limit that it must not pass. A number of None is not to be judged now."""

    def check(moment: Moment, limits: GuardSettings) -> str | None:
        value, limit = compared(moment, limits)
        return None if value is None else _above(value, limit, unit)

    return check


def _between_s(moment: Moment) -> float:
    """Two samples may arrive close together, so their distance counts as a period at least."""
    return max(moment.force.time_s - moment.before.time_s, moment.period_s)


GUARDS: dict[str, Check] = {
    "force limit": force_limit,
    "sensor overload": overload,
    "lost device": lost_device,
    # the loop was held up
    "overrun": _most("s late", lambda now, limits: (now.late_s, limits.late_s)),
    "following": following,
    "untrusted force": untrusted_force,
    # force that jumps
    "force rate": _most("N/s", lambda now, limits: (
        abs(now.force_n - now.force_before_n) / _between_s(now), limits.force_rate_n_per_s
    )),
    "lateral force": lateral_force,
    # the probe presses far from the middle of the sensor, or something else leans on it
    "torque": _most("N m", lambda now, limits: (now.force.torque_size_nm, limits.torque_nm)),
    # the springs are bent though nothing touches the probe: an encoder has a wrong zero, or a spring is broken
    "springs at rest": _most("N by the springs at rest, with the probe free", lambda now, limits: (
        _size(now.seen.spring_rest_n), limits.spring_rest_n
    )),
    # the springs are bent further than the largest force bends them, whatever the force sensor says
    "spring limit": spring_limit,
    "frozen force": frozen_force,
    # the way to the retracted position leads into something: home_deg or the encoders' zeros are wrong
    "way home": _most("N more on the way home", lambda now, _: (now.seen.rise_n, now.contact_n)),
    # the ramp is over, and neither contact nor F_max has come
    "travel": _most("mm", lambda now, _: (now.depth_mm, now.travel_mm)),
    # the probe has met something that the force sensor does not feel
    "unfelt contact": _most(f"A more than in free motion, and less than {UNFELT_N:g} N felt", lambda now, limits: (
        now.seen.unfelt_a, _UNFELT_SHARE * limits.current_a
    )),
    # the shaft is deeper than the specimen's surface can be, and no contact was felt
    "no contact": _most("mm without contact", lambda now, limits: (now.seen.approach_mm, limits.contact_mm)),
    # force over depth is of another specimen, or a scale is wrong
    "specimen": specimen,
    # the specimen gives way more than it can: it is gone, or its force is not felt
    "past contact": _most("mm past contact", lambda now, limits: (now.seen.past_contact_mm, limits.past_contact_mm)),
    # a motor stalls, or works against something that the force sensor does not bear
    "motor current": _most("A", lambda now, limits: (now.seen.current_a, limits.current_a)),
    # the newest sample is old
    "stale sensor": _most("s without a sample", lambda now, limits: (now.now_s - now.force.time_s, limits.stale_s)),
    # no frame for too long
    "lost camera": _most("s without a frame", lambda now, limits: (
        None if now.frame_s is None else now.now_s - now.frame_s, limits.camera_s
    )),
}  # fmt: skip
"""The first that speaks names the cause: a loop held up makes samples and frames look old, motors that have gone off
stay behind their commands, and springs are known by the motors' encoders, so what explains them comes before them.

All are asked twice in every turn of every run, also of those that are added here: before the command is sent, and with
the same moment once the actuator has been read, when ``seen`` and ``active`` are newer.
"""

_OWN = dict(GUARDS)


def changed_guards() -> tuple[str, ...]:
    """Names of `GUARDS` that this program has added, replaced or taken out. No other process knows of them, nor can
    what they do be told by a key: such runs stay in this process, and are never taken from a store."""
    return tuple(sorted(name for name in {*_OWN, *GUARDS} if GUARDS.get(name) is not _OWN.get(name)))


def tripped(moment: Moment, limits: GuardSettings, guards: Mapping[str, Check] = GUARDS) -> tuple[str, str] | None:
    """Name and words of the first of ``guards`` that speaks. What is no text speaks, too, by its repr."""
    for name, check in tuple(guards.items()):  # a guard may add another
        if found := check(moment, limits):
            return name, found if isinstance(found, str) else repr(found)
    return None


def laxer_guards(rig: RigSettings) -> list[str]:
    """A line for each limit of ``rig`` that protects less than its default."""
    usual = RigSettings()
    pairs = [(f"rig.guards.{each.name}", getattr(rig.guards, each.name), getattr(usual.guards, each.name))
             for each in fields(GuardSettings)]  # fmt: skip
    pairs.append(("rig.max_mm_per_s", rig.max_mm_per_s, usual.max_mm_per_s))
    lines = [f"{name} = {set_to:g} protects less than {default:g}, the default" for name, set_to, default in pairs
             if (set_to < default if name.endswith("following_deg_per_s") else set_to > default)]  # fmt: skip
    own, default = rig.escape_mm_per_s, usual.escape_mm_per_s
    slower = [f"rig.escape_mm_per_s = {own:g} retreats more slowly than {default:g}, the default"]
    return lines + slower if own < default else lines


def _above(value: float, limit: float, unit: str) -> str | None:
    return f"{value:.6g} {unit}, limit {limit:.4g}" if value > limit else None


def _size(value: float | None) -> float | None:
    return None if value is None else abs(value)
