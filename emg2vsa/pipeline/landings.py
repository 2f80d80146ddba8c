"""Recordings that are written while somebody waits for them: which, when they are complete, and their verdicts."""

from __future__ import annotations

import importlib
import os
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from emg2vsa.errors import Emg2vsaError, SettingError
from emg2vsa.pipeline.judged_sessions import STAGES, judge
from emg2vsa.pipeline.plan import survey
from emg2vsa.pipeline.run_study import Progress
from emg2vsa.session_verdict import SessionVerdict
from emg2vsa.study import RecordingEntry, Study

POLL_S = 0.25
"""A file that has kept its size and time over two looks so far apart is complete."""


class Awaited:
    """The recordings of a study that are written into a folder, with the files that they have now.

    Parameters
    ----------
    study : those that are judged. whole : beside all of these. folder : that is watched. again : both studies, read
        again. below : results that may be read. say : is told why they cannot be read again.

    SettingError : no such folder, or none of the recordings belongs into it.
    """

    def __init__(
        self, study: Study, whole: Study, folder: Path, again: Callable[[], tuple[Study, Study]], below: Path | None,
        say: Callable[[str], None],
    ) -> None:  # fmt: skip
        self.folder = folder = Path(os.path.abspath(folder))
        self._study, self._whole, self._again, self._below, self._say = study, whole, again, below, say
        if not folder.is_dir():
            do = "Make this folder, or correct the path."
            raise SettingError(folder, wanted="a folder to watch", found="none", do=do)
        if not self._entries():
            raise SettingError(
                folder, wanted="the folder into which recordings of the study are written",
                found="a folder to which none of them belongs", do=f"The study's recordings lie in {study.data}.",
            )  # fmt: skip
        self._listed = _listing(folder)

    def _entries(self) -> list[RecordingEntry]:
        return [each for each in self._study.recordings if any(self.folder in path.parents for path in each.files)]

    def now(self) -> list[RecordingEntry]:
        """What is awaited; a pattern with * or {repetition} finds other files once files have come or gone."""
        if (present := _listing(self.folder)) != self._listed:
            self._listed = present
            try:
                chosen, found = self._again()
                self._whole = replace(self._whole, recordings=found.recordings)
                self._study = replace(self._study, recordings=chosen.recordings)
            except Emg2vsaError as error:  # the study file was edited meanwhile
                self._say(str(error))
        return self._entries()

    def verdicts(self, shown: Progress) -> Iterator[tuple[str, SessionVerdict]]:
        """Key and verdict of each recording that lands, without end."""
        for entry in landings(self.now, time.sleep):
            (verdict,) = judge(replace(self._study, recordings=(entry,)), self._whole, 1, shown, self._below)
            yield entry.key, verdict

    def warm_up(self) -> None:
        """Load and look up beforehand what would delay the first verdict."""
        for name in ("readers.roles", "readers.plain_csv", "extraction.extract", "fits"):
            importlib.import_module(f"emg2vsa.{name}")
        survey(self._study, STAGES, lambda text: None, below=self._below)


def _listing(folder: Path) -> frozenset[str]:
    """The files below the folder, but for hidden folders."""
    found: set[str] = set()
    for inside, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        found.update(os.path.join(inside, name) for name in files)
    return frozenset(found)


def landings(now: Callable[[], Iterable[RecordingEntry]], wait: Callable[[float], None]) -> Iterator[RecordingEntry]:
    """Each recording whenever its files are complete: there, and unchanged over two looks; again when they change.

    now : the recordings with the files that they have at a look. Those that are complete at the first look are not
    told: they were there before.
    """
    before = {entry.key: _state(entry) for entry in now()}
    done = dict(before)
    while True:
        wait(POLL_S)
        for entry in now():
            state = _state(entry)
            if state is not None and state == before.get(entry.key) != done.get(entry.key):
                done[entry.key] = state
                yield entry
            before[entry.key] = state


_State = tuple[tuple[Path, int, int], ...]


def _state(entry: RecordingEntry) -> _State | None:
    """Each file of a recording with its size and time; None while one is absent or empty."""
    found = []
    for path in entry.files:
        try:
            status = path.stat()
        except OSError:
            return None
        if status.st_size == 0:
            return None
        found.append((path, status.st_size, status.st_mtime_ns))
    return tuple(found)
