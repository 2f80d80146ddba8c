"""The tests of section IV.B on tables of fits with known clusters."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats

from emg2vsa import hypotheses
from emg2vsa.fits import Fits
from emg2vsa.settings import HypothesisSettings

PAPER = HypothesisSettings(kept_specimens=("S1", "S3", "S5"))


def fits_of(participant: list[str], specimen: list[str], b: np.ndarray, verdict: str = "ok") -> Fits:
    n = len(b)
    columns = {f.name: np.zeros(n) for f in dataclasses.fields(Fits)}
    texts = {"activity_unit": "V", "points": "bins", "weights": "none", "confidence": 0.95}
    names = {"participant": np.array(participant, dtype=np.str_), "specimen": np.array(specimen, dtype=np.str_)}
    return Fits(**columns | texts | names | {"b_v": b, "verdict": np.full(n, verdict, dtype="<U8")})  # type: ignore[arg-type]


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
    normality = hypotheses.test_hypotheses(fits, PAPER).normality
    assert normality.participant.size == 70
    assert (normality.n == 10).all()
    assert normality.participant[-1] == "P14"
    assert normality.specimen[:6].tolist() == [
        "S1",
        "S2",
        "S3",
        "S4",
        "S5",
        "S1",
    ]
    for d, p, x in zip(normality.d_standardised, normality.p_standardised, b.reshape(70, 10), strict=True):
        peer = stats.kstest((x - x.mean()) / x.std(ddof=1), "norm")
        np.testing.assert_allclose([d, p], peer[:2], rtol=1e-9)
    assert (normality.p_raw <= 0.0079).all()


def test_analyses_of_variance_are_scipys() -> None:
    fits, b = study()
    result = hypotheses.test_hypotheses(fits, PAPER)
    between = result.between_participants
    for j in range(5):
        np.testing.assert_allclose([between.f[j], between.p[j]], stats.f_oneway(*b[:, j]), rtol=1e-11)
    assert (between.df1 == 13).all()
    assert (between.df2 == 126).all()
    assert (between.n == 140).all()
    assert (between.n_participants == 14).all()
    for i in range(14):
        peer = stats.f_oneway(*b[i])
        np.testing.assert_allclose([result.between_specimens.f[i], result.between_specimens.p[i]], peer, rtol=1e-11)


def test_worst_p_is_the_largest_among_the_kept_pairs() -> None:
    fits, b = study()
    result = hypotheses.test_hypotheses(fits, PAPER)
    pairs = result.pairs
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
    assert ((pairs.lo_v < pairs.difference_v) & (pairs.difference_v < pairs.hi_v)).all()


def test_power_is_that_of_the_papers_plan() -> None:
    result = hypotheses.test_hypotheses(study()[0], PAPER)
    assert abs(result.power - 0.819421399316) < 1e-12
    assert any("between repetitions, not between specimens" in note for note in result.notes)


def test_order_of_the_table_and_unit_do_not_matter() -> None:
    fits, _b = study(seed=1)
    order = np.lexsort((fits.specimen, fits.participant))
    sorted_fits = fits_of(fits.participant[order].tolist(), fits.specimen[order].tolist(), 1e6 * fits.b_v[order])
    one, other = (hypotheses.test_hypotheses(f, PAPER) for f in (fits, sorted_fits))
    np.testing.assert_allclose(other.pairs.p, one.pairs.p, rtol=1e-9)
    np.testing.assert_allclose(other.between_participants.f, one.between_participants.f, rtol=1e-10)
    assert other.worst_pair == one.worst_pair


def test_only_admitted_trials_enter() -> None:
    fits, _ = study(3, 2, 4)
    verdict = fits.verdict.copy()
    verdict[:3], verdict[3] = "warned", "rejected"
    fits = dataclasses.replace(fits, verdict=verdict)
    counts = {
        use: hypotheses.test_hypotheses(fits, HypothesisSettings(use=use)).normality.n.sum()
        for use in ("ok", "ok+warned")
    }
    assert counts == {"ok": 20, "ok+warned": 23}


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
    assert result.between_participants.n_participants.tolist() == [3, 3, 2]
    assert np.isfinite(result.worst_p)


@pytest.mark.parametrize(
    ("participants", "specimens", "repetitions"), [(1, 1, 1), (1, 3, 4), (3, 1, 4), (1, 1, 10), (2, 2, 1)]
)
def test_small_studies_have_notes_not_errors(participants: int, specimens: int, repetitions: int) -> None:
    result = hypotheses.test_hypotheses(study(participants, specimens, repetitions)[0], HypothesisSettings())
    assert result.normality.n.tolist() == [repetitions] * (participants * specimens)
    assert result.between_participants.f.size == (specimens if participants > 1 else 0)
    assert result.between_specimens.f.size == (participants if specimens > 1 else 0)
    assert result.pairs.p.size == participants * specimens * (specimens - 1) // 2
    assert result.notes
    assert np.isnan(result.worst_p) == (specimens == 1 or repetitions == 1)


def test_nothing_at_all() -> None:
    for fits in (fits_of([], [], np.empty(0)), fits_of(["P1", "P2"], ["S1", "S1"], np.ones(2), "rejected")):
        result = hypotheses.test_hypotheses(fits, PAPER)
        assert np.isnan(result.power)
        assert np.isnan(result.worst_p)
        assert result.worst_pair == ""
        assert any("power undefined" in note for note in result.notes)


def test_identical_values_are_undefined_not_significant() -> None:
    fits, _ = study(2, 3, 4)
    result = hypotheses.test_hypotheses(dataclasses.replace(fits, b_v=np.full(24, 1e-5)), HypothesisSettings())
    assert np.isnan(result.between_specimens.p).all()
    assert np.isnan(result.worst_p)
    assert any("6 of 6 pairs" in note for note in result.notes)
