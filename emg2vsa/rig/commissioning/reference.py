"""A reference of stated stiffness, pressed: are force and depth to scale, and what does a motor draw for a newton?

A flat plate presses a spring, or a specimen whose stiffness was measured elsewhere, from its touch to 5 N at one
speed. The slope of depth over force is its stiffness; that of current over force makes a rigid motor's current the
second witness of its force. Friction at one speed, and what filters are late, shift both lines and do not turn them.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import NamedTuple

import numpy as np

from casr.atomic import write_text_atomic
from emg2vsa.devices.protocols import Identity
from emg2vsa.errors import DeviceError
from emg2vsa.rig.commissioning.hand_motion import LIMIT_N, TOUCH_N, HandMotion, Turn
from emg2vsa.rig.rig_settings import RigSettings

AGREES = 0.1
"""Share by which the stiffness that was found may differ from the stated one."""
_FROM_N, MOST_N = 1.0, 5.0
"""Ends of the line; never more than half of the force limit."""
_LEAST_TURNS = 10
_DEEP = 0.75
"""Share of the largest force of the slow press to which the others go, as they end later than they are told to."""
SLOW_MM_PER_S = 0.5
"""Speed at which a reference that turns out to be stiff goes little beyond 5 N."""
_ALONG, _LEFT_N = 0.94, 0.3
"""Of the force, that must lie along push_axis: 20 degrees off; and what may be felt when the probe is free again."""
_COUNTS, _COUNT_S, _COUNT_SHARE = 1 << 32, 3.0, 0.005
"""Of the force sensor: its numbers begin anew there; what its count may be off by, and share of the time since."""
_HOLDS = timedelta(hours=12)
"""For so long a proof holds: a working day."""


@dataclass(frozen=True)
class ReferenceProof:
    """What was found, and with what.

    date : of the press, ISO 8601 with its zone.
    stated_n_per_mm, found_n_per_mm, se_n_per_mm : stiffness as stated, as found, and its standard error.
    motor_a_per_n : speed, mm/s, and current for a newton of a rigid motor, A/N; empty with springs.
    device_id, firmware : of the actuator. serial_numbers : by table, empty where a device tells none.
    gear_mm_per_degree, push_axis : of the rig file.
    force_sequence, force_per_s : the force sensor's number of its newest sample, which begins anew with its power, and
    by how much it grows in a second; None where it counts none.
    """

    date: str
    stated_n_per_mm: float
    found_n_per_mm: float
    se_n_per_mm: float
    motor_a_per_n: tuple[tuple[float, float], ...]
    device_id: int
    firmware: str
    serial_numbers: dict[str, str]
    gear_mm_per_degree: float
    push_axis: tuple[float, ...]
    force_sequence: int | None
    force_per_s: float | None

    @property
    def good(self) -> bool:
        """Whether the two stiffnesses agree within `AGREES`."""
        return math.isclose(self.found_n_per_mm, self.stated_n_per_mm, rel_tol=AGREES, abs_tol=0.0)

    def a_per_n(self, mm_per_s: float) -> float | None:
        """Current for a newton of a motor that presses at this speed; None where that was not tried."""
        return next((value for speed, value in self.motor_a_per_n if math.isclose(speed, mm_per_s)), None)

    def refused(self, now: datetime, rig: RigSettings) -> str:
        """Why it does not hold for a run with ``rig``, before any device is asked; "" where it does."""
        if not self.good:
            return f"{self.found_n_per_mm:.3g} N/mm were found, {self.stated_n_per_mm:g} stated"
        if not timedelta(0) <= now - datetime.fromisoformat(self.date) <= _HOLDS:
            return f"it was pressed at {self.date}, more than {_HOLDS.total_seconds() / 3600:g} h ago"
        if (self.gear_mm_per_degree, self.push_axis) != (rig.gear_mm_per_degree, rig.push_axis):
            return "gear_mm_per_degree or push_axis has been changed since"
        return ""

    def refused_by(
        self, info: Identity, serial_numbers: Mapping[str, str], force_sequence: int | None, now: datetime
    ) -> str:
        """Why it does not hold for these devices; "" where it does. A force sensor that has not counted on as fast as
        at the reference has been switched off since."""
        if (self.device_id, self.firmware) != (info.device_id, info.firmware):
            return f"it was pressed with another device: {self.firmware}, id {self.device_id}"
        for table, number in self.serial_numbers.items():
            if serial_numbers.get(table, number) != number:
                return f"it was pressed with another [{table}]: serial number {number}"
        if force_sequence is None:
            return ""
        if self.force_sequence is None or not self.force_per_s:
            return "it does not tell how far the force sensor had counted"
        elapsed_s = (now - datetime.fromisoformat(self.date)).total_seconds()
        counted_s = (force_sequence - self.force_sequence) % _COUNTS / self.force_per_s
        if abs(counted_s - elapsed_s) > _COUNT_S + _COUNT_SHARE * elapsed_s:
            return "the force sensor has been switched off since"
        return ""


class Pressed(NamedTuple):
    """Stiffness and its standard error, N/mm."""

    n_per_mm: float
    se_n_per_mm: float


def press_reference(
    hand: HandMotion, rig: RigSettings, speeds_mm_per_s: Collection[float], reach_deg: float, say: Callable[[str], None]
) -> tuple[Pressed, dict[float, float]]:
    """Press the reference slowly to 5 N, then with a rigid motor three quarters as deep at each speed, and leave it;
    what the slow press tells, and speed to current for a newton of a rigid motor, A/N.

    DeviceError : as `HandMotion`; no touch, or too little force, within ``reach_deg``; a force across push_axis, or one
    that is left when the probe is free again.
    """
    start = hand.start()
    say(f"start: shaft at {start.shaft_deg:.2f} degrees; the force of now counts as zero")
    most_n, (low, high) = min(MOST_N, rig.guards.force_n / 2), rig.position_deg
    to_deg = min(max(start.shaft_deg + rig.push_sign * reach_deg, low), high)
    turns: list[Turn] = []
    place = hand.go(to_deg, until_n=most_n, deg_per_s=SLOW_MM_PER_S / rig.gear_mm_per_degree, turns=turns)
    left = hand.go(start.shaft_deg, from_zero=False)
    if not place.touched:
        do = "Put the reference 3 to 5 mm below the plate, or give more with --reach-deg."
        wanted, found = f"{most_n:g} N within its reach", f"{place.size_n:.2f} N at {place.shaft_deg:.1f} degrees"
        raise DeviceError("reference", wanted=wanted, found=found, do=do)
    along_n = float(place.force_n @ np.array(rig.push_axis))
    if along_n < _ALONG * place.size_n:
        do = "Check push_axis with emg2vsa rig commission, and the sensor's sign."
        wanted, found = "a force along push_axis", f"{along_n:.2f} N along it of {place.size_n:.2f} N"
        raise DeviceError("reference", wanted=wanted, found=found, do=do)
    if left.size_n > _LEFT_N:
        do = "Look at the zero of the force sensor, and whether the probe is free at the start."
        wanted = "no force when the probe is free again"
        raise DeviceError("reference", wanted=wanted, found=f"{left.size_n:.2f} N", do=do)
    slow = _stiffness(rig, used := _used(turns, _FROM_N))
    deep_deg = next(turn.shaft_deg for turn in used if turn.felt_n >= _DEEP * used[-1].felt_n)
    say(f"pressed: {slow.n_per_mm:.3g} +- {1.96 * slow.se_n_per_mm:.2g} N/mm (95 %)")
    a_per_n = {}
    for speed in speeds_mm_per_s if hand.joint is None else ():
        turns = []
        deg_per_s = speed / rig.gear_mm_per_degree
        hand.go(to_deg, until_n=most_n + LIMIT_N, deg_per_s=deg_per_s, turns=turns, until_deg=deep_deg)
        hand.go(start.shaft_deg, from_zero=False)
        used = _used(turns, TOUCH_N)
        a_per_n[speed] = _slope([turn.felt_n for turn in used], [turn.current_a for turn in used])[0]
    return slow, a_per_n


def _used(turns: Sequence[Turn], from_n: float) -> list[Turn]:
    """Those that feel so much. DeviceError where they are too few."""
    used = [turn for turn in turns if turn.felt_n >= from_n]
    if len(used) < _LEAST_TURNS:
        wanted = f"{_LEAST_TURNS} readings from {from_n:g} N on"
        raise DeviceError("reference", wanted=wanted, found=str(len(used)), do="Take a softer reference.")
    return used


def _stiffness(rig: RigSettings, used: Sequence[Turn]) -> Pressed:
    mm_per_n, se = _slope([turn.felt_n for turn in used], [rig.depth_at(turn.shaft_deg) for turn in used])
    if mm_per_n <= 0:
        do = "Look at the reference, the gear and the zero of the force sensor."
        raise DeviceError("reference", wanted="depth that grows with force", found=f"{mm_per_n:.3g} mm/N", do=do)
    return Pressed(1 / mm_per_n, se / mm_per_n**2)


def _slope(x: Sequence[float], y: Sequence[float]) -> tuple[float, float]:
    """Slope of y over x, and its standard error."""
    (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
    return float(slope), math.sqrt(float(covariance[0, 0]))


def _file(rig_file: Path, virtual: bool) -> Path:
    """Where the proof of a rig file is kept: beside it; that of the emulated rig apart."""
    return rig_file.with_name(f"{rig_file.stem}.{'virtual-' if virtual else ''}reference.json")


def read_reference(rig_file: Path, *, virtual: bool = False) -> ReferenceProof | None:
    """The proof that is kept; None without a file. DeviceError for another form."""
    path = _file(rig_file, virtual)
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        of_motor = tuple((float(speed), float(value)) for speed, value in found["motor_a_per_n"])
        proof = ReferenceProof(**found | {"push_axis": tuple(found["push_axis"]), "motor_a_per_n": of_motor})
        if datetime.fromisoformat(proof.date).tzinfo is None or not all(0 < value < math.inf for _, value in of_motor):
            raise ValueError("a date without its zone, or a current that is not above 0")
        return proof
    except FileNotFoundError:
        return None
    except (OSError, ValueError, TypeError, KeyError) as error:
        do = "Delete it, and press the reference again."
        raise DeviceError(
            path, wanted="a proof as emg2vsa rig commission --reference writes it", found=str(error), do=do
        ) from error


def write_reference(rig_file: Path, proof: ReferenceProof, *, virtual: bool = False) -> Path:
    """Keep the proof in place of an older one; the file."""
    path = _file(rig_file, virtual)
    write_text_atomic(path, json.dumps(asdict(proof), indent=2) + "\n")
    return path
