"""``emg2vsa tools stiffness``, ``clean``, ``bench`` and ``completion``: what is needed now and then."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import Any

from casr.command_line import JSON, Commands, add_command, answer, benchmarks, command_of
from emg2vsa.cli.arguments import COUNT, STUDY, WAIT, WORK, study_of
from emg2vsa.errors import SettingError

STIFFNESS_SUMMARY = "Compute the stiffness of specimens over a range of force from presses with a flat plate."
STIFFNESS = """
A log is a folder written by emg2vsa rig run --plate, or a table: a header row that names depth and force with their
units, such as indentation_mm and force_n or Compression (mm) and Load (N), perhaps a row of units beneath; what a
testing machine writes above it tells sample, diameter and height. Pressing is positive; if depth and force both are
negative, they are turned. A table of several trials also has the columns specimen and trial, and casting and mounting
where there are several. kappa is the secant over the range; its tangents at both ends, contact with its interval, and
a rating stand beside. The interval of a specimen counts presses of one mounting as one witness, and mountings of one
casting likewise; what was done once has a stated spread. Of a cylinder of known size there are modulus and laws of
rubber too. Exit status 1: a trial is unusable. Example: emg2vsa tools stiffness runs-plate/*
"""
STIFFNESS_OPTIONS = f"""
files FILE...  folder of a run, or a table with commas, semicolons, tabs or blanks between the columns
--write STUDY  write mean, standard error, range of force and worst adjusted R2 of each specimen into this study file
--study STUDY  take range of force and sizes of specimens from this study file, and write nothing
--from N  smaller force of the range, newtons (default: [window] force_n of the study file, else 0.5)
--to N  larger force; presses that do not reach it are unusable (default: as --from, else 7; or what a press reaches)
--depth NAME  column of the depth in tables that name it otherwise, with its unit: "Travel (mm)"
--force NAME  column of the force likewise
--ends {{frictionless,bonded}}  whether the ends of cylinders slide (default: [specimens] ends, else frictionless)
--mountings PERCENT  SD of kappa between mountings of one specimen, where there is one (default 2)
--castings PERCENT  SD between castings of one recipe, where there is one (default 3.5, of published silicone; not for
 runs of the rig, nor with 0: then the study presses this very one)
--window SAMPLES = 5  length of the moving average before the paper's line (default 5, as in the paper)
{JSON}
"""
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
    types: dict[str, type] = {"N": float, "SAMPLES": int, "PERCENT": float}
    ends: dict[str, Any] = {"from": {"dest": "from_n"}, "to": {"dest": "to_n"}}
    add_command(commands, "stiffness", stiffness, STIFFNESS_SUMMARY, STIFFNESS, STIFFNESS_OPTIONS, types, **ends)
    add_command(commands, "clean", clean, CLEAN_SUMMARY, CLEAN, CLEAN_OPTIONS)
    add_command(commands, "bench", bench, BENCH_SUMMARY, BENCH, BENCH_OPTIONS, COUNT, only={"default": ""})
    command_of("emg2vsa", "emg2vsa tools")(commands)


def stiffness(arguments: argparse.Namespace) -> int:
    from emg2vsa.rig_file import specimen_stiffness as plates

    asked = plates.study_says(study) if (study := arguments.study or arguments.write) else plates.Asked()
    from_n, to_n = (
        n if own is None else own for own, n in zip((arguments.from_n, arguments.to_n), asked.range_n, strict=True)
    )
    given = {key: getattr(arguments, key) for key in ("mountings", "castings")}
    for key, percent in given.items():
        if percent is not None and not 0 <= percent < 100:
            wanted = "a standard deviation between 0 and 100, in percent of kappa"
            raise SettingError(f"--{key}", wanted=wanted, found=f"{percent:g}", do="Say how much they differ.")
    spread = replace(asked.spread, **{key: each / 100 for key, each in given.items() if each is not None})
    found = plates.read_plates(
        arguments.files,
        replace(
            asked, range_n=(from_n, to_n), whole=arguments.to_n is not None, depth=arguments.depth or "",
            force=arguments.force or "", window=arguments.window, spread=spread, ends=arguments.ends,
        ),
    )  # fmt: skip
    if arguments.write:
        plates.write_stiffness(arguments.write, found)
    rows = plates.trial_rows(found)
    answer(arguments.json, {"specimens": plates.specimen_rows(found), "trials": rows}, plates.lines(found))
    return 1 if any(row["rating"] == "unusable" for row in rows) else 0


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
