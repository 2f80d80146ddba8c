"""The benchmark of the statistics on a tiny configuration: its references are right, and so is what it says of us."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mpmath import mpf
from scipy import optimize, stats

from benchmarks.statistics import acceptance, digit_table
from benchmarks.statistics.curve_tasks import curve_tasks
from benchmarks.statistics.exact_curves import exact_exponential
from benchmarks.statistics.exact_laws import chi2_survival, f_survival, ks_survival, power_of_rm, range_survival
from benchmarks.statistics.exact_tests import exact_kruskal, exact_mann_whitney
from benchmarks.statistics.group_tasks import group_tasks
from benchmarks.statistics.mixed_tasks import mixed_tasks
from benchmarks.statistics.nist_samples import anova_table
from benchmarks.statistics.nist_tables import nist_tables
from benchmarks.statistics.sample_tasks import sample_tasks
from benchmarks.statistics.task import Peer, Task, digits, measured

TINY = (
    *curve_tasks(n_fits=2, n_points=12, n_resamples=2),
    *sample_tasks(n_samples=4, simulated=100_000),
    *group_tasks(n_people=1, n_angles=2, n=5),
    *mixed_tasks(n_people=4, n_specimens=3, n_repetitions=3),
)
ROUGH = {("Lilliefors", "p"): 1.5}
"""Digits of numbers that cannot have 12: known from simulation."""


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("task", TINY, ids=[task.title for task in TINY])
def test_every_number_of_ours_is_right(task: Task, capsys: pytest.CaptureFixture[str]) -> None:
    found = measured(task, repeats=1)
    assert set(found.digits[""]) == set(task.exact())
    for name, right in found.digits[""].items():
        wanted = next((least for (part, which), least in ROUGH.items() if part in task.title and which == name), 12.0)
        assert right >= wanted, name
    assert all(
        found.seconds[peer.name] > 0 and found.digits[peer.name] for peer in task.peers if "tukey" not in peer.name
    )
    assert task.title in capsys.readouterr().out


def test_digits_are_counted() -> None:
    truth = {"p": {0: mpf(2), 1: mpf(0)}}
    assert digits({"p": [2.002, 0.0]}, truth)["p"] == pytest.approx(3)
    assert digits({"p": [2.0, 0.0]}, truth)["p"] == 16
    assert digits({"p": [np.nan, 0.0]}, truth)["p"] == 0
    assert digits({}, truth) == {}


def test_wanted_is_half_of_what_was_noted() -> None:
    peer = Peer("peer", dict, (10.0, 1.0))
    task = Task("task", dict, (peer,), dict)
    for seconds, met in ((5.1, True), (4.9, False)):
        assert acceptance.Measured(task, {"": 1.0, "peer": seconds}, {}).met(peer) is met


def test_laws_are_scipys() -> None:
    assert float(f_survival(mpf("2.5"), 4, 45)) == pytest.approx(stats.f.sf(2.5, 4, 45), rel=1e-13)
    assert float(chi2_survival(mpf(7), 2)) == pytest.approx(stats.chi2.sf(7, 2), rel=1e-13)
    assert float(ks_survival(mpf("0.3"), 10)) == pytest.approx(stats.kstwo.sf(0.3, 10), rel=1e-12)
    assert float(range_survival(mpf(4), 5, 45)) == pytest.approx(stats.studentized_range.sf(4, 5, 45), rel=1e-9)
    assert float(power_of_rm(14, 10, "0.25", "0.5", "0.05")) == pytest.approx(0.819421399316, abs=1e-12)


def test_rank_tests_are_scipys() -> None:
    scores = np.random.default_rng(0).standard_normal((3, 6))
    assert float(exact_kruskal(scores)["p"]) == pytest.approx(stats.kruskal(*scores).pvalue, rel=1e-12)
    peer = stats.mannwhitneyu(scores[0], scores[1], method="exact").pvalue
    assert float(exact_mann_whitney(scores[0], scores[1])) == pytest.approx(peer, rel=1e-12)
    tied = np.array([1.0, 1.0, 2.0]), np.array([1.0, 3.0, 3.0])
    every = stats.mannwhitneyu(*tied, method=stats.PermutationMethod(n_resamples=np.inf)).pvalue
    assert float(exact_mann_whitney(*tied)) == pytest.approx(every, rel=1e-12)


def test_exponential_is_curve_fits() -> None:
    x, y = np.array([0.2, 0.7, 1.4, 2.0]), np.array([7.7, 3.3, 1.2, 0.3])
    (p, q), _ = optimize.curve_fit(lambda z, p, q: p * np.exp(q * z), x, y, p0=(9, -1), ftol=1e-15, xtol=1e-15)
    found = exact_exponential(x, y)
    assert float(found["p"]) == pytest.approx(p, rel=1e-6)
    assert float(found["q"]) == pytest.approx(q, rel=1e-6)


def test_absent_nist_data_are_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(digit_table, "NIST", tmp_path)
    acceptance.acceptance([], nist_tables())
    out = capsys.readouterr().out
    assert "nist_anova is not in" in out
    assert "power of n = 14" in out
    assert "NO" not in out


def test_nist_anova_meets_what_is_wanted(
    shared_data: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(digit_table, "NIST", shared_data("nist"))
    table = anova_table()
    assert table is not None
    assert len(table.rows) == 11
    table.show()
    assert "SmLs09" in capsys.readouterr().out
    assert table.column("from decimal text").min() >= 14.5
    assert (table.column("emg2vsa") >= table.column("doubles allow") - 0.1).all()
