"""The index of co-contraction, by which muscles become one activity: recordings and presets of schedules by each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import Emg2vsaError, SettingError
from emg2vsa.extraction import Trials
from emg2vsa.fits import concatenate, fit_trials, in_session
from emg2vsa.profiles import build_profiles
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import CocontractionSettings, Index
from emg2vsa.signals.cocontraction import cocontraction_index
from emg2vsa.study import Study


def by_index(study: Study, trials: Sequence[Trials]) -> Iterator[tuple[Index, list[Trials]]]:
    """The recordings by the study's own index, and then by every other one that their muscles allow."""
    own: Index = study.cocontraction.index
    for name in sorted(get_args(Index), key=lambda each: each != own):
        with suppress(SettingError):  # another number of muscles, or levels that only the recordings' files tell
            yield name, _with_index(study, trials, replace(study.cocontraction, index=name))


def _with_index(study: Study, trials: Sequence[Trials], settings: CocontractionSettings) -> list[Trials]:
    if settings.needs_session:
        sessions: dict[str, list[Trials]] = {}
        for each in trials:
            sessions.setdefault(each.participant, []).append(each)
        return [in_session(each, sessions[each.participant], settings, study.judgements) for each in trials]
    if settings == study.cocontraction:
        return list(trials)
    made = [cocontraction_index(each.envelopes_v, each.muscles, settings) for each in trials]
    return [
        replace(each, activity=activity, activity_unit=unit)
        for each, (activity, unit, _) in zip(trials, made, strict=True)
    ]


@dataclass(frozen=True, eq=False)
class IndexPresets:
    """The stiffness profiles of S specimens in K force steps by I indices of co-contraction, the study's own first.

    participant : whose presses, "" for the mean of all. percent : (I, S, K) stiffness; NaN where an index gives no
    schedule. range_percent : of the mapping.
    """

    participant: str
    indices: tuple[str, ...]
    specimens: tuple[str, ...]
    percent: Floats
    range_percent: tuple[float, float]

    @property
    def largest_move(self) -> Floats:
        """(I, S) points of percent by which a preset moves against the study's own index, at any force."""
        return np.asarray(np.abs(self.percent - self.percent[0]).max(axis=2))

    @property
    def rank(self) -> Floats:
        """(I, S) place of a specimen among all by its mean preset, from 1, the stiffest preset first."""
        mean = self.percent.mean(axis=2)
        place = 1.0 + np.sum(mean[:, :, None] < mean[:, None, :], axis=2)
        return np.where(np.isfinite(mean), place, np.nan)


def index_presets(study: Study, trials: Sequence[Trials], participant: str) -> IndexPresets | None:
    """Schedule the profiles of a participant, "" for the mean of all, by every index. None without a schedule."""
    own = [each for each in trials if participant in ("", each.participant)]
    percent: dict[str, dict[str, Floats]] = {}
    for name, recordings in by_index(study, own):
        percent[name] = {}
        with suppress(Emg2vsaError):  # a press that does not change with force, or no profile of a specimen
            percent[name] = _percent(study, recordings, participant)
    indices = tuple(percent)
    if not indices or not percent[indices[0]]:
        return None
    base = percent[indices[0]]
    lost = {specimen: np.full(each.shape, np.nan) for specimen, each in base.items()}
    table = np.array([[(percent[name] or lost)[specimen] for specimen in base] for name in indices])
    return IndexPresets(participant, indices, tuple(base), table, study.schedule.stiffness_percent)


def _percent(study: Study, recordings: Sequence[Trials], participant: str) -> dict[str, Floats]:
    """Specimen to its presets (K,)."""
    fitted = (fit_trials(each, study.fit, study.window, study.judgements) for each in recordings)
    fits = concatenate(fitted, bins=study.profile.curve == "spline")
    profile = replace(study.profile, participant=participant or None)
    profiles = build_profiles(fits, study.stiffness_n_per_mm, profile, study.window, study.hypotheses.use)
    schedules = build_schedules(profiles, replace(study.schedule, conditions=("modular",)), {})
    return {each.specimen: each.stiffness_percent for each in schedules}
