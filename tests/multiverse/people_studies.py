"""Small studies of people as trials with envelopes: v = a + b g(F), what is claimed of them is known."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.extraction import Trials
from emg2vsa.study import Study
from tests.report.conftest import TRUE, make_study, make_trials

SHARES = np.array([[0.4], [0.6]])
"Of the two muscles in the activity."


def study_of(people: int) -> Study:
    return make_study(tuple(f"P{number:02d}" for number in range(1, people + 1)))


def with_slopes(study: Study, b_of: Mapping[str, Mapping[str, float]]) -> list[Trials]:
    """Presses of the study; b_of : of persons whose slopes, in volts, are not those of ``TRUE``."""
    return [
        made(each.participant, each.specimen, seed, b_of.get(each.participant, {}).get(each.specimen))
        for seed, each in enumerate(study.recordings)
    ]


def made(
    participant: str,
    specimen: str,
    seed: int,
    b_v: float | None = None,
    law: Callable[[Floats], Floats] = np.log,
    noise: float = 0.05,
    shares: Floats = SHARES,
) -> Trials:
    """Every press with a slope of its own, 5 % apart."""
    rng = np.random.default_rng(seed)
    trials = make_trials(participant, specimen, seed)
    a, b = TRUE[specimen][0], TRUE[specimen][1] if b_v is None else b_v
    presses = np.repeat(1 + noise * rng.standard_normal(trials.repetition.size), np.diff(trials.offsets))
    activity = a + b * presses * law(trials.force_n) + 0.1 * noise * a * rng.standard_normal(trials.force_n.size)
    envelopes = shares * activity
    return replace(trials, activity=envelopes.sum(axis=0), envelopes_v=envelopes)


def places(study: Study, seed: int = 0) -> dict[tuple[str, str], float]:
    """A random order of specimens for every person."""
    rng = np.random.default_rng(seed)
    found: dict[tuple[str, str], float] = {}
    for person in study.participants:
        names: Sequence[str] = [each.specimen for each in study.recordings if each.participant == person]
        found |= {
            (person, name): float(place) for name, place in zip(names, 1 + rng.permutation(len(names)), strict=True)
        }
    return found
