"""``emg2vsa stiffness``: specimens' stiffness from plate indentation logs."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_command, add_json, print_json

if TYPE_CHECKING:
    from emg2vsa.arrays import Floats

Trial = tuple[str, str, "Floats", "Floats"]
"""Specimen, trial, indentation in mm, force in N."""


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "stiffness",
        run,
        "Compute the stiffness of specimens from plate indentation logs by a moving average and Hooke's law.",
        "A log is a folder written by emg2vsa rig run --plate, or a table with the columns indentation_mm and "
        "force_n (positive while pressing). A table of several trials also has the columns specimen and "
        "trial; a table without them is one trial of the specimen that its file is named after. Exit "
        "status 1: a trial has no stiffness. Example: emg2vsa stiffness runs-plate/*",
    )
    parser.add_argument(
        "files",
        type=Path,
        nargs="+",
        metavar="FILE",
        help="folder of a run, or a table with commas, semicolons, tabs or blanks between the columns",
    )
    parser.add_argument(
        "--write",
        type=Path,
        metavar="STUDY",
        help="write mean, standard error and worst adjusted R2 of each specimen into this study file",
    )
    parser.add_argument(
        "--window",
        type=int,
        default=5,
        metavar="N",
        help="length of the moving average in samples (default 5, as in the paper)",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.curves.plate import fit_plate

    trials = [trial for path in arguments.files for trial in _trials(path)]
    fit = fit_plate([(indentation, force) for _, _, indentation, force in trials], arguments.window)
    rows: list[dict[str, Any]] = [
        {
            "specimen": specimen, "trial": trial, "stiffness_n_per_mm": float(fit.kappa[i]),
            "standard_error": float(fit.kappa_se[i]), "contact_mm": float(fit.contact[i]),
            "adjusted_r2": float(fit.adj_r2[i]), "points": int(fit.n[i]), "notes": list(fit.notes(i)),
        }
        for i, (specimen, trial, _, _) in enumerate(trials)
    ]  # fmt: skip
    good = all(row["stiffness_n_per_mm"] > 0 for row in rows)
    if arguments.write:
        _write(arguments.write, rows)
    if arguments.json:
        print_json(rows)
    else:
        _print(rows)
    return 0 if good else 1


def _trials(path: Path) -> Iterator[Trial]:
    import numpy as np

    from emg2vsa.readers.tidy_table import read_tidy_table
    from emg2vsa.run_folders.plate import read_plate

    if path.is_dir():
        yield from ((t.specimen, t.trial, t.indentation_mm, t.force_n) for t in read_plate(path))
        return
    table = read_tidy_table(path)
    x, y = (
        np.array([np.nan if value is None else float(value) for value in table.numbers(name)])
        for name in ("indentation_mm", "force_n")
    )
    specimens = table.texts("specimen") if "specimen" in table.names else [path.stem] * x.size
    numbers = table.texts("trial") if "trial" in table.names else ["1"] * x.size
    for key in dict.fromkeys(zip(specimens, numbers, strict=True)):
        mine = np.array([pair == key for pair in zip(specimens, numbers, strict=True)])
        yield *key, x[mine], y[mine]


def _print(rows: list[dict[str, Any]]) -> None:
    import numpy as np

    print(f"{'specimen':<12}{'trial':<8}{'kappa, N/mm':>12}{'+-':>9}{'contact, mm':>13}{'adj. R2':>9}{'points':>8}")
    for row in rows:
        print(
            f"{row['specimen']:<12}{row['trial']:<8}{row['stiffness_n_per_mm']:>12.4f}{row['standard_error']:>9.4f}"
            f"{row['contact_mm']:>13.4f}{row['adjusted_r2']:>9.4f}{row['points']:>8}"
        )
        for note in row["notes"]:
            print(f"  note: {note}")
    worst = min((row["adjusted_r2"] for row in rows), default=np.nan)
    print(f"worst adjusted R2 {worst:.4f} (the paper's: 0.882)")
    print("For the study file:")
    for name, values in _by_specimen(rows).items():
        print(f'[[specimens]]\nname = "{name}"')
        print("\n".join(f"{key} = {value:g}" for key, value in values.items()))


def _by_specimen(rows: list[dict[str, Any]]) -> dict[str, dict[str, float]]:
    """Specimen to the keys of its table in a study file: mean, standard error of the mean, worst adjusted R2."""
    import numpy as np

    found: dict[str, dict[str, float]] = {}
    for name in dict.fromkeys(row["specimen"] for row in rows):
        mine = [row for row in rows if row["specimen"] == name]
        values = [row["stiffness_n_per_mm"] for row in mine]
        found[name] = {"stiffness_n_per_mm": float(f"{np.mean(values):.4g}")}
        if len(values) > 1:
            found[name]["stiffness_se_n_per_mm"] = float(f"{np.std(values, ddof=1) / np.sqrt(len(values)):.2g}")
        found[name]["plate_adjusted_r2"] = float(f"{min(row['adjusted_r2'] for row in mine):.4g}")
    return found


def _write(path: Path, rows: list[dict[str, Any]]) -> None:
    """Set the keys of every specimen in the study file. DataError where one has no stiffness or no table."""
    from emg2vsa.errors import DataError
    from emg2vsa.rig_file.edit import write_values
    from emg2vsa.study_file.toml_file import read_toml

    _, raw = read_toml(path, "a study file")
    names = [table.get("name") for table in raw.get("specimens", []) if isinstance(table, dict)]
    values = _by_specimen(rows)
    for name, keys in values.items():
        if name not in names:
            known = ", ".join(map(str, names)) or "none"
            do = "Add its [[specimens]] table, or correct the name of the log."
            raise DataError(f"{path}, specimens", wanted=f"a specimen {name}", found=known, do=do)
        if not keys["stiffness_n_per_mm"] > 0:
            do = "Leave its trials out, or measure it again."
            raise DataError(f"{name}", wanted="a stiffness above 0", found=f"{keys['stiffness_n_per_mm']:g}", do=do)
    write_values(
        path,
        {("specimens", names.index(name), key): value for name, keys in values.items() for key, value in keys.items()},
    )
