"""``emg2vsa rig run``: carry out one run on the real rig, or any number on the emulated one in virtual time."""

from __future__ import annotations

import argparse
from pathlib import Path

from casr.command_line import Commands, add_command, whole_number
from emg2vsa.cli.arguments import add_jobs, jobs_of
from emg2vsa.cli.rig.choice import add_choice, add_rig, runs_chosen


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "run",
        run,
        "Press one specimen at one angle under one condition; with --virtual, do all runs on the emulated rig.",
        "Before anything moves, the run is checked against the rig file and the limits the device tells. Ctrl-C, a "
        "signal, a file named stop in the folder of the run, or a guard end a run: the probe is retracted, the motors "
        "go off, ended.json says why. A second Ctrl-C does not wait for the loop. Exit status 0: completed; 1: ended "
        "otherwise; 2: unusable rig file, schedule or device, nothing has moved.",
    )
    add_rig(parser)
    add_choice(parser)
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder of the runs (default: as the rig file says; with --virtual another beside that one)",
    )
    parser.add_argument(
        "--repetitions", type=whole_number, metavar="N", help="presses of the run (default: as the rig file says)"
    )
    parser.add_argument("--virtual", action="store_true", help="emulated rig, minutes in seconds; no device is opened")
    add_jobs(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.rig_file import load_rig

    file = load_rig(arguments.rig)
    runs = runs_chosen(arguments, file)
    if arguments.virtual:
        from emg2vsa.cli.rig.virtual_runs import run_virtually

        return run_virtually(file, runs, arguments.out or file.virtual_runs, arguments.repetitions, jobs_of(arguments))
    from emg2vsa.cli.rig.real_run import run_for_real

    return run_for_real(file, runs, arguments.out or file.runs, arguments.repetitions)
