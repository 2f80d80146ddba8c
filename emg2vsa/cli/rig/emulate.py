"""``emg2vsa rig emulate``: the emulated rig behind real ports, for all other commands."""

from __future__ import annotations

import argparse
import json
import sys
import threading
from pathlib import Path

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.rig.choice import add_rig


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "emulate",
        run,
        "Run an emulated rig behind serial, UDP and HTTP ports in real time, until Ctrl-C.",
        "Use the file of --write with emg2vsa rig info, run and watch in another shell. Type lines here to switch "
        "faults on and off; type help for a list. Linux and macOS only.",
    )
    add_rig(parser)
    add = parser.add_argument
    add("--specimen", metavar="NAME", help="specimen on the bench (default: the first of the rig file)")
    add("--angle", type=float, default=0.0, metavar="DEG", help="angle of its surface in degrees (default: 0)")
    add("--rigid", action="store_true", help="use the rigid motor of the condition high-stiffness")
    fault = 'fault that is on from the start, such as "ignore at 2 N for 1.5 s"; may be repeated'
    add("--fault", action="append", default=[], metavar="LINE", help=fault)
    add("--write", type=Path, metavar="FILE", help="write a copy of RIG with the addresses of the emulated devices")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.by_hand import signals_interrupt
    from emg2vsa.lab.emulation import Emulation, emulation, toml_lines
    from emg2vsa.rig_file import load_rig

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

    file, angle_deg = load_rig(arguments.rig), arguments.angle
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
