"""The settings of a rig that protect it, found anew by a touch on a soft pad: axis, sign, gear, home; and the stiffness
of a joint that nothing but a measurement tells: felt force over deflection, against the force sensor.

For the stiffness the probe presses the pad in small steps. The torque of the felt force over the angle by which the
shaft stays behind its command is the stiffness. A constant friction shifts that line and does not turn it, so its slope
is taken. Friction that varies, and the steps of the encoder, are errors of the angle and not of the force: the line is
that of the angle over the torque, as the other way round it would be too flat.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import DeviceError
from emg2vsa.rig.commissioning.hand_motion import TOUCH_N, HandMotion, Place
from emg2vsa.rig.rig_settings import RigSettings

_TRY_DEG = 5.0
"""First move, to see which way it goes: 1 mm with the paper's gear."""
REACH_DEG = 45.0
_SAME_AXIS_DEG = 10.0
_SAME_STIFFNESS = 0.05
_SAME_GEAR = 0.03
"""A calliper read to 0.1 mm over 3 mm."""
_LEAST_WAY_DEG = 5.0
_CLEAR_MM = (1.0, 3.0)
"""Least distance of a retracted probe from what it presses, and the one that is proposed."""
_ROOM_MM = 2.0
"""Least way left behind the first touch."""
_STEP_N = 0.25
"""Force that a step of the command adds, at most: of the stiffest joint on a pad that does not give way."""
_MOST_N = 5.0
"""And no more than half of the force limit."""
_LEAST_POINTS = 6
_MOST_STEPS = 200


class Person(Protocol):
    """Who stands at the rig. None as an answer: nobody knows."""

    def towards(self, degrees: float) -> bool | None:
        """Has the probe gone towards the pad, when the shaft turned so far?"""

    def zero_calliper(self) -> None:
        """The probe touches the pad: whoever measures begins here."""

    def moved_mm(self, degrees: float) -> float | None:
        """How far, mm, by a calliper, has the probe gone away from the pad, when the shaft turned so many degrees
        back?"""


@dataclass(frozen=True)
class Check:
    """One setting: key under [rig], what the file says, what was found; ``good``: they agree. found None: not found.
    ``table`` : that has the key, where it is not [rig]."""

    key: str
    said: Any
    found: Any
    good: bool
    remark: str
    table: str = "rig"

    @property
    def new(self) -> bool:
        """Found, and the file says nothing of it, nor must it."""
        return self.good and self.said is None and self.found is not None


def check_rig(
    hand: HandMotion, rig: RigSettings, person: Person, say: Callable[[str], None], reach_deg: float = REACH_DEG,
    stiffness_said: float | None = None,
) -> tuple[Check, ...]:  # fmt: skip
    """The settings of ``rig`` against what the rig does, ending with the probe at the home that was found.

    The probe begins free, some millimetres above a soft pad that lies flat. ``say`` is told of each step.

    stiffness_said : by the file, of a joint whose stiffness is measured.

    DeviceError : as `HandMotion`; no touch within ``reach_deg``; the probe is not free at the home that was found.
    """
    start = hand.start()
    say(f"start: shaft at {start.shaft_deg:.2f} degrees; the force of now counts as zero")
    push_sign, touch = _approach(hand, rig, person, say, reach_deg)
    say(f"touch: {touch.size_n:.2f} N at {touch.shaft_deg:.2f} degrees")
    with hand.resting():
        person.zero_calliper()
        zeroed_deg = hand.shaft_deg()  # the pad pushes the shaft back when the motors go off
    axis = _axis(rig, touch)
    sign = Check("push_sign", rig.push_sign, push_sign, push_sign == rig.push_sign, "which way the shaft pushes")
    back = hand.go(start.shaft_deg, until_n=touch.size_n + TOUCH_N)
    _check_free(back, "after the touch")
    with hand.resting():
        gear = _gear(rig, abs(zeroed_deg - hand.shaft_deg()), person)
    gear_mm_per_degree = gear.found or rig.gear_mm_per_degree
    found = replace(rig, push_sign=sign.found, push_axis=axis.found, gear_mm_per_degree=gear_mm_per_degree)
    home, depth_mm = _home(found, touch, back)
    found = replace(found, home_deg=home.found)
    say(f"home: to {found.home_deg:.2f} degrees")
    _check_free(hand.go(found.home_deg), "at home")
    checks = axis, sign, gear, home, _depth(found, depth_mm)
    if hand.joint is None or hand.joint.measured_key is None:
        return checks
    return (*checks, _stiffness(hand, found, abs(touch.shaft_deg - found.home_deg) + _TRY_DEG, stiffness_said, say))


