import numpy as np
import pytest
from scipy import stats

from emg2vsa.statistics.hierarchy import MOST_ALIKE, recording_means, shrunken
from emg2vsa.statistics.mixed_variances import mixed_residuals
from emg2vsa.statistics.reml import fit_reml

NONE = np.nan


def means(values, level=1.0, error=0.0):
    values = np.atleast_2d(np.array(values, dtype=float))
    return recording_means(values, np.full(len(values), level), np.full(len(values), error))


def test_one_recording_has_the_interval_of_student() -> None:
    values = np.array([3.0, 5.0, 4.0, 4.5, 3.5, NONE])
    found = means(values)
    there = values[:5]
    half = stats.t.ppf(0.975, 4) * there.std(ddof=1) / np.sqrt(5)
    assert (found.mean[0], found.half[0], found.count[0]) == pytest.approx((4.0, half, 5))
    assert (found.df, found.rho, found.sd) == pytest.approx((0.0, 0.0, there.std(ddof=1)))


def test_recordings_that_scatter_alike_share_all_degrees_of_freedom() -> None:
    rng = np.random.default_rng(1)
    level = rng.uniform(1, 4, 40)
    found = recording_means(level[:, None] * (1 + 0.1 * rng.standard_normal((40, 3))), level, np.zeros(40))
    assert found.df == np.inf
    half = stats.t.ppf(0.975, 80) * found.sd / np.sqrt(3)
    assert found.half / level == pytest.approx(np.full(40, half))
    assert found.sd == pytest.approx(0.1, rel=0.15)


def test_law_of_the_variances_is_found() -> None:
    rng = np.random.default_rng(2)
    sd = np.sqrt(0.04 * 8 / rng.chisquare(8, 4000))
    found = means(5 + sd[:, None] * rng.standard_normal((4000, 4)))
    assert found.df == pytest.approx(8, rel=0.15)
    assert found.sd == pytest.approx(0.2, rel=0.02)


def test_a_recording_that_scatters_more_has_a_wider_interval() -> None:
    rng = np.random.default_rng(3)
    scatter = np.where(np.arange(20) < 4, 10.0, 1.0)
    found = means(50 + scatter[:, None] * rng.standard_normal((20, 6)))
    assert found.half[:4].min() > 2 * found.half[4:].max()


def test_a_single_press_borrows_from_the_others_and_has_no_interval_alone() -> None:
    assert np.isnan(means([4.0, NONE]).half[0])
    assert np.isnan(means([[4.0, NONE], [5.0, NONE]]).half).all()
    found = means([[4.0, NONE, NONE], [5.0, 5.2, 5.1], [6.0, 6.3, 5.9]])
    assert found.half[0] > found.half[1] * np.sqrt(3) * 0.999


def test_presses_that_are_alike_count_for_less_but_within_reason() -> None:
    rng = np.random.default_rng(4)
    steps = rng.standard_normal((30, 8))
    alike = np.zeros((30, 8))
    for k in range(8):
        alike[:, k] = 0.5 * alike[:, k - 1] + steps[:, k] if k else steps[:, 0] / np.sqrt(0.75)
    found, other = means(20 + alike), means(20 + steps)
    assert found.rho == pytest.approx(0.5, abs=0.12)
    assert other.rho < 0.15
    assert found.half.mean() > 1.4 * other.half.mean()
    assert means(np.arange(8.0)).rho == MOST_ALIKE


def test_an_error_in_common_does_not_shrink_with_presses() -> None:
    values = np.random.default_rng(5).normal(10, 0.1, (3, 9))
    found = means(values, error=2.0)
    assert np.all(found.half > 1.96 * 2.0)
    assert np.all(found.half < 2.2 * 2.0)


@pytest.mark.parametrize("level", [0.0, -1.0, NONE])
def test_a_level_that_scatter_cannot_follow_leaves_that_recording_out(level: float) -> None:
    values = np.array([[1.0, 2.0, 3.0], [4.0, 4.1, 4.2]])
    found, alone = recording_means(values, np.array([level, 1.0]), np.zeros(2)), means(values[1])
    assert np.isnan(found.half[0])
    assert found.mean[0] == 2.0
    assert found.half[1] == pytest.approx(alone.half[0])


def test_nothing_and_equal_presses() -> None:
    assert recording_means(np.empty((0, 1)), np.empty(0), np.empty(0)).mean.size == 0
    assert means([[3.0, 3.0, 3.0], [4.0, 4.0, 4.0]]).half.tolist() == [0.0, 0.0]


def study(seed: int = 6):
    rng = np.random.default_rng(seed)
    values = 10 + np.array([0.0, 2.0, 5.0]) + 2 * rng.standard_normal((7, 1)) + 0.7 * rng.standard_normal((7, 3))
    values = values[..., None] + rng.standard_normal((7, 3, 4))
    values[0, 2], values[3, 1, 1:] = NONE, NONE
    return values


def by_henderson(values, fit):
    """Predictions (P, S) and of people (P,), and their error variances, from Henderson's equations of single values."""
    p, s, _ = values.shape
    person, specimen, _ = np.nonzero(np.isfinite(values))
    y = values[np.isfinite(values)]
    x, cell = np.eye(s)[specimen], np.eye(p * s)[person * s + specimen]
    z = np.hstack([np.eye(p)[person], cell])
    error = np.ldexp(fit.error, 2 * fit.unit)
    shrink = np.diag(np.concatenate([np.full(p, 1 / fit.ratios[0]), np.full(p * s, 1 / fit.ratios[1])]))
    left = np.block([[x.T @ x, x.T @ z], [z.T @ x, z.T @ z + shrink]])
    inverse = np.linalg.inv(left)
    solved = inverse @ np.concatenate([x.T @ y, z.T @ y])
    of_cells = np.hstack([np.tile(np.eye(s), (p, 1)), np.repeat(np.eye(p), s, axis=0), np.eye(p * s)])
    of_people = of_cells.reshape(p, s, -1).mean(axis=1)
    return [(w @ solved, error * np.einsum("ij,jk,ik->i", w, inverse, w)) for w in (of_cells, of_people)]


def test_shrunken_values_are_those_of_hendersons_equations() -> None:
    values = study()
    fit = fit_reml(values)
    found = shrunken(fit)
    t = stats.t.ppf(0.975, 6)
    (cell, cell_error), (person, person_error) = by_henderson(values, fit)
    assert found.cell.ravel() == pytest.approx(cell)
    assert found.person == pytest.approx(person)
    assert (found.cell_high - found.cell_low).ravel() / 2 == pytest.approx(t * np.sqrt(cell_error))
    assert (found.person_high - found.person_low) / 2 == pytest.approx(t * np.sqrt(person_error))


def test_shrunken_values_are_what_the_residuals_are_about() -> None:
    values = study(7)
    fit = fit_reml(values)
    about = np.broadcast_to(shrunken(fit).cell[..., None], values.shape)[np.isfinite(values)]
    assert mixed_residuals(values, fit).fitted == pytest.approx(about)


def test_shrunken_values_do_not_mind_units() -> None:
    values = study(8)
    found, small = shrunken(fit_reml(values)), shrunken(fit_reml(1e-6 * values))
    assert 1e6 * small.cell_low == pytest.approx(found.cell_low, rel=1e-6)
