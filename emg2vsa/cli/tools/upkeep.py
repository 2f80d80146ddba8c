"""``emg2vsa tools clean``, ``bench`` and ``completion``: what is needed now and then."""

from __future__ import annotations

import argparse
import sys

from casr.command_line import JSON, Commands, add_command, answer, benchmarks, command_of
from emg2vsa.cli.arguments import COUNT, STUDY, WAIT, WORK, study_of
from emg2vsa.errors import SettingError

CLEAN_SUMMARY = "Remove stored results that no step of the study needs any more, such as those of earlier settings."
CLEAN = "This command never removes recordings, runs or reports. Everything it removes can be computed again."
CLEAN_OPTIONS = f"""
{STUDY}
--move-virtual  also move the emulated runs of version 0.1.0 from runs/ to runs-virtual-0.1.0/
{WORK}{WAIT}{JSON}
"""
BENCH_SUMMARY = "Measure time and error together, beside other libraries."
BENCH = """
An area is one question with its cases; --list names the areas. All ways of a case run in turn on one thread,
and times are processor times. Other libraries take part where they are installed. A full run of whole areas
writes docs/benchmarks; with --smoke, --only or --compare the tables are only printed unless --out is given.
The word stress alone prints the digits of every function in hard worlds.
Needs the folder benchmarks/ of a source checkout. Example: emg2vsa tools bench conditioning --smoke
"""
BENCH_OPTIONS = """
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
    add_command(commands, "clean", clean, CLEAN_SUMMARY, CLEAN, CLEAN_OPTIONS)
    add_command(commands, "bench", bench, BENCH_SUMMARY, BENCH, BENCH_OPTIONS, COUNT, only={"default": ""})
    command_of("emg2vsa", "emg2vsa tools")(commands)


def clean(arguments: argparse.Namespace) -> int:
    from emg2vsa.pipeline.campaign import move_virtual_runs
    from emg2vsa.pipeline.run_study import clean

    study, _ = study_of(arguments)
    moved = move_virtual_runs(study) if arguments.move_virtual else None
    removed, size = clean(study, wait=not arguments.no_wait, say=lambda text: print(text, file=sys.stderr))
    lines = [f"{removed} result{'s' if removed != 1 else ''} removed, {size / 1e6:.1f} MB, from {study.results}"]
    if moved is not None:
        lines.append(f"The virtual runs of version 0.1.0 are now in {moved}")
    told = {"removed": removed, "bytes": size, "moved_to": None if moved is None else str(moved)}
    answer(arguments.json, told, lines)
    return 0


def bench(arguments: argparse.Namespace) -> int:
    """Run benchmarks by area, or the stress test. SettingError : an option that the stress test has not."""
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
