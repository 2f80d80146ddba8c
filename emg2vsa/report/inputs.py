"""What a study report is written from, what it lacks, and whether its data were simulated."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.discrimination import Discrimination
from emg2vsa.fits import Fits
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.profiles import Profiles
from emg2vsa.report.failures import Failure
from emg2vsa.runs import RunScores
from emg2vsa.schedules import Schedule
from emg2vsa.study import Study
from emg2vsa.trials import Trials
from emg2vsa.truth import Truth


@dataclass(frozen=True)
class StudyResults:
    """All products of a run. A stage that failed is None (or empty), and ``failures`` say why.

    A study of measured runs alone has no trials, and neither fits nor what follows from them.
    """

    study: Study
    trials: tuple[Trials, ...] = ()
    "Their samples are not needed: see ``without_samples``."
    fits: Fits | None = None
    hypotheses: Hypotheses | None = None
    profiles: Profiles | None = None
    schedules: tuple[Schedule, ...] = ()
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

    @property
    def fitted(self) -> Fits:
        """``fits``, for what is only asked of a study that has them."""
        assert self.fits is not None
        return self.fits

    def by_participant(self) -> dict[str, tuple[list[Trials], list[Failure]]]:
        """Each participant of the recordings, in their order, with the own trials and failures."""
        own: dict[str, tuple[list[Trials], list[Failure]]] = {r.participant: ([], []) for r in self.study.recordings}
        for trials in self.trials:
            own[trials.participant][0].append(trials)
        for failure in self.failures:
            if failure.participant in own:
                own[failure.participant][1].append(failure)
        return own

    def verdict_counts(self) -> dict[str, int]:
        """Trials by verdict."""
        return {name: int(np.count_nonzero(self.fitted.verdict == name)) for name in ("ok", "warned", "rejected")}

    def why_absent(self, stage: str) -> str:
        """One sentence on why a section has nothing to show."""
        reasons = [failure.message for failure in self.failures if failure.stage == stage]
        return f"Failed: {' '.join(reasons)}" if reasons else f"The study has no {stage}."


def without_samples(trials: Trials) -> Trials:
    """What a report reads of ``trials``: no force, activity and envelopes over time, which take most of the memory."""
    samples = ("force_n", "activity", "envelopes_v", "overview_time_s", "overview_force_n")
    arrays = {f.name: value for f in fields(trials) if isinstance(value := getattr(trials, f.name), np.ndarray)}
    # a copy lets go of the file that the array was a part of
    kept: dict[str, Any] = {name: value[..., : 0 if name in samples else None].copy() for name, value in arrays.items()}
    return replace(trials, **kept)


@dataclass(frozen=True)
class Origin:
    """Whether the data were simulated, as far as a report can know: it sees a table of the truth, or it sees none.

    ``strong`` and ``text`` open the report, ``source`` is what tables call the data, ``kind`` the colour.
    """

    kind: str
    strong: str
    text: str
    source: str


_SIMULATED = Origin(
    "usable",
    "These results come from a simulation.",
    "Every recording was synthesised from chosen curves plus noise. Numbers on this page show that the method finds "
    "what was put in; they are no evidence about people, and agreement with the paper is not a replication.",
    "simulated data",
)
_PERHAPS = Origin(
    "repeat",
    "These data may be simulated.",
    "The study file has a [simulation] table, but no table of simulated truth was found beside the recordings. If "
    "emg2vsa made them, nothing here is evidence about people; if people did, remove the [simulation] table.",
    "data that may be simulated",
)
_NO_TRUTH = Origin(
    "",
    "No table of simulated truth was found beside the recordings,",
    "so they are taken as recorded from people, and no fit can be compared with a truth.",
    "data taken as recorded",
)


def origin(results: StudyResults) -> Origin:
    """What can be said of the data of this study."""
    if results.truth is not None:
        return _SIMULATED
    return _NO_TRUTH if results.study.simulation is None else _PERHAPS
