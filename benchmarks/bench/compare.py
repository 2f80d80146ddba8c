"""Another revision of emg2vsa and casr beside this checkout, measured by the benchmarks of this checkout."""

from __future__ import annotations

import io
import subprocess
import tarfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.bench.child import SOURCE, measured_in_child
from benchmarks.bench.results import AreaResult, Row
from benchmarks.bench.tables import number, ratio_text, table
from benchmarks.bench.timing import Spread
from emg2vsa.errors import SettingError

PACKAGES = ("emg2vsa", "casr")
Runs = dict[tuple[str, str], list[Row]]
"By case and label, one row of each process."


@dataclass(frozen=True)
class Compared:
    """One of our ways. ratio : time of this checkout over that of the revision, None where one has no such way."""

    case: str
    label: str
    old: Row | None
    new: Row | None
    ratio: Spread | None


@contextmanager
def product_of(revision: str) -> Iterator[Path]:
    """A temporary folder with the packages of a revision; it is removed at the end, also after Ctrl-C.

    SettingError for what git does not know as a commit.
    """
    try:
        known = subprocess.run(
            [
                "git",
                "-C",
                str(SOURCE),
                "rev-parse",
                "--verify",
                "--quiet",
                "--end-of-options",
                f"{revision}^{{commit}}",
            ],
            capture_output=True,
            text=True,
        )
    except OSError as error:
        raise SettingError(
            "--compare", wanted="git, which gives other revisions", found="none", do="Install git."
        ) from error
    if known.returncode:
        raise SettingError(
            "--compare", wanted="a revision of this checkout, as git names it", found=repr(revision),
            do="Name a commit, a tag or a branch: git log --oneline lists them.",
        )  # fmt: skip
    archive = subprocess.run(
        ["git", "-C", str(SOURCE), "archive", known.stdout.strip(), *PACKAGES], capture_output=True, check=True
    )
    with TemporaryDirectory(prefix="emg2vsa-bench-") as folder:
        with tarfile.open(fileobj=io.BytesIO(archive.stdout)) as files:
            files.extractall(folder, filter="data")
        yield Path(folder)


def compare(name: str, options: dict[str, Any], old: Path, pairs: int) -> list[Compared]:
    """Our ways of one area in both, in processes in turn: old, new, new, old, ..."""
    runs: dict[Path | None, list[AreaResult]] = {old: [], None: []}
    for pair in range(pairs):
        for product in (old, None) if pair % 2 == 0 else (None, old):
            asked = {**options, "ours_alone": True, "memory": False, "older": product is not None}
            runs[product].append(measured_in_child(name, asked, product))
    before, after = _rows(runs[old]), _rows(runs[None])
    return [_compared(key, before.get(key), after.get(key)) for key in dict.fromkeys([*after, *before])]


def _compared(key: tuple[str, str], old: list[Row] | None, new: list[Row] | None) -> Compared:
    return Compared(*key, old=old[0] if old else None, new=new[0] if new else None, ratio=_ratio(old, new))


def lines(revision: str, compared: list[Compared]) -> list[str]:
    """As Markdown."""
    head = ("case", "way", f"{revision}, CPU ms", "here, CPU ms", "here / there", "error there", "error here")
    return table(head, [_cells(revision, one) for one in compared])


def _cells(revision: str, one: Compared) -> list[str]:
    old, new = one.old, one.new
    ratio = ratio_text(one.ratio) if one.ratio else f"not in {revision}" if new else "not here any more"
    return [
        one.case, one.label, number(old.median_ms if old else None), number(new.median_ms if new else None), ratio,
        number(old.error if old else None, ".2g"), number(new.error if new else None, ".2g"),
    ]  # fmt: skip


def _rows(results: list[AreaResult]) -> Runs:
    found: Runs = {}
    for result in results:
        for case in result.cases:
            for row in case.rows:
                if row.median_ms:
                    found.setdefault((case.name, row.label), []).append(row)
    return found


def _ratio(old: list[Row] | None, new: list[Row] | None) -> Spread | None:
    if not old or not new:
        return None
    ratios = [(b.least_ms or 0.0) / (a.least_ms or 1.0) for a, b in zip(old, new, strict=False)]
    low, median, high = np.quantile(ratios, (0.05, 0.5, 0.95))
    return Spread(float(median), float(low), float(high))
