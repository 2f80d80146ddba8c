"""``emg2vsa rig commission``: the settings that protect a rig, checked by a touch on a soft pad, and mended."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from casr.command_line import Commands
from emg2vsa.cli.rig.hand import add_hand_command, add_yes, answer, confirmed, hand_rig

if TYPE_CHECKING:
    from emg2vsa.rig.commissioning.checks import Check
    from emg2vsa.study_file.problems import KeyPath

_BEGIN = """\
Put a soft pad flat on the force sensor, where the specimen lies.
The probe must be free, 3 to 5 mm above it. It moves slowly, 5 degrees of the shaft a second, to a touch of 0.5 N.
Any force of 0.5 N ends a move. Keep a hand on the switch of the power supply."""


def add_to(commands: Commands) -> None:
    parser = add_hand_command(
        commands,
        "commission",
        run,
        "Check push_axis, push_sign, gear, home and depth by a touch of 0.5 N on a soft pad, and correct the rig file.",
        "What is wrong is written into the rig file after a question; comments stay. With --yes nobody looks: the "
        "direction is searched, and the gear, which needs a calliper, is not checked. Exit status 0: all right, or "
        "written; 1: something is wrong and not written; 2: not finished.",
    )
    parser.add_argument(
        "--reach-deg",
        type=float,
        default=45.0,
        metavar="DEG",
        help="farthest that the shaft may turn to reach the pad (default 45)",
    )
    add_yes(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.errors import SettingError
    from emg2vsa.rig.commissioning.checks import check_rig
    from emg2vsa.rig_file import load_rig
    from emg2vsa.rig_file.edit import write_values

    file = load_rig(arguments.rig)
    if not 0 < arguments.reach_deg <= 180:
        do = "Choose another."
        raise SettingError("--reach-deg", wanted="above 0 and at most 180", found=f"{arguments.reach_deg:g}", do=do)
    print(_BEGIN)
    if not confirmed("Ready?", arguments.yes):
        return 1
    with hand_rig(arguments, file) as ready:
        rig, person = ready.opened.rig, Asked(arguments.yes)
        checks = check_rig(ready.hand, rig, person, _say, arguments.reach_deg)
    print("\n".join(_table(checks)))
    wrong: dict[KeyPath, object] = {("rig", check.key): check.found for check in checks if not check.good}
    if not wrong:
        print(f"{file.path}: these settings are right")
        return 0
    if not confirmed(f"Write {', '.join(str(key[-1]) for key in wrong)} into {file.path}?", arguments.yes):
        return 1
    write_values(file.path, wrong)
    print(f"written: {file.path}; run emg2vsa rig commission once more to confirm it")
    return 0


def _say(text: str) -> None:
    print(text, flush=True)


def _table(checks: tuple[Check, ...]) -> list[str]:
    lines = [f"{'setting':<20}{'rig file':<18}{'found':<18}{'':<8}"]
    for check in checks:
        verdict = "-" if check.found is None else "right" if check.good else "WRONG"
        lines.append(f"{check.key:<20}{_text(check.said):<18}{_text(check.found):<18}{verdict:<8}{check.remark}")
    return lines


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(f"{part:g}" for part in value)
    return "" if value is None else f"{value:g}"


class Asked:
    """The person at the terminal; nobody with --yes."""

    def __init__(self, nobody: bool) -> None:
        self._nobody = nobody

    def towards(self, degrees: float) -> bool | None:
        """Which way the probe went."""
        if self._nobody:
            return None
        while True:
            said = answer(
                f"The shaft has turned {degrees:g} degrees. Has the probe gone towards the pad? [y/n] "
            ).lower()
            if said in ("y", "yes", "n", "no"):
                return said.startswith("y")

    def zero_calliper(self) -> None:
        """The gear is measured from here on."""
        if not self._nobody:
            answer("The probe touches the pad. Set a calliper to zero there, if you have one, and press Enter. ")

    def moved_mm(self, degrees: float) -> float | None:
        """How far the probe went, by a calliper."""
        if self._nobody:
            return None
        question = (
            f"The probe has gone back from the pad, {degrees:.2f} degrees of the shaft. How far, in mm, by a calliper? "
            "(Enter: not measured) "
        )
        while said := answer(question):
            try:
                return float(said.replace(",", "."))
            except ValueError:
                print("Type a number of millimetres, such as 3.2.")
        return None
