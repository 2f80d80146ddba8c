"""Is a published package what its data give? Its manifest, its own numbers twice, and all of them recomputed.

The numbers are made once more by the package's study file, on the data, in a place of its own.
"""

from __future__ import annotations

import contextlib
import csv
import json
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path

import emg2vsa
from emg2vsa.deposit.agreement import (
    OF_PEOPLE,
    OF_RUNS,
    Agreement,
    Difference,
    compared,
    compared_texts,
    restated_list,
    restated_macros,
)
from emg2vsa.deposit.crate import METADATA, SOURCES, sha256_of
from emg2vsa.deposit.open_deposit import Deposit, open_deposit
from emg2vsa.errors import DataError, SettingError
from emg2vsa.pipeline.places import OWNER_FILE, placed_in
from emg2vsa.pipeline.registered import registered
from emg2vsa.pipeline.run_study import Progress, run_study
from emg2vsa.pipeline.stage_order import stages_for
from emg2vsa.registration import Registered
from emg2vsa.study import Study
from emg2vsa.study_file import load_study

RESULTS = "results.json"
AGREES, DIFFERS, UNVERIFIED = 0, 1, 2


@dataclass(frozen=True)
class Data:
    """The data of a package. folder : where the study file would lie. missing, changed : of its files."""

    folder: Path
    missing: frozenset[str]
    changed: tuple[str, ...]


def data_of(deposit: Deposit, given: Path | None) -> Data:
    """The data in ``given``; without it inside the package, where its report says, or beside it.

    DataError : ``given`` is no folder.
    """
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


def _study(deposit: Deposit, data: Data, work: Path) -> Study:
    """The package's study on these data, with its own rig file and registration."""
    study_file, rig, registration = (deposit.folder / name for name in SOURCES)
    study = placed_in(load_study(study_file, data.folder), work)
    source = study.runs_source
    if source is not None and source.rig is not None:
        study = replace(study, runs_source=replace(source, rig=rig))
    return replace(study, registration=registration if deposit.has(registration.name) else None)


def recompute(deposit: Deposit, data: Data, work: Path, jobs: int, progress: Progress) -> Path:
    """Run the package's study with everything that is written in ``work``; the folder of the report.

    DataError : the study in the package gives no report on these data.
    """
    study = _study(deposit, data, work)
    asked = ("paths",) if "paths.count" in deposit.json("results.json") else ()
    board = run_study(study, stages=stages_for("report"), jobs=jobs, progress=progress, asked=asked)
    why = [message for item, stage, message in board.failures() if (item, stage) == ("study", "report")]
    if why or not (study.reports / "results.json").is_file():
        found = why[0] if why else "no report"
        do = "Look whether --data names the data of this package."
        raise DataError(deposit.source, wanted="numbers from the data", found=found, do=do)
    return study.reports


@dataclass(frozen=True)
class Verification:
    """What was found.

    damage : (file, what is wrong with it) of the package. restated : numbers that its other files say otherwise than
    its results.json. numbers : against those recomputed. texts : lines of tables and schedules, likewise; None where
    they could not be. unchecked : numbers, and files of lines, that could not be recomputed.
    registered : the registration in the package and every deviation from it, None where it has none.
    """

    deposit: Deposit
    data: Data
    damage: tuple[tuple[str, str], ...]
    restated: tuple[Difference, ...]
    numbers: Agreement
    texts: Agreement
    unchecked: tuple[str, ...]
    registered: Registered | None

    @property
    def status(self) -> int:
        """0 everything agrees; 1 something differs or was changed; 2 not everything could be checked."""
        wrong = (self.damage, self.data.changed, self.restated, self.numbers.differ, self.texts.differ)
        if any(wrong):
            return DIFFERS
        return UNVERIFIED if self.unchecked else AGREES


