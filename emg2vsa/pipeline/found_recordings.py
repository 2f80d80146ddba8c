"""The files of a folder that may be recordings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from emg2vsa.errors import SettingError
from emg2vsa.pipeline.ledger import LEDGER_FILE
from emg2vsa.pipeline.places import OWNER_FILE

NOT_RECORDINGS = {
    ".json", ".tsv", ".md", ".toml", ".html", ".py", ".cal", ".pdf", ".docx", ".gitignore", ".bidsignore", ".svg",
    ".tex", ".png",
}  # fmt: skip
"""Files of a folder that are known to be no recordings."""


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
        hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
        named = path.stem.upper().startswith(("LICENSE", "README", "SOURCES"))
        kept = not hidden and not named and path.suffix.lower() not in NOT_RECORDINGS and made.isdisjoint(path.parents)
        if kept and (path.is_file() or not path.exists()):  # a link to nothing is told as unreadable
            yield path
