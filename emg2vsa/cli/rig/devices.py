"""``emg2vsa rig scan``, ``info`` and ``emulate``: which devices there are, what they know, and emulated ones."""

from __future__ import annotations

import argparse
import json
import sys
import threading
from dataclasses import asdict
from functools import partial

from casr.command_line import JSON, Commands, wanted, whole, whole_number
from emg2vsa.cli.rig.choice import RIG, add_rig_command, file_of, finish, person_of

SCAN = """
Each port takes about 3 s. The command changes nothing, and sends nothing to a port or address that you do not name.
Exit status 0: adapters are present and every named device answers; 1: otherwise; 2: the rig file has problems, or
another run or command is using the rig.
"""
NAMED = f"""
rig [RIG]  rig file whose devices are asked
--port PORT...  ask this port, even if it is not listed; may be repeated
--id ID...  ask only this device id; may be repeated
--kind KIND = qbmove  kind of actuator to ask for on --port (default qbmove; or dynamixel)
--baud BAUD  baud rate of --port (default: as the kind has it)
--wait-ms MS = 5  time to wait for each answer in ms (default 5; 20 for slow lines)
{JSON}"""
INFO = """
Exit status 0: all devices can be used; 1: some cannot be used; 2: the rig file has problems, or another run or command
is using the rig and would lose its force sensor and camera.
"""
EMULATE = """
Use the file of --write with emg2vsa rig info, run and watch in another shell. Type lines here to switch faults on and
off; type help for a list. Linux and macOS only.
"""
BENCH = f"""
{RIG}--specimen NAME  specimen on the bench (default: the first of the rig file)
--angle DEG = 0  angle of its surface in degrees (default: 0)
--rigid  use the rigid motor of the condition high-stiffness
--fault LINE...  fault that is on from the start, such as "ignore at 2 N for 1.5 s"; may be repeated
--write FILE  write a copy of RIG with the addresses of the emulated devices
{JSON}"""


def add_to(commands: Commands) -> None:
    add = partial(add_rig_command, commands)
    numbers = {"ID": wanted("a device id of 0 to 255", whole(0, 255)), "BAUD": whole_number, "MS": whole_number}
    add("scan", scan, "List the serial adapters of actuators, and ask the devices that --port or a rig file names.",
        SCAN, NAMED, numbers)  # fmt: skip
    add("info", info, "Ask each device of a rig file for its firmware, limits, parameters and readings. The motors are "
        "not switched.", INFO, RIG + JSON)  # fmt: skip
    add("emulate", emulate, "Run an emulated rig behind serial, UDP and HTTP ports in real time, until Ctrl-C.",
        EMULATE, BENCH)  # fmt: skip


def scan(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab import device_states

    file, person = file_of(arguments) if arguments.rig else None, person_of(arguments)
    asked = {
        "ports": arguments.port,
        "kind": arguments.kind,
        "baud": arguments.baud,
        "ids": arguments.id,
        "wait_s": arguments.wait_ms / 1000,
    }
    devices = device_states.scan(file, **asked, person=person)
    if none := not any(not each.device.startswith("[") for each in devices):
        person.say("no serial port with an actuator's adapter; name another with --port")
    result = {"devices": [asdict(each) for each in devices]}
    return finish(arguments, result, good=not none and all(each.usable for each in devices))


def info(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab import device_states

    devices = device_states.info(file_of(arguments), person_of(arguments))
    result = {"devices": [asdict(each) for each in devices]}
    return finish(arguments, result, good=all(each.usable for each in devices))


def emulate(arguments: argparse.Namespace) -> int:
    """Serve emulated devices until ``quit``, Ctrl-C or SIGTERM."""
    from emg2vsa.lab.by_hand import signals_interrupt
    from emg2vsa.lab.emulation import Emulation, emulation, toml_lines

    def introduce(served: Emulation) -> None:
        if arguments.json:  # one line: what reads it need not wait for the end
            told = {"specimen": served.specimen, "angle_deg": served.angle_deg, "devices": served.devices}
            print(json.dumps(told | {"faults": list(served.faults)}), flush=True)
            return
        under = f"the {served.actuator}"
        print(f"# {served.specimen} at {served.angle_deg:g} degrees under {under}")
        print("\n".join(toml_lines(served.devices)).strip())
        written = [f"\n# written: {arguments.write}"] if arguments.write else []
        faults = [f"# {fault}" for fault in served.faults]
        print("\n".join([*written, *faults, "# help for faults, Ctrl-C to end"]), flush=True)

    file, angle_deg = file_of(arguments), arguments.angle
    options = {"specimen": arguments.specimen, "rigid": arguments.rigid, "faults": arguments.fault}
    with (
        signals_interrupt("SIGTERM"),
        emulation(file, angle_deg=angle_deg, write=arguments.write, **options) as served,
    ):
        introduce(served)
        try:
            for line in filter(str.strip, sys.stdin):
                if line.strip() == "quit":
                    raise KeyboardInterrupt
                print(served.obey(line), flush=True)
            threading.Event().wait()  # nobody types: serve on
        except KeyboardInterrupt:
            print("\nend of the emulation", flush=True)
    return 0
