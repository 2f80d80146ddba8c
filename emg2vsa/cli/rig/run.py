"""``emg2vsa rig run``: carry out runs on the real rig, one or a sequence, or any number on the emulated one."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

from casr.command_line import Commands, add_command, add_json, whole_number
from emg2vsa.cli.arguments import add_jobs, jobs_of
from emg2vsa.cli.rig.choice import add_choice, add_rig, runs_chosen
from emg2vsa.cli.rig.kappa_options import add_kappa, kappa_plans


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
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder of the runs (default: the folder of the rig file; emulated runs go into another folder beside it)",
    )
    parser.add_argument(
        "--repetitions",
        type=whole_number,
        metavar="N",
        help="number of presses (default: those that the run still lacks). With --adaptive: the largest number of "
        "presses (default: [experiment] repetitions for each calibration)",
    )
    parser.add_argument(
        "--all",
        action="store_true",
        help="do all chosen runs one after the other: place the specimen, press Enter; continues a stopped sequence "
        "and repeats rejected presses",
    )
    parser.add_argument(
        "--order",
        choices=("random", "listed"),
        help="with --all: random order, or as the rig file lists the runs (default: [experiment] order); order.json "
        "keeps it",
    )
    parser.add_argument(
        "--seed", type=int, metavar="N", help="with --all: seed of the random order (default: [experiment] seed)"
    )
    parser.add_argument("--yes", action="store_true", help="with --all: ask no questions (for scripts)")
    parser.add_argument(
        "--plate",
        action="append",
        default=[],
        metavar="NAME",
        help="indent this specimen with a flat plate, as [plate] says, for emg2vsa stiffness; may be repeated",
    )
    parser.add_argument(
        "--virtual", action="store_true", help="use an emulated rig, faster than real time; no device is opened"
    )
    add_kappa(parser.add_argument_group("kappa while the finger presses"))
    add_jobs(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.errors import SettingError
    from emg2vsa.rig_file import load_rig
    from emg2vsa.rig_file.sequence import ordered, run_order

    for name in ("order", "seed"):
        if getattr(arguments, name) is not None and not arguments.all:
            do = "Add --all, or leave it out."
            raise SettingError(f"--{name}", wanted="--all beside this option", found="one run", do=do)
    for name in ("all", "plate"):
        if arguments.adaptive and getattr(arguments, name):
            do = "Leave out one of the two."
            raise SettingError("--adaptive", wanted="no other choice of runs", found=f"--{name}", do=do)
    if arguments.all and arguments.repetitions:
        do = "Leave it out: a sequence makes the presses that [experiment] repetitions asks for."
        raise SettingError("--repetitions", wanted="one run", found="--all", do=do)
    file = load_rig(arguments.rig)
    listed = (arguments.order or file.experiment.order) == "listed"
    if arguments.seed is not None and (listed or arguments.seed < 0):
        do = "Choose --order random and a seed from 0."
        raise SettingError("--seed", wanted="a seed for a random order", found=str(arguments.seed), do=do)
    root = arguments.out or (file.virtual_runs if arguments.virtual else file.runs)
    if arguments.plate:
        from emg2vsa.cli.rig.plate_runs import run_plates

        if arguments.calibration:
            do = "Leave out --calibration: a plate has no pins."
            raise SettingError("--calibration", wanted="presses of the tactile sensor", found="--plate", do=do)
        if arguments.all or arguments.specimen or arguments.angle or arguments.condition or arguments.repetitions:
            do = "Leave the others out: [plate] says how its trials go."
            raise SettingError("--plate", wanted="--plate alone", found="a choice of runs beside it", do=do)
        options = {"virtual": arguments.virtual, "yes": arguments.yes, "as_json": arguments.json}
        return run_plates(file, arguments.plate, root, **options)
    if arguments.adaptive:
        from emg2vsa.cli.rig.adaptive_runs import run_adaptively

        return run_adaptively(arguments, file, root)
    runs = runs_chosen(arguments, file)
    order = run_order(root, file.experiment, arguments.order, arguments.seed) if arguments.all else None
    if arguments.virtual:
        from emg2vsa.cli.rig.virtual_runs import run_virtually

        jobs, order = jobs_of(arguments), order or ordered(file.experiment)
        kappa = partial(kappa_plans, arguments, file)
        return run_virtually(
            file, runs, root, arguments.repetitions, jobs, order=order, kappa=kappa, as_json=arguments.json
        )
    if order:
        from emg2vsa.cli.rig.run_sequence import run_sequence

        kappa = partial(kappa_plans, arguments, file)
        return run_sequence(file, runs, root, order, kappa=kappa, yes=arguments.yes, as_json=arguments.json)
    from emg2vsa.cli.rig.real_run import run_for_real

    kappa = partial(kappa_plans, arguments, file)
    return run_for_real(file, runs, root, arguments.repetitions, kappa=kappa, as_json=arguments.json)
