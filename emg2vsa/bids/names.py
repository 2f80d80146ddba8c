"""Names of BIDS-EMG: of people, of recordings, and of the files beside a recording."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

DATA, SIDECAR, CHANNELS = "_emg.bdf", "_emg.json", "_channels.tsv"
EVENTS, EVENTS_SIDECAR = "_events.tsv", "_events.json"


def label_of(text: str) -> str:
    """A text without what a label may not hold: letters and digits; "" where nothing is left."""
    return re.sub(r"[^A-Za-z0-9]", "", text)


def is_label(text: str) -> bool:
    return text == label_of(text) != ""


@dataclass(frozen=True)
class RecordingName:
    """Labels of a recording. run : its number among several of one specimen. part : of those that make up one.

    visit : of the participant ("session" in BIDS), "" where each comes once.
    """

    participant: str
    task: str
    specimen: str = ""
    run: int | None = None
    part: str = ""
    visit: str = ""

    @property
    def stem(self) -> str:
        labels = (self.participant, self.visit, self.task, self.specimen, self.run, self.part)
        given = zip(("sub", "ses", "task", "acq", "run", "recording"), labels, strict=True)
        return "_".join(f"{entity}-{label}" for entity, label in given if label)

    def path(self, root: Path) -> Path:
        """The data file in the data set ``root``."""
        return visit_folder(root, self.participant, self.visit) / "emg" / f"{self.stem}{DATA}"


def visit_folder(root: Path, participant: str, visit: str) -> Path:
    """What ``root`` has of a participant, or of one of several visits."""
    return root / f"sub-{participant}" / (f"ses-{visit}" if visit else "")


def beside(data: Path, ending: str) -> Path:
    """The side file of a data file."""
    return data.with_name(data.name.removesuffix(DATA) + ending)


def remove_recording(data: Path) -> None:
    """Remove a data file and the side files that were written with it."""
    for ending in (DATA, SIDECAR, CHANNELS, EVENTS, EVENTS_SIDECAR):
        beside(data, ending).unlink(missing_ok=True)
