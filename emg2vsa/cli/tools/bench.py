"""``emg2vsa tools bench``: runs the benchmarks of a source checkout, which the installed package leaves out."""

from __future__ import annotations

import argparse

from casr.command_line import Commands, add_command
from casr.source_checkout import benchmarks
from emg2vsa.cli.arguments import COUNT
from emg2vsa.errors import SettingError

SUMMARY = "Measure time and error together, beside other libraries."
EPILOG = """
An area is one question with its cases; --list names the areas. All ways of a case run in turn on one thread,
and times are processor times. Other libraries take part where they are installed. A full run of whole areas
writes docs/benchmarks; with --smoke, --only or --compare the tables are only printed unless --out is given.
The word stress alone prints the digits of every function in hard worlds.
Needs the folder benchmarks/ of a source checkout. Example: emg2vsa tools bench conditioning --smoke
"""
OPTIONS = """
area [AREA...]  areas to measure (default all)
--list  name the areas with their questions
--smoke  small sizes and two rounds: seconds
--out DIR  folder of pages, plots and JSON
--json FILE  write the numbers there
--compare REV  our ways beside those of another revision of this checkout
--repeats N  rounds, or with --compare pairs of processes (default 9, with --smoke 2)
--only WORD  cases whose name, or ways whose library or name, holds the word
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "bench", run, SUMMARY, EPILOG, OPTIONS, COUNT, only={"default": ""})


def run(arguments: argparse.Namespace) -> int:
    if "stress" in arguments.area:
        if len(arguments.area) > 1:
            do = "Call it by itself: it is no area."
            raise SettingError("bench stress", wanted="no other area", found=" ".join(arguments.area), do=do)
        for name in ("only", "repeats", "json", "compare", "list"):
            if getattr(arguments, name):
                do = "Leave it out: stress has --smoke and --out alone."
                raise SettingError(f"bench stress, --{name}", wanted="no such option", found="it", do=do)
        return int(benchmarks("stress", "emg2vsa").run(arguments.out, arguments.smoke))
    program = benchmarks("bench.run", "emg2vsa")
    if arguments.list:
        program.list_areas()
        return 0
    program.bench(
        arguments.area, smoke=arguments.smoke, out=arguments.out, json_file=arguments.json, compare=arguments.compare,
        repeats=arguments.repeats, only=arguments.only,
    )  # fmt: skip
    return 0
