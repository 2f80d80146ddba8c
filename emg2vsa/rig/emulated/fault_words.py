"""Faults of the emulated rig by name, put on and off while it runs: at once, at a time, or at a force."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from emg2vsa.devices.qbmove.packets import Command
from emg2vsa.errors import SettingError
from emg2vsa.rig.emulated.bench import EmulatedRig
from emg2vsa.rig.emulated.faults import POSITION_COMMANDS

Strike = Callable[[EmulatedRig, float], None]


@dataclass(frozen=True)
class Fault:
    """What goes wrong, in words, and how.

    words : N stands for the number. strike : puts it on with a number, or off with ``neutral``.
    kind : count, it strikes so many times; switch, on or off; amount, so much until it is off.
    usual : the number when none is given. least, most : bounds of an amount.
    """

    words: str
    strike: Strike
    kind: Literal["count", "switch", "amount"] = "count"
    usual: float = 1
    neutral: float = 0
    least: float = -math.inf
    most: float = math.inf

    @property
    def lasts(self) -> bool:
        """Until it is put off."""
        return self.kind != "count"


def _lose(bench: EmulatedRig, count: float) -> None:
    bench.wire.lose("to host", at=-int(count), count=int(count))


def _corrupt(bench: EmulatedRig, count: float) -> None:
    for _ in range(int(count)):
        bench.wire.corrupt("to host", at=-1)


def _ignore(commands: frozenset[int]) -> Strike:
    def strike(bench: EmulatedRig, on: float) -> None:
        bench.wire.ignored = bench.wire.ignored | commands if on else bench.wire.ignored - commands

    return strike


def _of_wire(name: str, part: float | None = None) -> Strike:
    """``part`` of an amount is what the wire understands; without it the fault is a switch."""
    return lambda bench, value: setattr(bench.wire, name, bool(value) if part is None else value * part)


def _of_motors(name: str, kind: Callable[[float], object] = bool) -> Strike:
    return lambda bench, value: setattr(bench.firmware.motors.faults, name, kind(value))


def _of_box(name: str, kind: Callable[[float], object] = bool) -> Strike:
    return lambda bench, value: setattr(bench.box.faults, name, kind(value))


def _of_camera(name: str, kind: Callable[[float], object] = bool) -> Strike:
    return lambda bench, value: setattr(bench.camera.faults, name, kind(value))


def _drift(bench: EmulatedRig, n_per_s: float) -> None:
    bench.box.faults.drifts_from_s, bench.box.faults.drift_n_per_s = bench.clock.now_s(), n_per_s


def _encoder(sensor: int, name: str) -> dict[str, Fault]:
    def freeze(bench: EmulatedRig, on: float) -> None:
        bench.firmware.motors.freeze(sensor, bool(on))

    def jump(bench: EmulatedRig, ticks: float) -> None:
        bench.firmware.motors.faults.jumped_ticks[sensor] = int(ticks)

    return {
        f"frozen-{name}": Fault(f"the encoder of the {name} stays as it is", freeze, "switch"),
        f"jumped-{name}": Fault(
            f"the encoder of the {name} reads N ticks more", jump, "amount", 9000, 0, -20000, 20000
        ),
    }


_MS, _PERCENT = 1e-3, 1e-2
FAULTS = {
    "lose": Fault("the next reply of the actuator lacks its last N bytes", _lose),
    "corrupt": Fault("the next N replies of the actuator have a wrong byte", _corrupt),
    "reset": Fault("the actuator's power goes off and on", lambda bench, _: bench.reset_actuator()),
    "mute": Fault("the actuator hears but does not answer", _of_wire("mute"), "switch"),
    "deaf": Fault("the actuator hears nothing", _of_wire("deaf"), "switch"),
    "ignore": Fault("no position command reaches the actuator, all else does", _ignore(POSITION_COMMANDS), "switch"),
    "no-watchdog": Fault(
        "no SET_WATCHDOG reaches the actuator", _ignore(frozenset((Command.SET_WATCHDOG,))), "switch"
    ),
    "flag-only": Fault("an expired watchdog says off, and the motors stay on", _of_motors("flag_only"), "switch"),
    "late": Fault("replies of the actuator come N ms late", _of_wire("late_s", _MS), "amount", 4, 0, 0, 1000),
    "bytes-lost": Fault(
        "N % of the bytes of both ways are lost", _of_wire("lost_share", _PERCENT), "amount", 1, 0, 0, 100
    ),
    "bits-wrong": Fault(
        "N % of the bytes of both ways have a wrong bit", _of_wire("wrong_share", _PERCENT), "amount", 1, 0, 0, 100
    ),
    "doubled": Fault("every reply of the actuator comes twice", _of_wire("doubled"), "switch"),
    "stranger": Fault(
        "the actuator answers with the next id", lambda bench, on: setattr(bench.wire, "id_shift", int(on)), "switch"
    ),
    "jam": Fault("no motor moves, whatever it pulls", _of_motors("jammed"), "switch"),
    "brown-out": Fault("the motors have no supply, the electronics live on", _of_motors("unsupplied"), "switch"),
    "weak": Fault(
        "no motor does more than N N m",
        _of_motors("torque_nm", lambda torque_nm: torque_nm if math.isfinite(torque_nm) else None),
        "amount", 0.1, math.inf, 0,
    ),
    **_encoder(0, "motor-1"),
    **_encoder(1, "motor-2"),
    **_encoder(2, "shaft"),
    "current": Fault("both currents read N mA more", _of_motors("current_ma", float), "amount", 6000, 0, -2e4, 2e4),
    "gap": Fault("the next N datagrams of the force sensor are lost", _of_box("lose", int)),
    "skip": Fault("the force sensor leaves out N internal samples", _of_box("skip", int)),
    "trash": Fault("the next N datagrams are each followed by one of random numbers", _of_box("trash", int)),
    "garbage": Fault("every datagram is followed by one of a random sequence", _of_box("garbage"), "switch"),
    "thinned": Fault(
        "N % of the datagrams are lost", _of_box("thinned", lambda n: n * _PERCENT), "amount", 50, 0, 0, 100
    ),
    "twice": Fault("every datagram comes twice", _of_box("doubled"), "switch"),
    "shuffled": Fault("of N datagrams the oldest comes last", _of_box("shuffled", int), "amount", 4, 0, 2, 100),
    "delayed": Fault("datagrams come N ms late", _of_box("late_s", lambda n: n * _MS), "amount", 20, 0, 0, 1000),
    "lag": Fault("the force is that of N ms ago", _of_box("lag_s", lambda n: n * _MS), "amount", 20, 0, 0, 1000),
    "cut": Fault("datagrams lack their last byte", _of_box("cut"), "switch"),
    "replayed": Fault("the same datagram comes again and again", _of_box("replayed"), "switch"),
    "stuck": Fault("the force stays as it is", _of_box("stuck"), "switch"),
    "saturated": Fault("the force sensor says that it is saturated", _of_box("saturated"), "switch"),
    "overflow": Fault("the force sensor sends its largest counts", _of_box("overflow"), "switch"),
    "silent": Fault("the force sensor sends nothing", _of_box("mute"), "switch"),
    "swapped": Fault("x and z of the force sensor are exchanged", _of_box("swapped"), "switch"),
    "turned": Fault("z of the force sensor has the wrong sign", _of_box("turned"), "switch"),
    "dead": Fault("z of the force sensor gives its noise only", _of_box("dead"), "switch"),
    "gain": Fault("the force sensor gives N times the load", _of_box("gain", float), "amount", 0.2, 1, -100, 100),
    "drift": Fault("z of the force sensor drifts by N N/s", _drift, "amount", -2, 0, -1000, 1000),
    "push": Fault("somebody leans on the force sensor with N N", _of_box("push_n", float), "amount", 2, 0, -1000, 1000),
    "drop": Fault("the next N frames are lost", _of_camera("drop", int)),
    "dark": Fault("the camera gives no frames", _of_camera("mute"), "switch"),
    "few-frames": Fault("of N frames only the first comes", _of_camera("kept_of", int), "amount", 2, 1, 1, 1000),
    "old-frames": Fault(
        "pictures show what was N ms before their time",
        _of_camera("late_s", lambda n: n * _MS),
        "amount", 400, 0, 0, 10000,
    ),
}  # fmt: skip
"""By the name that is typed."""
_ON_OFF = {"on": 1.0, "": 1.0, "off": 0.0}
_LINE = re.compile(
    r"(?P<name>\S+)(?: +(?!at |for )(?P<how>\S+))?(?: +at +(?P<at>\S+) +(?P<unit>s|N))?(?: +for +(?P<lasting>\S+) +s)?"
)
FORM = "NAME [NUMBER | on | off] [at NUMBER s | at NUMBER N] [for NUMBER s]"


def put(bench: EmulatedRig, line: str) -> str:
    """Put a fault on or off as ``line`` says; ``off`` alone ends all that last, and forgets all that are to come.

    What was done or will be, in words. SettingError for anything else.

    A line is `FORM`: a name of `FAULTS`; how many, how much, on or off; ``at`` a time from now, s, or as soon as
    the true force on the specimen is so large, N, else at once; ``for`` so long, else until it is put off.
    """
    line = " ".join(line.split())
    if line == "off":
        bench.interrupt(lambda: _all_off(bench))
        return "all faults off"
    parts = _LINE.fullmatch(line)
    name = parts["name"] if parts else line.partition(" ")[0]
    fault = FAULTS.get(name)
    if fault is None:
        raise SettingError("fault", wanted=", ".join(FAULTS), found=repr(name), do="Type help for what they do.")
    if parts is None or (parts["lasting"] and not fault.lasts):
        wanted = FORM if parts is None else "no end: it strikes and is over"
        raise _no_fault(name, wanted, line)
    value = _value(name, fault, parts["how"] or "")
    at, lasting_s = _number(name, parts["at"], "at"), _number(name, parts["lasting"], "for")
    said = fault.words.replace("N ", f"{value:g} ", 1)
    state = " off" if fault.lasts and value == fault.neutral else " on" if fault.kind == "switch" else ""
    said = f"{name}{state}: {said}"

    def begin() -> None:
        fault.strike(bench, value)
        if lasting_s is not None:
            bench.plan.at_time(bench.clock.now_s() + lasting_s, lambda: fault.strike(bench, fault.neutral))

    def plan() -> None:
        if at is None:
            begin()
        elif parts["unit"] == "s":
            bench.plan.at_time(bench.clock.now_s() + at, begin)
        else:
            bench.plan.at_force(at, begin)

    bench.interrupt(plan)
    when = "" if at is None else f", at {at:g} {parts['unit']}"
    return said + when + ("" if lasting_s is None else f", for {lasting_s:g} s")


def _all_off(bench: EmulatedRig) -> None:
    bench.plan.clear()
    for lasting in filter(lambda fault: fault.lasts, FAULTS.values()):
        lasting.strike(bench, lasting.neutral)


def _value(name: str, fault: Fault, how: str) -> float:
    if fault.kind == "switch":
        if how in _ON_OFF:
            return _ON_OFF[how]
        raise _no_fault(name, "on or off", how)
    if fault.kind == "count":
        if not how or (how.isdecimal() and int(how) > 0):
            return int(how or fault.usual)
        raise _no_fault(name, "a whole number from 1", how)
    if how == "off":
        return fault.neutral
    value = _float(how) if how else fault.usual
    if value is None or not fault.least <= value <= fault.most:
        raise _no_fault(name, f"off, or a number from {fault.least:g} to {fault.most:g}", how)
    return value


def _number(name: str, text: str | None, word: str) -> float | None:
    if text is None:
        return None
    value = _float(text)
    if value is None or value < 0:
        raise _no_fault(name, f"a number from 0 after {word}", text)
    return value


def _float(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _no_fault(name: str, wanted: str, found: str) -> SettingError:
    return SettingError(f"fault {name}", wanted=wanted, found=repr(found), do="Type help for what it does.")


def help_text() -> str:
    """The faults, one a line."""
    forms = {"count": " [N]", "switch": " on|off", "amount": " N|off"}
    rows = [
        (name + (forms[f.kind] if f.kind != "count" or "N " in f.words else ""), f.words) for name, f in FAULTS.items()
    ]
    rows += [("off", "every fault that lasts ends"), ("quit", "as Ctrl-C")]
    return "\n".join([f"  {FORM}", *(f"  {form:<24}{words}" for form, words in rows)])
