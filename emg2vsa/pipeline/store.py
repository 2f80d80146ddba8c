"""Where results lie, files that steps wrote outside the store, and who works at which step.

A step's result is ``store/<stage>/<item>/<key>.result``. A stage that writes files stores their names and digests
instead. While a step is under way, ``under-way/`` holds its claim and its unfinished result. ``set-aside/`` holds what
was found in the place of a result and is none.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from emg2vsa import artifacts
from emg2vsa.errors import DataError
from emg2vsa.held_lock import myself, told
from emg2vsa.pipeline.fingerprint import MISSING, Fingerprints, digest


@dataclass(frozen=True)
class WrittenFiles:
    """Files that a step wrote into its folder: names relative to it, and digests of their content."""

    names: tuple[str, ...]
    digests: tuple[str, ...]

    def trouble(self, folder: Path, prints: Fingerprints) -> str:
        """Name of a file that is not there as it was written; "" where all are."""
        above = str(folder)
        for name, known in zip(self.names, self.digests, strict=True):
            found = prints.file(f"{above}/{name}")
            if found != known:
                return f"its file {name} {'is missing' if found == MISSING else 'was changed'}"
        return ""

    def besides(self, folder: Path, inner: Path) -> str:
        """A file in ``inner``, in ``folder``, that is none of them; "" for none. Hidden ones do not count."""
        above, known = len(f"{folder}{os.sep}"), set(self.names)
        shown = (path[above:].replace(os.sep, "/") for path in _shown(str(inner)))
        return min((name for name in shown if name not in known), default="")


def _shown(folder: str) -> Iterator[str]:
    """The files in a folder and in those below, but hidden ones. Links to folders are not followed."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _is_folder(entry):
                yield from () if entry.is_symlink() else _shown(entry.path)
            elif entry.name[0] != ".":
                yield entry.path


def _is_folder(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_dir()
    except OSError:  # a link that leads to itself
        return False


def written_files(folder: Path, paths: Sequence[Path]) -> WrittenFiles:
    """The files ``paths``, all inside ``folder``, as they are now."""
    names = tuple(Path(os.path.relpath(path, folder)).as_posix() for path in paths)
    return WrittenFiles(names, tuple(digest(path.read_bytes()) for path in paths))


class Store:
    """The results of one study.

    below : the results of the same study elsewhere, which are read and never written.
    """

    def __init__(self, folder: Path, below: Path | None = None) -> None:
        self.folder, self.below = folder, below

    def path(self, step: str, key: str) -> str:
        """Where the result of a step with this key is, or will be."""
        return f"{self.folder}/store/{step}/{key}.result"

    def path_below(self, step: str, key: str) -> str | None:
        """The same in the store below; None where there is none."""
        return None if self.below is None else f"{self.below}/store/{step}/{key}.result"

    def unfinished(self, step: str, key: str) -> Path:
        """Where a step writes its result before it is known to hold."""
        return self.folder / "under-way" / f"{_flat(step)}.{key}.{os.getpid()}.result"

    def claim(self, step: str) -> Path:
        """The claim of the process that works at a step."""
        return self.folder / "under-way" / f"{_flat(step)}.json"

    def settle(self, unfinished: Path, step: str, key: str) -> str:
        """Give a result its place."""
        path = Path(self.path(step, key))
        for folder in (each for each in path.parents if each.is_relative_to(self.folder / "store")):
            if folder.exists() and not folder.is_dir():
                set_aside(folder, self.folder)
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            set_aside(path, self.folder)
        os.replace(unfinished, path)
        return str(path)

    def sweep(self) -> None:
        """Remove what killed processes left; only the holder of the study's lock may."""
        with contextlib.suppress(OSError):
            for path in (self.folder / "under-way").iterdir():
                path.unlink(missing_ok=True)

    def results(self, step: str) -> list[Path]:
        """All results of a step."""
        return sorted(path for path in (self.folder / "store" / step).glob("*.result") if not path.is_dir())

    def keep_only(self, step: str, keys: Sequence[str]) -> list[Path]:
        """Remove the results of a step with other keys, and say which."""
        removed = [path for path in self.results(step) if path.stem not in keys]
        for path in removed:
            path.unlink(missing_ok=True)
        return removed

    def drop_empty_folders(self) -> None:
        """Remove folders that hold no result any more."""
        for folder, _, _ in os.walk(self.folder / "store", topdown=False):
            with contextlib.suppress(OSError):
                os.rmdir(folder)

    def stored_steps(self) -> Iterator[str]:
        """Ids of all steps that have a folder in the store."""
        root = self.folder / "store"
        for folder, _, names in os.walk(root):
            if any(name.endswith(".result") for name in names):
                yield Path(folder).relative_to(root).as_posix()


def set_aside(path: Path, results: Path) -> None:
    """Move what is in the place of a file or folder of ours to ``set-aside``: nobody knows whose it is."""
    places = (results / "set-aside" / f"{path.name}-{n}" for n in itertools.count(1))
    free = next(place for place in places if not place.exists())
    free.parent.mkdir(parents=True, exist_ok=True)
    os.rename(path, free)


def _flat(step: str) -> str:
    """A step's id as one file name; no name of a participant or specimen holds a tilde."""
    return step.replace("/", "~")


class ClaimedElsewhere(DataError):
    """Another process works at the step."""


@contextlib.contextmanager
def claimed(claim: Path) -> Iterator[None]:
    """Hold the claim of one step. Raises ClaimedElsewhere where another process holds it."""
    claim.parent.mkdir(parents=True, exist_ok=True)
    try:
        handle = os.open(claim, os.O_WRONLY | os.O_CREAT | os.O_EXCL)
    except FileExistsError:
        raise ClaimedElsewhere(
            claim.stem, wanted="a step that no other process works at", found=told(claim), do="Wait until it ends."
        ) from None
    try:
        os.write(handle, json.dumps(myself()).encode())
        os.close(handle)
        yield
    finally:
        claim.unlink(missing_ok=True)


def remove_left_files(folder: Path, old: Sequence[Path], new: WrittenFiles) -> None:
    """Remove from ``folder`` what earlier results of the same step wrote and the new one did not."""
    for path in old:
        with contextlib.suppress(artifacts.DamagedResult):
            before = artifacts.load(path)
            left = set(before.names) - set(new.names) if isinstance(before, WrittenFiles) else ()
            for name in left:
                (folder / name).unlink(missing_ok=True)