def _stiffness(
    hand: HandMotion, rig: RigSettings, reach_deg: float, said: float | None, say: Callable[[str], None]
) -> Check:
    """Stiffness at the two ends of the study's range. Both tell the same full stiffness where it is proportional to
    the gain.
    """
    joint = hand.joint
    assert joint is not None
    presets = joint.rounded([percent / 100 for percent in reversed(rig.stiffness_percent)]).tolist()
    measured = [measure_stiffness(hand, rig, preset, rig.home_deg, reach_deg, say) for preset in presets if preset > 0]
    weights = [(each.preset / each.se_nm_per_rad) ** 2 for each in measured]
    mean = sum(w * each.full_nm_per_rad for w, each in zip(weights, measured, strict=True)) / sum(weights)
    full = [f"{each.full_nm_per_rad:.3g} by {100 * each.preset:.3g} %" for each in measured]
    remark = f"at the full gain {' and '.join(full)} N m/rad"
    fulls = [each.full_nm_per_rad for each in measured]
    if max(fulls) > (1 + _SAME_STIFFNESS) * min(fulls):
        remark += "; they differ, so that the stiffness is not proportional to the gain"
    good = said is not None and math.isclose(mean, said, rel_tol=_SAME_STIFFNESS)
    found = said if good else float(f"{mean:.4g}")
    return Check(str(joint.measured_key), said, found, good, remark, table="actuator")


class MeasuredStiffness(NamedTuple):
    """At one preset. se_nm_per_rad : standard error of the slope. points : of it."""

    preset: float
    nm_per_rad: float
    se_nm_per_rad: float
    points: int

    @property
    def full_nm_per_rad(self) -> float:
        """Stiffness at the full preset, N m/rad, to which stiffness is proportional."""
        return self.nm_per_rad / self.preset


def measure_stiffness(
    hand: HandMotion, rig: RigSettings, preset: float, from_deg: float, reach_deg: float, say: Callable[[str], None]
) -> MeasuredStiffness:
    """Press from ``from_deg``, where the probe is free, until 5 N are felt, and go back there.

    DeviceError : as `HandMotion`; no 5 N within ``reach_deg``, or a shaft that does not stay behind.
    """
    hand.preset = preset
    most_n = min(_MOST_N, rig.guards.force_n / 2)
    touch = hand.go(from_deg + rig.push_sign * reach_deg, until_n=TOUCH_N)
    bent_deg, torque_nm = [], []
    step_deg = _step_deg(hand, rig, preset)
    for _ in range(_MOST_STEPS if touch.touched else 0):
        place = hand.go(hand.at_deg + rig.push_sign * step_deg, until_n=most_n)
        bent_deg.append(rig.push_sign * (hand.at_deg - place.shaft_deg))
        torque_nm.append(place.size_n * rig.lever_m)
        if place.size_n >= most_n:
            break
    else:
        hand.go(from_deg, from_zero=False)
        do = "Use a stiffer pad, or put it nearer."
        raise DeviceError("probe", wanted=f"{most_n:g} N within the reach", found="less", do=do)
    hand.go(from_deg, from_zero=False)
    found = _slope(np.radians(bent_deg), np.array(torque_nm), preset)
    said = f"{found.nm_per_rad:.3g} +- {found.se_nm_per_rad:.1g} N m/rad at {100 * preset:.3g} % of the full gain"
    say(f"stiffness: {said}, by {found.points} points")
    return found


def _step_deg(hand: HandMotion, rig: RigSettings, preset: float) -> float:
    """A step that adds `_STEP_N` where only the joint gives way."""
    joint = hand.joint
    assert joint is not None
    return math.degrees(_STEP_N * rig.lever_m / float(joint.stiffness_nm_per_rad(preset)))


def _slope(bent_rad: Floats, torque_nm: Floats, preset: float) -> MeasuredStiffness:
    if bent_rad.size < _LEAST_POINTS or np.ptp(bent_rad) <= 0:
        do = "Use a stiffer pad, and check that the rig file names the gain that the motor has."
        wanted = "a shaft that stays behind its command"
        raise DeviceError("probe", wanted=wanted, found=f"{bent_rad.size} points", do=do)
    (compliance, _), covariance = np.polyfit(torque_nm, bent_rad, 1, cov=True)
    se = math.sqrt(float(covariance[0, 0])) / float(compliance) ** 2
    return MeasuredStiffness(preset, 1 / float(compliance), se, bent_rad.size)


