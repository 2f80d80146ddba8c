"""What was run, with what, and how it ended: one JSON line for each step that ended.

Settings, code and libraries are the same for many steps; each stands in a line of its own, and steps name its digest.
Every line ends with its checksum. A killed run loses at most the line it was writing; a damaged line is left out, and
its step is stale.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from casr.atomic import write_bytes_atomic
from emg2vsa.pipeline.fingerprint import Part, digest
from emg2vsa.pipeline.store import set_aside

KEPT_RESULTS = 2
"""Results kept of a step: the current one and the one before, so that a setting can be tried and taken back."""

LEDGER_FILE = "ledger.jsonl"


class Parts(NamedTuple):
    """Everything a step's result depends on. files, inputs : name to digest."""

    settings: Part
    files: Mapping[str, str]
    inputs: Mapping[str, str]
    code: Part
    libraries: Part


class Entry(NamedTuple):
    """How a step ended.

    status : done or failed. final : the failure is the input's fault, and the step is not tried again. result : digest
    of the stored result, "" of a failed step. kernel : of the BLAS that it ran with; of another one the same result may
    differ in its last digits. "" where nobody noted it. loaded : what the step imported or looked up by name; the code
    and the libraries among its parts are those that follow from that.
    """

    step: str
    key: str
    status: str
    message: str
    final: bool
    result: str
    parts: Parts
    kernel: str = ""
    loaded: Sequence[str] = ()


_SHARED = ("settings", "code", "libraries")


class Ledger:
    """The newest entries of every step. warn : is told what could not be read."""

    def __init__(self, folder: Path, warn: Callable[[str], None] = lambda text: None) -> None:
        self._path = folder / LEDGER_FILE
        self._entries: dict[str, list[Entry]] = {}
        self._parts: dict[str, Part] = {}
        self._lines = 0
        self._written: set[str] = set()
        self.old = False
        """Whether it holds lines of version 0.1.0, which are not used."""
        self.damaged = 0
        """Number of lines that were left out."""
        self._read()
        if self.damaged:
            lines = f"{self.damaged} line{'s' if self.damaged != 1 else ''}"
            warn(f"{self._path} is damaged: {lines} left out. What they told of is done again.")
        if self.old:
            warn(f"{folder} holds results of version 0.1.0. They are not used; everything runs once more.")

    def last(self, step: str) -> Entry | None:
        """How the step ended when it last ran."""
        known = self._entries.get(step)
        return known[0] if known else None

    def with_key(self, step: str, key: str) -> Entry | None:
        """How the step ended with that key, if that is one of the kept entries."""
        for entry in self._entries.get(step, ()):
            if entry.key == key:
                return entry
        return None

    def steps(self) -> Iterable[str]:
        """Ids of all steps that ended once."""
        return self._entries.keys()

    def loaded(self, step: str) -> list[tuple[str, ...]]:
        """Libraries that the kept entries of a step loaded, the newest first."""
        return [tuple(entry.loaded) for entry in self._entries.get(step, ())]

    def keys(self, step: str) -> list[str]:
        """Keys of the kept entries of a step, the newest first."""
        return [entry.key for entry in self._entries.get(step, ())]

    def drop(self, step: str) -> None:
        """Forget a step; ``compact`` removes its lines."""
        self._entries.pop(step, None)

    def record(self, entry: Entry) -> None:
        """Append one entry; with the system when this returns."""
        shared = [part for part in (getattr(entry.parts, name) for name in _SHARED) if part.digest not in self._written]
        lines = [*(_line(_of_part(part)) for part in shared), _line(_of_entry(entry))]
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a+b") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(size - 1, 0))
            if size and file.read(1) != b"\n":  # a killed run left half a line
                file.seek(0)
                file.truncate(file.read().rfind(b"\n") + 1)
            file.write(b"".join(lines))
        self._lines += len(lines)
        self._written.update(part.digest for part in shared)
        self._keep(entry)

    def compact(self, force: bool = False) -> None:
        """Write the kept entries anew where replaced, damaged or old lines are half of the file.

        Only the holder of the study's lock may.
        """
        needless = self._lines > 2 * len(self._entries) + 2 * len(self._written) + 16
        if force or self.old or self.damaged or needless:
            lines = list(self._all_lines())
            if self._path.is_dir():
                set_aside(self._path, self._path.parent)
            write_bytes_atomic(self._path, b"".join(lines))
            self._lines, self.old, self.damaged = len(lines), False, 0

    def _all_lines(self) -> Iterator[bytes]:
        self._written = set()
        for entries in self._entries.values():
            for entry in reversed(entries):
                for part in (getattr(entry.parts, name) for name in _SHARED):
                    if part.digest not in self._written:
                        self._written.add(part.digest)
                        yield _line(_of_part(part))
                yield _line(_of_entry(entry))

    def _keep(self, entry: Entry) -> None:
        others = [other for other in self._entries.get(entry.step, ()) if other.key != entry.key]
        self._entries[entry.step] = [entry, *others][:KEPT_RESULTS]

    def _read(self) -> None:
        try:
            data = self._path.read_bytes()
        except FileNotFoundError:
            return
        except OSError:
            self.damaged += 1
            return
        *lines, unfinished = data.split(b"\n")
        for line in lines:
            self._read_line(line)
        self._lines = len(lines) + bool(unfinished)

    def _read_line(self, line: bytes) -> None:
        if not line:
            return
        body, seal = line[:-_SEAL_BYTES], line[-_SEAL_BYTES:]
        try:
            if seal != _seal(body):
                fields = json.loads(line)
                self.old |= isinstance(fields["parts"]["code"], dict)  # as 0.1.0 wrote it
                self.damaged += not isinstance(fields["parts"]["code"], dict)
                return
            fields = json.loads(line)
            if "part" in fields:
                self._parts[fields["part"]] = Part(fields["part"], fields["value"])
                self._written.add(fields["part"])
            else:
                self._keep(self._entry(fields))
        except (ValueError, TypeError, KeyError, RecursionError):
            self.damaged += 1

    def _entry(self, fields: dict[str, Any]) -> Entry:
        given = fields.pop("parts")
        settings, code, libraries = (self._parts[given[name]] for name in _SHARED)
        parts = Parts(settings, given["files"], given["inputs"], code, libraries)
        del fields["sum"]
        return Entry(**fields, parts=parts)


