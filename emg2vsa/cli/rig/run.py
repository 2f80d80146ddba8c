"""``emg2vsa rig run``: carry out runs on the real rig, one or a sequence, or any number on the emulated one."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from casr.command_line import JSON, Commands, add_options
from emg2vsa.cli.arguments import COUNT, JOBS, jobs_of
from emg2vsa.cli.rig.choice import CHOICE, RIG, add_rig_command, file_of, finish, person_of, runs_chosen, width

if TYPE_CHECKING:
    from emg2vsa.rig_file import RigFile

SUMMARY = """\
Press one specimen at one angle under one condition, or all of them with --all. Without a choice, list the runs."""
EPILOG = """
Before anything moves, the command checks the run against the rig file and against the limits of the device. Ctrl-C, a
signal, a file named stop in the folder of the run, or a guard ends a run: the probe is retracted, the motors are
switched off, and ended.json says why. A second Ctrl-C does not wait for the control loop. Exit status 0: completed, or
listed; 1: ended otherwise; 2: unusable rig file, schedule or device, nothing has moved.
"""
OPTIONS = f"""
{RIG}{CHOICE}
--out DIR  folder of the runs, or with --plate of the trials (default: the folder of the rig file; emulated runs and
 trials of plates go into other folders beside it)
--repetitions N  number of presses (default: those that the run still lacks). With --adaptive: the largest number of
  presses (default: [experiment] repetitions for each calibration)
--all  do all chosen runs one after the other: place the specimen, press Enter; continues a stopped sequence and repeats
  rejected presses
--order {{random,listed}}  with --all: random order, or as the rig file lists the runs (default: [experiment] order);
  order.json keeps it
--seed N  with --all: seed of the random order (default: [experiment] seed)
--yes  with --all: ask no questions (for scripts)
--plate NAME...  indent this specimen with a flat plate, as [plate] says, for emg2vsa tools stiffness; may be repeated
--virtual  use an emulated rig, faster than real time; no device is opened
"""
KAPPA = """
--calibration FILE...  judge the stiffness of the specimen while it is pressed, by this calibration of emg2vsa run;
  repeat it for other angles and conditions. kappa.csv in the folder of the run has a row for each frame
--stop-at PERCENT  with --calibration: end the loading of a press when the 95 %% interval of kappa reaches no more than
  this share of kappa to either side, or when the rest of the press would narrow it by less than a tenth. Such a press
  counts as done, and is marked as stopped
--adaptive  with --calibration and one --specimen: choose stiffness preset, angle and number of presses of each next run
  as emg2vsa rig next does, until --stop-at is reached or no press would narrow the interval by a tenth. Judged presses
  of the specimen in the folder of the runs count along. The command asks where an angle or a mounting must be changed
  by hand
--camera FILE  with --calibration: camera.toml of the tactile camera (default: camera.toml beside the rig file; an
  emulated rig has its own)
--domes FOLDER  with --calibration of a study with [runs] domes: the same tables
--specimen-height-mm MM  with --calibration: thickness of the specimen, for tables of it
"""


def add_to(commands: Commands) -> None:
    parser = add_rig_command(commands, "run", run, SUMMARY, EPILOG, OPTIONS, seed={"type": int})
    add_options(parser.add_argument_group("kappa while the finger presses"), KAPPA, {"PERCENT": width, "MM": float})
    add_options(parser, JOBS + JSON, COUNT)


def run(arguments: argparse.Namespace) -> int:
    _check_options(arguments)

    file = file_of(arguments)
    _check_for(arguments, file)
    from emg2vsa.cli.rig import run_words as words
    from emg2vsa.lab.judging import Judging
    from emg2vsa.study import plates_beside

    virtual, presses = arguments.virtual, arguments.repetitions
    root = arguments.out or (file.virtual_runs if virtual else file.runs)
    where: dict[str, Any] = {"folder": root, "virtual": virtual, "person": person_of(arguments)}
    if arguments.plate:
        from emg2vsa.lab.sequence import plates

        where["folder"] = root = arguments.out or plates_beside(root)
        return words.plates(arguments, plates(file, arguments.plate, **where), root)
    of_tables = {"domes": arguments.domes, "specimen_height_mm": arguments.specimen_height_mm}
    where["judging"] = Judging(tuple(arguments.calibration), arguments.stop_at, arguments.camera, **of_tables)
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


def _check_options(arguments: argparse.Namespace) -> None:
    """SettingError for options that do not go together, whatever the rig file says."""
    alone, beside_all = "Leave out one of the two.", "Add --all, or leave it out."
    sequence = "Leave it out: a sequence makes the presses that [experiment] repetitions asks for."
    one_run = not arguments.all
    _refuse(
        (arguments.order is not None and one_run, "--order", "--all beside this option", "one run", beside_all),
        (arguments.seed is not None and one_run, "--seed", "--all beside this option", "one run", beside_all),
        (arguments.adaptive and arguments.all, "--adaptive", "no other choice of runs", "--all", alone),
        (arguments.adaptive and arguments.plate, "--adaptive", "no other choice of runs", "--plate", alone),
        (arguments.all and arguments.repetitions, "--repetitions", "one run", "--all", sequence),
    )


def _check_for(arguments: argparse.Namespace, file: RigFile) -> None:
    """SettingError for options that do not go with the way of pressing, or with the order of the rig file."""
    seed, plate, adaptive, names = arguments.seed, arguments.plate, arguments.adaptive, arguments.specimen
    listed = (arguments.order or file.experiment.order) == "listed"
    chosen = names or arguments.angle or arguments.condition or arguments.repetitions or arguments.all
    none, random = "no choice of runs beside --adaptive", "Choose --order random and a seed from 0."
    fixed = "Leave it out: the calibrations say which {}s there are."
    by_number = "Leave it out: every new mounting gets the next number."
    _refuse(
        (seed is not None and (listed or seed < 0), "--seed", "a seed for a random order", str(seed), random),
        (plate and arguments.calibration, "--calibration", "presses of the tactile sensor", "--plate",
         "Leave out --calibration: a plate has no pins."),
        (plate and chosen, "--plate", "--plate alone", "a choice of runs beside it",
         "Leave the others out: [plate] says how its trials go."),
        *((adaptive and given, f"--{name}", none, str(given[0]) if given else "", do.format(name))
          for name, do in (("angle", fixed), ("condition", fixed), ("mounting", by_number))
          for given in [getattr(arguments, name)]),
        (adaptive and len(names) != 1, "--specimen", "one specimen", ", ".join(names) or "none",
         "Name the unknown specimen."),
        (adaptive and not arguments.calibration, "--adaptive", "--calibration beside this option", "none",
         "Add --calibration FILE for every angle and condition that may be pressed."),
    )  # fmt: skip


def _refuse(*cases: tuple[Any, str, str, str, str]) -> None:
    """SettingError for the first case that holds: which option, what was wanted and found, and what to do."""
    from emg2vsa.errors import SettingError

    for holds, option, wanted, found, do in cases:
        if holds:
            raise SettingError(option, wanted=wanted, found=found, do=do)
