"""Stiffness of specimens: trials of plate indentations, the fits of these, and into a study file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.plate import PAPER_WINDOW, PlateTests, plate_tests
from emg2vsa.errors import DataError
from emg2vsa.readers.press_table import read_press_table
from emg2vsa.rig.record.new_folder import EMULATED_FILE, PLAN_FILE
from emg2vsa.rig.record.press_counts import verdicts
from emg2vsa.rig.record.run_log import read_log
from emg2vsa.rig.rig_settings import axis_of
from emg2vsa.rig_file.edit import write_values
from emg2vsa.settings import WindowSettings
from emg2vsa.study_file.problems import shown
from emg2vsa.study_file.toml_file import read_toml

_LOADING = ("approach", "contact", "load")


@dataclass(frozen=True, eq=False)
class PlateTrial:
    """indentation_mm : (n,) way of the plate from its retracted position. force_n : (n,) along the push axis, as
    measured. diameter_mm, height_mm : of a cylinder, where the file states them."""

    specimen: str
    trial: str
    indentation_mm: Floats
    force_n: Floats
    diameter_mm: float | None = None
    height_mm: float | None = None


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


def read_trials(path: Path, depth: str = "", force: str = "") -> Iterator[PlateTrial]:
    """The trials of a run's folder, or of a table of depth and force as ``read_press_table`` reads it.

    A table of several trials also has the columns specimen and trial; one without them is one trial of the specimen
    that the lines above it name, or else that the file is named after. DataError, RecordingError : neither.
    """
    if path.is_dir():
        yield from read_plate(path)
        return
    found = read_press_table(path, depth, force)
    table, x, y = found.table, found.depth_mm, found.force_n
    specimens = table.texts("specimen") if "specimen" in table.names else [found.specimen or path.stem] * x.size
    numbers = table.texts("trial") if "trial" in table.names else [found.trial or "1"] * x.size
    for key in dict.fromkeys(zip(specimens, numbers, strict=True)):
        mine = np.array([pair == key for pair in zip(specimens, numbers, strict=True)])
        yield PlateTrial(*key, x[mine], y[mine], found.diameter_mm, found.height_mm)


Row = dict[str, Any]


@dataclass(frozen=True)
class Asked:
    """range_n : of force, newtons; whole : presses that do not reach its end are unusable. depth, force : columns of
    tables, where these say them not. window : length of the moving average before the paper's line, samples."""

    range_n: tuple[float, float] = WindowSettings().force_n
    whole: bool = False
    depth: str = ""
    force: str = ""
    window: int = PAPER_WINDOW


def read_plates(files: Sequence[Path], asked: Asked) -> tuple[list[PlateTrial], PlateTests]:
    """Every trial and its fits. DataError for what is no log."""
    trials = [trial for path in files for trial in read_trials(path, asked.depth, asked.force)]
    return trials, plate_tests(
        [(trial.specimen, trial.trial) for trial in trials],
        [(trial.indentation_mm, trial.force_n) for trial in trials],
        asked.range_n,
        [trial.height_mm for trial in trials],
        whole=asked.whole,
        window=asked.window,
        simulated=any((path / EMULATED_FILE).is_file() for path in files),
    )


def plate_rows(files: Sequence[Path], asked: Asked) -> list[Row]:
    """One row a trial; as ``read_plates``."""
    trials, found = read_plates(files, asked)
    return [
        {
            "specimen": trial.specimen, "trial": trial.trial, "stiffness_n_per_mm": own.secant,
            "standard_error": own.secant_se, "force_from_n": own.from_n, "force_to_n": own.to_n,
            "tangent": [
                {"force_n": force, "kappa_n_per_mm": kappa, "low": kappa - half, "high": kappa + half}
                for force, kappa, half in zip(
                    own.force_n.tolist(), own.tangent.tolist(), own.half_width(own.tangent_se).tolist(),
                    strict=True,
                )
            ],
            "nonlinear": own.nonlinear, "change": own.change, "contact_mm": own.contact,
            "contact_low_mm": own.contact_low, "contact_high_mm": own.contact_high, "rating": own.rating,
            "line_n_per_mm": float(found.fit.kappa[i]), "adjusted_r2": float(found.fit.adj_r2[i]),
            "points": int(found.fit.n[i]), "diameter_mm": trial.diameter_mm, "height_mm": trial.height_mm,
            "notes": list(own.notes()),
        }
        for i, (trial, own) in enumerate(zip(trials, found.ranges, strict=True))
    ]  # fmt: skip


