"""Guards of a running rig: each compares one moment with one limit, and says what is wrong, or None.

They do not hang on one instrument: the springs judge the force sensor, the commands judge the motors, and the shaft's
encoder tells how deep the probe is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import lru_cache
from operator import attrgetter

from emg2vsa.devices.protocols import ForceSample, Measurements, Rating
from emg2vsa.rig.executor.motion import Phase
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings

_GAP_AT_REST_N, _GAP_SHARE = 2.5, 0.3
"""Limits of a gap between springs and sensor while the probe goes in; without a fault it is at most 1.9 N and that
share.
"""
_JUMP_DEG = 0.5
"""Most by which springs let the shaft go ahead or stay behind in one turn; without a fault two encoder steps, 0.18."""
_UNFELT_SHARE = 0.2
"""Share of guards.current_a: 0.3 A, at which the emulated rigid motor presses with 5 N; in free motion it draws 0.05
A.
"""
UNFELT_N = 2.5
"""While less is felt, a rigid motor that draws so much presses with what the sensor does not feel."""
_UNMOVED_N = 2.0
"""One step of the encoder is far less on any specimen that a motor of such steps can press."""
_SURELY = 1 - 1e-9
"Share of a limit that is surely below it, though the guard rounds otherwise."
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
    "Time from that reading to the last."
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
    "Force of the turn before."
    force_n: float
    "Along the push axis."
    force_before_n: float
    angle_deg: float
    "Between probe and surface, by the plan."
    phase: Phase
    rating: Rating | None
    "Rating of the force sensor."
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
    if (along_n := abs(moment.force_n)) > limits.force_n:
        return _above(along_n, limits.force_n, "N")
    if (size_n := moment.force.size_n) <= limits.force_n:  # the limit of all three axes is no smaller
        return None
    return _above(size_n, limits.force_n / math.cos(math.radians(moment.angle_deg)), "N in all three axes")


def lateral_force(moment: Moment, limits: GuardSettings) -> str | None:
    """Force across the push axis on the way in, beyond angle and friction: a wrong push_axis or angle, or a crash."""
    if moment.phase not in _INWARDS:  # skin that slides back pulls nearly across
        return None
    if (size_n := moment.force.size_n) <= limits.lateral_n:  # across it is no more
        return None
    across_n = math.sqrt(max(0.0, size_n**2 - moment.force_n**2))
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
    force, (most_n, most_nm) = moment.force, moment.rating
    if force.size_n <= min(most_n) and force.torque_size_nm <= min(most_nm):  # no part is larger than the whole
        return None
    loads, ratings = force.loads, most_n + most_nm
    each = zip(_LOADS, map(abs, loads), ratings, strict=True)
    return next((_above(load, most, f"{name}, the sensor's rating") for name, load, most in each if load > most), None)


def untrusted_force(moment: Moment, limits: GuardSettings) -> str | None:
    """The sensor reports a fault or no number, or the springs bear what it does not feel, or the reverse."""
    force, seen = moment.force, moment.seen
    if not (math.isfinite(moment.force_n) and math.isfinite(force.size_n)):
        return f"the force is {moment.force_n}"
    if force.status.faults:
        return "; ".join(force.status.faults)
    spring_n, felt_n = seen.spring_n, seen.felt_n
    if spring_n is None:
        return None
    gap_n, limit_n = abs(spring_n - felt_n), limits.spring_gap_n
    if gap_n <= _GAP_AT_REST_N and gap_n <= limit_n:  # what follows makes the limit no smaller than that
        return None
    larger_n = max(abs(spring_n), abs(felt_n))
    if moment.phase in _INWARDS and not seen.starting:
        limit_n = min(limit_n, _GAP_AT_REST_N + _GAP_SHARE * larger_n)
    elif moment.phase not in _INWARDS:
        limit_n += abs(seen.lag_n)  # it turns round with the motion
    # the skin's friction holds probe and shaft, and the sensor feels it
    limit_n += limits.skin_friction * larger_n * math.sin(math.radians(moment.angle_deg))
    if not gap_n > limit_n:
        return None
    text = f"N between {spring_n:.1f} N by {seen.told_by} and {felt_n:.1f} N felt"
    return _above(gap_n, limit_n, text)


def spring_limit(moment: Moment, limits: GuardSettings) -> str | None:
    """The springs, or a rigid motor, press harder than any press does, whatever the force sensor says."""
    spring_n = moment.seen.spring_n
    if spring_n is None or abs(spring_n) <= limits.spring_n:
        return None
    return _above(abs(spring_n), limits.spring_n, f"N by {moment.seen.told_by}")


def frozen_force(moment: Moment, limits: GuardSettings) -> str | None:
    """The sensor goes on sending the same reading: no live one does while it is pressed, however coarse its steps."""
    still_mm, still_s = moment.seen.still_mm, moment.seen.still_s
    if still_mm > limits.frozen_mm:
        return _above(still_mm, limits.frozen_mm, "mm pressed with the same reading")
    return None if still_s is None else _above(still_s, limits.frozen_s, "s with the same reading")


def following(moment: Moment, limits: GuardSettings) -> str | None:
    """A motor is not where its commands lead: jammed, without power or deaf, or its encoder is wrong. The encoder of
    one that gives way itself moves while it presses; a specimen too stiff to show that looks like a frozen one. A shaft
    behind springs goes as evenly as its motors."""
    seen = moment.seen
    if seen.unmoved_n > _UNMOVED_N:
        return _above(seen.unmoved_n, _UNMOVED_N, "N more while the shaft's encoder stays the same")
    if seen.astray_deg > limits.following_deg:
        return _above(seen.astray_deg, limits.following_deg, "degrees off the way to its command")
    if seen.jumped_deg <= _JUMP_DEG:  # of a turn that took longer than a period the limit is larger
        return None
    most_deg = _JUMP_DEG * max(1.0, seen.between_s / moment.period_s)
    return _above(seen.jumped_deg, most_deg, "degrees that the shaft jumped beyond its motors in one turn")


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


def _most(unit: str, value: str, limit: str) -> Check:
    """A guard of one number of the moment and the limit that it must not pass; None is not to be judged now."""
    value_of, limit_of = attrgetter(value), attrgetter(limit)

    def check(moment: Moment, limits: GuardSettings) -> str | None:
        found = value_of(moment)
        return _above(found, limit_of(limits), unit) if found is not None and found > limit_of(limits) else None

    return check


def force_rate(moment: Moment, limits: GuardSettings) -> str | None:
    """Force that jumps. Two samples may arrive close together, so their distance counts as a period at least."""
    jump_n, period_s = abs(moment.force_n - moment.force_before_n), moment.period_s
    if jump_n / period_s <= limits.force_rate_n_per_s:
        return None
    between_s = max(moment.force.time_s - moment.before.time_s, period_s)
    return _above(jump_n / between_s, limits.force_rate_n_per_s, "N/s")


def unfelt_contact(moment: Moment, limits: GuardSettings) -> str | None:
    """The probe has met something that the force sensor does not feel."""
    unfelt_a, most_a = moment.seen.unfelt_a, _UNFELT_SHARE * limits.current_a
    if unfelt_a is None or unfelt_a <= most_a:
        return None
    return _above(unfelt_a, most_a, f"A more than in free motion, and less than {UNFELT_N:g} N felt")


def springs_at_rest(moment: Moment, limits: GuardSettings) -> str | None:
    """The springs are bent though nothing touches the probe: an encoder has a wrong zero, or a spring is broken."""
    rest_n, unit = moment.seen.spring_rest_n, "N by the springs at rest, with the probe free"
    return None if rest_n is None else _above(abs(rest_n), limits.spring_rest_n, unit)


def way_home(moment: Moment, limits: GuardSettings) -> str | None:
    """The way to the retracted position leads into something: home_deg or the encoders' zeros are wrong."""
    rise_n = moment.seen.rise_n
    return None if rise_n is None else _above(rise_n, moment.contact_n, "N more on the way home")


