"""Stiffness of specimens: trials of plate indentations, the fits of these, and into a study file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.plate import PAPER_WINDOW, PlateTests, fit_plate, smoothed
from emg2vsa.errors import DataError
from emg2vsa.readers.tidy_table import read_tidy_table
from emg2vsa.rig.record.new_folder import EMULATED_FILE, PLAN_FILE
from emg2vsa.rig.record.press_counts import verdicts
from emg2vsa.rig.record.run_log import read_log
from emg2vsa.rig.rig_settings import axis_of
from emg2vsa.rig_file.edit import write_values
from emg2vsa.study_file.toml_file import read_toml

_LOADING = ("approach", "contact", "load")


@dataclass(frozen=True, eq=False)
class PlateTrial:
    """indentation_mm : (n,) way of the plate from its retracted position. force_n : (n,) along the push axis, as
    measured."""

    specimen: str
    trial: str
    indentation_mm: Floats
    force_n: Floats


def read_plate(folder: Path) -> Iterator[PlateTrial]:
    """The trials in a folder of ``emg2vsa rig run --plate`` that reached their force, less those that are rejected.

    DataError : no such folder, a run that was no plate indentation, or a log of another form.
    """
    do = "Name folders of emg2vsa rig run --plate, or tables."
    try:
        document = json.loads((folder / PLAN_FILE).read_text(encoding="utf-8"))
        plan, axis = document["plan"], axis_of(document["rig"])
        log = read_log(folder / "log.csv", ["repetition", "phase", "force_n"])
        is_plate, specimen = plan.get("plate") is True, str(plan["specimen"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise DataError(folder, wanted="the folder of a plate indentation", found=str(error), do=do) from error
    if not is_plate:
        found = f"a run of {plan.get('condition')} with the tactile sensor"
        raise DataError(folder, wanted="the folder of a plate indentation", found=found, do=do)
    said = verdicts(folder)
    turned = set(log.loc[log["phase"] == "retract", "repetition"])
    loading = log[log["phase"].isin(_LOADING)].dropna()
    for number in loading["repetition"].unique().tolist():
        rows = loading[loading["repetition"] == number]
        if number in turned and said.get(number, ("ok", ""))[0] != "rejected":
            depth_mm = np.array([axis.depth_at(angle_deg) for angle_deg in rows["shaft_deg"]])
            force_n = rows["force_n"].to_numpy(dtype=np.float64)
            yield PlateTrial(specimen, f"{folder.name}/{number}", depth_mm, force_n)


def read_trials(path: Path) -> Iterator[PlateTrial]:
    """The trials of a run's folder, or of a table with the columns indentation_mm and force_n.

    A table of several trials also has the columns specimen and trial; one without them is one trial of the specimen
    that the file is named after. DataError, RecordingError : neither.
    """
    if path.is_dir():
        yield from read_plate(path)
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
        yield PlateTrial(*key, x[mine], y[mine])


Row = dict[str, Any]


def plate_tests(files: Sequence[Path], window: int = PAPER_WINDOW) -> PlateTests:
    """Every trial. window : length of the moving average in samples. DataError for what is no log."""
    trials = [trial for path in files for trial in read_trials(path)]
    measured = [(trial.indentation_mm, trial.force_n) for trial in trials]
    return PlateTests(
        tuple(trial.specimen for trial in trials),
        tuple(trial.trial for trial in trials),
        fit_plate(measured, window),
        tuple(smoothed(*each, window) for each in measured),
        any((path / EMULATED_FILE).is_file() for path in files),
    )


def plate_rows(files: Sequence[Path], window: int) -> list[Row]:
    """One row a trial; as ``plate_tests``."""
    found = plate_tests(files, window)
    fit = found.fit
    return [
        {
            "specimen": specimen, "trial": trial, "stiffness_n_per_mm": float(fit.kappa[i]),
            "standard_error": float(fit.kappa_se[i]), "contact_mm": float(fit.contact[i]),
            "adjusted_r2": float(fit.adj_r2[i]), "points": int(fit.n[i]), "notes": list(fit.notes(i)),
        }
        for i, (specimen, trial) in enumerate(zip(found.specimens, found.trials, strict=True))
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
        found[name]["plate_adjusted_r2"] = float(np.floor(1e4 * min(row["adjusted_r2"] for row in mine)) / 1e4)
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
