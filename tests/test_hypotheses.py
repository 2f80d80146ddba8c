"""The tests of section IV.B on tables of fits with known clusters."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from emg2vsa import artifacts, hypotheses
from emg2vsa.companions.groups import equality_tests
from emg2vsa.fits import Fits
from emg2vsa.settings import HypothesisSettings
from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.clusters import clusters_of
from emg2vsa.statistics.equivalence import tost
from emg2vsa.statistics.mixed import MixedModel

PAPER = HypothesisSettings(kept_specimens=("S1", "S3", "S5"))


def fits_of(participant: list[str], specimen: list[str], b: np.ndarray, verdict: str = "ok") -> Fits:
    n = len(b)
    columns = {f.name: np.zeros(n) for f in dataclasses.fields(Fits)}
    texts = {"activity_unit": "V", "points": "bins", "weights": "none", "confidence": 0.95}
    names = {"participant": np.array(participant, dtype=np.str_), "specimen": np.array(specimen, dtype=np.str_)}
    bins = {"bin_force_n": np.full((n, 4), np.nan), "bin_v": np.full((n, 4), np.nan)}
    verdicts = {"verdict": np.full(n, verdict, dtype="<U8")}
    return Fits(**columns | texts | names | bins | verdicts | {"b_v": b})  # type: ignore[arg-type]


def study(participants: int = 14, specimens: int = 5, repetitions: int = 10, seed: int = 0) -> tuple[Fits, np.ndarray]:
    """Fits in a shuffled order, and b (P, S, R) they were made of."""
    rng = np.random.default_rng(seed)
    means = np.array([9e-6, 7.5e-6, 6e-6, 5.6e-6, 3e-6])[:specimens]
    b = means[:, None] * (1 + 0.15 * rng.standard_normal((participants, specimens, repetitions)))
    i, j, _ = (index.ravel() for index in np.indices(b.shape))
    order = rng.permutation(b.size)
    names = [f"P{k + 1}" for k in i[order]], [f"S{k + 1}" for k in j[order]]
    return fits_of(*names, b.ravel()[order]), b


def test_seventy_clusters_are_scipys() -> None:
    fits, b = study()
    found = hypotheses.test_hypotheses(fits, PAPER)
    assert (found.count == np.full((14, 5), 10)).all()
    assert found.participants[-1] == "P14"
    assert found.specimens.tolist() == ["S1", "S2", "S3", "S4", "S5"]
    normality = found.tests.normality
    for i, x in enumerate(b.reshape(70, 10)):
        peer = stats.kstest((x - x.mean()) / x.std(ddof=1), "norm")
        np.testing.assert_allclose(
            [normality.standardised.statistic[i], normality.standardised.p[i]], peer[:2], rtol=1e-9
        )
        np.testing.assert_allclose(
            [normality.shapiro.statistic[i], normality.shapiro.p[i]], stats.shapiro(x), rtol=1e-6
        )
    assert normality.standardised.statistic.size == 70
    assert (normality.raw.p <= 0.0079).all()
    assert (normality.lilliefors.p < normality.standardised.p).all()


def test_analyses_of_variance_are_scipys() -> None:
    fits, b = study()
    result = hypotheses.test_hypotheses(fits, PAPER)
    between, within = result.tests.between_blocks.anova, result.tests.between_groups.anova
    for j in range(5):
        np.testing.assert_allclose([between.f[j], between.p[j]], stats.f_oneway(*b[:, j]), rtol=1e-11)
    assert (between.df1 == 13).all()
    assert (between.df2 == 126).all()
    assert (between.count == 10).all()
    for i in range(14):
        np.testing.assert_allclose([within.f[i], within.p[i]], stats.f_oneway(*b[i]), rtol=1e-11)


def test_companions_are_their_peers() -> None:
    fits, b = study()
    tests = hypotheses.test_hypotheses(fits, PAPER).tests
    for j in range(5):
        across = tests.between_blocks
        assert across.kruskal.p[j] == pytest.approx(stats.kruskal(*b[:, j]).pvalue, rel=1e-10)
        assert across.brown_forsythe.p[j] == pytest.approx(stats.levene(*b[:, j]).pvalue, rel=1e-10)
    peer = stats.tukey_hsd(*b[3])
    first, second = tests.pairs.first, tests.pairs.second
    np.testing.assert_allclose(tests.pairs.tukey.p[3], peer.pvalue[first, second], rtol=1e-6, atol=1e-14)
    exact = [stats.mannwhitneyu(b[3, i], b[3, j], method="exact").pvalue for i, j in zip(first, second, strict=True)]
    np.testing.assert_allclose(tests.pairs.mann_whitney.p[3], exact, rtol=1e-12)
    assert tests.blocks is not None
    people = stats.friedmanchisquare(*b.mean(axis=2).T)
    np.testing.assert_allclose([tests.blocks.friedman.statistic[0], tests.blocks.friedman.p[0]], people, rtol=1e-11)


def test_effects_are_of_the_two_groups() -> None:
    fits, b = study(2, 3, 6, seed=4)
    pairs = hypotheses.test_hypotheses(fits, PAPER).tests.pairs
    x, y = b[1, 0], b[1, 2]
    d = (x.mean() - y.mean()) / np.sqrt((x.var(ddof=1) + y.var(ddof=1)) / 2)
    assert pairs.g[1, 1] == pytest.approx(d * (1 - 3 / (4 * 10 - 1)), rel=2e-3)  # Hedges' approximate correction
    assert pairs.g_low[1, 1] < pairs.g[1, 1] < pairs.g_high[1, 1]


def test_over_people_the_sample_is_the_people() -> None:
    """Ten copies of each mean tell no more about people than one."""
    fits, b = study(6, 3, 1, seed=2)
    once = hypotheses.test_hypotheses(fits, HypothesisSettings()).tests.blocks
    values = np.repeat(b, 10, axis=2) * (1 + 1e-9 * np.random.default_rng(0).standard_normal((6, 3, 10)))
    i, j, _ = (index.ravel() for index in np.indices(values.shape))
    repeated = fits_of([f"P{k + 1}" for k in i], [f"S{k + 1}" for k in j], values.ravel())
    often = hypotheses.test_hypotheses(repeated, HypothesisSettings()).tests.blocks
    assert once is not None
    assert often is not None
    assert often.repeated.p[0] == pytest.approx(once.repeated.p[0], rel=1e-6)
    assert once.mixed is None
    assert often.mixed is not None
    assert often.mixed.p == pytest.approx(once.repeated.p[0], rel=1e-6)


def test_equality_is_shown_only_against_a_margin() -> None:
    fits, _ = study()
    bound = hypotheses.test_hypotheses(fits, PAPER).tests.equality
    assert bound.margin is None
    assert not bound.shown.any()
    assert np.isnan(bound.worst_p).all()
    values = np.swapaxes(clusters_of(fits.participant, fits.specimen, fits.b_v, fits.verdict == "ok").values, 0, 1)
    for margin_sd in (1.0, 3.0):
        settings = HypothesisSettings(equivalence_margin_sd=margin_sd)
        found = hypotheses.test_hypotheses(fits, settings).tests.equality
        pairs = tost(values, margin_sd, unit="sd")
        inside = np.fmax(np.abs(pairs.low), np.abs(pairs.high)) < pairs.margin
        np.testing.assert_array_equal(found.shown, np.count_nonzero(inside, axis=1))
        np.testing.assert_array_equal(found.worst_p, pairs.p.max(axis=1))
        np.testing.assert_array_equal(found.pairs, pairs.p.shape[1])
        assert found.unit == "sd"
        np.testing.assert_array_equal(found.p < 0.05, found.shown == found.pairs)
    np.testing.assert_allclose(bound.bound, np.fmax(np.abs(pairs.low), np.abs(pairs.high)).max(axis=1))


def test_a_pair_without_a_test_leaves_equality_open_unless_another_refutes_it() -> None:
    rng = np.random.default_rng(8)
    alike = rng.standard_normal((1, 3, 40))
    alike[0, 1:, 1:] = np.nan  # two groups of one value each have no pooled SD
    for margin, refuted in ((20.0, False), (1e-6, True)):
        found = equality_tests(alike, one_way(alike), 0.05, margin)
        assert (found.pairs[0], found.untested[0]) == (2, 1)
        assert (found.worst_p[0] >= 0.05) == refuted
        np.testing.assert_equal(found.p[0], found.worst_p[0] if refuted else np.nan)


def test_an_unbalanced_study_gets_the_other_mixed_model() -> None:
    fits, _ = study(4, 3, 6)
    verdict = fits.verdict.copy()
    verdict[0] = "rejected"
    blocks = hypotheses.test_hypotheses(dataclasses.replace(fits, verdict=verdict), HypothesisSettings()).tests.blocks
    assert blocks is not None
    assert isinstance(blocks.model, MixedModel)
    assert blocks.mixed is not None
    assert np.isfinite(blocks.mixed.p or np.nan)
    assert blocks.contrasts is not None


def test_the_stage_is_stored_and_read_back(tmp_path: Path) -> None:
    found = hypotheses.test_hypotheses(study(3, 3, 4)[0], PAPER)
    artifacts.save(tmp_path / "hypotheses", found)
    again = artifacts.load(tmp_path / "hypotheses")
    assert again.tests.pairs.outcomes(1, 2) == found.tests.pairs.outcomes(1, 2)
    assert again.tests.blocks.outcomes() == found.tests.blocks.outcomes()
    assert (again.worst, again.notes) == (found.worst, found.notes)


def test_balanced_studies_do_not_wait_for_statsmodels() -> None:
    program = (
        "import sys, emg2vsa.hypotheses\n"
        "assert not {'statsmodels', 'pandas', 'scipy.stats', 'matplotlib'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_worst_p_is_the_largest_among_the_kept_pairs() -> None:
    fits, b = study()
    result = hypotheses.test_hypotheses(fits, PAPER)
    pairs = result.tests.pairs.lsd
    assert pairs.p.size == 140
    worst, name = -1.0, ""
    for i in range(14):
        sd = np.sqrt(np.mean(b[i].var(axis=1, ddof=1)))
        for first, second in ((0, 2), (0, 4), (2, 4)):
            t = (b[i, first].mean() - b[i, second].mean()) / (sd * np.sqrt(0.2))
            p = 2 * stats.t.sf(abs(t), 45)
            if p > worst:
                worst, name = p, f"P{i + 1} S{first + 1}-S{second + 1}"
    np.testing.assert_allclose(result.worst_p, worst, rtol=1e-10)
    assert result.worst_pair == name
    assert result.kept == ("S1", "S3", "S5")
    assert ((pairs.low < pairs.difference) & (pairs.difference < pairs.high)).all()
    assert result.tests.pairs.p_holm[result.worst] >= result.worst_p == pairs.p[result.worst]


def test_power_is_that_of_the_papers_plan() -> None:
    result = hypotheses.test_hypotheses(study()[0], PAPER)
    assert abs(result.power.repetitions - 0.819421399316) < 1e-12
    assert abs(result.power.specimens - 0.604379) < 1e-6
    assert result.power.people == 21
    assert any("between repetitions, not between specimens" in note for note in result.notes)


def test_order_of_the_table_and_unit_do_not_matter() -> None:
    fits, _b = study(seed=1)
    order = np.lexsort((fits.specimen, fits.participant))
    sorted_fits = fits_of(fits.participant[order].tolist(), fits.specimen[order].tolist(), 1e6 * fits.b_v[order])
    one, other = (hypotheses.test_hypotheses(f, PAPER) for f in (fits, sorted_fits))
    np.testing.assert_allclose(other.tests.pairs.lsd.p, one.tests.pairs.lsd.p, rtol=1e-9)
    f, of_other = (found.tests.between_blocks.anova.f for found in (one, other))
    np.testing.assert_allclose(of_other, f, rtol=1e-10)
    assert other.worst_pair == one.worst_pair


def test_only_admitted_trials_enter() -> None:
    fits, _ = study(3, 2, 4)
    verdict = fits.verdict.copy()
    verdict[:3], verdict[3] = "doubtful", "rejected"
    fits = dataclasses.replace(fits, verdict=verdict)
    counts = {
        use: hypotheses.test_hypotheses(fits, HypothesisSettings(use=use)).count.sum() for use in ("ok", "ok+doubtful")
    }
    assert counts == {"ok": 20, "ok+doubtful": 23}


def test_incomplete_design_is_told() -> None:
    fits, _ = study(3, 3, 4)
    gone = (fits.participant == "P2") & (fits.specimen == "S3")
    b = fits.b_v.copy()
    b[gone] = np.nan
    b[np.flatnonzero((fits.participant == "P1") & (fits.specimen == "S1"))[0]] = np.nan
    result = hypotheses.test_hypotheses(dataclasses.replace(fits, b_v=b), PAPER)
    notes = "\n".join(result.notes)
    assert "no usable trial: P2 S3" in notes
    assert "fewer than 4 usable trials: P1 S1 (3)" in notes
    assert "kept specimens without trials: S5" in notes
    assert "2 of 9 pairs" in notes
    assert np.count_nonzero(result.tests.between_blocks.anova.count, axis=1).tolist() == [3, 3, 2]
    assert np.isfinite(result.worst_p)


@pytest.mark.parametrize(
    ("participants", "specimens", "repetitions"), [(1, 1, 1), (1, 3, 4), (3, 1, 4), (1, 1, 10), (2, 2, 1)]
)
def test_small_studies_have_notes_not_errors(participants: int, specimens: int, repetitions: int) -> None:
    result = hypotheses.test_hypotheses(study(participants, specimens, repetitions)[0], HypothesisSettings())
    tests = result.tests
    assert tests.normality.raw.n.tolist() == [repetitions] * (participants * specimens)
    assert tests.between_blocks.anova.f.size == (specimens if participants > 1 else 0)
    assert tests.between_groups.anova.f.size == (participants if specimens > 1 else 0)
    assert tests.pairs.lsd.p.size == participants * specimens * (specimens - 1) // 2
    assert (tests.blocks is None) == (min(participants, specimens) < 2)
    assert result.notes
    assert np.isnan(result.worst_p) == (specimens == 1 or repetitions == 1)


def test_nothing_at_all() -> None:
    for fits in (fits_of([], [], np.empty(0)), fits_of(["P1", "P2"], ["S1", "S1"], np.ones(2), "rejected")):
        result = hypotheses.test_hypotheses(fits, PAPER)
        assert np.isnan(result.power.repetitions)
        assert np.isnan(result.worst_p)
        assert result.worst_pair == ""
        assert any("power undefined" in note for note in result.notes)


def test_identical_values_are_undefined_not_significant() -> None:
    fits, _ = study(2, 3, 4)
    result = hypotheses.test_hypotheses(dataclasses.replace(fits, b_v=np.full(24, 1e-5)), HypothesisSettings())
    assert np.isnan(result.tests.between_groups.anova.p).all()
    assert np.isnan(result.tests.pairs.p_holm).all()
    assert np.isnan(result.worst_p)
    assert any("6 of 6 pairs" in note for note in result.notes)


def test_trend_and_laws() -> None:
    """b has no trend here and no force bins: the one is tested, the other says why it is not."""
    fits, b = study()
    fits = dataclasses.replace(fits, repetition=np.arange(b.size) % 10 + 1)
    found = hypotheses.test_hypotheses(fits, dataclasses.replace(PAPER, equivalence_margin_sd=1.0))
    assert found.trend.blocks.size == 14
    assert found.trend.p > 0.001
    assert np.isnan(found.laws.p).all()


def test_people_of_an_unknown_order_are_named() -> None:
    fits, _ = study(3, 3, 4)
    first, second, third = sorted(set(fits.participant.tolist()))
    specimens = enumerate(sorted(set(fits.specimen.tolist())), start=1)
    place = {(who, what): float(at) for at, what in specimens for who in (first, third)}
    found = hypotheses.test_hypotheses(fits, PAPER, place=place)
    (note,) = [note for note in found.notes if "order of specimens" in note]
    assert note.startswith(f"order of specimens not known of {second}: scans.tsv")
    assert found.drift.order == "same"
    assert np.isnan(found.place[1]).all()
