"""Profiles and schedules that follow monotone splines: the curves they follow, and the error without force bins."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from emg2vsa.errors import DataError
from emg2vsa.fits import Fits
from emg2vsa.profiles import Profiles, build_profiles
from emg2vsa.profiles.splines import cell_splines
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import ProfileSettings, ScheduleSettings, WindowSettings
from tests.test_profiles import STIFFNESS, fits_of

EDGES_N = np.append(np.arange(0.5, 6.9, 0.3), 7.0)
FORCE_N = np.sqrt(EDGES_N[1:] * EDGES_N[:-1])
WINDOW = WindowSettings()


def straight(force_n: np.ndarray, specimen: str) -> np.ndarray:
    return np.asarray(1e-6 * (5 + STIFFNESS[specimen] * force_n))


def logarithmic(force_n: np.ndarray, specimen: str) -> np.ndarray:
    return np.asarray(1e-6 * (20 + STIFFNESS[specimen] * np.log(force_n)))


def study(law=straight, people=("P1", "P2"), presses=3) -> Fits:  # type: ignore[no-untyped-def]
    """Of every person on every specimen, by the law times 1 for the first person, 2 for the second."""
    rows, bins = [], []
    for i, who in enumerate(people):
        for specimen in STIFFNESS:
            v = (i + 1) * law(FORCE_N, specimen)
            b, a = np.polyfit(np.log(FORCE_N), v, 1)
            rows += [(who, specimen, float(a), float(b))] * presses
            bins += [v] * presses
    force_n = np.broadcast_to(FORCE_N, (len(rows), FORCE_N.size))
    return dataclasses.replace(fits_of(rows), bin_edges_n=EDGES_N, bin_force_n=force_n, bin_v=np.array(bins))


def build(fits: Fits, **profile: object) -> Profiles:
    return build_profiles(fits, STIFFNESS, ProfileSettings(**profile), WINDOW, "ok")  # type: ignore[arg-type]


def test_a_profile_follows_the_points_and_weighs_people_alike() -> None:
    for profile in build(study(), curve="spline").profiles:
        np.testing.assert_allclose(profile.v, 1.5 * straight(profile.force_n, profile.specimen), rtol=0.01)
        assert profile.curve == "spline"
    one = build(study(), curve="spline", participant="P2").profiles[0]
    np.testing.assert_allclose(one.v, 2 * straight(one.force_n, one.specimen), rtol=0.01)


def test_the_default_is_the_logarithm_with_the_spline_beside() -> None:
    for profile in build(study()).profiles:
        np.testing.assert_array_equal(profile.v, profile.a_v + profile.b_v * np.log(profile.force_n))
        assert profile.curve == "log"
        np.testing.assert_allclose(
            profile.along("spline").v, 1.5 * straight(profile.force_n, profile.specimen), rtol=0.01
        )
        np.testing.assert_array_equal(profile.along("spline").along("log").v, profile.v)


@pytest.mark.parametrize("interpolation", ["bracket", "log-stiffness", "coefficients"])
def test_a_new_specimen_lies_between_splines(interpolation: str) -> None:
    found = build(
        study(), curve="spline", specimens=("S1", "S3", "S5"), new_specimen="new", interpolation=interpolation,
        new_stiffness_n_per_mm=STIFFNESS["S3"],
    ).new  # fmt: skip
    assert found is not None
    assert found.source == "interpolated"
    np.testing.assert_allclose(found.v, 1.5 * straight(found.force_n, "S3"), rtol=0.01)


def test_schedules_of_splines_are_the_means_of_the_true_curve_over_steps() -> None:
    made = {
        curve: build_schedules(build(study(), curve=curve), ScheduleSettings(conditions=("modular",)), {})
        for curve in ("log", "spline")
    }
    middle_n = (made["spline"][0].step_force_n[1:] + made["spline"][0].step_force_n[:-1]) / 2
    apart = 0.0
    for log, spline in zip(made["log"], made["spline"], strict=True):
        np.testing.assert_allclose(spline.activity_v, 1.5 * straight(middle_n, spline.specimen), rtol=0.01)
        assert spline.provenance["curve"] == "monotone spline"
        apart = max(apart, float(np.max(np.abs(spline.stiffness_percent - log.stiffness_percent))))
    assert apart > 3


def test_where_the_logarithm_holds_both_schedules_are_one() -> None:
    made = [
        build_schedules(build(study(logarithmic), curve=curve), ScheduleSettings(), {}) for curve in ("log", "spline")
    ]
    for log, spline in zip(*made, strict=True):
        np.testing.assert_allclose(spline.stiffness_percent, log.stiffness_percent, atol=1e-3)


def test_one_recording_at_a_time_gives_the_same() -> None:
    fits = study()
    splines = cell_splines(fits, "ok", WINDOW.force_n)
    nothing = np.empty((fits.verdict.size, 0))
    without = dataclasses.replace(fits, bin_force_n=nothing, bin_v=nothing)
    found = build_profiles(without, STIFFNESS, ProfileSettings(curve="spline"), WINDOW, "ok", None, splines)
    for one, other in zip(found.profiles, build(fits, curve="spline").profiles, strict=True):
        np.testing.assert_array_equal(one.v, other.v)


def test_without_force_bins_the_spline_is_refused_and_the_logarithm_made() -> None:
    fits = fits_of([("P1", "S1", 2e-5, 1e-5), ("P1", "S5", 1e-5, 4e-6)])
    assert build(fits).profiles[0].spline is None
    with pytest.raises(DataError) as caught:
        build(fits, curve="spline")
    assert caught.value.where == "profile.curve"
    assert "S1" in caught.value.wanted
    assert "log" in caught.value.do
