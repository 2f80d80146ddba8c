"""The numbers of a package once more: its study file, on the data, in a place of its own."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from emg2vsa.deposit.crate import SOURCES
from emg2vsa.deposit.open_deposit import Deposit, sha256_of
from emg2vsa.errors import DataError
from emg2vsa.pipeline.places import OWNER_FILE, placed_in
from emg2vsa.pipeline.run_study import Progress, run_study
from emg2vsa.pipeline.stage_order import stages_for
from emg2vsa.study_file import load_study


@dataclass(frozen=True)
class Data:
    """The data of a package. folder : where the study file would lie. missing, changed : of its files."""

    folder: Path
    missing: frozenset[str]
    changed: tuple[str, ...]


def data_of(deposit: Deposit, given: Path | None) -> Data:
    """The data in ``given``; without it inside the package, where its report says, or beside it."""
    if given is not None and not given.is_dir():
        found = "a file" if given.exists() else "no such folder"
        do = "Name the folder from which the study file names its data."
        raise DataError(f"--data {given}", wanted="a folder", found=found, do=do)
    places = [given] if given is not None else [*dict.fromkeys(_places(deposit))]
    folder = max(places, key=lambda place: sum((place / name).is_file() for name in deposit.inputs))
    missing = frozenset(name for name in deposit.inputs if not (folder / name).is_file())
    there = [name for name in deposit.inputs if name not in missing]
    return Data(folder, missing, tuple(name for name in there if sha256_of(folder / name) != deposit.inputs[name]))


def _places(deposit: Deposit) -> Iterator[Path]:
    yield deposit.folder
    around = [Path(os.path.abspath(deposit.source)), *Path(os.path.abspath(deposit.source)).parents[:3]]
    for folder in around:
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
            owner = json.loads((folder / OWNER_FILE).read_text(encoding="utf-8"))
            yield Path(os.path.normpath(folder / owner["file"])).parent
    yield from around


def without_data(keys: Iterable[str], provenance: Mapping[str, object], missing: frozenset[str]) -> set[str]:
    """The numbers that a missing file leads to. DataError : the package does not say which steps made its numbers."""
    if not missing:
        return set()
    try:
        return _led_to(keys, provenance, missing)
    except (KeyError, TypeError, AttributeError) as error:
        where, found = "provenance.json", f"no steps of {error}"
        raise DataError(where, wanted="the steps behind every number", found=found, do="Get it again.") from None


def _led_to(keys: Iterable[str], provenance: Mapping[str, object], missing: frozenset[str]) -> set[str]:
    numbers, steps = provenance["numbers"], provenance["steps"]
    assert isinstance(numbers, dict)
    assert isinstance(steps, dict)
    known: dict[str, bool] = {}

    def lacks(step: str) -> bool:
        if step not in known:
            known[step] = False  # steps form no circle
            known[step] = bool(missing & set(steps[step]["files"])) or any(map(lacks, steps[step]["inputs"]))
        return known[step]

    # a number that the package does not trace may come from anywhere
    return {key for key in keys if key not in numbers or any(map(lacks, numbers[key]))}


def recompute(deposit: Deposit, data: Data, work: Path, jobs: int, progress: Progress) -> Path:
    """Run the package's study with everything that is written in ``work``; the folder of the report.

    DataError : the study in the package gives no report on these data.
    """
    study = placed_in(load_study(deposit.folder / SOURCES[0], data.folder), work)
    source = study.runs_source
    if source is not None and source.rig is not None:
        study = replace(study, runs_source=replace(source, rig=deposit.folder / SOURCES[1]))
    board = run_study(study, stages=stages_for("report"), jobs=jobs, progress=progress)
    why = [message for item, stage, message in board.failures() if (item, stage) == ("study", "report")]
    if why or not (study.reports / "results.json").is_file():
        found = why[0] if why else "no report"
        do = "Look whether --data names the data of this package."
        raise DataError(deposit.source, wanted="numbers from the data", found=found, do=do)
    return study.reports
