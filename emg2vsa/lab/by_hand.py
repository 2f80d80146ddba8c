"""Moves, zeros and parameters of a rig by hand, and motors off: one user at a time, and they go off however it ends."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from casr.atomic import write_text_atomic
from emg2vsa.devices.board import Board
from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.device_settings import ActuatorSettings
from emg2vsa.devices.protocols import Identity, Measurements, Parameter
from emg2vsa.devices.qbmove import MotorSettings
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.lab.device_states import angles, shown
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.real_press import SAID
from emg2vsa.lab.rig_lock import end_user, rig_lock, stop_unnamed_run
from emg2vsa.rig.commissioning.hand_motion import (
    FASTEST_DEG_PER_S,
    LIMIT_SHARE,
    TOUCH_N,
    HandMotion,
)
from emg2vsa.rig.commissioning.watchdog import WatchdogProof, prove_watchdog, write_proof
from emg2vsa.rig.open_rig import OpenRig, board_settings, open_board, open_force, open_own_board, open_rig
from emg2vsa.rig.plan import RIGID, Condition
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.rig_file import RigFile, load_rig

_SIGNALS = ("SIGTERM", "SIGHUP", "SIGQUIT")
_RISE_N = 0.5
_LEFT_N = 0.2
_WAIT_S = 0.2
_SHORT_MM = 0.2
"""Shortfall from which on a move fell short: friction holds a shaft under soft springs, or something is in its way."""
Force = tuple[float, float, float]


@dataclass(frozen=True)
class AtHome:
    """shaft_deg, from_home_mm : where the probe is. force_n : (x, y, z) N, as measured. touched : a force ended the
    move. force_remains : more than 0.5 N in one axis. short : more than 0.2 mm from home."""

    shaft_deg: float
    from_home_mm: float
    force_n: Force
    touched: bool
    force_remains: bool
    short: bool


@dataclass(frozen=True)
class Jogged:
    """Where the shaft began and is, degrees; how far it turned; how far the probe went towards the specimen, mm
    by the gear of the rig file. force_n : (x, y, z) N above that at the start. touched : a force ended the move.
    asked_mm : towards the specimen. short : it went 0.2 mm less or more than that, and no force ended it."""

    from_deg: float
    shaft_deg: float
    moved_deg: float
    moved_mm: float
    force_n: Force
    touched: bool
    asked_mm: float
    short: bool


@dataclass(frozen=True)
class Tared:
    """Force (x, y, z) N before and after. good : it is zero now, within 0.2 N."""

    before_n: Force
    force_n: Force

    @property
    def good(self) -> bool:
        """Not where a force is no number, either."""
        return all(abs(part_n) <= _LEFT_N for part_n in self.force_n)


@dataclass(frozen=True)
class Zeroed:
    """Angles of motors and shaft, before and after."""

    before: Measurements
    after: Measurements


@dataclass(frozen=True)
class BoardParameters:
    """where : port and id of the device. parameters : in the order of their numbers."""

    where: str
    info: Identity
    parameters: tuple[Parameter, ...]

    def document(self) -> dict[str, Any]:
        """For JSON."""
        listed = {str(each.number): {"name": each.name, "values": list(each.values)} for each in self.parameters}
        return {"firmware": self.info.firmware, "device_id": self.info.device_id, "parameters": listed}


@contextmanager
def hand_rig(file: RigFile, *, motor: bool) -> Iterator[tuple[OpenRig, HandMotion]]:
    """The rig without its camera, opened and held, and what moves it; at the end, also by a signal, the motors go off.

    DeviceError : as `open_rig`, or another process uses the rig.
    """
    clock, devices = WallClock(), replace(file.devices, camera=None)
    with (
        rig_lock(file.path),
        signals_interrupt(),
        open_rig(devices, file.rig, _condition(motor), clock) as opened,
    ):
        yield opened, HandMotion(opened.devices, opened.rig, clock)


@contextmanager
def signals_interrupt(*names: str) -> Iterator[None]:
    """A signal that would kill the program at once interrupts it as Ctrl-C does: so the motors go off first."""
    before = {}
    for name in names or _SIGNALS:
        if number := getattr(signal, name, None):
            before[number] = signal.signal(number, signal.default_int_handler)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _held_board(file: RigFile, motor: bool, clock: WallClock | None = None) -> Iterator[Board]:
    """The actuator that is asked for, the rig held."""
    own = file.devices, _condition(motor), file.rig, clock or WallClock()
    with rig_lock(file.path), closing(open_own_board(*own)) as board:
        yield board


def _condition(motor: bool) -> Condition:
    return RIGID if motor else "modular"


def home(file: RigFile, *, motor: bool = False) -> AtHome:
    """Move the probe slowly to its retracted position, home_deg; also one that stands pressed.

    A force 0.5 N above that at the start ends the move. motor : the rigid motor instead of the actuator. DeviceError :
    as `hand_rig`, or a device is lost.
    """
    with hand_rig(file, motor=motor) as (opened, hand):
        hand.start()
        place = hand.go(file.rig.home_deg, until_n=_RISE_N, from_zero=False)
        force_n = opened.devices.force.read().force_n
    remains = float(abs(force_n).max()) > TOUCH_N
    depth_mm = file.rig.depth_at(place.shaft_deg)
    return AtHome(place.shaft_deg, depth_mm, _force(force_n), place.touched, remains, abs(depth_mm) > _SHORT_MM)


def jog(
    file: RigFile, *, mm: float | None = None, deg: float | None = None, deg_per_s: float = 5.0, limit_n: float = 2.0,
    motor: bool = False, person: Person = NOBODY,
) -> Jogged:  # fmt: skip
    """Move the probe slowly by ``mm`` towards the specimen, or the shaft by ``deg`` degrees.

    The move ends where a force is ``limit_n`` N above that at the start; the probe then goes back until it is free.
    deg_per_s : speed of the shaft. SettingError : a speed or force that is too large, or not one of the two ways.
    DeviceError : as `hand_rig`, or a guard ended the move: the probe may still press.
    """
    if (mm is None) == (deg is None):
        raise SettingError("jog", wanted="mm or deg", found="both or neither", do="Give one of them.")
    _check("--deg-per-s", deg_per_s, FASTEST_DEG_PER_S)
    _check("--limit-n", limit_n, LIMIT_SHARE * file.rig.guards.force_n)
    mm_per_degree = file.rig.gear_mm_per_degree * file.rig.push_sign
    degrees = mm / mm_per_degree if mm is not None else deg or 0.0
    with hand_rig(file, motor=motor) as (_, hand):
        start, begin = hand.start(), hand.at_deg
        place = hand.go(begin + degrees, until_n=limit_n, deg_per_s=deg_per_s)
        if touched := place.touched:
            person.say(
                f"{place.size_n:.2f} N at {place.shaft_deg:.2f} degrees ended the move; back until the probe is free"
            )
            place = hand.away(begin)
    moved_deg = place.shaft_deg - start.shaft_deg
    force_n, moved_mm, asked_mm = _force(place.force_n), moved_deg * mm_per_degree, degrees * mm_per_degree
    short = not touched and abs(moved_mm - asked_mm) > _SHORT_MM
    return Jogged(start.shaft_deg, place.shaft_deg, moved_deg, moved_mm, force_n, touched, asked_mm, short)


def _check(name: str, value: float, most: float) -> None:
    if not 0 < value <= most:
        raise SettingError(
            name, wanted=f"above 0 and at most {most:g}", found=f"{value:g}", do="Choose a value in this range."
        )


def _force(force_n: Any) -> Force:
    x, y, z = map(float, force_n)
    return x, y, z


def tare(file: RigFile) -> Tared:
    """Set the zero of the force sensor to the present load; the probe must touch nothing.

    SettingError : the sensor keeps no zero. DeviceError : the sensor is absent, or another process uses the rig.
    """
    clock = WallClock()
    if file.devices.force.kind != "net-ft":
        do = "Set [force] bias = true: every run then begins with a tare."
        raise SettingError(f"{file.path}, force.kind", wanted="net-ft, which keeps a zero", found="ni-daq", do=do)
    with rig_lock(file.path):
        sensor = open_force(file.devices.force, file.rig.guards, clock)
        try:
            sensor.start()
            before_n = sensor.read().force_n
            sensor.bias()
            clock.sleep_until(clock.now_s() + _WAIT_S)
            return Tared(_force(before_n), _force(sensor.read().force_n))
        finally:
            sensor.close()


def zero(file: RigFile, *, motor: bool = False, person: Person = NOBODY) -> Zeroed | None:
    """Make the present place of motors and shaft their zero, stored in the device; None where the person disagrees.

    The motors must be off, and the shaft at rest without load. DeviceError : the device is absent or refuses, or
    another process uses the rig.
    """
    with _held_board(file, motor) as board:
        board.identify()
        before = board.measurements()
        person.say(angles(before))
        if not person.agrees(f"Make this the zero of {board.where}?"):
            return None
        return Zeroed(before, board.set_zeros())


def parameters(
    file: RigFile, *, change: tuple[int, tuple[float, ...]] | None = None, backup: Path | None = None,
    motor: bool = False, person: Person = NOBODY,
) -> BoardParameters | None:  # fmt: skip
    """Parameters of the device, after ``change``, a number and its values, was stored; None where the person disagrees.

    backup : first write all of them to this new JSON file. SettingError : it is there, or the values do not fit.
    DeviceError : the device is absent or its motors are on, or another process uses the rig.
    """
    with _held_board(file, motor) as board:
        found = BoardParameters(board.where, board.identify(), tuple(board.parameters().values()))
        if backup:
            if backup.exists():
                do = "Choose another name for --backup."
                raise SettingError(backup, wanted="a new file", found="an existing file", do=do)
            write_text_atomic(backup, json.dumps(found.document(), indent=2) + "\n")
        if change:
            number, values = change
            was = next((shown(each.values) for each in found.parameters if each.number == number), "nothing")
            new = shown(values)
            if not person.agrees(f"Set parameter {number} of {board.where} from {was} to {new}, and store it?"):
                return None
            board.set_parameter(number, values)
            found = replace(found, parameters=tuple(board.parameters().values()))
    return found


def proven_watchdog(file: RigFile, *, motor: bool = False, person: Person = NOBODY) -> WatchdogProof | None:
    """Whether the motors go off when the program is silent for longer than watchdog_s; None where the person disagrees.

    It moves the free probe by 2.5 degrees, and keeps the proof beside the rig file. DeviceError : the device is lost or
    does not move, or another process uses the rig.
    """
    settings, clock = board_settings(file.devices, _condition(motor)), WallClock()
    if not person.agrees("Is the probe free, with 1 mm of way on both sides?"):
        return None
    with signals_interrupt(), _held_board(file, motor, clock) as board, board:
        info = board.identify()
        date, away_sign = datetime.now(UTC).isoformat(timespec="seconds"), -file.rig.push_sign
        proof = prove_watchdog(board, info, clock, watchdog_s=settings.watchdog_s, away_sign=away_sign, date=date)
    path = write_proof(file.path, "motor" if motor else "actuator", proof)
    silent = f"silent for {proof.silence_s:g} s with watchdog_s = {proof.watchdog_s:g}"
    person.say(f"{board.where}, {proof.firmware}: {silent}")
    person.say(f"moved by one command: {proof.moved_before_deg:.2f} degrees before, {proof.moved_after_deg:.2f} after")
    person.say(f"{proof.verdict}: {SAID[proof.verdict]}\nwritten: {path}")
    return proof


@dataclass(frozen=True)
class Off:
    """device : table of the rig file. problem : why its motors are not known to be off; "" where they are.
    at : angles of motors and shaft."""

    device: str
    problem: str
    at: Measurements | None


def off(rig_file: str | Path, person: Person = NOBODY) -> tuple[Off, ...]:
    """Switch the motors off in any state, and end the process that uses the rig: asked first, ended when silent.

    The lock needs no more of the rig file than its name: a file with problems keeps no run going. StudyError : the file
    cannot be read; DeviceError : somebody else's process uses the rig.
    """
    end_user(Path(rig_file), person.warn)
    file = load_rig(rig_file)
    stop_unnamed_run(file.runs, person.warn)
    boards = {"actuator": file.devices.actuator, "motor": file.devices.motor}
    return tuple(board_off(name, board, person) for name, board in boards.items() if board)


def board_off(name: str, settings: ActuatorSettings | MotorSettings, person: Person = NOBODY) -> Off:
    """Switch the motors of one device off, and ask it. SettingError where ``settings`` name no port."""
    try:
        with closing(open_board(settings, RigSettings(), WallClock())) as board:
            board.deactivate()
            at = board.measurements()
    except DeviceError as error:
        person.say(f"[{name}] NOT confirmed off: {error}")
        return Off(name, str(error), None)
    person.say(f"[{name}] motors off; {angles(at)}")
    return Off(name, "", at)
