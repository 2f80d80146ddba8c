"""Side files of BIDS-EMG: ``_channels.tsv`` and ``_emg.json`` beside ``_emg.edf`` or ``_emg.bdf`` (BIDS 1.11)."""

from __future__ import annotations

import csv
import json
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from emg2vsa.errors import RecordingError
from emg2vsa.readers.units import canonical

_ABSENT = ("", "n/a")
_EXTENSIONS = (".edf", ".bdf")
_MOST_LEVELS = 4  # root, subject, session, emg


class SideChannel(NamedTuple):
    """One row of ``_channels.tsv``; None where the column is absent or "n/a"."""

    unit: str | None = None
    fs_hz: float | None = None
    status: str | None = None
    status_description: str | None = None

    def warnings(self, name: str, fs_hz: float) -> tuple[str, ...]:
        """What a user of the channel should know, given the rate that the data file states, Hz."""
        notes = []
        if self.status == "bad":
            why = f" ({self.status_description})" if self.status_description else ""
            notes.append(f"{name}: channels.tsv marks this channel bad{why}.")
        if self.fs_hz is not None and abs(self.fs_hz - fs_hz) > 1e-3 * fs_hz:
            notes.append(f"{name}: channels.tsv states {self.fs_hz:g} Hz, the file {fs_hz:g} Hz; the file counts.")
        return tuple(notes)


@dataclass(frozen=True)
class SideFiles:
    """channels : label to row. emg : the ``_emg.json`` of the recording, with what it inherits."""

    channels: Mapping[str, SideChannel] = field(default_factory=dict)
    emg: Mapping[str, Any] = field(default_factory=dict)

    def notes(self, fs_hz: float) -> list[str]:
        """Where ``_emg.json`` states another rate than the data file, Hz."""
        stated = self.emg.get("SamplingFrequency")
        if isinstance(stated, (int, float)) and abs(stated - fs_hz) > 1e-3 * fs_hz:
            return [f"_emg.json states {stated:g} Hz, the file {fs_hz:g} Hz; the file counts."]
        return []


class SideFileIndex:
    """The folders looked into so far, each listed once: for asking about many recordings at one moment."""

    def __init__(self) -> None:
        self._folders: dict[str, _Folder | None] = {}
        self._chains: dict[str, list[_Folder]] = {}

    def holds(self, path: str, name: str) -> bool:
        """Whether a folder has a file of this name."""
        folder = self._folder(path)
        return folder is not None and name in folder.names

    def _folder(self, path: str) -> _Folder | None:
        if path not in self._folders:
            self._folders[path] = _listed(path)
        return self._folders[path]

    def chain(self, own: str) -> list[_Folder]:
        """Folders from the root of the data set to ``own``; ``own`` alone where there is no root."""
        if own not in self._chains:
            self._chains[own] = self._chain(own)
        return self._chains[own]

    def _chain(self, path: str) -> list[_Folder]:
        found: list[_Folder] = []
        for _ in range(_MOST_LEVELS):
            folder = self._folder(path)
            if folder is None:
                break
            found.append(folder)
            if "dataset_description.json" in folder.names:
                return found[::-1]
            path = os.path.dirname(path)
        return found[:1]


def side_file_paths(path: Path, index: SideFileIndex | None = None) -> tuple[str, ...]:
    """Every side file that reading ``path`` consults; () where its name is none of BIDS-EMG or it has none.

    They are looked for in the recording's folder and, where a dataset_description.json marks the root of a data set,
    in those between. Give one ``index`` for many recordings, so that each folder is listed once. Paths are absolute.
    """
    tables, emg = _applying(path, index or SideFileIndex())
    return (*tables, *emg)


def side_files(path: Path) -> SideFiles:
    """The side files of a BIDS-named recording; empty where it has none. Raises RecordingError for damaged ones."""
    tables, levels = _applying(path, SideFileIndex())
    emg: dict[str, Any] = {}
    for level in levels:
        emg.update(_json(Path(level)))
    return SideFiles(_channels(Path(tables[0])) if tables else {}, emg)


_EQUIPMENT = (
    "ElectrodeManufacturer", "ElectrodeManufacturersModelName", "ElectrodeType", "ElectrodeMaterial",
    "InterelectrodeDistance", "EMGPlacementSchemeDescription", "SkinPreparation", "EMGReference", "EMGGround",
    "Manufacturer", "ManufacturersModelName",
)  # fmt: skip


def equipment(path: Path) -> tuple[str, ...]:
    """``key: value`` of what the ``_emg.json`` of a recording states of electrodes, place and amplifier."""
    emg = side_files(path).emg
    stated = {key: " ".join(str(emg.get(key, "")).split()) for key in _EQUIPMENT}
    return tuple(f"{key}: {text}" for key, text in stated.items() if text and not text.startswith("n/a"))


