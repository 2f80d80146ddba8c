"""``casr sensor``: a sensor's pole, pin length, depth and dome from presses of known specimens."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from casr.cli import arguments as shared
from casr.cli.kappa import SPECIMENS, asked
from casr.command_line import JSON, Commands, add_command, answer
from casr.errors import SettingError

if TYPE_CHECKING:
    from casr.kappa.sensor import IdentifiedSensor, Quantity

OUT = """
-o --out FILE = sensor.toml  camera file to write, which casr dome reads, too (default %(default)s)
--overwrite  replace a file that is there
"""
SUMMARY = "Identify a sensor from presses of known specimens: pole, pin length, depth, moduli of its dome."
EPILOG = """
Standard errors hold what the tables of domes lack of this sensor. Three known specimens from soft to stiff are good; a
rigid plate (stiffness: rigid) leaves more unknown, and the command says what. camera.toml says what is thought of the
sensor: depth to 3 %, pin length to 0.4 mm, pole to 2 mm, or as it states. Use the file as camera.toml of the presses,
or with --camera. Exit status 1: a press could not be used, presses contradict what is stated of their specimens, or the
tables do not fit this sensor. Example: casr sensor presses -o sensor.toml
"""


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "sensor", run, SUMMARY, EPILOG)
    shared.add_frames(parser, "a folder of presses")
    shared.add_shared(shared.add_method(parser), shared.LAG)
    shared.add_shared(parser.add_argument_group("output"), SPECIMENS, OUT, JSON)


def run(arguments: argparse.Namespace) -> int:
    """Identify the sensor. Returns 1 where presses are not used, or do not fit one sensor.

    SettingError : the file of ``--out`` is there and may not be replaced.
    """
    from casr.atomic import write_text_atomic
    from casr.dome.library import tables_of
    from casr.kappa.posterior import CONTRADICTED
    from casr.kappa.sensor import identify_sensor

    out: Path = arguments.out
    if out.exists() and not (arguments.overwrite and out.is_file()):
        do = "Choose another name, or replace a file with --overwrite."
        raise SettingError(f"--out {out}", wanted="a new file", found="one that is there", do=do)
    used, unused, camera, library = asked(arguments)
    own = {
        table.dome: (table.solved["skin_mm"], table.solved["skin"]["modulus_mpa"], table.solved["gel"]["modulus_mpa"])
        for table in (tables_of(arguments.domes) if arguments.domes else ())
        if table.solved
    }
    found = identify_sensor(used, camera, library=library, own_domes=own)
    write_text_atomic(out, found.to_toml())
    plain = asdict(found) | {"file": str(out), "not_used": unused}
    answer(arguments.json, plain, _lines(found, out, unused))
    return int(bool(unused) or not found.fits or found.contradicted > CONTRADICTED)


def _lines(found: IdentifiedSensor, out: Path, unused: dict[str, str]) -> list[str]:
    def row(name: str, each: Quantity) -> str:
        stated, told = "-" if each.stated is None else f"{each.stated:.4g}", "yes" if each.told else "no"
        return f"{name:<17}{stated:>8}{each.value:>9.4g}{each.sd:>16.2g}{each.prior_sd:>8.2g}  {told}"

    return [
        "quantity           stated    found  standard error  before  told by the presses",
        *(row(name, each) for name, each in found.quantities.items()),
        f"skin of {found.skin_mm:.3g} mm, as in the tables of dome {found.dome}, which fit best",
        f"left over of the pins' motion: {found.misfit_before:.1%} before, {found.misfit:.1%} now",
        *(f"not used: {name}: {reason}" for name, reason in unused.items()),
        *(f"note: {each}" for each in found.notes),
        f"written: {out}",
    ]
