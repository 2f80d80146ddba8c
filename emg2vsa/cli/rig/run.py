"""``emg2vsa rig run``: carry out runs on the real rig, one or a sequence, or any number on the emulated one."""

from __future__ import annotations

import argparse

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.arguments import add_jobs, jobs_of
from emg2vsa.cli.rig.choice import add_choice, add_rig, person_of, runs_chosen
from emg2vsa.cli.rig.kappa_options import add_kappa, judging_of
from emg2vsa.cli.rig.run_options import add_run_options, check_for, check_options


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "run",
        run,
        "Press one specimen at one angle under one condition, or all of them with --all. Without a choice, list the "
        "runs.",
        "Before anything moves, the command checks the run against the rig file and against the limits of the "
        "device. Ctrl-C, a signal, a file named stop in the folder of the run, or a guard ends a run: the "
        "probe is retracted, the motors are switched off, and ended.json says why. A second Ctrl-C does "
        "not wait for the control loop. Exit status 0: completed, or listed; 1: ended otherwise; 2: "
        "unusable rig file, schedule or device, nothing has moved.",
    )
    add_rig(parser)
    add_choice(parser)
    add_run_options(parser)
    add_kappa(parser.add_argument_group("kappa while the finger presses"))
    add_jobs(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    check_options(arguments)
    from emg2vsa.cli.rig import run_words as words
    from emg2vsa.lab.pressing import Pressing
    from emg2vsa.rig_file import load_rig
    from emg2vsa.rig_file.sequence import ordered, run_order

    file, person = load_rig(arguments.rig), person_of(arguments)
    check_for(arguments, file)
    root = arguments.out or (file.virtual_runs if arguments.virtual else file.runs)
    pressing, judging, presses = (
        Pressing(file, root, arguments.virtual, person),
        judging_of(arguments),
        arguments.repetitions,
    )
    if arguments.plate:
        from emg2vsa.lab.plate_runs import press_plates

        return words.plates(press_plates(pressing, arguments.plate), root, as_json=arguments.json)
    if arguments.adaptive:
        from emg2vsa.lab.adaptive_runs import press_adaptively

        done = press_adaptively(pressing, arguments.specimen[0], judging, presses)
        return words.adaptive(done, as_json=arguments.json)
    from emg2vsa.lab.sequence import press_in_order, press_side_by_side

    runs = runs_chosen(arguments, file)
    order = run_order(root, file.experiment, arguments.order, arguments.seed) if arguments.all else None
    if arguments.virtual:
        order, jobs = order or ordered(file.experiment), jobs_of(arguments)
        made = press_side_by_side(pressing, runs, order, judging, presses, jobs)
        return words.side_by_side(made, file, as_json=arguments.json)
    if order:
        return words.in_order(press_in_order(pressing, runs, order, judging), as_json=arguments.json)
    words.tell_left(file, root)
    if len(runs) != 1:
        return words.to_do(pressing, runs, as_json=arguments.json)
    return words.one(pressing.press_run(runs[0], judging, presses), as_json=arguments.json)
