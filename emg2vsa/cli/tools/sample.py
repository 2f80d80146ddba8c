"""``emg2vsa tools sample``: small data for the commands and snippets of the documentation."""

from __future__ import annotations

import argparse
from pathlib import Path

from casr.command_line import JSON, Commands, add_command, answer

NAMES = ("recordings", "plate", "slopes", "presses", "study")
SUMMARY = "Write small simulated data, on which the commands and snippets of the documentation run."
EPILOG = """
recordings: EMG and force of two people on two specimens; plate: plate indentation logs; slopes: a table for
emg2vsa stats; presses: two tactile presses for casr score; study: a study file with its recordings.
The same name gives the same bytes. Example: emg2vsa tools sample study
"""
OPTIONS = f"""
name NAME  {", ".join(NAMES)}
--out DIR  folder to write to (default: NAME)
--overwrite  replace files of the same names
{JSON}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "sample", run, SUMMARY, EPILOG, OPTIONS, name={"choices": NAMES})


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.sample_data import SAMPLES, write_sample

    folder = arguments.out or Path(arguments.name)
    made = [str(path) for path in write_sample(arguments.name, folder, overwrite=arguments.overwrite)]
    told = {"sample": arguments.name, "folder": str(folder), "files": made}
    answer(arguments.json, told, [f"{folder}: {SAMPLES[arguments.name][0]}", *(f"  {path}" for path in made)])
    return 0
