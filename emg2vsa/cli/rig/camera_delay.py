"""``emg2vsa rig camera-delay``: measure how late the frames of the camera are, from runs that are recorded."""

from __future__ import annotations

import argparse
from pathlib import Path

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.rig.choice import finish


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "camera-delay",
        run,
        "Measure the delay of the camera from presses, and print the line delay_s for the rig file.",
        "The pins move when the force rises, and the frames show it later by the delay. The command needs at least "
        "three presses, each from before contact to 2 N. It moves nothing. Exit status 0: measured; 2: not "
        "possible.",
    )
    parser.add_argument(
        "runs", type=Path, nargs="+", metavar="RUN", help="folder of a run, or a rig file to use all its runs"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.lab.camera_delay import camera_delay
    from emg2vsa.run_folders.camera_delay import SYSTEMATIC_S

    found = camera_delay(arguments.runs)
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
