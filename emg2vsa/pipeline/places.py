"""Where the outcomes of a study go, and whether they can go there; and the recordings of a folder beside them."""

from __future__ import annotations

import contextlib
import json
import os
import re
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from casr.atomic import write_text_atomic
from emg2vsa.errors import DataError, SettingError
from emg2vsa.pipeline.ledger import LEDGER_FILE
from emg2vsa.pipeline.lock import holder
from emg2vsa.pipeline.stage_order import REPORTS
from emg2vsa.study import Study

OWNER_FILE = ".study.json"
"""File in the folder of a report that names its study."""
NOT_RECORDINGS = {
    ".json", ".md", ".toml", ".html", ".py", ".cal", ".pdf", ".docx", ".gitignore", ".bidsignore", ".svg",
    ".tex", ".png",
}  # fmt: skip
"""Files of a folder that are known to be no recordings."""
_TABLES_OF_BIDS = re.compile(
    r"(.*_)?(participants|sessions|scans|channels|electrodes|events|samples)\.tsv", re.IGNORECASE
)


def placed_in(study: Study, work: Path) -> Study:
    """The study with results, report and emulated runs in ``work``; its recordings and measured runs where they are."""
    work = Path(os.path.abspath(work))
    source = study.runs_source
    if source is not None and source.rig is not None:
        source = replace(source, root=work / "runs-virtual")
    return replace(study, results=work / "results", reports=work / "report", runs_source=source)


def is_writable(folder: Path) -> bool:
    """Whether files can be made in ``folder``, or in the nearest folder above it that is there. Leaves nothing."""
    return not _refusal(folder)


def locked_places(study: Study, stages: Sequence[str]) -> list[Path]:
    """Folders that one run at a time may write to, in the order in which their locks are taken.

    Two studies may share the folder of an emulated rig's runs.
    """
    source = study.runs_source
    emulates = "emulation" in stages and source is not None and source.rig is not None
    return [study.results, *([source.root] if emulates and source is not None else [])]


@contextlib.contextmanager
def writable_or_temporary(
    study: Study, below: Path | None, *, now: bool = False
) -> Iterator[tuple[Study, Path | None]]:
    """The study as it is; with results in a folder that goes when this ends where its own cannot be written to.

    now : also where another run holds them, which may take long.
    """
    if is_writable(study.results) and not (now and holder(study.results)):
        yield study, below
        return
    import tempfile  # loads much, which few runs need

    with tempfile.TemporaryDirectory() as folder:
        yield placed_in(study, Path(folder)), study.results


def check_places(study: Study, stages: Sequence[str]) -> None:
    """See that every folder that the stages write to can be written to, and that the report's is this study's.

    SettingError : one cannot. DataError : the folder of the report holds that of another study.
    """
    written = {study.results}
    for name in stages:
        if name in ("pages", *REPORTS):
            written.add(study.reports)
        if name == "emulation" and study.runs_source is not None and study.runs_source.rig is not None:
            written.add(study.runs_source.root)
    for folder in sorted(written):
        if refusal := _refusal(folder):
            do = "Give another place for everything that is written with --work DIR, or mend the permissions."
            raise SettingError(folder, wanted="a folder that can be written to", found=refusal, do=do)
    if study.reports in written:
        own_report(study)


def own_report(study: Study) -> None:
    """Mark the report's folder as this study's. DataError where it holds another study's."""
    path = study.reports / OWNER_FILE
    mine = {"study": study.name, "file": Path(os.path.relpath(study.path, study.reports)).as_posix()}
    with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
        theirs = json.loads(path.read_text())
        if theirs == mine:
            return
        file = Path(os.path.normpath(study.reports / theirs["file"]))
        if file.exists() and not file.samefile(study.path):
            raise DataError(
                study.reports, wanted="a folder for the report of this study",
                found=f"the report of the study {theirs['study']!r} in {file}",
                do="Give this study another folder: reports under [study], or --work DIR.",
            )  # fmt: skip
    write_text_atomic(path, json.dumps(mine) + "\n")


def _refusal(folder: Path) -> str:
    """Why no file can be made in the folder; "" where one can."""
    there = next(path for path in (folder, *folder.parents) if path.exists())
    name = there / f".writable.{os.getpid()}.{time.monotonic_ns()}"
    try:
        handle = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except OSError as error:
        return error.strerror or str(error)
    os.close(handle)
    os.unlink(name)
    return ""


def recordings_in(given: Sequence[Path]) -> list[Path]:
    """The files given, and those below folders that may be recordings, in their order. SettingError where none is."""
    paths: list[Path] = []
    for path in given:
        paths += _below(path) if path.is_dir() else [path]
    if not paths:
        do = "Name the folder that holds the files."
        raise SettingError(given[0], wanted="recordings", found="a folder without any", do=do)
    return paths


def _below(folder: Path) -> Iterator[Path]:
    """The files that may be recordings. Folders inside it that hold a report or results of this program have none."""
    found = sorted(folder.rglob("*"))
    made = {path.parent for path in found if path.name in (OWNER_FILE, LEDGER_FILE)} - {folder}
    for path in found:
        hidden = any(part.startswith((".", "~$")) for part in path.relative_to(folder).parts)
        named = path.stem.upper().startswith(("LICENSE", "README", "SOURCES")) or _TABLES_OF_BIDS.fullmatch(path.name)
        kept = not hidden and not named and path.suffix.lower() not in NOT_RECORDINGS and made.isdisjoint(path.parents)
        if kept and (path.is_file() or not path.exists()):  # a link to nothing is told as unreadable
            yield path
