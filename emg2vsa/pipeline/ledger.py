"""What was run, with what, and how it ended: one JSON line per finished step, and the store of results.

A line is appended when a step ends, and a result is written whole or not at all, so that a killed run loses at most
the steps that were under way.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

from emg2vsa.atomic import write_text_atomic

KEPT_RESULTS = 2
"""Results kept per step: the current one and the one before, so that a setting can be tried and taken back."""


@dataclass(frozen=True)
class Parts:
    """Everything a step's result depends on; each value is text or a digest."""

    settings: dict[str, object]
    files: dict[str, str]
    inputs: dict[str, str]
    code: dict[str, str]
    libraries: dict[str, str]


@dataclass(frozen=True)
class Entry:
    """How a step ended. ``status`` is done or failed; a final failure is the input's fault and not tried again."""

    step: str
    key: str
    status: str
    message: str
    final: bool
    parts: Parts


class Ledger:
    """The entries of a study, the newest of each step, and the paths of its results."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._path = folder / "ledger.jsonl"
        self._entries: dict[str, Entry] = {}
        self._lines = 0
        for line in self._path.read_text().splitlines() if self._path.exists() else ():
            self._lines += 1
            try:
                fields = json.loads(line)
                entry = Entry(**fields | {"parts": Parts(**fields["parts"])})
            except (ValueError, TypeError, KeyError):
                continue  # the last line of a killed run
            self._entries[entry.step] = entry

    def last(self, step: str) -> Entry | None:
        """How the step ended when it last ran."""
        return self._entries.get(step)

    def result_path(self, step: str, key: str) -> Path:
        """Where the result of a step with this key is, or will be."""
        return self._folder / "store" / step / f"{key}.result"

    def record(self, entry: Entry) -> None:
        """Append one entry; on disk when this returns."""
        self._entries[entry.step] = entry
        self._lines += 1
        self._folder.mkdir(parents=True, exist_ok=True)
        with self._path.open("a+b") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(size - 1, 0))
            whole = size == 0 or file.read(1) == b"\n"  # a killed run may have left half a line
            file.write(("" if whole else "\n").encode() + json.dumps(asdict(entry)).encode() + b"\n")

    def compact(self) -> None:
        """Drop entries that newer ones replaced, and results no longer kept."""
        if self._lines > 2 * len(self._entries):
            lines = [json.dumps(asdict(entry)) + "\n" for entry in self._entries.values()]
            write_text_atomic(self._path, "".join(lines))
            self._lines = len(lines)
        for entry in self._entries.values():
            folder = self.result_path(entry.step, entry.key).parent
            if folder.is_dir():
                results = sorted(folder.glob("*.result"), key=lambda p: (p.stem != entry.key, -p.stat().st_mtime_ns))
                for old in results[KEPT_RESULTS:]:
                    old.unlink(missing_ok=True)


def differences(old: Parts, new: Parts) -> list[str]:
    """Why a step with ``new`` parts is not the one that ran with ``old``: one short reason per change."""
    reasons = [f"setting {name}: {a} -> {b}" for name, a, b in _changed(_flat(old.settings), _flat(new.settings))]
    reasons += [f"{_verb(a, b)} file {name}" for name, a, b in _changed(old.files, new.files)]
    reasons += [f"{_verb(a, b)} input {name}" for name, a, b in _changed(old.inputs, new.inputs)]
    reasons += [f"{_verb(a, b)} code {name}" for name, a, b in _changed(old.code, new.code)]
    reasons += [f"library {name} {a} -> {b}" for name, a, b in _changed(old.libraries, new.libraries)]
    return reasons


def _changed(old: dict[str, str], new: dict[str, str]) -> list[tuple[str, str, str]]:
    names = [*old, *(name for name in new if name not in old)]
    return [(n, old.get(n, "unset"), new.get(n, "unset")) for n in names if old.get(n, "unset") != new.get(n, "unset")]


def _verb(old: str, new: str) -> str:
    return {"unset": "new"}.get(old) or {"unset": "removed", "missing": "missing"}.get(new) or "changed"


def _flat(tree: object, name: str = "") -> dict[str, str]:
    if isinstance(tree, dict):
        leaves: dict[str, str] = {}
        for key, item in tree.items():
            leaves |= _flat(item, f"{name}.{key}" if name else str(key))
        return leaves
    return {name: json.dumps(tree)}