def _approach(
    hand: HandMotion, rig: RigSettings, person: Person, say: Callable[[str], None], reach_deg: float
) -> tuple[int, Place]:
    """Which way pushes, 1 or -1, and the place of the touch."""
    start, sign = hand.at_deg, rig.push_sign
    say(f"move: {_TRY_DEG:g} degrees the way that push_sign = {sign} calls towards the pad")
    place = hand.go(start + sign * _TRY_DEG, until_n=TOUCH_N)
    if place.touched:
        return sign, place
    with hand.resting():
        towards = person.towards(_TRY_DEG)
    ways = (sign, -sign) if towards is None else (sign,) if towards else (-sign,)
    for way in ways:
        say(f"move: until {TOUCH_N:g} N are felt, at most {reach_deg:g} degrees")
        place = hand.go(start + way * reach_deg, until_n=TOUCH_N)
        if place.touched:
            return way, place
        hand.go(start, until_n=TOUCH_N)
    do = "Put the pad nearer to the probe, or give more with --reach-deg."
    raise DeviceError("probe", wanted=f"a touch within {reach_deg:g} degrees", found="none", do=do)


def _axis(rig: RigSettings, touch: Place) -> Check:
    unit = touch.force_n / touch.size_n
    off_deg = _angle_deg(unit, np.array(rig.push_axis))
    remark = f"the touch pushes {off_deg:.0f} degrees off push_axis"
    if off_deg <= _SAME_AXIS_DEG:
        return Check("push_axis", rig.push_axis, rig.push_axis, True, remark)
    main = np.zeros(3)
    main[np.argmax(np.abs(unit))] = np.sign(unit[np.argmax(np.abs(unit))])
    chosen = main if _angle_deg(unit, main) <= _SAME_AXIS_DEG else unit
    return Check("push_axis", rig.push_axis, tuple(round(float(part), 4) for part in chosen), False, remark)


def _gear(rig: RigSettings, way_deg: float, person: Person) -> Check:
    said = rig.gear_mm_per_degree
    moved_mm = person.moved_mm(way_deg) if way_deg >= _LEAST_WAY_DEG else None
    if not moved_mm or moved_mm <= 0:
        remark = "not checked: it needs a calliper, and 5 degrees or more between start and pad"
        return Check("gear_mm_per_degree", said, None, True, remark)
    gear = moved_mm / way_deg
    remark = f"{moved_mm:g} mm in {way_deg:.2f} degrees"
    if math.isclose(gear, said, rel_tol=_SAME_GEAR):
        return Check("gear_mm_per_degree", said, said, True, remark)
    return Check("gear_mm_per_degree", said, float(f"{gear:.4g}"), False, remark)


def _home(rig: RigSettings, touch: Place, start: Place) -> tuple[Check, float]:
    """The check, and the depth of the touch from the home that was found, mm. ``start``: where the probe was free."""
    said = rig.home_deg
    depth_mm = rig.depth_at(touch.shaft_deg)
    free_mm = depth_mm - rig.depth_at(start.shaft_deg)
    least_mm, usual_mm = _CLEAR_MM
    if least_mm <= depth_mm <= min(rig.travel_mm - _ROOM_MM, rig.guards.contact_mm):
        return Check("home_deg", said, said, True, f"{depth_mm:.1f} mm before the touch"), depth_mm
    clear_mm = min(usual_mm, free_mm)  # no further up than the probe is known to come
    if clear_mm < least_mm:
        do = "Begin with the probe 3 mm above the pad."
        wanted = f"{least_mm:g} mm or more between start and touch"
        raise DeviceError("probe", wanted=wanted, found=f"{free_mm:.1f} mm", do=do)
    home = round(touch.shaft_deg - rig.position_at(clear_mm) + rig.home_deg, 3)
    where = f"{-depth_mm:.1f} mm beyond the touch" if depth_mm < 0 else f"{depth_mm:.1f} mm before the touch"
    measured = f"it is {where}; home_deg should be {clear_mm:.1f} mm before it"
    return Check("home_deg", said, home, False, measured), clear_mm


def _depth(rig: RigSettings, depth_mm: float) -> Check:
    room_mm, (low, high) = rig.travel_mm - depth_mm, rig.position_deg
    deepest = rig.position_at(rig.travel_mm)
    remark = f"touch {depth_mm:.1f} mm from home, {room_mm:.1f} mm left to press"
    if not low <= deepest <= high:
        remark = f"the deepest position, {deepest:.2f} degrees, is outside position_deg, {low:.6g} to {high:.6g}"
        fits_mm = math.floor(10 * max(rig.depth_at(low), rig.depth_at(high))) / 10
        return Check("travel_mm", rig.travel_mm, fits_mm, False, remark)
    return Check("travel_mm", rig.travel_mm, rig.travel_mm, True, remark)


def _check_free(place: Place, where: str) -> None:
    if place.touched or place.size_n > TOUCH_N / 2:
        do = "Look whether the probe is free there, and tare the sensor."
        raise DeviceError("probe", wanted=f"no force {where}", found=f"{place.size_n:.2f} N", do=do)


def _angle_deg(one: Floats, other: Floats) -> float:
    cosine = float(one @ other) / float(np.linalg.norm(one) * np.linalg.norm(other))
    return math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