def travel(moment: Moment, limits: GuardSettings) -> str | None:
    """The ramp is over, and neither contact nor F_max has come."""
    return _above(moment.depth_mm, moment.travel_mm, "mm")


def stale_sensor(moment: Moment, limits: GuardSettings) -> str | None:
    """The newest sample is old."""
    return _above(moment.now_s - moment.force.time_s, limits.stale_s, "s without a sample")


def lost_camera(moment: Moment, limits: GuardSettings) -> str | None:
    """No frame for too long."""
    frame_s = moment.frame_s
    return None if frame_s is None else _above(moment.now_s - frame_s, limits.camera_s, "s without a frame")


GUARDS: dict[str, Check] = {
    "force limit": force_limit,
    "sensor overload": overload,
    "lost device": lost_device,
    "overrun": _most("s late", "late_s", "late_s"),  # the loop was held up
    "following": following,
    "untrusted force": untrusted_force,
    "force rate": force_rate,
    "lateral force": lateral_force,
    # the probe presses far from the middle of the sensor, or something else leans on it
    "torque": _most("N m", "force.torque_size_nm", "torque_nm"),
    "springs at rest": springs_at_rest,
    "spring limit": spring_limit,
    "frozen force": frozen_force,
    "way home": way_home,
    "travel": travel,
    "unfelt contact": unfelt_contact,
    # the shaft is deeper than the specimen's surface can be, and no contact was felt
    "no contact": _most("mm without contact", "seen.approach_mm", "contact_mm"),
    "specimen": specimen,
    # the specimen gives way more than it can: it is gone, or its force is not felt
    "past contact": _most("mm past contact", "seen.past_contact_mm", "past_contact_mm"),
    # a motor stalls, or works against something that the force sensor does not bear
    "motor current": _most("A", "seen.current_a", "current_a"),
    "stale sensor": stale_sensor,
    "lost camera": lost_camera,
}
"""The first that speaks names the cause: a loop held up makes samples and frames look old, motors that have gone off
stay behind their commands, and springs are known by the motors' encoders, so what explains them comes before them.

All are asked twice in every turn of every run, also of those that are added here: before the command is sent, and with
the same moment once the actuator has been read, when ``seen`` and ``active`` are newer. Where there are no others,
`quiet` may answer for all of them.
"""

