"""``emg2vsa rig scan``: which ports there are, who answers on those that are named, and sensor and camera."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from functools import partial
from pathlib import Path

from casr.command_line import Commands, add_command, add_json, whole_number
from emg2vsa.cli.rig.choice import finish, person_of


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "scan",
        run,
        "List the serial adapters of actuators, and ask the devices that --port or a rig file names.",
        "Each port takes about 3 s. The command changes nothing, and sends nothing to a port or address that you do "
        "not name. Exit status 0: adapters are present and every named device answers; 1: otherwise; 2: "
        "the rig file has problems, or another run or command is using the rig.",
    )
    add, several = parser.add_argument, partial(parser.add_argument, action="append", default=[])
    add("rig", nargs="?", type=Path, metavar="RIG", help="rig file whose devices are asked")
    several("--port", help="ask this port, even if it is not listed; may be repeated")
    several("--id", type=_device_id, help="ask only this device id; may be repeated")
    add("--kind", default="qbmove", help="kind of actuator to ask for on --port (default qbmove; or dynamixel)")
    add("--baud", type=whole_number, help="baud rate of --port (default: as the kind has it)")
    longest = "time to wait for each answer in ms (default 5; 20 for slow lines)"
    add("--wait-ms", type=whole_number, default=5, metavar="MS", help=longest)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.device_states import scan
    from emg2vsa.rig_file import load_rig

    file, person = load_rig(arguments.rig) if arguments.rig else None, person_of(arguments)
    asked = {
        "ports": arguments.port,
        "kind": arguments.kind,
        "baud": arguments.baud,
        "ids": arguments.id,
        "wait_s": arguments.wait_ms / 1000,
    }
    devices = scan(file, **asked, person=person)
    if none := not any(not each.device.startswith("[") for each in devices):
        person.say("no serial port with an actuator's adapter; name another with --port")
    result = {"devices": [asdict(each) for each in devices]}
    return finish(arguments, result, good=not none and all(each.usable for each in devices))


def _device_id(text: str) -> int:
    if not text.isdecimal() or not 0 <= int(text) <= 255:
        raise argparse.ArgumentTypeError(f"expected a device id of 0 to 255, but found {text!r}")
    return int(text)
