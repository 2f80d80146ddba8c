"""``casr kappa``: stiffness of specimens from presses of one sensor, some of them of known specimens."""

from __future__ import annotations

import argparse
import csv
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.cli import arguments as shared
from casr.command_line import JSON, Commands, add_command, answer
from casr.errors import CasrError, SettingError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from casr.camera import Camera
    from casr.dome.library import Library
    from casr.kappa.estimate import SensorKappa
    from casr.kappa.posterior import Kappa
    from casr.kappa.presses import KappaPress

COLUMNS = ("press", "specimen", "stiffness_n_per_mm", "stiffness_sd_percent", "mounting")
SPECIMENS = f"""
--specimens FILE  CSV: {", ".join(COLUMNS)}; a line for each press, named as casr score names it; stiffness is empty
    where it is not known, rigid of a plate; the last two columns may be left out (default: specimens.csv in PATH)
"""
PAGE = "--page FILE.html  write a page: how much of the pins' motion is left over at each kappa, and what each cue says"
SUMMARY = "Stiffness kappa of specimens, N/mm, from presses of one sensor on known and unknown specimens."
EPILOG = """
All presses are held against one dome, between those of the tables; the known specimens tell how this sensor differs
from it. Two known specimens or more, softer and stiffer than the unknown one, are best. The line of a known specimen is
what the others say of it. bound: the standard error that noise of the pins and errors of the known stiffnesses alone
would leave. Needs camera.toml. Exit status 1: a press could not be used.
Example: casr kappa presses --specimens specimens.csv
"""


STIFFNESSES, SDS_PERCENT = (0.01, 1e4), (0.0, 50.0)
"What may stand in the table."


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "kappa", run, SUMMARY, EPILOG)
    shared.add_frames(parser, "a folder of presses")
    shared.add_shared(shared.add_method(parser), shared.LAG)
    shared.add_shared(parser.add_argument_group("output"), SPECIMENS, PAGE, JSON)


def run(arguments: argparse.Namespace) -> int:
    from casr.atomic import write_text_atomic
    from casr.kappa.estimate import estimate_kappa
    from casr.page.kappa_page import kappa_page
    from casr.press_files import PressFiles

    PressFiles(page=arguments.page).check(arguments.path, [])
    used, unused, camera, library = asked(arguments)
    found = estimate_kappa(used, camera, library=library)
    if arguments.page:
        write_text_atomic(arguments.page, kappa_page(arguments.path.resolve().name, found, unused))
    answer(arguments.json, {**_plain(found), "not_used": unused}, _lines(found, unused))
    return int(bool(unused))


def asked(arguments: argparse.Namespace) -> tuple[list[KappaPress], dict[str, str], Camera, Library]:
    """Presses of a folder with what a table says of their specimens, why others are not used, their camera, and the
    tables of domes. SettingError : no such table or press, no camera, or several."""
    shared.check_forces(arguments)
    from casr.contact_area.library_front import height_in_tables
    from casr.dome.library import tables
    from casr.frame_files import find_presses
    from casr.kappa.presses import KappaPress
    from casr.press_files import named_presses
    from casr.scoring import score

    root = arguments.path
    if not root.is_dir():
        raise SettingError(
            str(root), wanted="a folder of presses", found="a file" if root.exists() else "nothing",
            do="Name the folder that holds the folders of presses.",
        )  # fmt: skip
    presses, table = named_presses(root, find_presses(root)), arguments.specimens or root / "specimens.csv"
    stated = _specimens(table, presses)
    settings, open_press = shared.score_settings(arguments), partial(shared.open_sequence, arguments)
    used, unused, cameras = [], {}, {}
    for name, of_specimen in stated.items():
        try:
            sequence = open_press(presses[name])
            scored = score(sequence, settings)
            used.append(KappaPress.of_score(scored, name=name, **of_specimen))
            cameras[name] = sequence.camera
        except CasrError as error:
            unused[name] = str(error)
    if not used:
        name, why = next(iter(unused.items()))
        raise SettingError(
            str(root), wanted="a press that can be used", found=f"none of {len(unused)}; {name}: {why}",
            do="See to this first.",
        )  # fmt: skip
    camera = _one_camera(cameras)
    height_mm = height_in_tables(camera, arguments.domes, arguments.specimen_height_mm)
    return used, unused, camera, tables(arguments.domes, height_mm)


def _one_camera(cameras: Mapping[str, Camera | None]) -> Camera:
    """The camera of all presses, by name. SettingError : a press has none, or another one."""
    first, camera = next(iter(cameras.items()))
    other = next((name for name, each in cameras.items() if each is None or not each.sees_like(camera)), "")
    if camera is None or other:
        raise SettingError(
            f"{other or first}, camera.toml", wanted=f"the camera of all presses, as of {first}",
            found="none" if cameras[other or first] is None else "another one",
            do="Put one camera.toml into the folder of the presses (casr calibrate makes it).",
        )  # fmt: skip
    return camera


