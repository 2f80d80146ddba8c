"""``emg2vsa rig zero``: motors and shaft are at zero where they stand."""

from __future__ import annotations

import argparse

from casr.command_line import Commands
from emg2vsa.cli.rig.hand import add_hand_command, add_yes, board_of, confirmed


def add_to(commands: Commands) -> None:
    parser = add_hand_command(
        commands,
        "zero",
        run,
        "Make the present place of motors and shaft their zero, and store it in the device (SET_ZEROS).",
        "The motors must be off, and the shaft at rest without load. home_ticks of the rig file counts from this zero: "
        "check it afterwards with emg2vsa rig commission. Exit status 0: the encoders read zero; 1: not asked for.",
    )
    add_yes(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.rig.rig_lock import rig_lock
    from emg2vsa.rig.clock import WallClock
    from emg2vsa.rig.open_rig import board_info, open_board
    from emg2vsa.rig_file import load_rig

    file = load_rig(arguments.rig)
    with rig_lock(file.path), open_board(board_of(arguments, file), file.rig.stiffness_percent, WallClock()) as board:
        board_info(board)
        at = board.measurements()
        print("motors at {} and {} ticks, shaft at {}".format(*at))
        if not confirmed(f"Make this the zero of {board.where}?", arguments.yes):
            return 1
        print("now {}, {} and {} ticks, stored".format(*board.set_zeros()))
    print(f"home_ticks = {file.rig.home_ticks} of {file.path} counts from the new zero: check it")
    return 0
