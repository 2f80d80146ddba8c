"""Normalisation to the session: one level for all recordings of a participant, so that specimens stay comparable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from emg2vsa.settings import CocontractionSettings
from emg2vsa.signals.cocontraction import cocontraction_index
from emg2vsa.trials import Trials


def in_session(trials: Trials, session: Sequence[Trials], settings: CocontractionSettings) -> Trials:
    """``trials`` with its activity relative to the largest envelope of each muscle in the whole ``session``.

    Rejected trials do not set the level: an artefact would.
    """
    levels_v = {muscle: max(_largest_v(part, muscle) for part in session) for muscle in trials.muscles}
    activity, unit, said = cocontraction_index(trials.envelopes_v, trials.muscles, settings, levels_v)
    return replace(trials, activity=activity, activity_unit=unit, notes=(*trials.notes, *said))


def _largest_v(trials: Trials, muscle: str) -> float:
    usable = np.repeat(trials.verdict != "rejected", np.diff(trials.offsets))
    if muscle not in trials.muscles:
        return 0.0
    return float(trials.envelopes_v[trials.muscles.index(muscle), usable].max(initial=0.0))
