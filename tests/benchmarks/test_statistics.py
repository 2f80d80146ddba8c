"""The exact references of the benchmarks' statistics are right, and NIST's analyses of variance keep their digits."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy import optimize, stats

from benchmarks import nist
from benchmarks.bench.case import NotHere, Size
from benchmarks.nist import worst_error
from benchmarks.statistics.exact_laws import chi2_survival, f_survival, ks_survival, power_of_rm, range_survival
from benchmarks.statistics.sample_cases import anova_cases, digits_allowed
from benchmarks.stress import exact_tests as exact
from benchmarks.stress.exact_curves import exact_exponential, mpfs


def test_the_worst_number_decides() -> None:
    error = worst_error(lambda: {"p": {0: mpf(2), 1: mpf(0)}, "F": {0: mpf(4)}})
    assert error({"p": [2.002, 0.0]}) == pytest.approx(1e-3)
    assert error({"p": [2.0, 0.0], "F": [5.0]}) == pytest.approx(0.25)
    assert error({"p": [np.nan, 0.0]}) == 1.0
    with pytest.raises(ValueError, match="empty"):  # a way that gives none of the numbers is no way
        error({})


def test_laws_are_scipys() -> None:
    assert float(f_survival(mpf("2.5"), 4, 45)) == pytest.approx(stats.f.sf(2.5, 4, 45), rel=1e-13)
    assert float(chi2_survival(mpf(7), 2)) == pytest.approx(stats.chi2.sf(7, 2), rel=1e-13)
    assert float(ks_survival(mpf("0.3"), 10)) == pytest.approx(stats.kstwo.sf(0.3, 10), rel=1e-12)
    assert float(range_survival(mpf(4), 5, 45)) == pytest.approx(stats.studentized_range.sf(4, 5, 45), rel=1e-9)
    assert float(power_of_rm(14, 10, "0.25", "0.5", "0.05")) == pytest.approx(0.819421399316, abs=1e-12)


def test_rank_tests_are_scipys() -> None:
    scores = np.random.default_rng(0).standard_normal((3, 6))
    assert float(exact.kruskal(exact.groups_of(scores))["p"]) == pytest.approx(stats.kruskal(*scores).pvalue, rel=1e-12)
    peer = stats.mannwhitneyu(scores[0], scores[1], method="exact").pvalue
    assert float(exact.mann_whitney(*exact.groups_of(scores[:2]))["p"]) == pytest.approx(peer, rel=1e-12)
    tied = np.array([[1.0, 1.0, 2.0], [1.0, 3.0, 3.0]])
    every = stats.mannwhitneyu(*tied, method=stats.PermutationMethod(n_resamples=np.inf)).pvalue
    assert float(exact.mann_whitney(*exact.groups_of(tied))["p"]) == pytest.approx(every, rel=1e-12)


def test_exponential_is_curve_fits() -> None:
    x, y = np.array([0.2, 0.7, 1.4, 2.0]), np.array([7.7, 3.3, 1.2, 0.3])
    (p, q), _ = optimize.curve_fit(lambda z, p, q: p * np.exp(q * z), x, y, p0=(9, -1), ftol=1e-15, xtol=1e-15)
    found = exact_exponential(mpfs(x), mpfs(y))
    assert float(found["level"] * mp.exp(-found["q"] * found["centre"])) == pytest.approx(p, rel=1e-6)
    assert float(found["q"]) == pytest.approx(q, rel=1e-6)


def test_designs_are_scipys() -> None:
    rng = np.random.default_rng(1)
    groups = rng.standard_normal((3, 6)) * np.array([1.0, 2.0, 3.0])[:, None]
    peer = stats.f_oneway(*groups, equal_var=False)
    assert float(exact.welch(exact.groups_of(groups))["F"]) == pytest.approx(peer.statistic, rel=1e-12)
    assert float(exact.welch(exact.groups_of(groups))["p"]) == pytest.approx(peer.pvalue, rel=1e-12)
    people = rng.standard_normal((6, 2))
    pair = stats.ttest_rel(*people.T)
    assert float(exact.rm_anova(exact.groups_of(people))["F"]) == pytest.approx(pair.statistic**2, rel=1e-12)
    assert float(exact.rm_anova(exact.groups_of(people))["p"]) == pytest.approx(pair.pvalue, rel=1e-12)
    people = rng.standard_normal((6, 4))
    ranks = stats.friedmanchisquare(*people.T)
    assert float(exact.friedman(exact.groups_of(people))["chi2"]) == pytest.approx(ranks.statistic, rel=1e-12)
    above = stats.ttest_ind(groups[0] + 1, groups[1], alternative="greater").pvalue
    below = stats.ttest_ind(groups[0] - 1, groups[1], alternative="less").pvalue
    assert float(exact.tost(*exact.groups_of(groups[:2]), mpf(1))["p"]) == pytest.approx(max(above, below), rel=1e-12)


def test_absent_nist_data_are_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nist, "NIST", tmp_path)
    with pytest.raises(NotHere, match="EMG2VSA_TEST_DATA names the folder that holds nist/nist_anova"):
        list(anova_cases(Size.SMOKE))


@pytest.mark.slow
def test_nist_anova_keeps_the_digits_that_doubles_allow(
    shared_data: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(nist, "NIST", shared_data("nist"))
    cases = {case.name.split()[1]: case for case in anova_cases(Size.FULL)}
    assert len(cases) == 11
    for path in nist.nist_files("nist_anova"):
        doubles, text = (case_way for case_way in cases[path.stem].ways if case_way.library == "emg2vsa")
        errors = [cases[path.stem].error_of(way, way.run()) or 0.0 for way in (doubles, text)]
        assert -np.log10(errors[0]) >= digits_allowed(path) - 0.1, path.stem
        assert -np.log10(errors[1]) >= 14.5, path.stem
