"""What a study report is written from."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.discrimination import Discrimination
from emg2vsa.fits import Fits
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.profiles import Profiles
from emg2vsa.runs import RunScores
from emg2vsa.schedules import Schedule
from emg2vsa.study import Study
from emg2vsa.trials import Trials
from emg2vsa.truth import Truth


@dataclass(frozen=True)
class Failure:
    """A step that could not be done. key : "participant/specimen", a participant, or "study"."""

    key: str
    stage: str
    message: str


@dataclass(frozen=True)
class RunsResults:
    """All products of a study of measured runs alone; what failed is None, and ``failures`` say why."""

    study: Study
    runs: tuple[RunScores, ...]
    discrimination: Discrimination | None
    calibration: CalibrationResults | None
    failures: tuple[Failure, ...] = ()
    provenance: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class StudyResults:
    """All products of a run. A stage that failed is None (or empty), and ``failures`` say why."""

    study: Study
    trials: tuple[Trials, ...]
    fits: Fits
    hypotheses: Hypotheses | None
    profiles: Profiles | None
    schedules: tuple[Schedule, ...]
    failures: tuple[Failure, ...] = ()
    provenance: dict[str, str] = field(default_factory=dict)
    "Versions and digests by name."
    truth: Truth | None = None
    "Of a simulated study: (participant, specimen, repetition) to the true (a, b) in volts."
    runs: tuple[RunScores, ...] = ()
    "Scored runs of the rig; empty where the study has none."
    discrimination: Discrimination | None = None
    "What is tested of them."
    calibration: CalibrationResults | None = None
    "Stiffness of the new specimen by them."

    def verdict_counts(self) -> dict[str, int]:
        """Trials by verdict."""
        return {name: int(np.count_nonzero(self.fits.verdict == name)) for name in ("ok", "warned", "rejected")}

    def why_absent(self, stage: str) -> str:
        """One sentence on why a section has nothing to show."""
        return why_absent(self.failures, stage)


def why_absent(failures: Sequence[Failure], stage: str) -> str:
    """One sentence on why a section has nothing to show."""
    reasons = [failure.message for failure in failures if failure.stage == stage]
    return f"Failed: {' '.join(reasons)}" if reasons else f"The study has no {stage}."


def with_short_paths(failures: Sequence[Failure], study: Study) -> tuple[Failure, ...]:
    """The failures, with paths as seen from the study file: a report must not depend on where the project lies."""
    return tuple(replace(failure, message=short_paths(failure.message, study)) for failure in failures)


def short_paths(text: str, study: Study) -> str:
    """``text`` with the folders of the study, its data, recordings and runs relative to the study file's folder."""
    base = study.path.parent
    files = [path for entry in study.recordings for path in (entry.emg_file, entry.force_file) if path]
    folders = {base, study.data, *(path.parent for path in files)}
    folders |= {study.runs_source.root} if study.runs_source else set()
    for folder in sorted(folders, key=lambda path: len(path.parts), reverse=True):
        if folder.is_absolute() and folder.anchor == base.anchor != str(folder):
            short = Path(os.path.relpath(folder, base)).as_posix() + "/"
            found = rf"(?<![\w.-]){re.escape(str(folder))}[\\/]"
            text = re.sub(found, "" if short == "./" else short, text)
    return text
