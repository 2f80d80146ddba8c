"""``emg2vsa rig prove-watchdog``: do the motors of this very device go off when the program is silent?"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from casr.command_line import Commands
from emg2vsa.cli.rig.hand import add_hand_command, add_yes, board_of, confirmed, signals_interrupt, table_of

if TYPE_CHECKING:
    from emg2vsa.rig.commissioning.watchdog import WatchdogProof

SAID = {
    "motors off": "the motors go off by themselves",
    "flag only": "the device says that its motors are off, and they still follow commands",
    "no effect": "the motors stay on: there is no watchdog",
}


def add_to(commands: Commands) -> None:
    parser = add_hand_command(
        commands,
        "prove-watchdog",
        run,
        "Try whether the motors go off when the program is silent for longer than watchdog_s, and keep the proof.",
        "It moves the free probe 2.5 degrees away from the specimen and back, is silent, and commands the same "
        "move again: motors that follow are on, whatever the device says. The proof is kept beside the rig file; "
        "emg2vsa rig run says so when there is none for the device at hand. Exit status 0: the motors go off; 1: they "
        "do not; 2: nothing was proven.",
    )
    add_yes(parser)


def run(arguments: argparse.Namespace) -> int:
    from datetime import UTC, datetime

    from emg2vsa.cli.rig.rig_lock import rig_lock
    from emg2vsa.rig.clock import WallClock
    from emg2vsa.rig.commissioning.watchdog import prove_watchdog, write_proof
    from emg2vsa.rig.open_rig import board_info, open_board
    from emg2vsa.rig_file import load_rig

    file, clock = load_rig(arguments.rig), WallClock()
    settings = board_of(arguments, file)
    if not confirmed("Is the probe free, with 1 mm of way on both sides?", arguments.yes):
        return 1
    with (
        rig_lock(file.path),
        signals_interrupt(),
        open_board(settings, file.rig.stiffness_percent, clock) as board,
        board,
    ):
        info = board_info(board)
        date, away_sign = datetime.now(UTC).isoformat(timespec="seconds"), -file.rig.push_sign
        proof = prove_watchdog(board, info, clock, watchdog_s=settings.watchdog_s, away_sign=away_sign, date=date)
    path = write_proof(file.path, table_of(arguments), proof)
    print(f"{board.where}, {proof.firmware}: silent for {proof.silence_s:g} s with watchdog_s = {proof.watchdog_s:g}")
    print(f"moved by one command: {proof.moved_before_ticks} ticks before, {proof.moved_after_ticks} ticks after")
    print(f"{proof.verdict}: {SAID[proof.verdict]}\nwritten: {path}")
    return int(proof.verdict != "motors off")


def remark(proof: WatchdogProof | None, firmware: str) -> str:
    """What a run should say of its watchdog; "" where it is proven."""
    if proof is None:
        return f"the watchdog of this device ({firmware}) is not proven: emg2vsa rig prove-watchdog"
    return "" if proof.verdict == "motors off" else f"watchdog tried on {proof.date[:10]}: {SAID[proof.verdict]}"
