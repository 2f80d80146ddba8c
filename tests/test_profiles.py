"""Mean trends, the new specimen and leaving one out, on fits whose truth is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.errors import DataError, InputError
from emg2vsa.exemplary import Choice, compare_participants
from emg2vsa.fits import Fits
from emg2vsa.profiles import Profiles, build_profiles
from emg2vsa.settings import ProfileSettings, WindowSettings

STIFFNESS = {"S1": 7.63, "S2": 5.32, "S3": 3.35, "S4": 3.12, "S5": 1.11}
Row = tuple[str, str, float, float]


def fits_of(rows: Sequence[Row], verdict: str | Sequence[str] = "ok") -> Fits:
    """Fits with only what profiles use: (participant, specimen, a, b) per trial."""
    n = len(rows)
    participant, specimen, a, b = zip(*rows, strict=True)
    blank = np.full(n, np.nan)
    return Fits(
        participant=np.array(participant), specimen=np.array(specimen), repetition=np.arange(1, n + 1),
        verdict=np.broadcast_to(np.array(verdict, dtype="<U8"), n), reason=np.full(n, ""), start_s=blank,
        visit=np.full(n, ""),
        a_v=np.array(a, dtype=float), b_v=np.array(b, dtype=float), a_se_v=blank, b_se_v=blank, b_lo_v=blank,
        b_hi_v=blank, n_points=np.full(n, 22), adj_r2=blank, r2_bins=blank, adj_r2_bins=blank, r2_samples=blank,
        adj_r2_samples=blank, n_effective=blank, lag1=blank, b_bias=blank, b_bias_se=blank,
        b_corrected=blank, cause=np.full(n, ""), v_min_v=blank, v_max_v=blank,
        bin_edges_n=np.array([0.5, 7.0]), bin_force_n=np.full((n, 1), np.nan), bin_v=np.full((n, 1), np.nan),
        activity_unit="V", points="bins", weights="none", confidence=0.95,
    )  # fmt: skip


def build(fits: Fits, use: str = "ok+doubtful", stiffness: dict[str, float] | None = None, **profile: Any) -> Profiles:
    how = stiffness or STIFFNESS, ProfileSettings(**profile), WindowSettings(), use
    return build_profiles(fits, *how, compare_participants(fits, *how))


def compared(fits: Fits, **profile: Any) -> Choice | None:
    return compare_participants(fits, STIFFNESS, ProfileSettings(**profile), WindowSettings(), "ok+doubtful")


def one_person(noise: float = 0.0) -> Fits:
    """Five specimens, four trials each, a and b proportional to stiffness."""
    rng = np.random.default_rng(7)
    rows = [
        ("P1", name, 5 * k + noise * rng.normal(), 2 * k + noise * rng.normal())
        for name, k in STIFFNESS.items()
        for _ in range(4)
    ]
    return fits_of(rows)


def test_profile_of_one_participant_is_the_mean_of_its_curves() -> None:
    fits = fits_of([("P1", "S1", 1, 3), ("P1", "S1", 2, 7), ("P2", "S1", 100, 100)])
    (profile,) = build(fits, participant="P1", grid_points=11).profiles
    force = np.linspace(0.5, 7, 11)
    curves = np.array([1 + 3 * np.log(force), 2 + 7 * np.log(force)])
    np.testing.assert_array_equal(profile.force_n, force)
    np.testing.assert_allclose(profile.v, curves.mean(axis=0), rtol=1e-15, atol=1e-15)
    np.testing.assert_allclose(profile.sd_v, curves.std(axis=0, ddof=1), rtol=1e-14)
    assert (profile.a_v, profile.b_v, profile.n_trials, profile.source) == (1.5, 5, 2, "measured")


def test_all_participants_weigh_the_same_whatever_their_number_of_trials() -> None:
    fits = fits_of([("P1", "S1", 1, 1), ("P1", "S1", 1, 3), ("P1", "S1", 1, 5), ("P2", "S1", 4, 9)])
    profiles = build(fits, grid_points=2)
    (profile,) = profiles.profiles
    assert (profile.a_v, profile.b_v, profile.n_trials) == (2.5, 6, 4)
    curves = np.array([1 + 3 * np.log([0.5, 7]), 4 + 9 * np.log([0.5, 7])])
    np.testing.assert_allclose(profile.sd_v, curves.std(axis=0, ddof=1), rtol=1e-14)
    assert profiles.participant == ""


def test_only_participant_counts_as_the_exemplary_one() -> None:
    profiles = build(one_person(0.1), grid_points=5)
    assert profiles.participant == "P1"
    assert np.all(profiles.profiles[0].sd_v > 0)


def test_a_single_trial_has_no_spread() -> None:
    assert np.all(np.isnan(build(fits_of([("P1", "S1", 1, 1)])).profiles[0].sd_v))


def test_trials_that_are_not_used_do_not_count() -> None:
    rows = [("P1", "S1", 1, 1), ("P1", "S1", 3, 3), ("P1", "S1", 50, 50), ("P1", "S1", math.nan, math.nan)]
    fits = fits_of(rows, ["ok", "doubtful", "rejected", "ok"])
    assert (build(fits).profiles[0].a_v, build(fits).profiles[0].n_trials) == (2, 2)
    assert (build(fits, use="ok").profiles[0].a_v, build(fits, use="ok").profiles[0].n_trials) == (1, 1)


def test_specimens_come_in_the_order_asked_for() -> None:
    fits = one_person()
    assert [p.specimen for p in build(fits, specimens=("S5", "S1")).profiles] == ["S5", "S1"]
    shuffled = fits_of([("P1", name, 1, 1) for name in ("S3", "Sx", "S5", "S1")])
    assert [p.specimen for p in build(shuffled).profiles] == ["S1", "S3", "S5", "Sx"]
    assert math.isnan(build(shuffled).profiles[-1].stiffness_n_per_mm)
    assert any("Sx" in note for note in build(shuffled).notes)


def test_the_paper_specimen() -> None:
    fits = one_person()
    kept = ("S1", "S3", "S5")
    bracket = build(fits, specimens=kept, new_specimen="S_new", new_stiffness_n_per_mm=5.32)
    assert bracket.bracket == ("S1", "S3")
    assert bracket.weight_alpha == pytest.approx(0.5397, abs=5e-5)
    assert bracket.new is not None
    assert (bracket.new.source, bracket.new.n_trials) == ("interpolated", 8)
    # a and b are proportional to stiffness here, so a blend linear in stiffness is exact
    assert bracket.new.b_v == pytest.approx(2 * 5.32, rel=1e-14)
    paper = build(fits, specimens=kept, new_specimen="S_new", new_stiffness_n_per_mm=5.32, interpolation="paper")
    assert paper.weight_alpha == 0.532
    assert paper.new is not None
    s1, s3 = paper.profiles[0], paper.profiles[1]
    np.testing.assert_allclose(paper.new.v, (1 - 0.532) * s1.v + 0.532 * s3.v, rtol=1e-13)


@pytest.mark.parametrize(("k", "bracket_weight", "implied"), [(7.0, 0.147, 4.634), (4.0, 0.848, 5.918)])
def test_the_paper_weight_inverts_the_order_elsewhere(k: float, bracket_weight: float, implied: float) -> None:
    asked: dict[str, Any] = {"specimens": ("S1", "S3"), "new_specimen": "n", "new_stiffness_n_per_mm": k}
    assert build(one_person(), **asked).weight_alpha == pytest.approx(bracket_weight, abs=6e-4)
    paper = build(one_person(), interpolation="paper", **asked).new
    assert paper is not None
    assert paper.b_v / 2 == pytest.approx(implied, abs=5e-4)  # b = 2 kappa in these fits


def test_new_against_the_measured_specimen_of_equal_stiffness() -> None:
    profiles = build(one_person(0.3), specimens=("S1", "S3"), new_specimen="S_new", new_stiffness_n_per_mm=5.32)
    assert profiles.new is not None
    assert profiles.new_measured is not None
    assert profiles.new_error is not None
    assert profiles.new_measured.specimen == "S2"
    difference = profiles.new.v - profiles.new_measured.v
    assert profiles.new_error.rmse_v == pytest.approx(np.sqrt(np.mean(difference**2)), rel=1e-12)
    assert profiles.new_error.rmse_v > 0


def test_a_measured_specimen_has_no_part_in_its_own_prediction() -> None:
    fits = one_person(0.3)
    asked = build(fits, new_specimen="S2")
    assert asked.bracket == ("S1", "S3")
    assert asked.new_measured is not None
    assert asked.new_measured.specimen == "S2"
    (left_out,) = (one for one in asked.leave_one_out if one.specimen == "S2")
    assert asked.new_error == left_out


@pytest.mark.parametrize("method", ["bracket", "log-stiffness", "coefficients"])
@pytest.mark.parametrize("twin", ["S1", "S3", "S5"])
def test_interpolation_is_exact_at_measured_specimens(method: str, twin: str) -> None:
    profiles = build(
        one_person(0.5), specimens=("S1", "S3", "S5"), new_specimen="new", new_stiffness_n_per_mm=STIFFNESS[twin],
        interpolation=method,
    )  # fmt: skip
    (measured,) = (p for p in profiles.profiles if p.specimen == twin)
    assert profiles.new is not None
    np.testing.assert_allclose(profiles.new.v, measured.v, rtol=1e-14 if method == "coefficients" else 0)
    np.testing.assert_array_equal(profiles.new.sd_v, measured.sd_v)


@given(k=st.floats(1.11, 7.63), method=st.sampled_from(["bracket", "log-stiffness", "coefficients"]))
def test_interpolated_coefficients_stay_between_their_neighbours(k: float, method: str) -> None:
    profiles = build(one_person(0.2), new_specimen="new", new_stiffness_n_per_mm=k, interpolation=method)
    assert profiles.bracket is not None
    assert profiles.new is not None
    pair = {p.specimen: p for p in profiles.profiles if p.specimen in profiles.bracket}
    stiffer, softer = (pair[name] for name in profiles.bracket)
    assert softer.stiffness_n_per_mm <= k <= stiffer.stiffness_n_per_mm
    low, high = sorted((softer.b_v, stiffer.b_v))
    assert low - 1e-12 <= profiles.new.b_v <= high + 1e-12


def test_log_stiffness_weight() -> None:
    profiles = build(
        one_person(), specimens=("S1", "S3"), new_specimen="n", new_stiffness_n_per_mm=math.sqrt(7.63 * 3.35),
        interpolation="log-stiffness",
    )  # fmt: skip
    assert profiles.weight_alpha == pytest.approx(0.5, rel=1e-14)


def test_coefficients_use_every_specimen() -> None:
    rows = [("P1", name, k**2, k**2) for name, k in STIFFNESS.items()]
    asked: dict[str, Any] = {"new_specimen": "n", "new_stiffness_n_per_mm": 5.0, "specimens": ("S1", "S3", "S5")}
    cubic = build(fits_of(rows), interpolation="coefficients", **asked)
    line = build(fits_of(rows), **asked)
    assert cubic.new is not None
    assert line.new is not None
    assert abs(cubic.new.b_v - 25) < abs(line.new.b_v - 25)
    assert math.isnan(cubic.weight_alpha)
    assert cubic.new.n_trials == 3


@pytest.mark.parametrize("method", ["bracket", "paper", "log-stiffness", "coefficients"])
@pytest.mark.parametrize("k", [1.0, 8.0])
def test_extrapolation_is_refused(method: str, k: float) -> None:
    with pytest.raises(InputError, match=r"between 1.11 and 7.63 N/mm"):
        build(one_person(), new_specimen="n", new_stiffness_n_per_mm=k, interpolation=method)


@pytest.mark.parametrize("method", ["bracket", "coefficients"])
def test_extrapolation_on_request_follows_the_nearest_line(method: str) -> None:
    profiles = build(one_person(), new_specimen="n", new_stiffness_n_per_mm=9.0, interpolation=method, extrapolate=True)
    assert profiles.new is not None
    assert profiles.bracket == ("S1", "S2")
    assert profiles.new.b_v == pytest.approx(18, rel=1e-12)
    assert profiles.weight_alpha < 0
    assert [one.specimen for one in profiles.leave_one_out] == list(STIFFNESS)


def test_the_paper_weight_ends_at_its_range() -> None:
    stiffness = {"S1": 20.0, "S3": 2.0}
    with pytest.raises(InputError, match="at most 10 N/mm"):
        build(
            fits_of([("P1", "S1", 1, 1), ("P1", "S3", 2, 2)]), stiffness=stiffness, new_specimen="n",
            new_stiffness_n_per_mm=12.0, interpolation="paper",
        )  # fmt: skip


def test_leaving_one_out_of_a_linear_law_is_free_of_error() -> None:
    left_out = build(one_person(), specimens=("S1", "S3")).leave_one_out
    assert [(one.specimen, one.bracket) for one in left_out] == [
        ("S2", ("S1", "S3")), ("S3", ("S2", "S4")), ("S4", ("S3", "S5")),
    ]  # fmt: skip
    assert all(one.rmse_v < 1e-13 for one in left_out)


def test_leave_one_out_error_by_hand() -> None:
    fits = fits_of([("P1", "S1", 10, 4), ("P1", "S2", 5, 2), ("P1", "S3", 0, 0)])
    (one,) = build(fits, stiffness={"S1": 4.0, "S2": 3.0, "S3": 0.5}, grid_points=50).leave_one_out
    force = np.linspace(0.5, 7, 50)
    alpha = (4 - 3) / (4 - 0.5)
    error = (1 - alpha) * (10 + 4 * np.log(force)) - (5 + 2 * np.log(force))
    assert one.rmse_v == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
    assert one.relative == pytest.approx(one.rmse_v / np.sqrt(np.mean((5 + 2 * np.log(force)) ** 2)), rel=1e-12)


def test_what_the_paper_weight_cannot_reach_is_not_left_out() -> None:
    stiffness = {"S1": 30.0, "S2": 12.0, "S3": 6.0, "S4": 2.0}
    fits = fits_of([("P1", name, k, k) for name, k in stiffness.items()])
    assert [one.specimen for one in build(fits, stiffness=stiffness, interpolation="paper").leave_one_out] == ["S3"]


@pytest.mark.parametrize(
    ("profile", "note"),
    [
        ({}, "n (5.32 N/mm) = 0.4603 S1 + 0.5397 S3 (bracket)."),
        ({"interpolation": "paper"}, "n (5.32 N/mm) = 0.4680 S1 + 0.5320 S3 (paper)."),
        ({"interpolation": "coefficients"}, "n (5.32 N/mm) lies on monotone cubics"),
        ({"new_stiffness_n_per_mm": 8.0, "extrapolate": True}, "extrapolated, as asked for."),
    ],
)
def test_the_blend_is_stated(profile: dict[str, Any], note: str) -> None:
    asked: dict[str, Any] = {"specimens": ("S1", "S3"), "new_specimen": "n", "new_stiffness_n_per_mm": 5.32} | profile
    assert note in build(one_person(), **asked).notes[-1]


def test_the_ends_are_named_as_extrapolation() -> None:
    assert any("S1 and S5 are not left out" in note for note in build(one_person()).notes)


@pytest.mark.parametrize(
    ("profile", "complaint"),
    [
        ({"participant": "P9"}, r"one of P1 .*found P9"),
        ({"specimens": ("S1", "S9")}, r"usable trials by P1: S1, .*found S9"),
        ({"new_specimen": "n"}, "the stiffness of n"),
        ({"specimens": ("S1",), "new_specimen": "n", "new_stiffness_n_per_mm": 2.0}, "two specimens of known"),
    ],
)
def test_what_cannot_be_made_is_said(profile: dict[str, Any], complaint: str) -> None:
    with pytest.raises(DataError, match=complaint):
        build(one_person(), **profile)


def test_no_usable_trial() -> None:
    with pytest.raises(DataError, match="at least one usable trial"):
        build(fits_of([("P1", "S1", 1, 1)], "rejected"))


def test_scaling_the_activity_scales_everything() -> None:
    fits = one_person(0.2)
    scaled = fits_of(
        [(p, s, 8 * a, 8 * b) for p, s, a, b in zip(fits.participant, fits.specimen, fits.a_v, fits.b_v, strict=True)]
    )
    one, other = (build(f, new_specimen="n", new_stiffness_n_per_mm=6.0) for f in (fits, scaled))
    assert one.new is not None
    assert other.new is not None
    np.testing.assert_array_equal(other.new.v, 8 * one.new.v)
    for first, second in zip(one.leave_one_out, other.leave_one_out, strict=True):
        assert (second.rmse_v, second.relative) == (8 * first.rmse_v, first.relative)


def people(levels: dict[str, tuple[float, float]]) -> Fits:
    """Participants who press S1 and S5: (a, b) on S1, and half of both on S5."""
    return fits_of([(who, s, k * a, k * b) for who, (a, b) in levels.items() for s, k in (("S1", 1.0), ("S5", 0.5))])


def shares(a: float, b: float, force: np.ndarray) -> np.ndarray:
    """Schedules of such a participant from 0 to 1, written anew."""
    v = np.concatenate([a + b * np.log(force), (a + b * np.log(force)) / 2])
    return (v - v.min()) / (v.max() - v.min())


def test_the_medoid_is_the_participant_whose_schedules_are_nearest_to_all_others() -> None:
    levels = {"P1": (10.0, 1.0), "P2": (10.0, 3.0), "P3": (10.0, 4.0), "P4": (10.0, 9.0)}
    profiles = build(people(levels), participant="medoid", grid_points=50)
    choice = compared(people(levels), participant="medoid", grid_points=50)
    assert choice is not None
    force = np.linspace(0.5, 7, 50)
    own = np.array([shares(a, b, force) for a, b in levels.values()])
    apart = np.array([[np.sqrt(np.mean((p - q) ** 2)) for q in own] for p in own])
    np.testing.assert_allclose(choice.to_others, apart.sum(axis=1) / 3, rtol=1e-12)
    used = int(np.argmin(apart.sum(axis=1)))
    assert profiles.participant == choice.medoid == list(levels)[used] == "P2"
    np.testing.assert_allclose(choice.to_used, apart[used], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(choice.largest, np.abs(own - own[used]).max(axis=1), rtol=1e-12, atol=1e-15)


@given(st.floats(0.01, 100.0))
def test_amplitudes_of_emg_do_not_choose_the_medoid(gain: float) -> None:
    levels = {"P1": (10.0, 1.0), "P2": (10.0, 3.0), "P3": (10.0, 4.0), "P4": (10.0, 9.0)}
    amplified = levels | {"P4": (10 * gain, 9 * gain)}
    plain, loud = (compared(people(each), participant="medoid", grid_points=9) for each in (levels, amplified))
    assert plain is not None
    assert loud is not None
    np.testing.assert_allclose(plain.to_others, loud.to_others, rtol=1e-9)


def test_who_did_not_press_every_specimen_is_no_medoid_and_is_named() -> None:
    fits = people({"P1": (10.0, 1.0), "P2": (10.0, 3.0), "P3": (10.0, 4.0)})
    keep = [k for k in range(6) if k != 3]
    rows = [(str(fits.participant[k]), str(fits.specimen[k]), float(fits.a_v[k]), float(fits.b_v[k])) for k in keep]
    choice = compared(fits_of(rows), participant="medoid")
    assert choice is not None
    assert (choice.participants, choice.left_out) == (("P1", "P3"), ("P2",))
    assert build(fits_of(rows), participant="medoid").participant == "P1"  # of two the first
    with pytest.raises(DataError, match=r"two participants or more .* but found fewer"):
        build(fits_of(rows[1:4]), participant="medoid")


def test_the_distance_to_the_mean_over_all_where_no_participant_is_chosen() -> None:
    choice = compared(people({"P1": (10.0, 1.0), "P2": (10.0, 3.0)}), grid_points=50)
    assert choice is not None
    force = np.linspace(0.5, 7, 50)
    expected = np.sqrt(np.mean((shares(10, 1, force) - shares(10, 2, force)) ** 2))
    assert choice.to_used[0] == pytest.approx(expected, rel=1e-12)
    assert compared(one_person()) is None


def test_the_new_specimen_by_both_rules() -> None:
    fits = one_person()
    made = build(fits, specimens=("S1", "S3", "S5"), new_specimen="new", new_stiffness_n_per_mm=5.32).by_rule
    assert [each.rule for each in made] == ["bracket", "paper"]
    assert [each.alpha for each in made] == pytest.approx([(7.63 - 5.32) / (7.63 - 3.35), 0.532])
    errors = [each.error for each in made]
    assert errors[0] is not None
    assert errors[1] is not None
    assert errors[0].rmse_v < 1e-12 < errors[1].rmse_v  # a and b are proportional to stiffness, and S2 is as stiff
    stiff = build(fits, stiffness={"S1": 12.0, "S3": 10.5}, new_specimen="new", new_stiffness_n_per_mm=11.0)
    assert [each.rule for each in stiff.by_rule] == ["bracket"]
