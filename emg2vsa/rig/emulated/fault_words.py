"""Faults of the emulated rig by name, put on and off while it runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from emg2vsa.errors import SettingError
from emg2vsa.rig.emulated.bench import EmulatedRig

Strike = Callable[[EmulatedRig, int], None]


@dataclass(frozen=True)
class Fault:
    """What goes wrong, in words, and how: ``strike`` takes a number of pieces, or 1 and 0 for on and off."""

    words: str
    strike: Strike
    lasts: bool = False


def _lose(bench: EmulatedRig, count: int) -> None:
    bench.wire.lose("to host", at=-count, count=count)


def _corrupt(bench: EmulatedRig, count: int) -> None:
    for _ in range(count):
        bench.wire.corrupt("to host", at=-1)


def _reset(bench: EmulatedRig, count: int) -> None:
    bench.reset_actuator()


def _mute(bench: EmulatedRig, on: int) -> None:
    bench.wire.mute = bool(on)


def _of_box(name: str, kind: type = int) -> Strike:
    return lambda bench, value: setattr(bench.box.faults, name, kind(value))


def _of_camera(name: str, kind: type = int) -> Strike:
    return lambda bench, value: setattr(bench.camera.faults, name, kind(value))


FAULTS = {
    "lose": Fault("the next reply of the actuator lacks its last N bytes", _lose),
    "corrupt": Fault("the next N replies of the actuator have a wrong byte", _corrupt),
    "reset": Fault("the actuator's power goes off and on", _reset),
    "mute": Fault("the actuator hears but does not answer", _mute, lasts=True),
    "gap": Fault("the next N datagrams of the force sensor are lost", _of_box("lose")),
    "skip": Fault("the force sensor leaves out N internal samples", _of_box("skip")),
    "stuck": Fault("the force stays as it is", _of_box("stuck", bool), lasts=True),
    "saturated": Fault("the force sensor says that it is saturated", _of_box("saturated", bool), lasts=True),
    "silent": Fault("the force sensor sends nothing", _of_box("mute", bool), lasts=True),
    "drop": Fault("the next N frames are lost", _of_camera("drop")),
    "dark": Fault("the camera gives no frames", _of_camera("mute", bool), lasts=True),
}
_ON_OFF = {"on": 1, "": 1, "off": 0}


def put(bench: EmulatedRig, line: str) -> str:
    """Put a fault on or off as ``line`` says: its name, then a number, on or off; ``off`` alone ends all that last.

    What was done, in words. SettingError for anything else.
    """
    name, _, how = line.strip().partition(" ")
    how = how.strip()
    if name == "off" and not how:
        for lasting in filter(lambda fault: fault.lasts, FAULTS.values()):
            lasting.strike(bench, 0)
        return "all faults off"
    fault = FAULTS.get(name)
    if fault is None:
        raise SettingError("fault", wanted=", ".join(FAULTS), found=repr(name), do="Type help for what they do.")
    if fault.lasts and how in _ON_OFF:
        fault.strike(bench, _ON_OFF[how])
        return f"{name} {how or 'on'}: {fault.words}"
    if not fault.lasts and (not how or (how.isdecimal() and int(how) > 0)):
        fault.strike(bench, int(how or 1))
        return f"{name}: {fault.words.replace('N', how or '1')}"
    wanted = "on or off" if fault.lasts else "a whole number from 1"
    raise SettingError(f"fault {name}", wanted=wanted, found=repr(how), do="Type help for what it does.")


def help_text() -> str:
    """The faults, one a line."""
    forms = {name: " on|off" if fault.lasts else " [N]" if "N" in fault.words else "" for name, fault in FAULTS.items()}
    lines = [f"  {name + forms[name]:<18}{fault.words}" for name, fault in FAULTS.items()]
    return "\n".join([*lines, f"  {'off':<18}every fault that lasts ends", f"  {'quit':<18}as Ctrl-C"])
