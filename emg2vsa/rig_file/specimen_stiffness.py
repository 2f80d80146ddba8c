"""Stiffness of specimens from the fits of their plate indentations, and into a study file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from emg2vsa.curves.plate import fit_plate
from emg2vsa.errors import DataError
from emg2vsa.rig_file.edit import write_values
from emg2vsa.run_folders.plate import read_trials
from emg2vsa.study_file.toml_file import read_toml

Row = dict[str, Any]


def plate_rows(files: Sequence[Path], window: int) -> list[Row]:
    """One row a trial. window : length of the moving average in samples. DataError for what is no log."""
    trials = [trial for path in files for trial in read_trials(path)]
    fit = fit_plate([(trial.indentation_mm, trial.force_n) for trial in trials], window)
    return [
        {
            "specimen": trial.specimen, "trial": trial.trial, "stiffness_n_per_mm": float(fit.kappa[i]),
            "standard_error": float(fit.kappa_se[i]), "contact_mm": float(fit.contact[i]),
            "adjusted_r2": float(fit.adj_r2[i]), "points": int(fit.n[i]), "notes": list(fit.notes(i)),
        }
        for i, trial in enumerate(trials)
    ]  # fmt: skip


def lines(rows: Sequence[Row]) -> Iterator[str]:
    """A table of the trials, and the tables for a study file."""
    yield f"{'specimen':<12}{'trial':<8}{'kappa, N/mm':>12}{'+-':>9}{'contact, mm':>13}{'adj. R2':>9}{'points':>8}"
    for row in rows:
        yield (
            f"{row['specimen']:<12}{row['trial']:<8}{row['stiffness_n_per_mm']:>12.4f}{row['standard_error']:>9.4f}"
            f"{row['contact_mm']:>13.4f}{row['adjusted_r2']:>9.4f}{row['points']:>8}"
        )
        yield from (f"  note: {note}" for note in row["notes"])
    worst = min((row["adjusted_r2"] for row in rows), default=np.nan)
    yield f"worst adjusted R2 {worst:.4f} (the paper's: 0.882)"
    yield "For the study file:"
    for name, values in by_specimen(rows).items():
        yield f'[[specimens]]\nname = "{name}"'
        yield "\n".join(f"{key} = {value:g}" for key, value in values.items())


def by_specimen(rows: Sequence[Row]) -> dict[str, dict[str, float]]:
    """Specimen to the keys of its table in a study file: mean, standard error of the mean, worst adjusted R2."""
    found: dict[str, dict[str, float]] = {}
    for name in dict.fromkeys(row["specimen"] for row in rows):
        mine = [row for row in rows if row["specimen"] == name]
        values = [row["stiffness_n_per_mm"] for row in mine]
        found[name] = {"stiffness_n_per_mm": float(f"{np.mean(values):.4g}")}
        if len(values) > 1:
            found[name]["stiffness_se_n_per_mm"] = float(f"{np.std(values, ddof=1) / np.sqrt(len(values)):.2g}")
        found[name]["plate_adjusted_r2"] = float(f"{min(row['adjusted_r2'] for row in mine):.4g}")
    return found


def write_stiffness(path: Path, rows: Sequence[Row]) -> None:
    """Set the keys of every specimen in the study file. DataError where one has no stiffness or no table."""
    _, raw = read_toml(path, "a study file")
    names = [table.get("name") for table in raw.get("specimens", []) if isinstance(table, dict)]
    values = by_specimen(rows)
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
