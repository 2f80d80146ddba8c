"""``emg2vsa rig parameters``: read, set and store the parameters of a device, and back them up."""

from __future__ import annotations

import argparse
from pathlib import Path

from casr.command_line import Commands
from emg2vsa.cli.rig.choice import add_hand_command, finish, person_of

_ID = 1


def add_to(commands: Commands) -> None:
    parser = add_hand_command(
        commands,
        "parameters",
        run,
        "List the parameters of a device; set and store one; write them to a file.",
        "A parameter is set, stored and read back; the motors must be off. Numbers are those of the kind: see the "
        "list first. Example for a qbmove: --backup old.json --set 13=1200. Exit status 0: done; 1: not asked for.",
        asks=True,
    )
    parser.add_argument(
        "--set", type=_setting, metavar="N=V,V", help="set parameter N to these values and store it in the device"
    )
    parser.add_argument("--backup", type=Path, metavar="FILE", help="first write all parameters to a new JSON file")


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.by_hand import parameters
    from emg2vsa.lab.device_states import parameter_line
    from emg2vsa.rig_file import load_rig

    chosen = {"change": arguments.set, "backup": arguments.backup, "motor": arguments.motor}
    found = parameters(load_rig(arguments.rig), **chosen, person=person_of(arguments))
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