def lines(rows: Sequence[Row], range_n: tuple[float, float]) -> Iterator[str]:
    """A table of the trials, and the tables for a study file whose presses have the forces ``range_n``."""
    wide = max(8, *(len(row["specimen"]) for row in rows)) + 2
    yield (
        f"{'specimen':<{wide}}{'trial':<8}{'kappa, N/mm':>12}{'+-':>9}{'over, N':>12}{'first':>8}{'last':>8}"
        f"{'contact, mm':>24}{'adj. R2':>9}  rating"
    )
    for row in rows:
        ends = [row["tangent"][i]["kappa_n_per_mm"] if row["tangent"] else np.nan for i in (0, -1)]
        over = f"{row['force_from_n']:.3g} to {row['force_to_n']:.3g}"
        contact = f"{row['contact_mm']:.3f} ({row['contact_low_mm']:.3f}, {row['contact_high_mm']:.3f})"
        yield (
            f"{row['specimen']:<{wide}}{row['trial']:<8}{row['stiffness_n_per_mm']:>12.4f}{row['standard_error']:>9.4f}"
            f"{over:>12}{ends[0]:>8.3g}{ends[1]:>8.3g}{contact:>24}{row['adjusted_r2']:>9.4f}  {row['rating']}"
        )
        yield from (f"  note: {note}" for note in row["notes"])
    yield "kappa is the secant over these forces, first and last the tangents at their ends; adj. R2 is that of a line."
    worst = min((row["adjusted_r2"] for row in rows), default=np.nan)
    yield f"worst adjusted R2 {worst:.4f} (the paper's: 0.882)"
    yield "For the study file:"
    for name, values in by_specimen(rows, range_n).items():
        yield f'[[specimens]]\nname = "{name}"'
        yield "\n".join(f"{key} = {shown(value)}" for key, value in values.items())


def by_specimen(rows: Sequence[Row], range_n: tuple[float, float]) -> dict[str, dict[str, Any]]:
    """Specimen to the keys of its table in a study file: mean over the trials that are not unusable, its standard
    error, the range of force that all of them reach, and the worst adjusted R2. The error of a
    nonlinear specimen holds by how much kappa changes from there to the middle of ``range_n``."""
    found: dict[str, dict[str, Any]] = {}
    for name in dict.fromkeys(row["specimen"] for row in rows):
        mine = [row for row in rows if row["specimen"] == name and row["rating"] != "unusable"]
        if not mine:
            continue
        values, n = [row["stiffness_n_per_mm"] for row in mine], len(mine)
        error = max(
            float(np.sqrt(np.mean([row["standard_error"] ** 2 for row in mine]))),
            float(np.std(values, ddof=1)) if n > 1 else 0.0,
        ) / np.sqrt(n)
        from_n, to_n = mine[0]["force_from_n"], min(row["force_to_n"] for row in mine)
        if 2 * sum(row["nonlinear"] for row in mine) > n:
            moved = (sum(range_n) - from_n - to_n) / 2 / (to_n - from_n)
            error = float(np.hypot(error, np.mean([row["change"] for row in mine]) * moved * np.mean(values)))
        found[name] = {
            "stiffness_n_per_mm": float(f"{np.mean(values):.4g}"),
            "stiffness_se_n_per_mm": float(f"{error:.2g}"),
            "stiffness_range_n": [
                from_n, float(f"{to_n:.3g}"),
            ],
        }  # fmt: skip
        worst = min(row["adjusted_r2"] for row in mine)
        if np.isfinite(worst):
            found[name]["plate_adjusted_r2"] = float(np.floor(1e4 * worst) / 1e4)
    return found


def range_in(path: Path) -> tuple[float, float]:
    """The forces of the study's presses, [window] force_n. StudyError, DataError : no study file, or no such forces."""
    _, raw = read_toml(path, "a study file")
    given = raw.get("window", {}).get("force_n", WindowSettings().force_n)
    try:
        lower, upper = (float(each) for each in given)
    except (TypeError, ValueError) as error:
        do = "Correct them, or say --from and --to."
        raise DataError(f"{path}, window.force_n", wanted="two forces", found=shown(given), do=do) from error
    return lower, upper


def write_stiffness(path: Path, rows: Sequence[Row], range_n: tuple[float, float]) -> None:
    """Set the keys of every specimen in the study file. DataError where one has no stiffness or no table."""
    _, raw = read_toml(path, "a study file")
    names = [table.get("name") for table in raw.get("specimens", []) if isinstance(table, dict)]
    values = by_specimen(rows, range_n)
    for name in dict.fromkeys(row["specimen"] for row in rows):
        if name not in names:
            known = ", ".join(map(str, names)) or "none"
            do = "Add its [[specimens]] table, or correct the name of the log."
            raise DataError(f"{path}, specimens", wanted=f"a specimen {name}", found=known, do=do)
        if name not in values:
            reasons = [note for row in rows if row["specimen"] == name for note in row["notes"]]
            do = "Measure it again."
            raise DataError(name, wanted="a press that gives a stiffness", found=reasons[0], do=do)
    write_values(
        path,
        {("specimens", names.index(name), key): value for name, keys in values.items() for key, value in keys.items()},
    )
