"""What a study report is written from, what it lacks, and whether its data were simulated."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.curves.plate_tests import PlateTests
from emg2vsa.discrimination import Discrimination
from emg2vsa.exemplary import Choice
from emg2vsa.extraction import Trials
from emg2vsa.figures.palette import ActivityScale, activity_scale
from emg2vsa.fits import Fits, usable
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.multiverse import IndexPresets, Paths
from emg2vsa.profiles import Profiles
from emg2vsa.registration import Registered
from emg2vsa.report.failures import Failure
from emg2vsa.run_scores import RunScores
from emg2vsa.schedules import Schedule
from emg2vsa.stiffness_effect import StiffnessEffect
from emg2vsa.study import RecordingEntry, Study
from emg2vsa.truth import Truth


@dataclass(frozen=True)
class People:
    """What a study found of people. A stage that failed is None or empty; without fits there is no such part."""

    fits: Fits
    trials: tuple[Trials, ...] = ()
    "Their samples are not needed: see ``without_samples``."
    hypotheses: Hypotheses | None = None
    choice: Choice | None = None
    "How far the participants' schedules are apart."
    profiles: Profiles | None = None
    schedules: tuple[Schedule, ...] = ()
    truth: Truth | None = None
    "Truth of a simulated study: (participant, specimen, repetition) to the true (a, b) in volts."

    def verdict_counts(self) -> dict[str, int]:
        """Trials by verdict."""
        return {name: int(np.count_nonzero(self.fits.verdict == name)) for name in ("ok", "doubtful", "rejected")}


@dataclass(frozen=True)
class Runs:
    """What a study found of the rig's runs. A stage that failed is None."""

    scores: tuple[RunScores, ...]
    "Scored runs, one or more."
    discrimination: Discrimination | None = None
    "What is tested of them."
    calibration: CalibrationResults | None = None
    "Stiffness of the new specimen by them."

    @property
    def simulated(self) -> bool:
        """Whether any run was made by the emulated rig."""
        return any(run.simulated for run in self.scores)


@dataclass(frozen=True)
class StudyResults:
    """Everything that a report is written from. ``failures`` say why a stage, or a whole part, is missing."""

    study: Study
    people: People | None = None
    runs: Runs | None = None
    stiffness: StiffnessEffect | None = None
    failures: tuple[Failure, ...] = ()
    provenance: dict[str, str] = field(default_factory=dict)
    "Versions and digests by name."
    pages: str = "participants"
    'Folder of the participants\' pages, as the report links to it; "" for no links.'
    registered: Registered | None = None
    "The registration of the study, with its deviations; None: it is not registered."
    paths: Paths | None = None
    "Verdicts along other paths of analysis; None unless somebody asked for them."
    presets: IndexPresets | None = None
    "Presets of the schedules, by index of co-contraction."
    plates: PlateTests | None = None
    "Indentations of the specimens by a flat plate, where there are logs."
    run_order: str = ""
    'Order in which the rig made its runs, as ``random, seed 0``; "" where nothing tells.'

    @property
    def recorded(self) -> People:
        """``people``, for a section that only a study with people has."""
        assert self.people is not None
        return self.people

    @property
    def pressed(self) -> Runs:
        """``runs``, for a section that only a study with runs has."""
        assert self.runs is not None
        return self.runs

    @property
    def specimens(self) -> list[str]:
        """Names, in the order of the study."""
        return [specimen.name for specimen in self.study.specimens]

    @property
    def used(self) -> NDArray[np.bool_]:
        """(fits,) which of them enter the tests."""
        return usable(self.recorded.fits, self.study.hypotheses.use)

    @property
    def scale(self) -> ActivityScale:
        """The unit of all activities of the report."""
        fits = self.recorded.fits
        return activity_scale(fits.activity_unit, fits.v_max_v[self.used])

    @property
    def activity_suffix(self) -> str:
        """End of the names of activities: their unit, unless they are normalised."""
        return "_v" if self.recorded.fits.activity_unit == "V" else ""

    def by_participant(self) -> dict[str, tuple[list[RecordingEntry], list[Trials], list[Failure]]]:
        """Each participant of the recordings, in their order, with the own recordings, trials and failures."""
        parts: tuple[Any, ...] = (self.study.recordings, self.people.trials if self.people else (), self.failures)
        own: dict[str, Any] = {recording.participant: ([], [], []) for recording in self.study.recordings}
        for i, part in ((i, part) for i, each in enumerate(parts) for part in each):
            if part.participant in own:
                own[part.participant][i].append(part)
        return own

    def why_absent(self, stage: str) -> str:
        """One sentence on why a section has nothing to show."""
        reasons = [failure.message for failure in self.failures if failure.stage == stage]
        return f"Failed: {' '.join(reasons)}" if reasons else f"The study has no {stage}."


_KEPT = ("repetition", "start_s", "verdict", "visit")
_NOTHING = np.empty(0)


def without_samples(trials: Trials) -> Trials:
    """What a report reads of ``trials``: of its arrays repetition, start, verdict and visit, no others.

    A study of a thousand people is held so in a few megabytes. Texts that many recordings share are held once.
    """
    # a copy lets go of the file that the array was a part of
    kept: dict[str, Any] = {name: getattr(trials, name).copy() for name in _KEPT}
    texts: dict[str, Any] = {
        name: tuple(map(sys.intern, getattr(trials, name)))
        for name in ("notes", "remarks", "reasons", "muscles", "equipment")
    }
    inner = {name: getattr(trials, name) for name in ("bias", "traits")}
    lighter = {name: replace(value, **_no_arrays(value)) for name, value in inner.items()}
    return replace(trials, **_no_arrays(trials) | kept | texts | lighter, overviews=())


def _no_arrays(value: Any) -> dict[str, Any]:
    """The fields of a dataclass that hold arrays, with empty ones."""
    arrays = (each.name for each in fields(value) if isinstance(getattr(value, each.name), np.ndarray))
    return dict.fromkeys(arrays, _NOTHING)


_NO_EVIDENCE = (
    "The numbers show whether the method recovers what was put in; they are no evidence about people or sensors."
)
_PERHAPS = (
    "The study file has a [simulation] table, but no table of simulated truth lies beside the recordings. If people "
    "made these recordings, remove the [simulation] table."
)


def origin(results: StudyResults) -> tuple[str, str, str]:
    """Whether the data were simulated, as far as a report can know: kind, first words and text of ``html.statement``.

    Of people it sees a table of the simulated truth, or none; of a run it reads who made it.
    """
    truth = results.people is not None and results.people.truth is not None
    made = [run.simulated for run in results.runs.scores] if results.runs else []
    recordings = "The recordings were synthesised from chosen curves plus noise."
    presses = f"An emulated rig made {'the' if all(made) else f'{sum(made)} of {len(made)}'} runs."
    parts = [recordings] * truth + [presses] * any(made)
    if parts:
        whole = (truth or results.people is None) and all(made)
        strong = "These data are simulated." if whole else "Part of these data is simulated."
        return ("usable", strong, " ".join([*parts, _NO_EVIDENCE]))
    if results.people is not None and results.study.simulation is not None:
        return ("repeat", "These data may be simulated.", _PERHAPS)
    said = "No sign of a simulation was found, so the data are taken as measured."
    return ("", said, "No estimate can be compared with a simulated truth.")
