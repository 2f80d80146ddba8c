"""Trials of a plate indentation from the folders of the rig's own runs: indentation and force of each loading."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError
from emg2vsa.readers.tidy_table import read_tidy_table
from emg2vsa.rig.record.new_folder import PLAN_FILE
from emg2vsa.rig.record.press_counts import verdicts
from emg2vsa.rig.record.run_log import read_log
from emg2vsa.rig.rig_settings import axis_of

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
