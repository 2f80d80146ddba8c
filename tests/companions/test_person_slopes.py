"""Mean b of each person: its interval holds presses, corrections and the bias left, and says what it leaves out."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats

from emg2vsa.companions.person_slopes import person_slopes
from emg2vsa.fits import Fits
from tests.companions.test_force_laws import fits_of


def slopes(b_v: np.ndarray, **columns: object) -> Fits:
    """Fits of b (P, S, R), volts; the level is 40 uV."""
    n = b_v.size
    own = {"b_v": b_v.ravel(), "v_min_v": np.full(n, 30e-6), "v_max_v": np.full(n, 50e-6)}
    return dataclasses.replace(
        fits_of(b_v[..., None]), **own | {"b_bias": np.zeros(n), "b_bias_se": np.zeros(n)} | columns
    )  # type: ignore[arg-type]


B_V = 15e-6 * (1 + 0.1 * np.random.default_rng(1).standard_normal((6, 2, 5)))


def test_people_share_the_scatter_of_presses() -> None:
    found = person_slopes(slopes(B_V), "ok")
    assert found.participant.tolist()[:3] == ["P0", "P0", "P1"]
    assert found.specimen.tolist()[:3] == ["S0", "S1", "S0"]
    assert found.mean == pytest.approx(B_V.mean(axis=2).ravel())
    assert found.press_sd == pytest.approx(0.1 * 15 / 40, rel=0.2)
    half = stats.t.ppf(0.975, 48) * found.press_sd * 40e-6 / np.sqrt(5)
    assert found.press_rho == 0
    own = stats.t.ppf(0.975, 4) * B_V.std(axis=2, ddof=1).ravel() / np.sqrt(5)
    shared = (found.high - found.low) / 2
    assert shared == pytest.approx(np.full(12, half), rel=0.15)
    assert np.std(shared) < 0.2 * np.std(own)


def test_corrections_and_the_bias_left_are_in_the_interval() -> None:
    plain, n = person_slopes(slopes(B_V), "ok"), B_V.size
    found = person_slopes(slopes(B_V, b_bias_se=np.full(n, 0.2)), "ok")
    assert np.all(found.high - found.mean > 0.39 * found.mean)
    found = person_slopes(slopes(B_V, b_bias=np.full(n, -0.2)), "ok")
    assert found.low == pytest.approx(plain.low)
    assert found.high == pytest.approx(plain.high + found.mean / 4)


def test_presses_that_do_not_count_leave_an_empty_recording() -> None:
    verdict = np.full(B_V.size, "ok", dtype="<U8")
    verdict[:5] = "doubtful"
    found = person_slopes(slopes(B_V, verdict=verdict), "ok")
    assert found.presses[:2].tolist() == [0, 5]
    assert np.isnan([found.mean[0], found.low[0]]).all()
    assert next(iter(found.said("V"))) == ""
    assert person_slopes(slopes(B_V, verdict=verdict), "ok+doubtful").presses[0] == 5


@pytest.mark.parametrize(
    ("presses", "said"),
    [
        (1, "b of the person: 15 uV, mean of 1 press. One press does not tell how presses of a person differ."),
        (4, "; fewer than 5 presses do not tell whether successive ones are alike."),
        (5, "]."),
    ],
)
def test_a_lone_recording_says_what_its_interval_leaves_out(presses: int, said: str) -> None:
    b_v = 15e-6 * np.array([1.0, 1.1, 0.92, 1.05, 0.95])[None, None, :presses]
    (told,) = person_slopes(slopes(b_v), "ok").said("V")
    assert told.endswith(said)
    assert ("fewer" in told) == (presses == 4)


def test_rows_are_plain() -> None:
    first = person_slopes(slopes(B_V), "ok").rows()[0]
    assert first["participant"] == "P0"
    assert first["presses"] == 5
    assert first["b_lo_v"] < first["b_v"] < first["b_hi_v"]
    (alone,) = person_slopes(slopes(B_V[:1, :1, :1]), "ok").rows()
    assert (alone["presses"], alone["b_lo_v"], alone["b_hi_v"]) == (1, None, None)


def test_no_fits_at_all() -> None:
    empty = person_slopes(slopes(np.empty((0, 0, 0))), "ok")
    assert empty.mean.size == 0
    assert list(empty.said("V")) == []