def _specimens(path: Path, presses: dict[str, Path]) -> dict[str, dict[str, Any]]:
    """What is stated of each press. SettingError : no such file, column or press, or a number that is none."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = csv.DictReader(file)
            heads = rows.fieldnames or []
            lines = list(rows)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SettingError(
            str(path),
            wanted=f"a table of {', '.join(COLUMNS[:3])}",
            found=getattr(error, "strerror", None) or str(error),
            do="Give --specimens FILE.",
        ) from error
    if missing := [name for name in COLUMNS[:3] if name not in heads]:
        raise SettingError(
            str(path), wanted=f"columns {', '.join(COLUMNS[:3])}", found=f"no {', '.join(missing)}", do="Add it."
        )
    stated: dict[str, dict[str, Any]] = {}
    for number, row in enumerate(lines, start=2):
        name, where = (row["press"] or "").strip(), f"{path}, line {number}"
        if name not in presses or name in stated:
            raise SettingError(
                f"{where}, press", wanted=f"one of {', '.join(presses)}, each once", found=repr(name),
                do="Name presses by their folders, with dashes between folder and folder.",
            )  # fmt: skip
        if None in row:
            raise SettingError(
                where, wanted=f"{len(heads)} columns, as the first line names", found="more of them",
                do="Write decimal points, not commas.",
            )  # fmt: skip
        known = _number(row["stiffness_n_per_mm"], f"{where}, stiffness_n_per_mm", STIFFNESSES, rigid=True)
        error_percent = _number(row.get("stiffness_sd_percent"), f"{where}, stiffness_sd_percent", SDS_PERCENT)
        stated[name] = {
            "specimen": (row["specimen"] or "").strip() or name, "stiffness_n_per_mm": known,
            "stiffness_sd": (error_percent or 0.0) / 100, "mounting": (row.get("mounting") or "").strip(),
        }  # fmt: skip
    if not stated:
        raise SettingError(str(path), wanted="a line for each press", found="no press", do="Add presses.")
    return stated


def _number(text: str | None, where: str, within: tuple[float, float], *, rigid: bool = False) -> float | None:
    if text is None or not text.strip():
        return None
    if rigid and text.strip() == "rigid":
        return float("inf")
    try:
        number = float(text)
    except ValueError:
        number = float("nan")
    if not within[0] <= number <= within[1]:
        wanted = f"a number from {within[0]:g} to {within[1]:g}{', rigid,' if rigid else ''} or nothing"
        raise SettingError(where, wanted=wanted, found=repr(text), do="Correct the table.")
    return number


def _lines(found: SensorKappa, unused: dict[str, str]) -> list[str]:
    width = max([8, *map(len, found.kappas)])
    lines = [f"{'specimen':<{width}}  kappa N/mm  95 % interval        known  determined  bound %  efficiency  by"]
    for name, each in found.kappas.items():
        cues = ", ".join(f"{cue} {value:.3g} ± {100 * sd:.0f} %" for cue, (value, sd) in each.by_cue.items())
        known = "-" if each.known is None else f"{each.known:.3g}"
        lines.append(
            f"{name:<{width}}  {each.value:>10.3g}  {f'[{each.low:.3g}, {each.high:.3g}]':<18}  {known:>6}  "
            f"{'yes' if each.determined else 'no':>10}  {100 * each.bound_sd:>7.1f}  {_efficiency(each):>10}  {cues}"
        )
    if not found.kappas:
        lines.append("note: nothing is asked: each specimen is known, and of two no other tells one")
    lines += [f"not used: {name}: {reason}" for name, reason in unused.items()]
    return lines + [f"note: {each}" for each in found.notes]


def _efficiency(kappa: Kappa) -> str:
    return "-" if kappa.efficiency != kappa.efficiency else f"{kappa.efficiency:.2f}"


def _plain(found: SensorKappa) -> dict[str, Any]:
    specimens = {
        name: {
            "kappa_n_per_mm": each.value, "low": each.low, "high": each.high, "known_n_per_mm": each.known,
            "expected_half_width": each.expected, "determined": each.determined, "bound_sd": each.bound_sd,
            "contradicted": each.contradicted,
            "efficiency": None if each.efficiency != each.efficiency else each.efficiency,
            "stick": each.stick, "presses": each.n_presses,
            "by_cue": {cue: {"kappa_n_per_mm": value, "sd": sd} for cue, (value, sd) in each.by_cue.items()},
        }
        for name, each in found.kappas.items()
    }  # fmt: skip
    return {
        "specimens": specimens, "misfit": found.misfit, "noise_px": found.noise_px, "notes": list(found.notes),
    }  # fmt: skip
