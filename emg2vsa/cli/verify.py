"""``emg2vsa verify``: recompute every number of an authors' package and say which differ."""

from __future__ import annotations

import argparse
from pathlib import Path

from casr.command_line import JSON, Commands, add_command, answer
from emg2vsa.cli.arguments import COUNT, JOBS, jobs_of

SUMMARY = "Recompute every number of an authors' package from its data and say which differ."
EPILOG = """
The package's files are held against its manifest, its macros against its numbers, and its numbers, tables and schedules
against those that its study file gives on the data. Nothing is written beside them. Exit status 0: everything agrees;
1: a number differs, or a file was changed; 2: the package cannot be verified, or not all of it, as data are missing.
"""
OPTIONS = f"""
package PACKAGE  folder that emg2vsa report STUDY --paper wrote, or its archive
--data FOLDER  folder of the study file, from which it names its data (default: found in or beside the package)
--keys GLOB = *  compare only numbers with such keys, for example 'fit.*'
--work DIR  recompute in DIR and keep it (default: temporary)
{JOBS}{JSON}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "verify", run, SUMMARY, EPILOG, OPTIONS, COUNT | {"PACKAGE": Path})


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.deposit.verification import verify_package
    from emg2vsa.deposit.verification_words import as_json, lines

    found = verify_package(
        arguments.package, data=arguments.data, work=arguments.work, keys=arguments.keys, jobs=jobs_of(arguments),
        progress=progress(quiet=arguments.json),
    )  # fmt: skip
    answer(arguments.json, as_json(found), lines(found))
    return found.status
