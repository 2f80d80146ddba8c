"""``emg2vsa rig`` by hand: one thing at a time with an actuator, its zero and parameters, or with the force sensor."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from functools import partial

from casr.command_line import JSON, Commands, add_options
from emg2vsa.cli.rig.choice import RIG, add_rig_command, file_of, finish, person_of

HAND = f"{RIG}--motor  use the rigid motor of [motor] instead of the actuator\n"
ASKS = f"{HAND}--yes  answer yes to every question (for scripts)\n{JSON}"
WATCHDOG = """
It moves the free probe 2.5 degrees away from the specimen and back, is silent, and commands the same move again: motors
that follow are on, whatever the device says. The proof is kept beside the rig file; emg2vsa rig run says so when there
is none for the device at hand. Exit status 0: the motors go off; 1: they do not; 2: nothing was proven.
"""
OFF = """
A run is asked to stop, which takes the probe away. A program that is silent for 1 s is ended, by the process id in the
rig's lock. Then the motors are switched off and asked. The probe stays where it is: emg2vsa rig home takes it away. It
replaces no emergency stop. Exit status 0: motors off; 1: not confirmed, switch the power off.
"""
HOME = """
The move ends where the force is 0.5 N above that at the start. The motors are off afterwards. Exit status 0: at home
and free; 1: a force ended the move, or remains; 2: nothing has moved, or a device is lost.
"""
JOG = """
The move ends where a force of any direction is --limit-n above that at the start; the probe then goes back until it is
free, at most 20 degrees of the shaft. It also goes back, while that does not raise the force, when force, springs or
current pass a limit or a device fails. The motors are off afterwards. Exit status 0: moved; 1: a force ended it; 2: bad
input, nothing has moved; or a guard or a device ended the move: the probe may still press, emg2vsa rig info tells the
force.
"""
TARE = """
A Net F/T box keeps this zero until its power is switched off. A National Instruments card keeps no zero: set [force]
bias = true instead. Exit status 0: the force is zero; 1: the force is not zero, and the command prints it.
"""
ZERO = """
A qbmove takes it by SET_ZEROS, a Dynamixel as its Homing Offset. The motors must be off, the shaft at rest without
load. home_deg of the rig file counts from this zero: check it then with emg2vsa rig commission. Exit status 0: the
encoders read zero; 1: not asked for.
"""
PARAMETERS = """
A parameter is set, stored and read back; the motors must be off. Numbers are those of the kind: see the list first.
Example for a qbmove: --backup old.json --set 13=1200. Exit status 0: done; 1: not asked for.
"""
PORT = """
rig [RIG]  rig file
--port PORT  serial port to use when there is no usable rig file
--id N = 1  device id with --port (default 1)
"""
WAY = """
--mm MM  distance towards the specimen in mm; negative values move away
--deg DEG  angle of the shaft in degrees, positive towards larger angles
"""
HOW = """
--deg-per-s V = 5  speed of the shaft (default 5; at most 25)
--limit-n N = 2  force that ends the move (default 2; at most half of guards.force_n)
"""
CHANGE = """
--set N=V,V  set parameter N to these values and store it in the device
--backup FILE  first write all parameters to a new JSON file
"""
_HELD = "friction holds the shaft under soft springs, or something is in its way"
_ID = 1


def add_to(commands: Commands) -> None:
    add = partial(add_rig_command, commands)
    add("prove-watchdog", prove_watchdog, "Try whether the motors go off when the program is silent for longer than "
        "watchdog_s, and keep the proof.", WATCHDOG, ASKS)  # fmt: skip
    add("off", off, "Switch the motors off in any state, and end the program that is using the rig.", OFF, PORT + JSON,
        {"N": int})  # fmt: skip
    add("home", home, "Move the probe slowly to its retracted position, home_deg; also one that stands pressed.", HOME,
        HAND + JSON)  # fmt: skip
    parser = add("jog", jog, "Move the probe slowly by some millimetres or degrees; a force ends the move.", JOG,
                 HAND + JSON)  # fmt: skip
    types = dict.fromkeys(("MM", "DEG", "V", "N"), float)
    add_options(parser.add_mutually_exclusive_group(required=True), WAY, types)
    add_options(parser, HOW, types)
    add("tare", tare, "Set the zero of the force sensor to the present load. The probe must touch nothing.", TARE,
        RIG + JSON)  # fmt: skip
    add("zero", zero, "Make the present place of the actuator its zero, and store it in the device.", ZERO, ASKS)
    add("parameters", parameters, "List the parameters of a device; set and store one; write them to a file.",
        PARAMETERS, ASKS + CHANGE, {"N=V,V": _setting})  # fmt: skip


def prove_watchdog(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.by_hand import proven_watchdog

    proof = proven_watchdog(file_of(arguments), motor=arguments.motor, person=person_of(arguments))
    return 1 if proof is None else finish(arguments, proof, good=proof.verdict == "motors off")


def off(arguments: argparse.Namespace) -> int:
    """Switch motors off; returns 1 where one has a problem. SettingError : not one of a rig file and a port."""
    from emg2vsa.devices.qbmove import QbmoveSettings
    from emg2vsa.errors import SettingError
    from emg2vsa.lab.by_hand import board_off
    from emg2vsa.lab.by_hand import off as motors_off

    if bool(arguments.rig) == bool(arguments.port):
        do = "Name one of them."
        raise SettingError("rig off", wanted="a rig file or --port", found="both or neither", do=do)
    person = person_of(arguments)
    by_port = QbmoveSettings(port=arguments.port, id=arguments.id)
    boards = (board_off("device", by_port, person),) if arguments.port else motors_off(arguments.rig, person)
    result = {"devices": [asdict(each) for each in boards]}
    return finish(arguments, result, good=not any(each.problem for each in boards))


def home(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab import by_hand

    at = by_hand.home(file_of(arguments), motor=arguments.motor)
    remark = []
    if at.touched:
        remark = ["the force rose on the way: is home_deg right? emg2vsa rig commission checks it"]
    elif at.force_remains:
        remark = ["a force remains: tare the sensor if the probe is free, else check home_deg"]
    elif at.short:
        remark = [f"the probe fell short of home: {_HELD}"]
    where = f"shaft at {at.shaft_deg:.2f} degrees, {at.from_home_mm:.2f} mm from home; motors off"
    return finish(
        arguments,
        at,
        where,
        "force {:.2f}, {:.2f}, {:.2f} N".format(*at.force_n),
        *remark,
        good=not (at.touched or at.force_remains),
    )


def jog(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab import by_hand

    names = ("mm", "deg", "deg_per_s", "limit_n", "motor")
    chosen = {name: getattr(arguments, name) for name in names}
    done = by_hand.jog(file_of(arguments), **chosen, person=person_of(arguments))
    way = f"{done.moved_deg:.2f} degrees, {done.moved_mm:.2f} mm towards the specimen by the gear of the rig file"
    shaft = f"shaft from {done.from_deg:.2f} to {done.shaft_deg:.2f} degrees: {way}"
    force = "force {:.2f}, {:.2f}, {:.2f} N above that at the start; motors off".format(*done.force_n)
    short = [f"the probe went {done.moved_mm:.2f} of {done.asked_mm:.2f} mm: {_HELD}"] if done.short else []
    return finish(arguments, done, shaft, force, *short, good=not done.touched)


def tare(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab import by_hand

    found = by_hand.tare(file_of(arguments))
    before = "before: {:.3f}, {:.3f}, {:.3f} N".format(*found.before_n)
    return finish(arguments, found, before, "now: {:.3f}, {:.3f}, {:.3f} N".format(*found.force_n), good=found.good)


def zero(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab import by_hand
    from emg2vsa.lab.device_states import angles

    file = file_of(arguments)
    done = by_hand.zero(file, motor=arguments.motor, person=person_of(arguments))
    if done is None:
        return 1
    at, home_deg = f"now {angles(done.after)}, stored", file.rig.home_deg
    check = f"home_deg = {home_deg:g} of {file.path} counts from the new zero: check it"
    return finish(arguments, asdict(done) | {"home_deg": home_deg}, at, check)


def parameters(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab import by_hand
    from emg2vsa.lab.device_states import parameter_line

    chosen = {"change": arguments.set, "backup": arguments.backup, "motor": arguments.motor}
    found = by_hand.parameters(file_of(arguments), **chosen, person=person_of(arguments))
    if found is None:
        return 1
    lines = [f"{found.where}: {found.info.firmware}", *(f"  {parameter_line(each)}" for each in found.parameters)]
    lines += [f"written: {arguments.backup}"] if arguments.backup else []
    return finish(arguments, found.document(), *lines)


def _setting(text: str) -> tuple[int, tuple[float, ...]]:
    number, _, values = text.partition("=")
    try:
        found = int(number), tuple(float(value) for value in values.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number and its values, 13=1200, but found {text!r}") from None
    if found[0] == _ID:
        raise argparse.ArgumentTypeError(
            "expected a parameter from 2; the id is changed with qbadmin: a device answers "
            "with its new id, and listens to the old one, until it is stored"
        )
    return found
