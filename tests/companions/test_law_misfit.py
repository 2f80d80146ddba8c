"""Lack of fit of three laws: found where it is, of the size it has; not where there is none."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from emg2vsa.companions.force_laws import LAWS
from emg2vsa.companions.law_misfit import LawMisfits, cell_misfits, compare_misfits
from emg2vsa.fits import Fits
from tests.companions.test_force_laws import fits_of

EDGES_N = np.append(np.arange(0.5, 6.9, 0.3), 7.0)
FORCE_N = np.sqrt(EDGES_N[1:] * EDGES_N[:-1])
TRUE = {
    "logarithm": 30 + 15 * np.log(FORCE_N),
    "power .7": 4 + 9 * FORCE_N**0.7,
    "power": 25 * FORCE_N**0.4,
    "linear": 5 + 8 * FORCE_N,
    "quadratic": 10 + 1.2 * FORCE_N**2,
    "sigmoid": 8 + 50 / (1 + np.exp(-1.6 * (FORCE_N - 3.5))),
    "saturating": 60 * (1 - np.exp(-FORCE_N / 1.2)),
}
SHAPE = (6, 1, 8)


def presses(law: str, rng: np.random.Generator, noise: float = 0.07, shape: tuple[int, ...] = SHAPE) -> np.ndarray:
    """Noise of a bin as in `benchmarks.force_law`; part of it is shared with the next."""
    size = np.exp(0.2 * rng.standard_normal((*shape, 1)))
    wave = rng.standard_normal((*shape, FORCE_N.size + 1))
    return np.asarray(TRUE[law] * size * (1 + noise * (wave[..., 1:] + 0.4 * wave[..., :-1]) / np.hypot(1, 0.4)))


def fits_with(v: np.ndarray) -> Fits:
    bin_v = v.reshape(-1, FORCE_N.size)
    force_n = np.broadcast_to(FORCE_N, bin_v.shape)
    return dataclasses.replace(fits_of(v[..., :1]), bin_edges_n=EDGES_N, bin_force_n=force_n, bin_v=bin_v)


def misfits(v: np.ndarray) -> LawMisfits:
    return compare_misfits(cell_misfits(fits_with(v), "ok", spline=True))


@pytest.mark.parametrize("law", LAWS)
def test_a_true_law_is_at_no_distance_and_the_others_at_theirs(law: str) -> None:
    found = misfits(presses(law, np.random.default_rng(0), 1e-6))
    v = TRUE[law]
    for i, other in enumerate(LAWS):
        if other == law:
            assert found.together[i].share < 1e-5
        else:
            assert found.together[i].low > 0.01
    assert found.nearest() == law
    line = np.polyval(np.polyfit(np.log(FORCE_N), v, 1), np.log(FORCE_N))
    rms = np.sqrt(np.mean((v - line) ** 2)) / v.mean()
    assert found.together[0].share == pytest.approx(rms, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("law", [law for law in TRUE if law != "logarithm"])
def test_a_wrong_logarithm_is_told(law: str) -> None:
    rng = np.random.default_rng(7)
    found = [misfits(presses(law, rng)) for _ in range(20)]
    assert sum(each.together[0].told for each in found) >= 19
    if law in ("sigmoid", "saturating", "quadratic"):
        assert sum(all(misfit.told for misfit in each.together) for each in found) >= 19
    if law in LAWS:
        assert sum(each.nearest() == law for each in found) >= 18
        assert sum(each.together[LAWS.index(law)].told for each in found) <= 3


def test_a_true_logarithm_is_seldom_told() -> None:
    rng = np.random.default_rng(8)
    found = [misfits(presses("logarithm", rng)) for _ in range(100)]
    assert sum(each.together[0].told for each in found) <= 8
    assert 0.01 < np.mean([each.p[0] < 0.05 for each in found]) < 0.09


def test_the_spline_tells_where_the_logarithm_is_off_most_and_by_how_much() -> None:
    found = misfits(presses("linear", np.random.default_rng(0), 1e-6))
    assert found.at_n == pytest.approx(np.full(6, 6.9))
    weighted = np.polyval(np.polyfit(np.log(FORCE_N), TRUE["linear"], 1, w=1 / TRUE["linear"]), np.log(FORCE_N))
    off = (TRUE["linear"] - weighted)[-1] / TRUE["linear"].mean()
    assert found.largest == pytest.approx(np.full(6, off), rel=0.15)


def test_cells_of_a_person_are_taken_together() -> None:
    v = presses("logarithm", np.random.default_rng(1), shape=(2, 3, 4))
    found = misfits(v)
    assert found.presses.tolist() == [12, 12]
    alone = misfits(v[:1])
    assert alone.share[:, 0] == pytest.approx(found.share[:, 0], rel=1e-12)
    assert dataclasses.astuple(alone.together[0]) == pytest.approx(dataclasses.astuple(alone.of(0, 0)), rel=1e-12)


def test_the_unit_of_activity_changes_nothing_but_the_level() -> None:
    v = presses("linear", np.random.default_rng(2))
    one, other = misfits(v), misfits(1e-6 * v)
    assert other.share == pytest.approx(one.share, rel=1e-9)
    assert other.level_v == pytest.approx(1e-6 * one.level_v, rel=1e-12)


def test_presses_that_reach_little_of_the_range_do_not_count() -> None:
    v = presses("logarithm", np.random.default_rng(3), shape=(1, 1, 8))
    v[0, 0, 2, 12:] = np.nan
    v[0, 0, 5, ::7] = np.nan
    found = misfits(v)
    assert found.presses.tolist() == [7]
    assert np.isfinite(found.p).all()


@pytest.mark.parametrize("change", ["no bins", "few presses", "silent", "none"])
def test_what_cannot_be_said_is_not(change: str) -> None:
    v = presses("logarithm", np.random.default_rng(4), shape=(1, 1, 3 if change == "few presses" else 8))
    v = np.full_like(v, np.nan) if change == "no bins" else 0 * v if change == "silent" else v
    found = compare_misfits([]) if change == "none" else misfits(v)
    assert np.isnan([misfit.p for misfit in found.together]).all()
    assert not any(misfit.told for misfit in found.together)
    assert found.nearest() == ""
    assert found.participant.size == (1 if change == "few presses" else 0)


@pytest.mark.parametrize(
    ("law", "noise", "said"),
    [
        ("logarithm", 1e-4, "The logarithm v = a + b ln F fits"),
        ("logarithm", 0.3, "is not shown to be off by 1 %"),
        ("linear", 0.07, "does not fit: presses are 1"),
        ("linear", 0.07, "(p < 0.001); the straight line is nearest"),
        ("saturating", 0.07, "neither does a power law nor a straight line; the logarithm is nearest"),
        ("power", 0.01, "the power law is nearest, 0."),
    ],
)
def test_the_sentence(law: str, noise: float, said: str) -> None:
    found = misfits(presses(law, np.random.default_rng(0), noise))
    assert said in found.said("uV")


def test_the_sentence_of_a_person_states_microvolts() -> None:
    found = misfits(1e-6 * presses("linear", np.random.default_rng(0), 1e-4))
    share, level = found.share[0, 2], found.level_v[2]
    assert f"], {1e6 * share * level:.2g} uV from it" in found.said("V", 2)
    assert compare_misfits([]).said("V") == ""