_OWN = dict(GUARDS)


def changed_guards() -> tuple[str, ...]:
    """Names of `GUARDS` that this program has added, replaced or taken out. No other process knows of them, nor can
    what they do be told by a key: such runs stay in this process, and are never taken from a store."""
    return tuple(sorted(name for name in {*_OWN, *GUARDS} if GUARDS.get(name) is not _OWN.get(name)))


def quiet(moment: Moment, limits: GuardSettings) -> bool:
    """Whether surely none of this program's own guards speaks, at a fifth of the cost of asking all of them.

    False says nothing: then they are asked. What is no number is never quiet."""
    force, seen, force_n = moment.force, moment.seen, moment.force_n
    size_n, spring_n, still_s, off = force.size_n, seen.spring_n, seen.still_s, seen.off_specimen
    if moment.rating is not None:
        most_n, most_nm = moment.rating
        if not (size_n <= min(most_n) and force.torque_size_nm <= min(most_nm)):
            return False
    return (
        moment.active
        and not force.status.faults
        and -limits.force_n <= force_n <= limits.force_n
        and size_n <= limits.force_n
        and (size_n <= limits.lateral_n or lateral_force(moment, limits) is None)
        and force.torque_size_nm <= limits.torque_nm
        and abs(force_n - moment.force_before_n) <= limits.force_rate_n_per_s * moment.period_s * _SURELY
        and moment.now_s - force.time_s <= limits.stale_s
        and moment.late_s <= limits.late_s
        and (moment.frame_s is None or moment.now_s - moment.frame_s <= limits.camera_s)
        and moment.depth_mm <= moment.travel_mm
        and seen.astray_deg <= limits.following_deg
        and seen.jumped_deg <= _JUMP_DEG
        and seen.unmoved_n <= _UNMOVED_N
        and seen.current_a <= limits.current_a
        and seen.still_mm <= limits.frozen_mm
        and (still_s is None or still_s <= limits.frozen_s)
        and (spring_n is None or (abs(spring_n - seen.felt_n) <= min(limits.spring_gap_n, _GAP_AT_REST_N)
                                  and -limits.spring_n <= spring_n <= limits.spring_n))
        and (seen.spring_rest_n is None or abs(seen.spring_rest_n) <= limits.spring_rest_n)
        and (seen.rise_n is None or seen.rise_n <= moment.contact_n)
        and (seen.unfelt_a is None or seen.unfelt_a <= _UNFELT_SHARE * limits.current_a)
        and (seen.approach_mm is None or seen.approach_mm <= limits.contact_mm)
        and (seen.past_contact_mm is None or seen.past_contact_mm <= limits.past_contact_mm)
        and (off is None or abs(off) <= limits.specimen_share)
    )  # fmt: skip


def tripped(moment: Moment, limits: GuardSettings, guards: Mapping[str, Check] = GUARDS) -> tuple[str, str] | None:
    """Name and words of the first of ``guards`` that speaks. What is no text speaks, too, by its repr."""
    if guards == _OWN and quiet(moment, limits):
        return None
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
