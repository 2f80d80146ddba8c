"""``emg2vsa simulate``: synthetic recordings of a study, with their truth beside them."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

from emg2vsa.cli.arguments import Commands, add_command, add_json, add_study, print_json


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "simulate",
        run,
        "Write synthetic recordings where the study expects its data, with the truth beside them.",
        "The same seed gives the same bytes. Existing recordings are never overwritten without --force.",
    )
    add_study(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="another folder (default: the study's own data folder)")
    parser.add_argument(
        "--format",
        choices=("bids", "csv", "emgworks", "c3d"),
        default="bids",
        help="file format (default: bids; choose the one that the [recordings] table of the study expects)",
    )
    parser.add_argument("--seed", type=int, metavar="N", help="another seed than the study's")
    parser.add_argument("--force", action="store_true", help="replace recordings that are there")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import counter
    from emg2vsa.errors import SettingError
    from emg2vsa.study_file import load_study
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
    if folder.exists() and any(folder.iterdir()) and not arguments.force:
        raise SettingError(
            folder, wanted="an empty or absent folder", found="files in it",
            do="Choose another with --out, or replace them with --force.",
        )  # fmt: skip
    made = simulate_study(study, folder, format=arguments.format, progress=counter("simulate"))
    size_mb = sum(path.stat().st_size for path in made.recordings) / 1e6
    if arguments.json:
        print_json({"folder": str(folder), "recordings": [str(p) for p in made.recordings], "truth": str(made.truth)})
    else:
        print(f"{len(made.recordings)} recordings ({size_mb:.1f} MB, {made.format}) in {folder}")
        print(f"truth: {made.truth}")
    return 0
