"""Options of rig run: how many presses, in which order, where they are kept; and which of them go together."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import whole_number

if TYPE_CHECKING:
    from emg2vsa.rig_file import RigFile


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """All but the choice of runs and what judges them."""
    add = parser.add_argument
    where = "folder of the runs (default: the folder of the rig file; emulated runs go into another folder beside it)"
    add("--out", type=Path, metavar="DIR", help=where)
    one = "number of presses (default: those that the run still lacks)"
    unknown = "the largest number of presses (default: [experiment] repetitions for each calibration)"
    add("--repetitions", type=whole_number, metavar="N", help=f"{one}. With --adaptive: {unknown}")
    every = "do all chosen runs one after the other: place the specimen, press Enter"
    again = "continues a stopped sequence and repeats rejected presses"
    add("--all", action="store_true", help=f"{every}; {again}")
    order = "random order, or as the rig file lists the runs (default: [experiment] order); order.json keeps it"
    add("--order", choices=("random", "listed"), help=f"with --all: {order}")
    seed = "with --all: seed of the random order (default: [experiment] seed)"
    add("--seed", type=int, metavar="N", help=seed)
    add("--yes", action="store_true", help="with --all: ask no questions (for scripts)")
    plate = "indent this specimen with a flat plate, as [plate] says, for emg2vsa tools stiffness; may be repeated"
    add("--plate", action="append", default=[], metavar="NAME", help=plate)
    add("--virtual", action="store_true", help="use an emulated rig, faster than real time; no device is opened")


def check_options(arguments: argparse.Namespace) -> None:
    """SettingError for options that do not go together, whatever the rig file says."""
    for name in ("order", "seed"):
        if getattr(arguments, name) is not None and not arguments.all:
            _refuse(f"--{name}", "--all beside this option", "one run", "Add --all, or leave it out.")
    for name in ("all", "plate"):
        if arguments.adaptive and getattr(arguments, name):
            _refuse("--adaptive", "no other choice of runs", f"--{name}", "Leave out one of the two.")
    if arguments.all and arguments.repetitions:
        do = "Leave it out: a sequence makes the presses that [experiment] repetitions asks for."
        _refuse("--repetitions", "one run", "--all", do)


def check_for(arguments: argparse.Namespace, file: RigFile) -> None:
    """SettingError for options that do not go with the way of pressing, or with the order of the rig file."""
    listed = (arguments.order or file.experiment.order) == "listed"
    if arguments.seed is not None and (listed or arguments.seed < 0):
        do = "Choose --order random and a seed from 0."
        _refuse("--seed", "a seed for a random order", str(arguments.seed), do)
    if arguments.plate and arguments.calibration:
        do = "Leave out --calibration: a plate has no pins."
        _refuse("--calibration", "presses of the tactile sensor", "--plate", do)
    chosen = arguments.specimen or arguments.angle or arguments.condition or arguments.repetitions
    if arguments.plate and (arguments.all or chosen):
        do = "Leave the others out: [plate] says how its trials go."
        _refuse("--plate", "--plate alone", "a choice of runs beside it", do)
    if not arguments.adaptive:
        return
    fixed = "the calibrations say which {}s there are"
    told = {"angle": fixed, "condition": fixed, "mounting": "every new mounting gets the next number"}
    for name, why in told.items():
        if given := getattr(arguments, name):
            do = f"Leave it out: {why.format(name)}."
            _refuse(f"--{name}", "no choice of runs beside --adaptive", str(given[0]), do)
    if len(arguments.specimen) != 1:
        _refuse("--specimen", "one specimen", ", ".join(arguments.specimen) or "none", "Name the unknown specimen.")
    if not arguments.calibration:
        do = "Add --calibration FILE for every angle and condition that may be pressed."
        _refuse("--adaptive", "--calibration beside this option", "none", do)


def _refuse(option: str, wanted: str, found: str, do: str) -> None:
    from emg2vsa.errors import SettingError

    raise SettingError(option, wanted=wanted, found=found, do=do)
