"""Faults of the emulated rig by name, put on and off while it runs: at once, at a time, or at a force."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace

from emg2vsa.errors import SettingError
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.far_ends.camera import CameraFaults
from emg2vsa.worlds.far_ends.faults import Fault, faults_in
from emg2vsa.worlds.far_ends.netft_faults import BoxFaults


def _drift(bench: EmulatedRig, n_per_s: float) -> None:
    bench.box.faults.drifts_from_s, bench.box.faults.drift_n_per_s = bench.clock.now_s(), n_per_s


SENSOR_FAULTS = faults_in("box.faults", BoxFaults) | faults_in("camera.faults", CameraFaults)
"""Faults by the name that is typed; those of an actuator stand beside its far end."""
SENSOR_FAULTS["drift"] = replace(SENSOR_FAULTS["drift"], strike=_drift)
_ON_OFF = {"on": 1.0, "": 1.0, "off": 0.0}
_LINE = re.compile(
    r"(?P<name>\S+)(?: +(?!at |for )(?P<how>\S+))?(?: +at +(?P<at>\S+) +(?P<unit>s|N))?(?: +for +(?P<lasting>\S+) +s)?"
)
FORM = "NAME [NUMBER | on | off] [at NUMBER s | at NUMBER N] [for NUMBER s]"


def put(bench: EmulatedRig, line: str) -> str:
    """Put a fault on or off as ``line`` says; ``off`` alone ends all that last, and forgets all that are to come.

    What was done or will be, in words. SettingError for anything else.

    A line is `FORM`: a name of `faults_of`; how many, how much, on or off; ``at`` a time from now, s, or as soon as
    the true force on the specimen is so large, N, else at once; ``for`` so long, else until it is put off.
    """
    line = " ".join(line.split())
    if line == "off":
        bench.interrupt(lambda: _all_off(bench))
        return "all faults off"
    parts = _LINE.fullmatch(line)
    name = parts["name"] if parts else line.partition(" ")[0]
    faults = faults_of(bench)
    fault = faults.get(name)
    if fault is None:
        raise SettingError("fault", wanted=", ".join(faults), found=repr(name), do="Type help for what they do.")
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
    for lasting in filter(lambda fault: fault.lasts, faults_of(bench).values()):
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


def faults_of(bench: EmulatedRig) -> Mapping[str, Fault]:
    """All of a bench by name: of its actuator, then of its sensors."""
    return {**bench.end.faults, **SENSOR_FAULTS}


def help_text(bench: EmulatedRig) -> str:
    """The faults, one a line."""
    forms = {"count": " [N]", "switch": " on|off", "amount": " N|off"}
    rows = [
        (name + (forms[f.kind] if f.kind != "count" or "N " in f.words else ""), f.words)
        for name, f in faults_of(bench).items()
    ]
    rows += [("off", "every fault that lasts ends"), ("quit", "as Ctrl-C")]
    return "\n".join([f"  {FORM}", *(f"  {form:<24}{words}" for form, words in rows)])
