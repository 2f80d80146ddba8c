"""``emg2vsa simulate``: synthetic recordings of a study, with their truth beside them."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_study

if TYPE_CHECKING:
    from emg2vsa.study import Study


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "simulate",
        run,
        "Write synthetic recordings, and their true values, into the data folder of the study.",
        "The same seed gives the same bytes. Existing recordings are never overwritten without --overwrite.",
    )
    add_study(parser)
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder to write to (default: the data folder of the study)"
    )
    parser.add_argument(
        "--format",
        choices=("bids", "csv", "emgworks", "c3d"),
        help="file format (default: the format of the recordings of the study)",
    )
    parser.add_argument("--seed", type=int, metavar="N", help="seed to use instead of the seed of the study")
    parser.add_argument("--overwrite", action="store_true", help="replace existing recordings")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import counter
    from emg2vsa.errors import SettingError
    from emg2vsa.study_file import load_study, missing_files
    from emg2vsa.synthetic import simulate_study

    study = load_study(arguments.study)
    if study.simulation is None:
        raise SettingError(
            arguments.study, wanted="a [simulation] table", found="none",
            do="Add one with the true a_v and b_v of every specimen.",
        )  # fmt: skip
    if arguments.seed is not None:
        simulation = dataclasses.replace(study.simulation, seed=arguments.seed)
        study = dataclasses.replace(study, simulation=simulation)
    folder = arguments.out or study.data
    if folder.exists() and any(folder.iterdir()) and not arguments.overwrite:
        raise SettingError(
            folder, wanted="an empty or absent folder", found="files in it",
            do="Choose another with --out, or replace them with --overwrite.",
        )  # fmt: skip
    format = arguments.format or _format_of(study)
    made = simulate_study(study, folder, format=format, progress=counter("simulate"))
    absent = [] if arguments.out else missing_files(study)
    size_mb = sum(path.stat().st_size for path in made.recordings) / 1e6
    if arguments.json:
        print_json({"folder": str(folder), "recordings": [str(p) for p in made.recordings], "truth": str(made.truth)})
    else:
        print(f"{len(made.recordings)} recordings ({size_mb:.1f} MB, {made.format}) in {folder}")
        print(f"truth: {made.truth}")
        if absent:
            print(
                f"note: the study looks for {absent[0].emg_file}, which is not among them; see its [recordings] table"
            )
    return 0


def _format_of(study: Study) -> Literal["bids", "csv", "c3d"]:
    """The format that the study's file names ask for."""
    suffix = study.recordings[0].emg_file.suffix.lower()
    return "c3d" if suffix == ".c3d" else "csv" if suffix == ".csv" else "bids"