def verify_package(
    source: Path, *, data: Path | None, work: Path | None, keys: str, jobs: int, progress: Progress
) -> Verification:
    """Verify the package in a folder or an archive; nothing in it, or beside it, is written.

    data : folder from which its study file names its data. work : where the numbers are recomputed, and kept; a
    temporary folder otherwise. keys : pattern of the numbers to compare.

    Raises
    ------
    DataError : there is no such package, or its study gives no report. SettingError : no key is like ``keys``, or
    ``work`` lies in the package. StudyError : the study file in the package has problems.
    """
    _check_work(work, source, data)
    with tempfile.TemporaryDirectory() as folder:
        deposit = open_deposit(source, Path(folder) / "package")
        place = Path(folder) / "work" if work is None else work / f"verify-{_short(deposit)}"
        return _verify(deposit, data_of(deposit, data), place, keys, jobs, progress)


def _verify(deposit: Deposit, data: Data, work: Path, keys: str, jobs: int, progress: Progress) -> Verification:
    published = deposit.json(RESULTS)
    wanted = [key for key in published if fnmatchcase(key, keys)]
    if not wanted:
        do = "Look at the keys in results.json; a pattern takes * and ?."
        raise SettingError(f"--keys {keys}", wanted=f"a pattern of keys in {RESULTS}", found="no such key", do=do)
    damage = tuple(deposit.damage())
    restated = tuple(
        difference for name, restate in (("numbers.tex", restated_macros), ("results.csv", restated_list))
        if deposit.has(name) for difference in restate(published, deposit.text(name))
    )  # fmt: skip
    plan = registered(_study(deposit, data, work), final=not data.missing)
    if data.missing and len(data.missing) == len(deposit.inputs):
        nothing = Agreement(0, 0, ())
        return Verification(deposit, data, damage, restated, nothing, nothing, (*wanted, *_texts(deposit)), plan)
    left = without_data(wanted, deposit.json("provenance.json") if data.missing else {}, data.missing)
    report = recompute(deposit, data, work, jobs, progress)
    ours = Deposit(report, report, {}, {}, emg2vsa.__version__)
    recomputed = ours.json(RESULTS)
    more = [key for key in recomputed if key not in published and fnmatchcase(key, keys)] if not left else []
    numbers = compared(published, recomputed, [*(key for key in wanted if key not in left), *more])
    texts, unread = [], [key for key in wanted if key in left]
    for name in _texts(deposit):
        if data.missing:
            unread.append(name)
        else:
            texts.append(_text(name, deposit, ours, exact=not numbers.within and not numbers.differ))
    return Verification(deposit, data, damage, restated, numbers, _sum(texts), tuple(unread), plan)


def _texts(deposit: Deposit) -> list[str]:
    """Files with numbers that the report writes anew, line by line."""
    return [
        name for name in deposit.sha256
        if deposit.has(name)
        and (name == "statements.tex" or (name.startswith(_FOLDERS) and name.endswith((".csv", ".tex"))))
    ]  # fmt: skip


_FOLDERS = ("tables/", "schedules/")


def _text(name: str, deposit: Deposit, ours: Deposit, *, exact: bool) -> Agreement:
    if not ours.has(name):
        return Agreement(0, 0, (Difference(name, "a file", "no such file"),))
    recomputed = ours.text(name)
    tolerance = OF_RUNS if _is_of_runs(name, ours) else OF_PEOPLE
    return compared_texts(name, deposit.text(name), recomputed, tolerance, exact=exact)


def _is_of_runs(name: str, ours: Deposit) -> bool:
    """Whether a table tells of runs, by its columns; statements tell of people and runs, schedules of people."""
    table = f"{name.rpartition('.')[0]}.csv"
    if not name.startswith("tables/") or not ours.has(table):
        return not name.startswith("schedules/")
    return bool(_COLUMNS_OF_RUNS & set(next(csv.reader(ours.text(table).splitlines()), [])))


_COLUMNS_OF_RUNS = {"angle_deg", "condition", "algorithm", "claim", "key", "quantity", "press", "contrast", "design"}


