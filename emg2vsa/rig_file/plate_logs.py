"""Logs of plates: runs of the rig with a flat plate, and tables of testing machines, to trials and their fits."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from emg2vsa.curves.plate import PAPER_WINDOW
from emg2vsa.curves.plate_tests import PlateTests, PlateTrial, plate_tests
from emg2vsa.curves.rubber import Cylinder, Ends
from emg2vsa.curves.specimen_kappa import Spread
from emg2vsa.errors import DataError
from emg2vsa.readers.press_table import read_press_table
from emg2vsa.rig.record.new_folder import EMULATED_FILE, PLAN_FILE
from emg2vsa.rig.record.press_counts import verdicts
from emg2vsa.rig.record.run_log import read_log
from emg2vsa.rig.rig_settings import axis_of
from emg2vsa.settings import WindowSettings

_LOADING = ("approach", "contact", "load")


def read_plate(folder: Path) -> Iterator[PlateTrial]:
    """The trials in a folder of ``emg2vsa rig run --plate`` that reached their force, less those that are rejected.

    DataError : no such folder, a run that was no plate indentation, or a log of another form.
    """
    do = "Name folders of emg2vsa rig run --plate, or tables."
    try:
        document = json.loads((folder / PLAN_FILE).read_text(encoding="utf-8"))
        plan, axis = document["plan"], axis_of(document["rig"])
        log = read_log(folder / "log.csv", ["time_s", "repetition", "phase", "force_n"])
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
            yield PlateTrial(
                specimen, f"{folder.name}/{number}", depth_mm, force_n, mounting=folder.name,
                time_s=rows["time_s"].to_numpy(dtype=np.float64),
            )  # fmt: skip


def read_trials(path: Path, depth: str = "", force: str = "") -> Iterator[PlateTrial]:
    """The trials of a run's folder, or of a table of depth and force as ``read_press_table`` reads it.

    A table of several trials also has the columns specimen and trial, perhaps casting and mounting; one without them is
    one trial of the specimen that the lines above it name, or else that the file is named after. DataError,
    RecordingError : neither.
    """
    if path.is_dir():
        yield from read_plate(path)
        return
    found = read_press_table(path, depth, force)
    table, x, y = found.table, found.depth_mm, found.force_n
    stated = {
        "specimen": found.specimen or path.stem, "trial": found.trial or "1", "casting": found.casting or "",
        "mounting": "",
    }  # fmt: skip
    columns = [table.texts(key) if key in table.names else [value] * x.size for key, value in stated.items()]
    of_rows = list(zip(*columns, strict=True))
    places: dict[tuple[str, ...], list[int]] = {}
    for place, row in enumerate(of_rows):
        places.setdefault(row, []).append(place)
    for key, mine in places.items():
        specimen, trial, casting, mounting = key
        yield PlateTrial(
            specimen, trial, x[mine], y[mine], casting, mounting, found.diameter_mm, found.height_mm,
            time_s=None if found.time_s is None else found.time_s[mine],
        )  # fmt: skip


@dataclass(frozen=True)
class Asked:
    """range_n : of force, newtons; whole : presses that do not reach its end are unusable. depth, force : columns of
    tables, where these say them not. window : length of the moving average before the paper's line, samples. spread :
    between presses, mountings and castings, where there is one of them. cylinders : of specimens whose files do not
    say their size. ends : of all cylinders; None: as these have them."""

    range_n: tuple[float, float] = WindowSettings().force_n
    whole: bool = False
    depth: str = ""
    force: str = ""
    window: int = PAPER_WINDOW
    spread: Spread = field(default_factory=Spread)
    cylinders: Mapping[str, Cylinder] = field(default_factory=dict)
    ends: Ends | None = None


def read_plates(files: Sequence[Path], asked: Asked) -> PlateTests:
    """Every trial and its fits. DataError for what is no log."""
    trials: list[PlateTrial] = []
    seen: dict[bytes, str] = {}
    for file in files:
        for trial in read_trials(file, asked.depth, asked.force):
            press, data = f"{file}, {trial.specimen} {trial.trial}", trial.depth_mm.tobytes() + trial.force_n.tobytes()
            if data in seen:
                raise DataError(
                    press, wanted="another press", found=f"that of {seen[data]}", do="Name each press once."
                )
            seen[data] = press
            trials.append(_sized(trial, asked))
    return plate_tests(
        trials, asked.range_n, whole=asked.whole, window=asked.window, spread=asked.spread,
        simulated=any((path / EMULATED_FILE).is_file() for path in files),
    )  # fmt: skip


def _sized(trial: PlateTrial, asked: Asked) -> PlateTrial:
    """With the size that its file does not say, and the ends that were asked for."""
    stated = asked.cylinders.get(trial.specimen)
    size = (stated.diameter_mm, stated.height_mm) if stated else (None, None)
    return replace(
        trial, diameter_mm=trial.diameter_mm or size[0], height_mm=trial.height_mm or size[1],
        ends=asked.ends or (stated.ends if stated else trial.ends),
    )  # fmt: skip
