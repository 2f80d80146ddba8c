"""A synthetic study as a BIDS dataset (BIDS-EMG, 1.11.1): recordings with side files, and the dataset around them."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from emg2vsa.atomic import write_bytes_atomic, write_text_atomic
from emg2vsa.errors import SettingError
from emg2vsa.settings import SimulationSettings
from emg2vsa.study import Study
from emg2vsa.synthetic import bids_texts
from emg2vsa.synthetic.bdf import bdf_bytes, cues
from emg2vsa.synthetic.delimited import text_rows
from emg2vsa.synthetic.plan import PlannedRecording
from emg2vsa.synthetic.recording import SyntheticRecording
from emg2vsa.synthetic.stored import stored_channels

BIDS_VERSION = "1.11.1"


def check_labels(plan: Sequence[PlannedRecording]) -> None:
    """BIDS labels are letters and digits only; refuse names that are not, before anything is written."""
    for name in dict.fromkeys(name for planned in plan for name in (planned.participant, planned.specimen)):
        if not re.fullmatch(r"[A-Za-z0-9]+", name):
            raise SettingError(
                f"name {name!r}",
                wanted="letters and digits only, for it becomes a BIDS label",
                found=repr(name),
                do="Rename it, or write another format.",
            )


def write_bids(folder: Path, planned: PlannedRecording, recording: SyntheticRecording) -> Path:
    """Data file of one recording, its ``_emg.json``, ``_channels.tsv`` and ``_events.tsv``; returns the data file."""
    channels = stored_channels(planned, recording, "uV")
    path = folder / _relative_path(planned)
    stem = path.name.removesuffix("_emg.bdf")
    write_bytes_atomic(path, bdf_bytes(planned, recording, channels))
    emg = bids_texts.emg_json(planned.task, recording, channels, planned.mains_hz)
    _write_json(path.with_suffix(".json"), emg)
    rows = [bids_texts.channel_row(channel, recording.fs_hz) for channel in channels]
    _write_tsv(path.with_name(f"{stem}_channels.tsv"), bids_texts.CHANNEL_COLUMNS, rows)
    events = [(onset, "n/a", text) for onset, text in cues(recording)]
    _write_tsv(path.with_name(f"{stem}_events.tsv"), ("onset", "duration", "trial_type"), events)
    return path


def write_dataset(folder: Path, study: Study, settings: SimulationSettings, plan: Sequence[PlannedRecording]) -> Path:
    """Files of the dataset as a whole, the scans files among them; returns the folder for the truth."""
    description = _description(study.title or study.name, "raw")
    _write_json(folder / "dataset_description.json", description)
    write_text_atomic(folder / "README.md", bids_texts.readme(description["Name"], settings, len(study.specimens)))
    participants = list(dict.fromkeys(planned.participant for planned in plan))
    _write_tsv(folder / "participants.tsv", ("participant_id",), [(f"sub-{name}",) for name in participants])
    _write_json(folder / "participants.json", bids_texts.PARTICIPANT_COLUMNS)
    for task in dict.fromkeys(planned.task for planned in plan):
        _write_json(folder / f"task-{task}_events.json", bids_texts.EVENT_COLUMNS)
    for name in participants:
        _write_scans(folder / f"sub-{name}", [planned for planned in plan if planned.participant == name])
    return _write_derivative(folder / "derivatives" / "truth", f"Truth of {description['Name']}")


def _write_derivative(folder: Path, name: str) -> Path:
    _write_json(folder / "dataset_description.json", _description(name, "derivative"))
    write_text_atomic(folder / "README.md", f"# {name}\n\n{bids_texts.TRUTH_README}")
    # the standard has no name for tables of what was simulated
    write_text_atomic(folder / ".bidsignore", "truth.*\norder.*\n")
    return folder


def _write_scans(folder: Path, plan: Sequence[PlannedRecording]) -> None:
    in_time = sorted(plan, key=lambda planned: planned.position)
    rows = [
        (_relative_path(planned).relative_to(folder.name).as_posix(), planned.acquired.isoformat())
        for planned in in_time
    ]
    _write_tsv(folder / f"{folder.name}_scans.tsv", ("filename", "acq_time"), rows)


def _relative_path(planned: PlannedRecording) -> Path:
    subject = f"sub-{planned.participant}"
    return Path(subject) / "emg" / f"{subject}_task-{planned.task}_acq-{planned.specimen}_emg.bdf"


def _description(name: str, kind: str) -> dict[str, Any]:
    return {
        "Name": name,
        "BIDSVersion": BIDS_VERSION,
        "DatasetType": kind,
        "License": "CC0",
        "Authors": ["emg2vsa"],
        "GeneratedBy": bids_texts.GENERATED_BY,
    }


def _write_json(path: Path, content: dict[str, Any]) -> None:
    write_text_atomic(path, json.dumps(content, indent=2) + "\n")


def _write_tsv(path: Path, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    write_text_atomic(path, text_rows([columns, *rows], "\t"))
