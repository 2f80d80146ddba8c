"""Curves compared at every force: the error rate of the whole, what the numbers are, and what must not change them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from emg2vsa.errors import DataError
from emg2vsa.statistics.repeated import paired_tests, rm_anova
from emg2vsa.statistics.whole_curve import FEWEST_FOR_BANDS, CurveTests, Threshold, curve_tests

DRAWS = 499


def people(n: int, specimens: int = 4, forces: int = 12, seed: int = 0, memory: float = 0.9) -> np.ndarray:
    """Curves (n, S, G) that do not differ but by noise with memory along force, and a level of each person."""
    rng = np.random.default_rng(seed)
    lag = np.abs(np.subtract.outer(np.arange(forces), np.arange(forces)))
    noise = rng.standard_normal((n, specimens, forces)) @ np.linalg.cholesky(memory**lag).T
    return 20 + 5 * rng.standard_normal((n, 1, 1)) + noise


def numbers(found: CurveTests) -> dict[str, np.ndarray]:
    names = ("mean", "half_width", "f", "p", "pair_difference", "pair_half_width", "pair_t", "pair_p")
    return {name: getattr(found, name) for name in names}


def test_statistics_are_those_of_one_force_at_a_time() -> None:
    y = people(7)
    found = curve_tests(y, draws=DRAWS)
    np.testing.assert_allclose(found.f, rm_anova(y.transpose(2, 0, 1)).f, rtol=1e-12)
    for force in range(12):
        paired = paired_tests(y[:, :, force]).t
        np.testing.assert_allclose(found.pair_t[:, force], paired.statistic[0], rtol=1e-9)
        np.testing.assert_allclose(found.pair_difference[:, force], paired.difference[0], rtol=1e-9)
    np.testing.assert_allclose(found.mean, y.mean(axis=0))


def test_one_force_and_one_pair_have_the_p_of_students_t() -> None:
    y = people(6, 2, 1, seed=3)
    found = curve_tests(y, draws=40_000)
    p = stats.ttest_rel(y[:, 0, 0], y[:, 1, 0]).pvalue
    assert found.pair_p[0, 0] == pytest.approx(p, abs=4 * np.sqrt(p * (1 - p) / 40_000))
    assert found.p[0] == pytest.approx(p, abs=4 * np.sqrt(p * (1 - p) / 40_000))
    critical = stats.t.ppf(0.975, 5)
    assert found.t_threshold.value == pytest.approx(critical, rel=0.03)
    assert found.t_threshold.low < critical < found.t_threshold.high


def test_a_random_direction_does_what_a_random_rotation_does() -> None:
    """The largest F and t of whole tables, each person's row replaced by a random mix of all rows."""
    y = people(5, 3, 6, seed=1)
    own = y - y.mean(axis=1, keepdims=True)
    found = curve_tests(y, draws=4000)
    rng, largest = np.random.default_rng(8), []
    for _ in range(1500):
        rotation = stats.ortho_group.rvs(5, random_state=rng)
        rotated = np.einsum("ij,jkl->ikl", rotation, own)
        t = [stats.ttest_rel(rotated[:, i], rotated[:, j]).statistic for i, j in itertools.combinations(range(3), 2)]
        largest.append([np.max(rm_anova(rotated.transpose(2, 0, 1)).f), np.max(np.abs(t))])
    beyond = np.mean(np.array(largest) > [found.f_threshold.value, found.t_threshold.value], axis=0)
    assert beyond[0] == pytest.approx(0.05, abs=4 * np.sqrt(0.05 * 0.95 / 1500))
    assert beyond[1] <= 0.05 + 4 * np.sqrt(0.05 * 0.95 / 1500)  # a pair has to pass the threshold of bands too


def test_it_agrees_with_all_patterns_of_signs_where_people_are_many_enough_for_them() -> None:
    signs = np.array(list(itertools.product((1.0, -1.0), repeat=11)))
    w = np.hstack([np.ones((len(signs), 1)), signs]) / np.sqrt(12)
    p = []
    for seed in range(12):
        y = people(12, 3, 8, seed=seed)
        y[:, 2] += 0.08 * seed
        own = y - y.mean(axis=1, keepdims=True)
        z = np.einsum("bp,psg->bsg", w, own)
        share = np.max(np.sum(z**2, axis=1) / np.sum(own**2, axis=(0, 1)), axis=1)
        p.append((np.min(curve_tests(y, draws=4000).p), np.mean(share >= share[0] - 1e-12)))
    ours, by_signs = np.array(p).T
    assert by_signs.min() < 0.05 < 0.5 < by_signs.max()
    np.testing.assert_allclose(ours, by_signs, atol=0.05)


