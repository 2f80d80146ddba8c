"""``emg2vsa rig commission`` and ``camera-delay``: settings of the rig file that the rig itself tells, measured."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands
from emg2vsa.cli.rig.by_hand import ASKS
from emg2vsa.cli.rig.choice import add_rig_command, file_of, finish, person_of

if TYPE_CHECKING:
    from emg2vsa.rig.commissioning.checks import Check
    from emg2vsa.rig.commissioning.reference import ReferenceProof

COMMISSION = """
What is wrong is written into the rig file after a question, and serial numbers that it lacks; comments stay. With --yes
nobody looks: the direction is searched, and the gear, which needs a calliper, is not checked. A reference, a spring of
1 to 6 N/mm, is pressed to 5 N; with --motor the motor's current becomes the second witness of the force of runs, for
12 hours. Exit status 0: all right, or written; 1: something is wrong and not written, or the reference is more than
10 % off; 2: not finished.
"""
REACH = """
--reference N_PER_MM  press a spring, or another reference of this stiffness, with the flat plate instead, and compare
--reach-deg DEG = 45  farthest that the shaft may turn to reach the pad (default 45)
--virtual  on the emulated rig, which is built as the rig file says; no device is opened
"""
CAMERA_DELAY = """
The pins move when the force rises, and the frames show it later by the delay. The command needs at least three presses,
each from before contact to 2 N. It moves nothing. Exit status 0: measured; 2: not possible.
"""
RUNS = f"runs RUN...  folder of a run, or a rig file to use all its runs\n{JSON}"


def add_to(commands: Commands) -> None:
    summary = (
        "Check push_axis, push_sign, gear, home and depth by a touch of 0.5 N on a soft pad, and correct the rig file."
    )
    add_rig_command(commands, "commission", commission, summary, COMMISSION, ASKS + REACH, {"N_PER_MM": float})
    summary = "Measure the delay of the camera from presses, and print the line delay_s for the rig file."
    add_rig_command(commands, "camera-delay", camera_delay, summary, CAMERA_DELAY, RUNS)


def commission(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.commissioning import check_reference, check_settings, mend_settings

    file, person = file_of(arguments), person_of(arguments)
    how = {"reach_deg": arguments.reach_deg, "motor": arguments.motor, "virtual": arguments.virtual}
    if arguments.reference is not None:
        proof = check_reference(file, arguments.reference, **how, person=person)
        return 1 if proof is None else finish(arguments, proof, *_reference_lines(proof), good=proof.good)
    checks = check_settings(file, **how, person=person)
    if checks is None:
        return 1
    width = 2 + max(len(check.key) for check in checks)
    person.say(f"{'setting':<{width}}{'rig file':<18}{'found':<18}{'':<8}")
    for check in checks:
        person.say(_row(check, width))
    good = mend_settings(file, checks, person)
    return finish(arguments, {"checks": [asdict(check) for check in checks], "good": good}, good=good)


def _reference_lines(proof: ReferenceProof) -> list[str]:
    found = f"found {proof.found_n_per_mm:.3g} +- {1.96 * proof.se_n_per_mm:.2g} N/mm (95 %)"
    lines = [f"reference: stated {proof.stated_n_per_mm:g} N/mm, {found}: {'they agree' if proof.good else 'WRONG'}"]
    if not proof.good:
        lines.append("more than 10 % off: check the calibration of the force sensor, the gear and the reference")
    lines += [f"at {speed:g} mm/s the motor draws {1e3 * value:.3g} mA for a newton"
              for speed, value in proof.motor_a_per_n if proof.good]  # fmt: skip
    return lines


def _row(check: Check, width: int) -> str:
    verdict = "-" if check.found is None else "new" if check.new else "right" if check.good else "WRONG"
    return f"{check.key:<{width}}{_text(check.said):<18}{_text(check.found):<18}{verdict:<8}{check.remark}"


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(f"{part:g}" for part in value)
    return "" if value is None else value if isinstance(value, str) else f"{value:g}"


def camera_delay(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.commissioning import camera_delay as measured
    from emg2vsa.run_folders.camera_delay import SYSTEMATIC_S

    found = measured(arguments.runs)
    unchanged = abs(found.delay_s - found.set_s) <= found.half_width_s + SYSTEMATIC_S
    interval = f"95 % interval of half width {_ms(found.half_width_s)}"
    return finish(
        arguments,
        found,
        *(f"left out: {why}" for why in found.left_out),
        f"presses: {len(found.by_press_s)}, of {_ms(min(found.by_press_s))} to {_ms(max(found.by_press_s))}",
        f"delay: {_ms(found.delay_s)}, {interval}, and up to {_ms(SYSTEMATIC_S)} of the method",
        f"set when they were recorded: {_ms(found.set_s)}",
        "what is set lies within that: nothing to change"
        if unchanged
        else f"for the rig file, in [camera]:\ndelay_s = {max(0.0, found.delay_s):.4f}",
    )


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.1f} ms"