class _Folder(NamedTuple):
    """names : of all that it holds. tables, emg : its side files, by `_by_entity`."""

    names: frozenset[str]
    tables: _ByEntity
    emg: _ByEntity


_ByEntity = dict[str, list[tuple[frozenset[str], str]]]


def _listed(path: str) -> _Folder | None:
    try:
        names = os.listdir(path)
    except OSError:
        return None
    tables, emg = (_by_entity(path, names, ending) for ending in ("channels.tsv", "emg.json"))
    return _Folder(frozenset(names), tables, emg)


def _by_entity(folder: str, names: Sequence[str], ending: str) -> _ByEntity:
    """Entities and paths of the files with that ending, under the entity that the fewest of them have ("" for none).

    A side file applies where its entities are all the recording's own, so those of other recordings are not looked at.
    """
    above = os.path.join(folder, "")
    files = [
        (frozenset(name.removesuffix(ending).split("_")) - {""}, above + name)
        for name in names
        if name.endswith(ending)
    ]
    uses = Counter(entity for entities, _ in files for entity in entities)
    found: _ByEntity = {}
    for entities, file in files:
        found.setdefault(min(entities, key=uses.__getitem__, default=""), []).append((entities, file))
    return found


def _applying(path: Path, index: SideFileIndex) -> tuple[list[str], list[str]]:
    """The ``_channels.tsv`` and ``_emg.json`` that apply by the inheritance principle, these the most general first."""
    folder, name = os.path.split(path)
    stem, extension = os.path.splitext(name)
    if not stem.endswith("_emg") or extension.lower() not in _EXTENSIONS:
        return [], []
    own = {"", *stem.split("_")[:-1]}
    chain = index.chain(folder if os.path.isabs(folder) else os.path.join(os.getcwd(), folder).rstrip(os.sep))
    tables = [file for level in chain for file in _fitting(level.tables, own)]
    return tables[-1:], [file for level in chain for file in _fitting(level.emg, own)]


def _fitting(files: _ByEntity, own: set[str]) -> list[str]:
    """Those whose entities are all the recording's own, the most general first."""
    if not files:
        return []
    fitting = [file for entity in own if entity in files for entities, file in files[entity] if entities <= own]
    return sorted(fitting, key=lambda file: (len(file), file)) if len(fitting) > 1 else fitting


def _json(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise RecordingError(path, wanted="a JSON object", found=str(error), do="Correct the side file.") from error
    return content if isinstance(content, dict) else {}


def _channels(path: Path) -> dict[str, SideChannel]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
    except (OSError, ValueError, csv.Error) as error:
        raise RecordingError(
            path, wanted="a tab-separated table", found=str(error), do="Correct the side file."
        ) from error
    if rows and "name" not in rows[0]:
        raise RecordingError(
            path, wanted="a column 'name'", found=", ".join(map(str, rows[0])), do="Add the column (BIDS channels.tsv)."
        )
    return {row["name"].strip(): _side_channel(path, number, row) for number, row in enumerate(rows, start=2)}


def _side_channel(path: Path, line: int, row: Mapping[str, str | None]) -> SideChannel:
    def cell(name: str) -> str | None:
        text = (row.get(name) or "").strip()
        return None if text in _ABSENT else text

    fs, unit = cell("sampling_frequency"), cell("units")
    try:
        fs_hz = float(fs) if fs else None
    except ValueError as error:
        raise RecordingError(
            f"{path}, line {line}, column 'sampling_frequency'",
            wanted="a number or n/a",
            found=repr(fs),
            do="Correct this cell.",
        ) from error
    return SideChannel(canonical(unit) if unit else None, fs_hz, cell("status"), cell("status_description"))


def events_beside(recording: Path, index: SideFileIndex) -> tuple[str, ...]:
    """The events file of a recording, whoever made it; () for none."""
    path = _events_of(recording)
    return (path,) if path and index.holds(*os.path.split(path)) else ()


def _events_of(recording: Path) -> str:
    """Where the events of a recording are, if it has any; "" where its name is none of BIDS-EMG."""
    stem = os.path.splitext(recording)[0]
    return f"{stem.removesuffix('emg')}events.tsv" if stem.endswith("_emg") else ""


def session_events(recording: Path) -> Path | None:
    """The events file of a recording that a session of emg2vsa made, known by its columns; None for any other."""
    if not (path := _events_of(recording)):
        return None
    try:
        with open(path, "rb") as file:
            head = file.readline().decode("utf-8-sig").rstrip("\r\n").split("\t")
    except (OSError, ValueError):
        return None
    return Path(path) if {"counts", "decision"} <= set(head) else None
