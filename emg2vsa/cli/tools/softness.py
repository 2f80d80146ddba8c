"""``emg2vsa tools stiffness`` and ``cast``: how soft specimens are, and how to make them as soft as wanted."""

from __future__ import annotations

import argparse
import re
from dataclasses import asdict, replace
from typing import Any

from casr.command_line import JSON, Commands, add_command, answer
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
CAST_SUMMARY = "List silicones and cylinders that have a wanted stiffness, from published moduli."
CAST = """
Without --stiffness these are the specimens of the paper, S1 to S5. kappa is the secant over the range of force between
lubricated plates; its interval is that of castings. Measure what you cast with emg2vsa tools stiffness. Example:
emg2vsa tools cast --diameter 50 --write specimens.toml
"""
CAST_OPTIONS = f"""
--stiffness NAME=K...  stiffness of a specimen in N/mm; may be repeated
--diameter MM = 50  of all cylinders (default 50, as published)
--height MM  of all cylinders; then the silicones that come nearest (default: whatever height has the stiffness)
--from N = 0.5  smaller force of the range, newtons (default 0.5)
--to N = 7  larger force (default 7)
--write FILE  write them into this new file as [[specimens]] of a study
{JSON}
"""


def add_to(commands: Commands) -> None:
    types: dict[str, type] = {"N": float, "SAMPLES": int, "PERCENT": float, "MM": float}
    ends: dict[str, Any] = {"from": {"dest": "from_n"}, "to": {"dest": "to_n"}}
    add_command(commands, "stiffness", stiffness, STIFFNESS_SUMMARY, STIFFNESS, STIFFNESS_OPTIONS, types, **ends)
    add_command(commands, "cast", cast, CAST_SUMMARY, CAST, CAST_OPTIONS, types, **ends)


def stiffness(arguments: argparse.Namespace) -> int:
    """Stiffness of specimens from logs of a plate; returns 1 where a press cannot be used.

    SettingError : a scatter that is no percentage from 0 to below 100.
    """
    from emg2vsa.rig_file import specimen_stiffness as told
    from emg2vsa.rig_file.plate_logs import Asked, read_plates

    asked = told.study_says(study) if (study := arguments.study or arguments.write) else Asked()
    from_n, to_n = (
        n if own is None else own for own, n in zip((arguments.from_n, arguments.to_n), asked.range_n, strict=True)
    )
    given = {key: getattr(arguments, key) for key in ("mountings", "castings")}
    for key, percent in given.items():
        if percent is not None and not 0 <= percent < 100:
            wanted = "a standard deviation between 0 and 100, in percent of kappa"
            raise SettingError(f"--{key}", wanted=wanted, found=f"{percent:g}", do="Say how much they differ.")
    spread = replace(asked.spread, **{key: each / 100 for key, each in given.items() if each is not None})
    found = read_plates(
        arguments.files,
        replace(
            asked, range_n=(from_n, to_n), whole=arguments.to_n is not None, depth=arguments.depth or "",
            force=arguments.force or "", window=arguments.window, spread=spread, ends=arguments.ends,
        ),
    )  # fmt: skip
    if arguments.write:
        told.write_stiffness(arguments.write, found)
    rows = told.trial_rows(found)
    answer(arguments.json, {"specimens": told.specimen_rows(found), "trials": rows}, told.lines(found))
    return 1 if any(row["rating"] == "unusable" for row in rows) else 0


def cast(arguments: argparse.Namespace) -> int:
    """Recipes of specimens as soft as wanted. SettingError : a size, a name or a range of force that cannot be."""
    from casr.specimens import SPECIMENS
    from emg2vsa.rig_file import silicone_kit as kit
    from emg2vsa.study_file.drafting import stiffness_of

    for key in ("diameter", "height"):
        value = getattr(arguments, key)
        if value is not None and not 0 < value < float("inf"):
            raise SettingError(f"--{key}", wanted="millimetres above 0", found=f"{value:g}", do="Correct it.")
    names = [each.partition("=")[0] for each in arguments.stiffness]
    for name in names:
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]*", name) or names.count(name) > 1:
            wanted = "names of letters, digits, - _ and dots, each once"
            raise SettingError("--stiffness", wanted=wanted, found=repr(name), do="Correct this option.")
    range_n = (arguments.from_n, arguments.to_n)
    if not 0 < range_n[0] < range_n[1] < float("inf"):
        found, do = f"{range_n[0]:g} to {range_n[1]:g}", "Give the smaller force first."
        raise SettingError("range of force", wanted="0 < F0 < F1, newtons", found=found, do=do)
    recipes = [
        kit.recipe_for(name, wanted, arguments.diameter, arguments.height, range_n)
        for name, wanted in (stiffness_of(arguments.stiffness) or SPECIMENS).items()
    ]
    if arguments.write:
        kit.write_specimens(arguments.write, recipes, range_n)
    rows = [asdict(each) | {"low": each.low, "high": each.high} for each in recipes]
    answer(arguments.json, rows, kit.lines(recipes, range_n))
    return 0
