"""The rounding of decimals is no variance: decimals answer as the integers they are a multiple of."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.statistics.effect_size import hedges_g, paired_g
from emg2vsa.statistics.mixed import balanced_mixed
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.reml import fit_reml
from emg2vsa.statistics.repeated import paired_tests, rm_anova

PERSON, SPECIMEN = np.indices((4, 3))
ADDITIVE = (SPECIMEN + 1 + 3 * PERSON).astype(np.float64)
DECIMALS = np.round(0.1 * ADDITIVE, 3)


@pytest.mark.parametrize("table", [ADDITIVE, DECIMALS, DECIMALS + 1000.0])
def test_additive_tables_have_no_error(table: np.ndarray) -> None:
    found = rm_anova(table)
    assert np.isinf(found.f[0])
    assert found.p_gg[0] == 0
    assert np.isinf(found.people_f[0])
    pairs = paired_tests(table)
    assert np.isnan(pairs.g).all()
    assert np.isnan(pairs.t.p).all()


def test_repetitions_that_are_alike_do_not_differ() -> None:
    thrice = np.repeat(DECIMALS[..., None], 3, axis=2)
    model = balanced_mixed(thrice)
    assert np.isinf(model.f)
    assert model.variance[1] == model.variance[2] == 0
    thrice[0, 0, 0] = np.nan
    found = fit_reml(thrice)
    assert isinstance(found, Outcome)
    assert found.notes == ("undefined: repetitions do not differ at all",)


def test_small_scatter_that_was_measured_stays() -> None:
    scatter = np.random.default_rng(0).standard_normal((6, 4))
    wanted, found = rm_anova(scatter), rm_anova(1e6 + scatter * 2.0**-20)
    assert found.f[0] == pytest.approx(wanted.f[0], rel=1e-3)


def test_epsilon_stays_in_its_range() -> None:
    y = np.random.default_rng(1).standard_normal((500, 3, 4)) * np.array([1e-9, 1e-9, 1.0, 3.0])
    found = rm_anova(y)
    assert found.epsilon_gg.min() >= 1 / 3
    assert found.epsilon_gg.max() <= 1


def test_two_people_have_no_standardised_difference() -> None:
    assert np.isnan(paired_g(5.0, 2)).all()
    assert np.isnan(hedges_g(5.0, 2, 1)).all()
    assert np.isfinite(paired_g(5.0, 3)).all()
