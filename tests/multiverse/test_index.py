"""Presets of the schedules by index of co-contraction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.multiverse import index_presets
from emg2vsa.multiverse.index import by_index
from emg2vsa.settings import CocontractionSettings
from tests.multiverse.people_studies import made, study_of


def trials_of(study, shares):
    """The muscles of every specimen have these shares (2, 1) in the activity."""
    return [made(e.participant, e.specimen, 0, noise=0.0, shares=shares[e.specimen]) for e in study.recordings]


ALIKE = dict.fromkeys(("S1", "S2", "S3", "S5"), np.array([[0.5], [0.5]]))
UNLIKE = ALIKE | {"S1": np.array([[0.98], [0.02]])}


def test_muscles_that_share_alike_have_one_schedule_by_every_index_but_the_ratio():
    study = study_of(2)
    found = index_presets(study, trials_of(study, ALIKE), "P01")
    assert found.indices == ("sum", "minimum", "rudolph", "falconer-winter")
    assert found.specimens == ("S1", "S3", "S5", "S_new")
    np.testing.assert_allclose(found.largest_move[:3], 0, atol=0.1)
    assert np.isnan(found.percent[3]).all()  # 1 at every force: a ratio that does not change cannot be mapped
    np.testing.assert_array_equal(found.rank[2], found.rank[0])
    assert np.isnan(found.rank[3]).all()


def test_an_index_of_the_weaker_muscle_turns_the_order_of_specimens():
    """S1 is pressed by one muscle alone: stiffest by the sum, softest by the minimum."""
    study = study_of(2)
    found = index_presets(study, trials_of(study, UNLIKE), "P01")
    s1 = found.specimens.index("S1")
    assert found.rank[0, s1] == 1
    assert found.rank[1, s1] == 4
    assert found.largest_move[1, s1] > 40
    low, high = found.range_percent
    assert np.nanmax(found.largest_move) <= high - low


def test_the_own_index_comes_first_and_its_recordings_are_as_they_were():
    study = replace(study_of(1), cocontraction=CocontractionSettings(index="minimum"))
    trials = trials_of(study, UNLIKE)
    (first, own), *others = by_index(study, trials)
    assert first == "minimum"
    assert all(a is b for a, b in zip(own, trials, strict=True))
    assert [name for name, _ in others] == ["sum", "rudolph", "falconer-winter"]


@pytest.mark.parametrize("participant", ["P01", ""])
def test_presets_are_of_one_person_or_of_the_mean_of_all(participant):
    study = study_of(2)
    assert index_presets(study, trials_of(study, UNLIKE), participant).participant == participant


def test_without_recordings_there_are_no_presets():
    assert index_presets(study_of(1), (), "") is None
