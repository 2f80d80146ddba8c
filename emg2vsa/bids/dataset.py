"""The files of a BIDS data set as a whole: what it is, who took part, and what the events files of a task hold."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from casr.atomic import write_text_atomic
from emg2vsa import __version__
from emg2vsa.bids.names import EVENTS_SIDECAR, RecordingName, visit_folder
from emg2vsa.bids.tables import Column, Json, described, merge_tsv, write_json
from emg2vsa.errors import DataError

BIDS_VERSION = "1.11.1"
_DESCRIPTION, _README = "dataset_description.json", "README.md"
_PEOPLE, _PERSON = "participants.tsv", "participant_id"


@dataclass(frozen=True)
class DataSet:
    """What a data set is. made : what the program did for it. readme : the text below the name.

    participants : their codes; () where it has no table of them. participant : what such a code is. events : by task,
    what its events files hold, where they do not tell it themselves. ignored : patterns of files that are none of BIDS.
    """

    name: str
    made: str
    readme: str
    kind: Literal["raw", "derivative"] = "raw"
    participants: Sequence[str] = ()
    participant: str = "Participant."
    events: Mapping[str, Json] = field(default_factory=dict)
    authors: Sequence[str] = ()
    licence: str = ""
    ethics: str = ""
    ignored: Sequence[str] = ()

    def description(self) -> Json:
        given: Json = {"License": self.licence} if self.licence else {}
        given |= {"Authors": list(self.authors)} if self.authors else {}
        given["GeneratedBy"] = [{"Name": "emg2vsa", "Version": __version__, "Description": self.made}]
        given |= {"EthicsApprovals": [self.ethics]} if self.ethics else {}
        return {"Name": self.name, "BIDSVersion": BIDS_VERSION, "DatasetType": self.kind, **given}


def write_dataset(root: Path, dataset: DataSet, *, keep: bool = False) -> None:
    """Everything but the recordings. keep : what others wrote stays, and people are added to those in the table.

    DataError : the table of people that is to be kept cannot be read.
    """
    if not (keep and (root / _DESCRIPTION).exists()):
        write_json(root / _DESCRIPTION, dataset.description())
    if not (keep and any((root / name).exists() for name in ("README", _README, "README.rst", "README.txt"))):
        write_text_atomic(root / _README, f"# {dataset.name}\n\n{dataset.readme}")
    if dataset.ignored:
        write_text_atomic(root / ".bidsignore", "".join(f"{pattern}\n" for pattern in dataset.ignored))
    if dataset.participants:
        if not (keep and (root / "participants.json").exists()):
            write_json(root / "participants.json", described({_PERSON: Column(dataset.participant)}))
        rows = [(f"sub-{one}",) for one in dataset.participants]
        merge_tsv(root / _PEOPLE, (_PERSON,), rows, (lambda row: True) if keep else None, 0o600 if keep else 0o644)
    for task, columns in dataset.events.items():
        write_json(root / f"task-{task}{EVENTS_SIDECAR}", columns)


def write_person(root: Path, participant: str, columns: Mapping[str, Column], cells: Mapping[str, str]) -> None:
    """What is told of a participant, by column, into the tables of people; whatever else they hold stays.

    The table can be read by its owner alone. DataError : one of the two files that are there cannot be read.
    """
    path = root / "participants.json"
    try:
        before = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        told = described({_PERSON: Column("Code of the participant.")}) | before | described(columns)
    except (OSError, ValueError, TypeError) as error:
        raise DataError(
            path, wanted="a JSON object", found=str(error), do="Correct the file, or move it away."
        ) from error
    merge_tsv(root / _PEOPLE, (_PERSON, *cells), [(f"sub-{participant}", *cells.values())], lambda row: True, 0o600)
    write_json(path, told)


def write_scans(
    root: Path, participant: str, began: Mapping[RecordingName, str], *, keep: bool = False, visit: str = ""
) -> None:
    """The recordings of a participant, or of a visit, and when each began, in time order; and when the visit did.

    keep : others stay whose files are there. DataError : a table that is to be kept cannot be read.
    """
    person, folder = root / f"sub-{participant}", visit_folder(root, participant, visit)
    rows = sorted(
        ((name.path(root).relative_to(folder).as_posix(), at) for name, at in began.items()), key=lambda row: row[1]
    )
    stays = (lambda file: (folder / file).exists()) if keep else None
    stem = "_".join(path.name for path in dict.fromkeys((person, folder)))
    merge_tsv(folder / f"{stem}_scans.tsv", ("filename", "acq_time"), rows, stays)
    if visit and rows:
        others = (lambda name: (person / name).is_dir()) if keep else None
        table = person / f"{person.name}_sessions.tsv"
        merge_tsv(table, ("session_id", "acq_time"), [(folder.name, rows[0][1])], others)
