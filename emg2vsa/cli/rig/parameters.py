"""``emg2vsa rig parameters``: read, set and store the parameters of a device, and back them up."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_json, print_json
from emg2vsa.cli.rig.hand import add_hand_command, add_yes, board_of, confirmed

if TYPE_CHECKING:
    from emg2vsa.rig.qbmove.info import Parameter, QbmoveInfo

_ID = 1


def add_to(commands: Commands) -> None:
    parser = add_hand_command(
        commands,
        "parameters",
        run,
        "List the parameters of a device; set and store one; write them to a file.",
        "A parameter is set, stored and read back; the motors must be off. Example: --backup old.json --set 13=1200. "
        "Exit status 0: done; 1: not asked for.",
    )
    parser.add_argument(
        "--set", type=_setting, metavar="N=V,V", help="set parameter N to these values and store it in the device"
    )
    parser.add_argument("--backup", type=Path, metavar="FILE", help="first write all parameters to a new JSON file")
    add_yes(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.rig.rig_lock import rig_lock
    from emg2vsa.rig.clock import WallClock
    from emg2vsa.rig.open_rig import board_info, open_board
    from emg2vsa.rig_file import load_rig

    file = load_rig(arguments.rig)
    with rig_lock(file.path), open_board(board_of(arguments, file), file.rig.stiffness_percent, WallClock()) as board:
        info, parameters = board_info(board), board.parameters()
        if arguments.backup:
            _write(arguments.backup, info, parameters)
        if arguments.set:
            number, values = arguments.set
            was = _shown(parameters[number].values) if number in parameters else "nothing"
            change = f"from {was} to {_shown(values)}"
            if not confirmed(f"Set parameter {number} of {board.where} {change}, and store it?", arguments.yes):
                return 1
            board.set_parameter(number, values)
            parameters = board.parameters()
    if arguments.json:
        print_json(_document(info, parameters))
    else:
        print(f"{board.where}: {info.firmware}")
        for each in parameters.values():
            print(f"  {each.number:>2} {each.name:<28} {_shown(each.values)}")
        if arguments.backup:
            print(f"written: {arguments.backup}")
    return 0


def _shown(values: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _document(info: QbmoveInfo, parameters: dict[int, Parameter]) -> dict[str, Any]:
    listed = {str(each.number): {"name": each.name, "values": list(each.values)} for each in parameters.values()}
    return {"firmware": info.firmware, "device_id": info.device_id, "parameters": listed}


def _write(path: Path, info: QbmoveInfo, parameters: dict[int, Parameter]) -> None:
    from casr.atomic import write_text_atomic
    from emg2vsa.errors import SettingError

    if path.exists():
        do = "Choose another name for --backup."
        raise SettingError(path, wanted="a new file", found="an existing file", do=do)
    write_text_atomic(path, json.dumps(_document(info, parameters), indent=2) + "\n")


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
