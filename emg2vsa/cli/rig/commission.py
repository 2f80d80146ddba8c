"""``emg2vsa rig commission``: the settings that protect a rig, checked by a touch on a soft pad, and mended."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING

from casr.command_line import Commands
from emg2vsa.cli.rig.choice import add_hand_command, finish, person_of

if TYPE_CHECKING:
    from emg2vsa.rig.commissioning.checks import Check


def add_to(commands: Commands) -> None:
    parser = add_hand_command(
        commands,
        "commission",
        run,
        "Check push_axis, push_sign, gear, home and depth by a touch of 0.5 N on a soft pad, and correct the rig file.",
        "What is wrong is written into the rig file after a question; comments stay. With --yes nobody looks: the "
        "direction is searched, and the gear, which needs a calliper, is not checked. Exit status 0: all right, or "
        "written; 1: something is wrong and not written; 2: not finished.",
        asks=True,
    )
    parser.add_argument(
        "--reach-deg",
        type=float,
        default=45.0,
        metavar="DEG",
        help="farthest that the shaft may turn to reach the pad (default 45)",
    )


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.commissioning import check_settings, mend_settings
    from emg2vsa.rig_file import load_rig

    file, person = load_rig(arguments.rig), person_of(arguments)
    checks = check_settings(file, reach_deg=arguments.reach_deg, motor=arguments.motor, person=person)
    if checks is None:
        return 1
    width = 2 + max(len(check.key) for check in checks)
    person.say(f"{'setting':<{width}}{'rig file':<18}{'found':<18}{'':<8}")
    for check in checks:
        person.say(_row(check, width))
    good = mend_settings(file, checks, person)
    return finish(arguments, {"checks": [asdict(check) for check in checks], "good": good}, good=good)


def _row(check: Check, width: int) -> str:
    verdict = "-" if check.found is None else "right" if check.good else "WRONG"
    return f"{check.key:<{width}}{_text(check.said):<18}{_text(check.found):<18}{verdict:<8}{check.remark}"


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(f"{part:g}" for part in value)
    return "" if value is None else f"{value:g}"
