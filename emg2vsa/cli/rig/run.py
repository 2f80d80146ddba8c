"""``emg2vsa rig run``: carry out runs on the real rig, one or a sequence, or any number on the emulated one."""

from __future__ import annotations

import argparse
from typing import Any

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.arguments import add_jobs, jobs_of
from emg2vsa.cli.rig.choice import add_choice, add_rig, finish, person_of, runs_chosen
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
    from emg2vsa.rig_file import load_rig

    file = load_rig(arguments.rig)
    check_for(arguments, file)
    from emg2vsa.cli.rig import run_words as words

    virtual, presses = arguments.virtual, arguments.repetitions
    root = arguments.out or (file.virtual_runs if virtual else file.runs)
    where: dict[str, Any] = {"folder": root, "virtual": virtual, "person": person_of(arguments)}
    if arguments.plate:
        from emg2vsa.lab.plate_runs import plates

        return words.plates(arguments, plates(file, arguments.plate, **where), root)
    where["judging"] = judging_of(arguments)
    if arguments.adaptive:
        from emg2vsa.lab.adaptive_runs import adaptive

        return words.adaptive(arguments, adaptive(file, arguments.specimen[0], presses=presses, **where))
    runs = runs_chosen(arguments, file)
    if arguments.all or virtual:
        from emg2vsa.lab.sequence import sequence

        chosen = {"order": arguments.order, "seed": arguments.seed, "kept": arguments.all, "presses": presses}
        done = sequence(file, runs, **chosen, jobs=jobs_of(arguments), **where)
        return words.side_by_side(arguments, done, file) if virtual else words.in_order(arguments, done)
    words.tell_left(file, root)
    if len(runs) != 1:
        return words.to_do(arguments, file, root, runs)
    from emg2vsa.lab.pressing import press

    one = press(file, *runs[0], presses=presses, **where)
    return finish(arguments, one.document(), good=one.completed)
