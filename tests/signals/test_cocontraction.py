"""Indices of co-contraction against their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.errors import SettingError
from emg2vsa.settings import CocontractionSettings
from emg2vsa.signals.cocontraction import cocontraction_index

MUSCLES = ("EDC", "FDS")
LEVELS = np.array([[1.0, 4.0, 0.0, 0.0], [3.0, 2.0, 5.0, 0.0]])


@pytest.mark.parametrize(
    ("index", "expected", "unit"),
    [
        ("sum", [4, 6, 5, 0], "V"),
        ("minimum", [1, 2, 0, 0], "V"),
        ("rudolph", [4 / 3, 3, 0, 0], "V"),
        ("falconer-winter", [0.5, 2 / 3, 0, 0], "1"),
    ],
)
def test_definitions(index, expected, unit):
    activity, found_unit, _ = cocontraction_index(LEVELS, MUSCLES, CocontractionSettings(index=index))
    assert activity == pytest.approx(expected)
    assert found_unit == unit


@pytest.mark.parametrize("index", ["sum", "minimum", "rudolph", "falconer-winter"])
def test_order_of_muscles_does_not_matter(index):
    settings = CocontractionSettings(index=index)
    one, other = (cocontraction_index(levels, MUSCLES, settings)[0] for levels in (LEVELS, LEVELS[::-1]))
    assert np.array_equal(one, other)


def test_normalised_to_mvc_or_to_the_session():
    mvc = CocontractionSettings(normalise="mvc", mvc_v={"EDC": 2.0, "FDS": 10.0})
    activity, unit, notes = cocontraction_index(LEVELS, MUSCLES, mvc)
    assert activity == pytest.approx([0.8, 2.2, 0.5, 0.0])
    assert unit == "1"
    assert "MVC" in notes[0]
    session = CocontractionSettings(normalise="session-max")
    activity, unit, notes = cocontraction_index(LEVELS, MUSCLES, session, {"EDC": 4.0, "FDS": 20.0})
    assert activity == pytest.approx([0.4, 1.1, 0.25, 0.0])
    assert unit == "1"
    assert "session" in notes[0]
    activity, unit, _ = cocontraction_index(LEVELS, MUSCLES, session)
    assert unit == "V"
    assert np.array_equal(activity, LEVELS.sum(axis=0))


def test_what_cannot_be_is_refused():
    with pytest.raises(SettingError, match="FDS"):
        cocontraction_index(LEVELS, MUSCLES, CocontractionSettings(normalise="mvc", mvc_v={"EDC": 1.0}))
    for index in ("rudolph", "falconer-winter", "minimum"):
        with pytest.raises(SettingError, match=index):
            cocontraction_index(LEVELS[:1], MUSCLES[:1], CocontractionSettings(index=index))


def test_one_muscle_sums_to_itself():
    assert np.array_equal(cocontraction_index(LEVELS[:1], MUSCLES[:1], CocontractionSettings())[0], LEVELS[0])