@pytest.mark.parametrize("n", [3, 5, 14])
def test_a_study_without_differences_finds_one_in_five_of_a_hundred(n: int) -> None:
    studies = 600
    spread = np.linspace(1, 4, 4)[:, None] * np.linspace(0.5, 2, 12)
    rejected = np.zeros(2)
    for seed in range(studies):
        found = curve_tests((people(n, seed=seed) - 20) * spread, draws=199, seed=seed)
        rejected += [np.any(found.p <= 0.05), np.any(found.pair_p <= 0.05)]
    margin = 3.5 * np.sqrt(0.05 * 0.95 / studies)
    assert rejected[0] / studies == pytest.approx(0.05, abs=margin)
    assert 0.02 < rejected[1] / studies < 0.05 + margin


def test_bands_hold_true_differences_also_where_these_are_large() -> None:
    held, studies = np.zeros(2), 300
    true = 30.0 * np.arange(4)[:, None] * np.ones(12)
    for seed in range(studies):
        y = people(6, seed=seed) + true
        found = curve_tests(y, draws=199, seed=seed)
        off = found.pair_difference - (true[found.first] - true[found.second])
        held[0] += np.all(np.abs(off) <= found.pair_half_width)
        off = found.mean - found.mean.mean(axis=0) - (true - true.mean(axis=0))
        held[1] += np.all(np.abs(off) <= found.half_width)
    assert np.all(held / studies > 0.95 - 3.5 * np.sqrt(0.05 * 0.95 / studies))


def test_a_planted_difference_is_found_there_and_only_there() -> None:
    y = people(14, 4, 20, seed=2, memory=0.5)
    y[:, 1, 6:11] += 6.0
    found = curve_tests(y)
    clusters = found.clusters()
    of_all, *pairs = clusters
    assert (of_all.pair, of_all.start, of_all.stop) == (-1, 6, 11)
    assert 6 <= of_all.at < 11
    assert of_all.largest == pytest.approx(found.f[of_all.at])
    assert of_all.p == found.p[of_all.at] == 1 / 10_000
    ends = {(int(found.first[each.pair]), int(found.second[each.pair])): (each.start, each.stop) for each in pairs}
    assert ends == {(0, 1): (6, 11), (1, 2): (6, 11), (1, 3): (6, 11)}


def test_bands_of_pairs_exclude_zero_exactly_where_pairs_differ() -> None:
    y = people(9, seed=4)
    y[:, 3, 4:] -= 1.5
    found = curve_tests(y, draws=DRAWS)
    beyond = np.abs(found.pair_difference) > found.pair_half_width
    assert beyond.any()
    np.testing.assert_array_equal(beyond, found.pair_p <= 0.05)
    np.testing.assert_array_equal(found.f > found.f_threshold.value, found.p <= 0.05)


def test_a_range_ends_where_the_difference_changes_its_sign_and_where_a_force_is_left_out() -> None:
    y = people(8, 2, 9, seed=6) + 0.0
    y[:, 1] += 40.0 * np.array([1, 1, 1, -1, -1, -1, -1, -1, -1])
    y[2, 0, 7] = np.nan
    found = curve_tests(y, draws=DRAWS)
    assert found.forces.tolist() == [0, 1, 2, 3, 4, 5, 6, 8]
    assert [(each.start, each.stop) for each in found.clusters() if each.pair < 0] == [(0, 7), (8, 9)]
    assert [(each.start, each.stop) for each in found.clusters() if each.pair == 0] == [(0, 3), (3, 7), (8, 9)]


@given(st.integers(0, 2**32 - 1), st.integers(-30, 30), st.floats(-1e3, 1e3))
@settings(max_examples=15, deadline=None)
def test_units_origin_and_orders_change_nothing(seed: int, power: int, shift: float) -> None:
    rng = np.random.default_rng(seed)
    y = people(6, 3, 5, seed=seed)
    wanted = curve_tests(y, draws=DRAWS)
    scale = 2.0**power
    for other, unit in ((y[rng.permutation(6)], 1.0), (y * scale, scale), (y * 1e-9, 1e-9), (y * 1e9, 1e9)):
        found = numbers(curve_tests(other, draws=DRAWS))
        for name, value in numbers(wanted).items():
            times = unit if "difference" in name or "half" in name or name == "mean" else 1.0
            np.testing.assert_allclose(found[name], value * times, rtol=1e-6, err_msg=name)
    found = curve_tests(y + shift * rng.standard_normal((6, 1, 1)), draws=DRAWS)
    np.testing.assert_allclose(found.f, wanted.f, rtol=1e-6)
    np.testing.assert_allclose(found.p, wanted.p, atol=1e-9)
    order = rng.permutation(3)
    found = curve_tests(y[:, order], draws=DRAWS)
    np.testing.assert_allclose(found.p, wanted.p, atol=1e-9)
    np.testing.assert_allclose(found.half_width, wanted.half_width[order], rtol=1e-6)
    assert found.t_threshold.value == pytest.approx(wanted.t_threshold.value, rel=1e-6)