def _sum(each: list[Agreement]) -> Agreement:
    differ = tuple(difference for one in each for difference in one.differ)
    return Agreement(sum(one.exact for one in each), sum(one.within for one in each), differ)


def _short(deposit: Deposit) -> str:
    return sha256_of(deposit.folder / METADATA)[:12]


def _check_work(work: Path | None, source: Path, data: Path | None) -> None:
    if work is None:
        return
    places: Iterator[Path] = (place.resolve() for place in (source, data) if place is not None)
    if (work.exists() and not work.is_dir()) or any(work.resolve().is_relative_to(place) for place in places):
        found = "a file" if work.is_file() else "a folder in the package or its data"
        do = "Name an empty folder elsewhere, or leave --work out."
        raise SettingError(f"--work {work}", wanted="a folder of its own", found=found, do=do)


_SHOWN = 20


def lines(found: Verification) -> Iterator[str]:
    """The verdict last."""
    deposit, data = found.deposit, found.data
    other = "" if deposit.version == emg2vsa.__version__ else f"; this is {emg2vsa.__version__}, so methods may differ"
    yield f"Package: {deposit.source}, written by emg2vsa {deposit.version}{other}"
    yield f"Files: {len(deposit.sha256)} in the manifest, {len(found.damage)} not as it says"
    yield from _few([f"{name}: {what}" for name, what in found.damage])
    there = len(deposit.inputs) - len(data.missing)
    yield f"Data: {there} of {len(deposit.inputs)} files in {data.folder}, {len(data.changed)} of them changed"
    yield from _few([f"{name}: changed" for name in data.changed])
    yield from _few([f"{name}: missing" for name in sorted(data.missing)])
    if len(data.missing) == len(deposit.inputs) and data.missing:
        yield "  Name the folder of the study file with --data."
    yield f"Inside the package: {len(found.restated)} numbers are not as in results.json"
    yield from _few(found.restated, "in the file", "in results.json")
    unchecked = [name for name in found.unchecked if "/" not in name and not name.endswith(".tex")]
    yield f"Numbers: {_counted(found.numbers)}, {len(unchecked)} not checked"
    yield from _few(found.numbers.differ)
    files = len(found.unchecked) - len(unchecked)
    yield f"Lines of tables, statements and schedules: {_counted(found.texts)}, {files} files not checked"
    yield from _few(found.texts.differ)
    if found.registered:
        yield from found.registered.lines()
    yield ("Verified.", "Not as published.", "Not verified: see what was not checked.")[found.status]


def _counted(agreement: Agreement) -> str:
    return f"{agreement.exact} equal, {agreement.within} within tolerance, {len(agreement.differ)} differ"


def _few(
    found: Sequence[Difference | str], published: str = "published", recomputed: str = "recomputed"
) -> Iterator[str]:
    for each in found[:_SHOWN]:
        yield f"  {each}".replace(": published ", f": {published} ").replace(", recomputed ", f", {recomputed} ")
    if len(found) > _SHOWN:
        yield f"  and {len(found) - _SHOWN} more; --json lists all"


def as_json(found: Verification) -> dict[str, object]:
    """All of it."""
    deposit, data = found.deposit, found.data
    return {
        "package": str(deposit.source),
        "version": deposit.version,
        "status": found.status,
        "files": [{"file": name, "found": what} for name, what in found.damage],
        "data": {"folder": str(data.folder), "missing": sorted(data.missing), "changed": list(data.changed)},
        "restated": [vars(difference) for difference in found.restated],
        "numbers": _agreement(found.numbers),
        "lines": _agreement(found.texts),
        "not_checked": list(found.unchecked),
        "registration": found.registered.as_json() if found.registered else None,
    }


def _agreement(agreement: Agreement) -> dict[str, object]:
    differ = [vars(difference) for difference in agreement.differ]
    return {"equal": agreement.exact, "within_tolerance": agreement.within, "differ": differ}
