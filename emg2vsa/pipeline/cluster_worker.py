"""What a worker of a cluster is asked: what its results depend on, and to carry out one task."""

from __future__ import annotations

import importlib
import os
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import casr
import emg2vsa
from casr.one_thread import VARIABLES
from emg2vsa.pipeline.fingerprint import digest, state_of
from emg2vsa.pipeline.tasks import Ended, Task

MARK = "mark of this run in the study's folder"
"""Among the facts: what the worker reads in a file that the run made there."""
AT_A_TIME = "tasks at a time"
_begun: list[str] = []


@dataclass(frozen=True)
class Asked:
    """mark : a file of the running study. libraries : whose versions count. wanted : digest of the facts."""

    mark: Path
    libraries: tuple[str, ...]
    wanted: str = ""


@dataclass(frozen=True)
class Refused:
    """A worker that would compute something else. facts : its own; unseen : a file that it does not see as it is."""

    facts: Mapping[str, str]
    unseen: str = ""


@cache
def facts_here(mark: Path, libraries: tuple[str, ...]) -> dict[str, str]:
    """What the results of this process depend on beside the task: versions, code, threads, the study's folder."""
    found = {"emg2vsa": emg2vsa.__version__, "python": platform.python_version()}
    found |= {name: _version(name) for name in libraries}
    found |= {name: os.environ.get(name, "unset") for name in VARIABLES}
    found[MARK] = _read_mark(mark)
    return found | _code()


def facts_of_worker(mark: Path, libraries: tuple[str, ...], dask_worker: Any = None) -> dict[str, str]:
    """The same of a worker of Dask, which gives itself."""
    return facts_here(mark, libraries) | {AT_A_TIME: str(dask_worker.state.nthreads)}


def attempt(task: Task, files: Mapping[str, tuple[int, int] | None], asked: Asked) -> Ended | Refused:
    """Carry out a task, unless this worker would compute something else.

    files : size and time of modification (ns) of the files that the task reads. The claim of an earlier attempt goes:
    the scheduler tries a task again only when it has given up the worker before.
    """
    worker = importlib.import_module("distributed").get_worker()
    facts = facts_of_worker(asked.mark, asked.libraries, worker)
    if digest_of(facts) != asked.wanted:
        return Refused(facts)
    for path, state in files.items():
        if size_and_time(path) != state:
            return Refused(facts, path)
    task.claim.unlink(missing_ok=True)
    _begun.append(task.step)
    try:
        return task()
    finally:
        _begun.remove(task.step)


def begun() -> list[str]:
    """Steps that this worker is at."""
    return list(_begun)


def size_and_time(path: str | Path) -> tuple[int, int] | None:
    """What two computers agree on of a file that both see; None where there is none."""
    found = state_of(path)
    return None if found is None else found[:2]


def digest_of(facts: Mapping[str, str]) -> str:
    """One digest of all facts."""
    return digest(repr(sorted(facts.items())))


@cache
def _code() -> dict[str, str]:
    """Digests as of the first question: a worker that runs old code does not become new when files change."""
    packages = (Path(str(package.__file__)).parent for package in (emg2vsa, casr))
    files = ((folder.parent, path) for folder in packages for path in sorted(folder.rglob("*.py")))
    return {f"code of {path.relative_to(base).as_posix()}": digest(path.read_bytes()) for base, path in files}


@cache
def _version(distribution: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(distribution)
    except PackageNotFoundError:
        return "absent"


def _read_mark(mark: Path) -> str:
    """What the file holds, if files can be written beside it too; else why not."""
    from emg2vsa.pipeline.places import is_writable

    try:
        held = mark.read_text()
    except OSError as error:
        return f"unreadable ({error.strerror or error})"
    return held if is_writable(mark.parent) else "in a folder that cannot be written to"
