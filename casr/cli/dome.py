"""``casr dome``: tables of a dome of your own, solved by finite elements."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import JSON, Commands, add_command, answer, whole_number
from casr.errors import SettingError, install_extra
from casr.terminal import VOICE

if TYPE_CHECKING:
    from casr.dome.solver.cases import Solved

SUMMARY = "Solve the contact of a soft dome with specimens, and write the tables that --domes reads."
EPILOG = f"""
SENSOR.toml says radius, skin and gel of the dome, and the specimens; its keys are in docs/reference/dome-tables.md.
Tables that are in the folder already, solved from the same numbers, stay: stopped work goes on where it was. Needs
{install_extra("solver")}. Exit status 1: a case could not be solved, or its error is too large for any use.
Example: casr dome sensor.toml --out mine, then casr score presses --domes mine
"""
OPTIONS = f"""
sensor SENSOR.toml  the sensor's file
-o --out FOLDER = domes  where to write (default %(default)s)
--page FILE  a page of the dome: section and pins, how they move, areas, how unlike it is to the domes of casr
--jobs N  cases at the same time (default: one for each core)
{JSON}
"""


def add_to(commands: Commands) -> None:
    types = {"SENSOR.toml": Path, "FILE": Path, "N": whole_number}
    add_command(commands, "dome", run, SUMMARY, EPILOG, OPTIONS, types)


USELESS = 0.2
"Relative error of the area: a table with a larger error tells nothing of a press."


def run(arguments: argparse.Namespace) -> int:
    """Solve the tables that are not there yet. Returns 1 where one is not solved or of no use.

    SettingError : ``--page`` is a folder, or ``--out`` a file.
    """
    from casr.dome.solver.cases import dome_radius_mm, solve
    from casr.dome.solver.sensor_file import read_sensor

    cases = read_sensor(arguments.sensor)
    if arguments.page and arguments.page.is_dir():
        raise SettingError("--page", wanted="a file", found=f"{arguments.page}, a folder", do="Name a file in it.")
    if arguments.out.is_file():
        raise SettingError("--out", wanted="a folder", found=f"{arguments.out}, a file", do="Name a folder.")
    found = []
    for number, each in enumerate(solve(cases, arguments.out, arguments.jobs or os.cpu_count() or 1), start=1):
        found.append(each)
        if not VOICE.quiet and sys.stderr.isatty():
            end = "\n" if number == len(cases) else ""
            print(f"\rdome: {number} of {len(cases)} tables", end=end, file=sys.stderr, flush=True)
    found.sort(key=lambda each: [case.name for case in cases].index(each.case.name))
    rows: list[dict[str, Any]] = [
        {"table": each.case.name, "was_there": each.before, "stopped": each.stopped or None, **each.said}
        for each in found
    ]
    useless = [each.case.name for each in found if each.said.get("area_error", 0.0) > USELESS]
    if arguments.page and (there := [each.case.name for each in found if not each.stopped]):
        _write_page(arguments.page, arguments.out, there)
    lines = _said(found, dome_radius_mm(cases[0]), arguments.out, useless)
    answer(arguments.json, {"folder": str(arguments.out), "tables": rows}, lines)
    return int(bool(useless) or any(each.stopped for each in found))


def _said(found: Sequence[Solved], radius_mm: float, folder: Path, useless: Sequence[str]) -> list[str]:
    """A table with a row a case, how to use what was solved, and what is of no use."""
    from casr.dome.solver.cases import AREA_AT_N

    wide = max(len(each.case.name) for each in found)
    lines = [f"{'table':<{wide}}" + "".join(f"{f'A({n:g} N)':>10}" for n in AREA_AT_N) + "  error"]
    for each in found:
        if each.stopped:
            lines.append(f"{each.case.name:<{wide}}  not solved: {each.stopped}.")
            continue
        areas = "".join(f"{area:>10.1f}" for area in each.said["area_mm2"].values())
        error = each.said["area_error"]
        lines.append(f"{each.case.name:<{wide}}{areas}  {100 * error:.1f} %")
    lines.append(
        "Areas in mm2 at a force; error: their largest change with a mesh and steps twice as coarse, plus that with\n"
        "half the penalty of contact.\n"
        f"Use them with dome_radius_mm = {radius_mm:.4g} under [sensor] in camera.toml: "
        f"casr score PRESSES --domes {folder}"
    )
    if useless:
        lines.append(
            f"Of no use, with an error above {USELESS:.0%}: {', '.join(useless)}.\n"
            "Check the units, mm and MPa, or halve mesh_mm."
        )
    return lines


def _write_page(path: Path, folder: Path, names: list[str]) -> None:
    from casr.atomic import write_text_atomic
    from casr.dome.library import worlds
    from casr.dome.solver.cases import said_of
    from casr.dome.tables import read_table
    from casr.page.dome_page import SolvedTable, dome_page

    files = [folder / f"{name}.npz" for name in names]
    solved = [SolvedTable(file.stem, read_table(file), said_of(file)) for file in files]
    write_text_atomic(path, dome_page(solved, worlds()))
