"""What a report says of steps that failed; apart from all results, so that a page loads none of the statistics."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from emg2vsa.study import Study


@dataclass(frozen=True)
class Failure:
    """A step that could not be done. key : "participant/specimen", a participant, or "study"."""

    key: str
    stage: str
    message: str

    @property
    def participant(self) -> str:
        return self.key.partition("/")[0]


class ShortPaths:
    """Shortens paths in messages to what is seen from the study file: a report tells not where the project lies."""

    def __init__(self, study: Study) -> None:
        base = study.path.parent
        files = [path for entry in study.recordings for path in entry.files]
        folders = {study.data, *(path.parent for path in files)}
        folders |= {study.runs_source.root} if study.runs_source else set()
        outer: set[Path] = set()
        for folder in sorted({base, *folders}, key=lambda path: (len(path.parts), path != base)):
            named = folder.is_absolute() and folder.anchor == base.anchor != str(folder)
            # a folder within another is shortened with it; the study's own lies within none
            if named and (folder == base or outer.isdisjoint((folder, *folder.parents))):
                outer.add(folder)
        self._short = {str(f): "" if f == base else Path(os.path.relpath(f, base)).as_posix() + "/" for f in outer}
        longest_first = sorted(self._short, key=len, reverse=True)
        self._found = re.compile(rf"(?<![\w.-])({'|'.join(map(re.escape, longest_first))})[\\/]") if outer else None

    def text(self, text: str) -> str:
        return self._found.sub(lambda found: self._short[found[1]], text) if self._found else text

    def failures(self, failures: Iterable[Failure]) -> tuple[Failure, ...]:
        return tuple(replace(failure, message=self.text(failure.message)) for failure in failures)
