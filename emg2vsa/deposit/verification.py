"""Is a published package what its data give? Its manifest, its own numbers twice, and all of them recomputed."""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
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
from emg2vsa.deposit.crate import METADATA
from emg2vsa.deposit.open_deposit import Deposit, open_deposit, sha256_of
from emg2vsa.deposit.recomputed import Data, data_of, recompute, without_data
from emg2vsa.errors import SettingError
from emg2vsa.pipeline.run_study import Progress

RESULTS = "results.json"
AGREES, DIFFERS, UNVERIFIED = 0, 1, 2


@dataclass(frozen=True)
class Verification:
    """What was found.

    damage : (file, what is wrong with it) of the package. restated : numbers that its other files say otherwise than
    its results.json. numbers : against those recomputed. texts : lines of tables and schedules, likewise; None where
    they could not be. unchecked : numbers, and files of lines, that could not be recomputed.
    """

    deposit: Deposit
    data: Data
    damage: tuple[tuple[str, str], ...]
    restated: tuple[Difference, ...]
    numbers: Agreement
    texts: Agreement
    unchecked: tuple[str, ...]

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
    if data.missing and len(data.missing) == len(deposit.inputs):
        nothing = Agreement(0, 0, ())
        return Verification(deposit, data, damage, restated, nothing, nothing, (*wanted, *_texts(deposit)))
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
    return Verification(deposit, data, damage, restated, numbers, _sum(texts), tuple(unread))


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
