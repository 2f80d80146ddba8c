"""Stiffness of specimens as it is told, and into a study file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from emg2vsa.curves.plate_tests import PlateTests, SpecimenPlates
from emg2vsa.curves.rubber import STRAIN, Cylinder, Ends
from emg2vsa.curves.specimen_kappa import LEVELS
from emg2vsa.errors import DataError
from emg2vsa.rig_file.edit import write_values
from emg2vsa.rig_file.plate_logs import Asked
from emg2vsa.settings import WindowSettings
from emg2vsa.study_file.problems import shown
from emg2vsa.study_file.tables import MOST_CHANGE
from emg2vsa.study_file.toml_file import read_toml

_ONE = {"presses": "press", "mountings": "mounting", "castings": "casting"}
Row = dict[str, Any]


def trial_rows(found: PlateTests) -> list[Row]:
    """One row a trial. The standard error is that within the press: what one press says of its own curve."""
    return [
        {
            "specimen": trial.specimen, "casting": trial.casting or None, "mounting": trial.mounting or None,
            "trial": trial.trial, "stiffness_n_per_mm": own.secant, "standard_error_within_press": own.secant_se,
            "force_from_n": own.from_n, "force_to_n": own.to_n,
            "tangent": [
                {"force_n": force, "kappa_n_per_mm": kappa, "low": kappa - half, "high": kappa + half}
                for force, kappa, half in zip(
                    own.force_n.tolist(), own.tangent.tolist(), own.half_width(own.tangent_se).tolist(),
                    strict=True,
                )
            ],
            "nonlinear": own.nonlinear, "change": own.change, "contact_mm": own.contact,
            "contact_low_mm": own.contact_low, "contact_high_mm": own.contact_high, "rests_before": own.rests,
            "rating": own.rating,
            "modulus_kpa": rubber.modulus_kpa if rubber else None,
            "laws": [asdict(law) for law in rubber.laws] if rubber else [],
            **(asdict(time) if time else dict.fromkeys(("speed_mm_per_s", "held_s", "relaxed"))),
            "line_n_per_mm": float(found.fit.kappa[i]), "adjusted_r2": float(found.fit.adj_r2[i]),
            "points": int(found.fit.n[i]),
            "diameter_mm": trial.diameter_mm, "height_mm": trial.height_mm,
            "notes": list(own.notes()),
        }
        for i, (trial, own, rubber, time) in enumerate(
            zip(found.trials, found.ranges, found.rubbers, found.times, strict=True)
        )
    ]  # fmt: skip


def specimen_rows(found: PlateTests) -> list[Row]:
    """One row a specimen whose trials can say: kappa and modulus with intervals over presses, mountings, castings."""
    return [_specimen_row(of) for name in found.specimens if (of := found.specimen(name))]


def _specimen_row(of: SpecimenPlates) -> Row:
    counts = dict(zip(LEVELS, of.kappa.count, strict=True))
    size = of.cylinder
    return {
        "specimen": of.name, "stiffness_n_per_mm": of.kappa.mean, "standard_error": of.error,
        "low": of.kappa.mean - of.half, "high": of.kappa.mean + of.half, "holds_for_further": of.level, **counts,
        "intervals": {
            level: {"low": of.kappa.mean - half, "high": of.kappa.mean + half}
            for level in LEVELS[: LEVELS.index(of.level) + 1] for half in [of.kappa.half(level)]
        },
        "force_from_n": of.range_n[0], "force_to_n": of.range_n[1], "change": of.change,
        "nonlinear": 2 * of.nonlinear > of.trials, "nonlinear_trials": of.nonlinear,
        "modulus": {
            "kpa": of.modulus.mean, "low": of.modulus.mean - (half := of.modulus.half(of.level)),
            "high": of.modulus.mean + half, "to_strain": STRAIN, "ends": size.ends,
        } if of.modulus and size else None,
        "law": of.laws[0].law if of.laws else None,
        "laws": [asdict(law) for law in of.laws],
        "notes": list(_remarks(of)),
    }  # fmt: skip


def _remarks(of: SpecimenPlates) -> Iterator[str]:
    """What entered the error without having been measured, and on what the modulus depends."""
    for level, count, step in zip(LEVELS, of.kappa.count, of.kappa.steps.tolist(), strict=True):
        if count == 1 and LEVELS.index(level) <= LEVELS.index(of.level) and step > 0:
            option = "" if level == "presses" else f", --{level} says otherwise"
            yield f"one {_ONE[level]}: a stated SD of {100 * step / of.kappa.mean:.1f} % between {level} enters{option}"
    if of.times:
        speeds = sorted(time.speed_mm_per_s for time in of.times)
        relaxed = [time.relaxed for time in of.times if time.held_s]
        lost = f", and relaxes by {100 * np.mean(relaxed):.2g} % while held" if relaxed else ""
        yield f"pressed at {speeds[0]:.3g}{f' to {speeds[-1]:.3g}' if speeds[-1] > 1.1 * speeds[0] else ''} mm/s{lost}"
    if of.modulus and of.cylinder and of.cylinder.ends == "frictionless":
        bonded = of.modulus.mean / of.cylinder.bonding
        yield f"the modulus takes ends that slide; if they cannot (--ends bonded) it is {bonded:.3g} kPa"


def lines(found: PlateTests) -> Iterator[str]:
    rows = trial_rows(found)
    wide = max(9, *(len(row["specimen"]) for row in rows)) + 1 if rows else 10
    long = max(5, *(len(row["trial"]) for row in rows)) + 2 if rows else 7
    yield (
        f"{'specimen':<{wide}}{'trial':<{long}}{'kappa N/mm':>12}{'over N':>12}{'first':>8}{'last':>8}"
        f"{'contact mm (95 %)':>24}{'adj. R2':>9}  rating"
    )
    for row in rows:
        ends = [row["tangent"][i]["kappa_n_per_mm"] if row["tangent"] else np.nan for i in (0, -1)]
        over = f"{row['force_from_n']:.3g} to {row['force_to_n']:.3g}"
        contact = f"{row['contact_mm']:.3f} ({row['contact_low_mm']:.3f}, {row['contact_high_mm']:.3f})"
        yield (
            f"{row['specimen']:<{wide}}{row['trial']:<{long}}{row['stiffness_n_per_mm']:>12.4f}"
            f"{over:>12}{ends[0]:>8.3g}{ends[1]:>8.3g}{contact:>24}{row['adjusted_r2']:>9.4f}  {row['rating']}"
        )
        yield from (f"  note: {note}" for note in row["notes"])
    yield "kappa is the secant over these forces, first and last the tangents at their ends; adj. R2 is that of a line."
    at_once = sum(row["rating"] != "unusable" and not row["rests_before"] for row in rows)
    if at_once:
        yield f"{at_once} of {len(rows)} logs begin in contact: that the first force is zero is taken from the file."
    worst = min((row["adjusted_r2"] for row in rows), default=np.nan)
    yield f"worst adjusted R2 {worst:.4f} (the paper's: 0.882)"
    for row in specimen_rows(found):
        counts = ", ".join(f"{row[level]} {level if row[level] > 1 else _ONE[level]}" for level in LEVELS)
        yield (
            f"{row['specimen']}: kappa {row['stiffness_n_per_mm']:.4g} N/mm, 95 % interval {row['low']:.4g} to "
            f"{row['high']:.4g}, which holds for further {row['holds_for_further']} ({counts})"
        )
        if modulus := row["modulus"]:
            best = row["laws"][0] if row["laws"] else None
            yield (
                f"  modulus {modulus['kpa']:.4g} kPa, 95 % interval {modulus['low']:.4g} to {modulus['high']:.4g}, by "
                f"a line to {100 * STRAIN:g} % of strain, ends {modulus['ends']}"
                + (f"; of the laws {best['law']} fits best, {best['left_n']:.2g} N are left" if best else "")
            )
        yield from (f"  note: {note}" for note in row["notes"])
    yield "For the study file:"
    for name, values in by_specimen(found).items():
        yield f'[[specimens]]\nname = "{name}"'
        yield "\n".join(f"{key} = {shown(value)}" for key, value in values.items())


def by_specimen(found: PlateTests) -> dict[str, dict[str, Any]]:
    """Specimen to the keys of its table in a study file."""
    keys: dict[str, dict[str, Any]] = {}
    for of in filter(None, map(found.specimen, found.specimens)):
        keys[of.name] = {
            "stiffness_n_per_mm": float(f"{of.kappa.mean:.4g}"),
            "stiffness_se_n_per_mm": float(f"{of.error:.2g}"),
            "stiffness_range_n": [of.range_n[0], float(f"{of.range_n[1]:.3g}")],
            "stiffness_change": float(f"{of.change if 2 * of.nonlinear > of.trials else of.of_rubber:.2g}"),
        }
        if np.isfinite(of.adj_r2):
            keys[of.name]["plate_adjusted_r2"] = float(np.floor(1e4 * of.adj_r2) / 1e4)
    return keys


def study_says(path: Path) -> Asked:
    """The forces of the study's presses, [window] force_n, and the sizes of its specimens. StudyError, DataError : no
    study file, or no such forces."""
    _, raw = read_toml(path, "a study file")
    given = raw.get("window", {}).get("force_n", WindowSettings().force_n)
    try:
        lower, upper = (float(each) for each in given)
    except (TypeError, ValueError) as error:
        do = "Correct them, or say --from and --to."
        raise DataError(f"{path}, window.force_n", wanted="two forces", found=shown(given), do=do) from error
    return Asked((lower, upper), cylinders=dict(_sizes(path, raw.get("specimens"))))


def _sizes(path: Path, tables: object) -> Iterator[tuple[str, Cylinder]]:
    """Sizes of [[specimens]] that have both. DataError : what is no size."""
    for place, table in enumerate(tables if isinstance(tables, list) else ()):
        if not isinstance(table, dict) or not {"diameter_mm", "height_mm"} <= table.keys():
            continue
        for key in ("diameter_mm", "height_mm"):
            if not isinstance(table[key], int | float) or not 0 < table[key] < np.inf:
                where, do = f"{path}, specimens[{place}].{key}", "Correct it."
                raise DataError(where, wanted="a number > 0", found=shown(table[key]), do=do)
        ends: Ends = "bonded" if table.get("ends") == "bonded" else "frictionless"
        yield str(table.get("name")), Cylinder(float(table["diameter_mm"]), float(table["height_mm"]), ends)


def write_stiffness(path: Path, found: PlateTests) -> None:
    """Set the keys of every specimen in the study file. DataError where one has no stiffness or no table."""
    _, raw = read_toml(path, "a study file")
    names = [table.get("name") for table in raw.get("specimens", []) if isinstance(table, dict)]
    values = by_specimen(found)
    for name in found.specimens:
        if name not in names:
            known = ", ".join(map(str, names)) or "none"
            do = "Add its [[specimens]] table, or correct the name of the log."
            raise DataError(f"{path}, specimens", wanted=f"a specimen {name}", found=known, do=do)
        if name not in values:
            reasons = [note for row in trial_rows(found) if row["specimen"] == name for note in row["notes"]]
            do = "Measure it again."
            raise DataError(name, wanted="a press that gives a stiffness", found=reasons[0], do=do)
        if not -1 < (change := values[name]["stiffness_change"]) <= MOST_CHANGE:
            found_change, do = f"one that changes by {100 * change:.0f} %", "Choose a smaller range of force: --to."
            raise DataError(f"{name}, stiffness", wanted="one number for the range of force", found=found_change, do=do)
    write_values(
        path,
        {("specimens", names.index(name), key): value for name, keys in values.items() for key, value in keys.items()},
    )
