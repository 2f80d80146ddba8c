"""The interpolated profile of every person is the one that ``build_profiles`` gives of that person alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.profiles import build_profiles, by_person
from emg2vsa.settings import ProfileSettings, WindowSettings
from tests.test_profiles import STIFFNESS, Row, fits_of

NEW = ProfileSettings(specimens=("S1", "S3", "S5"), new_specimen="S_new", new_stiffness_n_per_mm=5.32)
RNG = np.random.default_rng(3)
ROWS = [
    (who, name, level * (5 * k + RNG.normal()), level * (2 * k + RNG.normal()))
    for who, level in (("P1", 1.0), ("P2", 3.0), ("P3", 0.5))
    for name, k in STIFFNESS.items()
    for _ in range(4)
]
FORCE_N = np.array([0.5, 7.0])


@pytest.mark.parametrize("rule", ["bracket", "paper", "log-stiffness", "coefficients"])
def test_each_person_has_the_profile_of_the_study_of_that_person_alone(rule: str) -> None:
    settings = replace(NEW, interpolation=rule)
    found = by_person(fits_of(ROWS), STIFFNESS, settings, "ok+doubtful")
    assert found is not None
    assert (found.participants, found.measured_as, found.bracket) == (("P1", "P2", "P3"), "S2", ("S1", "S3"))
    for i, who in enumerate(found.participants):
        alone = build_profiles(
            fits_of(ROWS), STIFFNESS, replace(settings, participant=who), WindowSettings(), "ok+doubtful"
        )
        assert alone.new is not None
        assert alone.new_measured is not None
        np.testing.assert_allclose(found.interpolated[i], [alone.new.a_v, alone.new.b_v], rtol=1e-13)
        ends = alone.new.v[[0, -1]] - alone.new_measured.v[[0, -1]]
        np.testing.assert_allclose(found.error_v(FORCE_N)[i], ends, rtol=1e-12)
        np.testing.assert_allclose(found.level_v(FORCE_N)[i], alone.new_measured.v[[0, -1]], rtol=1e-12)
        stiffer, softer = (next(p for p in alone.profiles if p.specimen == name) for name in found.bracket)
        np.testing.assert_allclose(found.neighbours_v(FORCE_N)[i], (stiffer.v - softer.v)[[0, -1]], rtol=1e-12)


def test_only_people_who_pressed_every_specimen_that_is_needed_count() -> None:
    without = [row for row in ROWS if row[:2] not in {("P2", "S2"), ("P3", "S5")}]
    found = by_person(fits_of(without), STIFFNESS, NEW, "ok+doubtful")
    assert found is not None
    assert found.participants == ("P1",)


@pytest.mark.parametrize(
    ("settings", "rows"),
    [
        (replace(NEW, new_specimen=None), ROWS),
        (replace(NEW, specimens=()), ROWS),  # S2 has a part in the interpolation, and is no test of it
        (NEW, [row for row in ROWS if row[1] != "S2"]),
        (replace(NEW, new_stiffness_n_per_mm=20.0), ROWS),
        (replace(NEW, new_specimen="S1", new_stiffness_n_per_mm=20.0), ROWS),
    ],
    ids=["no new specimen", "equal is used", "equal not pressed", "no equal", "extrapolation"],
)
def test_none_where_there_is_nothing_to_compare(settings: ProfileSettings, rows: list[Row]) -> None:
    assert by_person(fits_of(rows), STIFFNESS, settings, "ok+doubtful") is None
