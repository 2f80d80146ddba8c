"""``emg2vsa tools simulate``: synthetic recordings of a study, with their truth beside them."""

from __future__ import annotations

import argparse
import dataclasses

from casr.command_line import JSON, Commands, add_command, answer
from emg2vsa.cli.arguments import STUDY

SUMMARY = "Write synthetic recordings, and their true values, into the data folder of the study."
EPILOG = "The same seed gives the same bytes. Existing recordings are never overwritten without --overwrite."
OPTIONS = f"""
{STUDY}
--out DIR  folder to write to (default: the data folder of the study)
--format {{bids,csv,emgworks,c3d}}  file format (default: the format of the recordings of the study)
--seed N  seed to use instead of the seed of the study
--overwrite  replace existing recordings
{JSON}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "simulate", run, SUMMARY, EPILOG, OPTIONS, {"N": int})


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import counter
    from emg2vsa.errors import SettingError
    from emg2vsa.study_file import load_study, missing_files
    from emg2vsa.worlds.people import simulate_study
    from emg2vsa.worlds.people.plan import format_of

    study = load_study(arguments.study)
    if study.simulation is None:
        do = "Add one with the true a_v and b_v of every specimen."
        raise SettingError(arguments.study, wanted="a [simulation] table", found="none", do=do)
    if arguments.seed is not None:
        study = dataclasses.replace(study, simulation=dataclasses.replace(study.simulation, seed=arguments.seed))
    folder = arguments.out or study.data
    if folder.exists() and any(folder.iterdir()) and not arguments.overwrite:
        do = "Choose another with --out, or replace them with --overwrite."
        raise SettingError(folder, wanted="an empty or absent folder", found="files in it", do=do)
    made = simulate_study(study, folder, format=arguments.format or format_of(study), progress=counter("simulate"))
    absent = [] if arguments.out else missing_files(study)
    size_mb = sum(path.stat().st_size for path in made.recordings) / 1e6
    lines = [f"{len(made.recordings)} recordings ({size_mb:.1f} MB, {made.format}) in {folder}", f"truth: {made.truth}"]
    if absent:
        file = absent[0].emg_file
        lines.append(f"note: the study looks for {file}, which is not among them; see its [recordings] table")
    told = {"folder": str(folder), "recordings": [str(path) for path in made.recordings], "truth": str(made.truth)}
    answer(arguments.json, told, lines)
    return 0
