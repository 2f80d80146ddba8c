"""``emg2vsa rig camera-delay``: measure how late the frames of the camera are, from runs that are recorded."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

from casr.command_line import Commands, add_command, add_json, print_json


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
    from emg2vsa.run_folders.camera_delay import SYSTEMATIC_S, measure_delay

    found = measure_delay([folder for path in arguments.runs for folder in _folders(path)])
    if arguments.json:
        print_json(asdict(found))
        return 0
    for why in found.left_out:
        print(f"left out: {why}")
    print(f"presses: {len(found.by_press_s)}, of {_ms(min(found.by_press_s))} to {_ms(max(found.by_press_s))}")
    interval = f"95 % interval of half width {_ms(found.half_width_s)}"
    print(f"delay: {_ms(found.delay_s)}, {interval}, and up to {_ms(SYSTEMATIC_S)} of the method")
    print(f"set when they were recorded: {_ms(found.set_s)}")
    if abs(found.delay_s - found.set_s) <= found.half_width_s + SYSTEMATIC_S:
        print("what is set lies within that: nothing to change")
    else:
        print(f"for the rig file, in [camera]:\ndelay_s = {max(0.0, found.delay_s):.4f}")
    return 0


def _folders(path: Path) -> list[Path]:
    """The run in ``path``; or those of the rig file ``path``. SettingError where it is neither, or there are none."""
    from emg2vsa.errors import SettingError
    from emg2vsa.rig.record.new_folder import PLAN_FILE
    from emg2vsa.rig_file import load_rig

    if path.is_dir():
        return [path]
    if not path.exists():
        raise SettingError(path, wanted="the folder of a run, or a rig file", found="neither", do="Check the path.")
    runs = load_rig(path).runs
    if not (folders := sorted(plan.parent for plan in runs.glob(f"*/{PLAN_FILE}"))):
        do = "Press first: emg2vsa rig run."
        raise SettingError(path, wanted=f"runs in {runs}", found="none", do=do)
    return folders


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.1f} ms"