@pytest.mark.parametrize(
    ("shape", "why"),
    [
        ((0, 0, 0), "the test takes 2 specimens with curves of half of the people or more, and found 0"),
        ((0, 5, 4), "the test takes 2 specimens with curves of half of the people or more, and found 0"),
        ((4, 3, 0), "the test takes 2 specimens with curves of half of the people or more, and found 0"),
        ((6, 1, 5), "the test takes 2 specimens with curves of half of the people or more, and found 1"),
        ((2, 5, 22), "the test takes 3 people with curves of every specimen, and found 2"),
    ],
)
def test_a_table_that_is_too_small_is_not_compared_and_says_why(shape: tuple[int, int, int], why: str) -> None:
    found = curve_tests(np.ones(shape))
    assert found.why == why
    assert found.clusters() == []
    assert found.people.size == found.specimens.size == found.forces.size == found.f.size == found.pair_t.size == 0
    assert np.isnan(found.f_threshold.value)


def test_three_people_are_tested_and_have_no_bands() -> None:
    y = people(3)
    y[:, 0] += 1000.0
    found = curve_tests(y)
    assert found.clusters()
    assert np.isnan(found.half_width).all()
    assert np.isnan(found.pair_half_width).all()
    assert np.isfinite(curve_tests(people(FEWEST_FOR_BANDS)).pair_half_width).all()


def test_people_specimens_and_forces_that_lack_data_are_left_out() -> None:
    y = people(10, 5, 12)
    y[3, 2] = np.nan  # a person without a specimen
    y[:6, 4] = np.nan  # a specimen that four of ten pressed
    y[5, :, 11] = np.nan  # a force that one person did not reach
    y[7, 1, 2:] = np.nan  # a press that broke off
    y[8, 0, 0] = np.nan
    found = curve_tests(y, draws=DRAWS)
    assert found.people.tolist() == [0, 1, 2, 4, 5, 6, 8, 9]
    assert found.specimens.tolist() == [0, 1, 2, 3]
    assert found.forces.tolist() == list(range(1, 11))
    wanted = curve_tests(y[np.ix_(found.people, found.specimens, found.forces)], draws=DRAWS)
    for name, value in numbers(wanted).items():
        np.testing.assert_array_equal(numbers(found)[name], value)


def test_curves_that_do_not_scatter_are_not_tested_or_differ_in_every_person() -> None:
    same = curve_tests(np.broadcast_to(people(1)[:, :1], (5, 3, 12)), draws=DRAWS)
    assert np.isnan(same.f).all()
    assert np.isnan(same.pair_t).all()
    assert same.clusters() == []
    y = np.broadcast_to(people(1)[:, :1], (5, 2, 12)) + np.array([0.0, 0.1])[:, None]
    by_the_same = curve_tests(y, draws=DRAWS)
    assert np.isinf(by_the_same.f).all()
    assert (by_the_same.pair_t == -np.inf).all()
    assert [(each.start, each.stop) for each in by_the_same.clusters()] == [(0, 12)] * 2
    assert (by_the_same.pair_half_width == 0).all()


def test_ties_and_few_values_have_a_p() -> None:
    y = np.random.default_rng(0).integers(0, 3, (6, 3, 8)).astype(float)
    found = curve_tests(y, draws=DRAWS)
    known = np.isfinite(found.f)
    assert np.all((found.p[known] > 0) & (found.p[known] <= 1))
    order = np.argsort(found.f[known])
    assert np.all(np.diff(found.p[known][order]) <= 0)


def test_an_alpha_below_one_direction_finds_nothing() -> None:
    y = people(6)
    y[:, 0] += 1e6
    found = curve_tests(y, alpha=1e-4, draws=DRAWS)
    assert found.f_threshold == Threshold(np.inf, np.inf, np.inf)
    assert found.clusters() == []


def test_a_table_of_another_shape_is_refused() -> None:
    with pytest.raises(DataError, match="shape \\(people, specimens, forces\\)"):
        curve_tests(np.ones((3, 4)))


def test_many_people_take_little_memory_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    y = people(20)
    whole = curve_tests(y, draws=DRAWS)
    monkeypatch.setattr("emg2vsa.statistics.whole_curve._AT_ONCE", 1000)
    np.testing.assert_allclose(curve_tests(y, draws=DRAWS).p, whole.p, atol=1e-12)
