"""``emg2vsa tools stiffness``: specimens' stiffness from plate indentation logs."""

from __future__ import annotations

import argparse

from casr.command_line import JSON, Commands, add_command, answer

SUMMARY = "Compute the stiffness of specimens from plate indentation logs by a moving average and Hooke's law."
EPILOG = """
A log is a folder written by emg2vsa rig run --plate, or a table with the columns indentation_mm and force_n (positive
while pressing). A table of several trials also has the columns specimen and trial; a table without them is one trial of
the specimen that its file is named after. Exit status 1: a trial has no stiffness. Example: emg2vsa tools stiffness
runs-plate/*
"""
OPTIONS = f"""
files FILE...  folder of a run, or a table with commas, semicolons, tabs or blanks between the columns
--write STUDY  write mean, standard error and worst adjusted R2 of each specimen into this study file
--window N = 5  length of the moving average in samples (default 5, as in the paper)
{JSON}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "stiffness", run, SUMMARY, EPILOG, OPTIONS, {"N": int})


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.rig_file.specimen_stiffness import lines, plate_rows, write_stiffness

    rows = plate_rows(arguments.files, arguments.window)
    if arguments.write:
        write_stiffness(arguments.write, rows)
    answer(arguments.json, rows, lines(rows))
    return 0 if all(row["stiffness_n_per_mm"] > 0 for row in rows) else 1
