"""What the commands share that move a rig by hand: arguments, one user at a time, signals, and questions."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_command
from emg2vsa.cli.rig.choice import add_rig

if TYPE_CHECKING:
    from emg2vsa.rig.clock import Clock
    from emg2vsa.rig.commissioning.hand_motion import HandMotion
    from emg2vsa.rig.device_settings import ActuatorSettings, MotorSettings
    from emg2vsa.rig.open_rig import OpenRig
    from emg2vsa.rig_file import RigFile

_SIGNALS = ("SIGTERM", "SIGHUP", "SIGQUIT")


def add_hand_command(commands: Commands, name: str, run: Any, summary: str, epilog: str) -> argparse.ArgumentParser:
    """A command for a rig file and one of its two actuators."""
    parser = add_command(commands, name, run, summary, epilog)
    add_rig(parser)
    parser.add_argument("--motor", action="store_true", help="use the rigid motor of [motor] instead of the qbmove")
    return parser


def add_yes(parser: argparse.ArgumentParser) -> None:
    """For scripts."""
    parser.add_argument("--yes", action="store_true", help="answer yes to every question (for scripts)")


def table_of(arguments: argparse.Namespace) -> str:
    """Table of the rig file that names the actuator."""
    return "motor" if arguments.motor else "actuator"


def board_of(arguments: argparse.Namespace, file: RigFile) -> ActuatorSettings | MotorSettings:
    """The actuator that is asked for. SettingError where the rig file has none."""
    from emg2vsa.rig.open_rig import board_settings
    from emg2vsa.rig.plan import RIGID

    return board_settings(file.devices, RIGID if arguments.motor else "modular")


@dataclass(frozen=True)
class HandRig:
    """A rig ready to be moved by hand."""

    opened: OpenRig
    hand: HandMotion
    clock: Clock


@contextmanager
def hand_rig(arguments: argparse.Namespace, file: RigFile) -> Iterator[HandRig]:
    """Actuator and force sensor of the rig, opened and held; at the end, also by a signal, the motors go off.

    DeviceError : as `open_rig`, or another process uses the rig.
    """
    from emg2vsa.cli.rig.rig_lock import rig_lock
    from emg2vsa.rig.clock import WallClock
    from emg2vsa.rig.commissioning.hand_motion import HandMotion
    from emg2vsa.rig.devices import Devices
    from emg2vsa.rig.open_rig import open_rig
    from emg2vsa.rig.plan import RIGID

    clock = WallClock()
    devices = replace(file.devices, camera=None)
    with (
        rig_lock(file.path),
        signals_interrupt(),
        open_rig(devices, file.rig, RIGID if arguments.motor else "modular", clock) as opened,
    ):
        both = Devices(opened.devices.actuator, opened.devices.force)
        yield HandRig(opened, HandMotion(both, opened.rig, clock), clock)


@contextmanager
def signals_interrupt() -> Iterator[None]:
    """A signal that would kill the program at once interrupts it as Ctrl-C does: so the motors go off first."""
    before = {}
    for name in _SIGNALS:
        if number := getattr(signal, name, None):
            before[number] = signal.signal(number, signal.default_int_handler)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def confirmed(question: str, yes: bool) -> bool:
    """Yes from the person, or from --yes."""
    return yes or answer(f"{question} [y/N] ").lower() in ("y", "yes")


def answer(question: str) -> str:
    """What the person types. SettingError where nobody can."""
    from emg2vsa.errors import SettingError

    try:
        print(question, end="", file=sys.stderr, flush=True)
        return input().strip()
    except EOFError:
        do = "Run it in a terminal, or add --yes."
        raise SettingError("standard input", wanted="an answer", found="the end of the input", do=do) from None