_SEAL_BYTES = len(b',"sum":"0123456789abcdef"}')


def _seal(body: bytes) -> bytes:
    return b',"sum":"' + digest(body).encode() + b'"}'


def _line(fields: dict[str, Any]) -> bytes:
    body = json.dumps(fields).encode()[:-1]
    return body + _seal(body) + b"\n"


def _of_part(part: Part) -> dict[str, Any]:
    return {"part": part.digest, "value": part.value}


def _of_entry(entry: Entry) -> dict[str, Any]:
    parts = {name: getattr(entry.parts, name).digest for name in _SHARED}
    parts |= {"files": dict(entry.parts.files), "inputs": dict(entry.parts.inputs)}
    told: dict[str, Any] = {"step": entry.step, "key": entry.key, "status": entry.status, "message": entry.message}
    told |= {"final": entry.final, "result": entry.result, "parts": parts}
    return told | {"kernel": entry.kernel, "loaded": entry.loaded}


def differences(old: Parts, new: Parts, unknown: Iterable[str] = ()) -> list[str]:
    """Why a step with ``new`` parts is not the one that ran with ``old``: one short reason for each change.

    unknown : inputs of which nobody knows yet whether they change.
    """
    same = old.settings.digest == new.settings.digest
    settings = [] if same else _changed(_flat(old.settings.value), _flat(new.settings.value))
    reasons = [f"setting {name}: {a} -> {b}" for name, a, b in settings]
    reasons += [f"{_verb(a, b)} file {name}" for name, a, b in _changed(old.files, new.files)]
    skipped = set(unknown)
    inputs = ((name, a, b) for name, a, b in _changed(old.inputs, new.inputs) if name not in skipped)
    reasons += [f"{_verb(a, b)} input {name}" for name, a, b in inputs]
    reasons += [f"{_verb(a, b)} code {name}" for name, a, b in _changed(old.code.value, new.code.value)]
    libraries = _changed(old.libraries.value, new.libraries.value)
    reasons += [f"library {name} {a} -> {b}" for name, a, b in libraries]
    return reasons or [f"the order of its {name} changed" for name in ("files", "inputs") if _reordered(old, new, name)]


def _reordered(old: Parts, new: Parts, name: str) -> bool:
    """The same names in another order, which counts: files and inputs are told apart by their places."""
    before, now = list(getattr(old, name)), list(getattr(new, name))
    return before != now and sorted(before) == sorted(now)


def _changed(old: Mapping[str, str], new: Mapping[str, str]) -> list[tuple[str, str, str]]:
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
