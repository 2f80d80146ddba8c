"""Curves of cells from force bins, and the names and forces of what differs."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from emg2vsa import artifacts
from emg2vsa.companions.whole_curve import WholeCurve, cell_curves, compare_curves
from emg2vsa.fits import Fits
from emg2vsa.statistics.whole_curve import curve_tests
from tests.companions.test_force_laws import fits_of

EDGES_N = np.append(np.arange(0.5, 4.0, 0.3), 4.0)
"""The last bin is the shorter one."""
BINS = EDGES_N.size - 1
STIFFNESS = {"S0": 1.0, "S1": 8.0, "S2": 3.0}


def fits(v: np.ndarray, verdict: str = "ok") -> Fits:
    """Of presses (P, S, R, B)."""
    return dataclasses.replace(fits_of(v, verdict), bin_edges_n=EDGES_N)


def presses(seed: int = 0, people: int = 12, repetitions: int = 4) -> np.ndarray:
    """Three specimens, of which S1 differs in the bins from 2.0 N on."""
    rng = np.random.default_rng(seed)
    v = 20 + 3 * rng.standard_normal((people, 1, 1, 1)) + rng.standard_normal((people, 3, repetitions, BINS))
    v[:, 1, :, 5:] += 10
    return v


def found_in(v: np.ndarray, alpha: float = 0.05) -> WholeCurve:
    return compare_curves(cell_curves(fits(v), "ok"), alpha)


def test_the_curve_of_a_cell_is_the_mean_of_the_presses_that_reach_the_bin() -> None:
    v = presses()
    v[3, 2, :2, -1] = np.nan  # half of the presses reach it
    v[4, 2, :3, -1] = np.nan  # fewer
    curves = {(each.participant, each.specimen): each.v for each in cell_curves(fits(v), "ok")}
    np.testing.assert_allclose(curves["P1", "S0"], v[1, 0].mean(axis=0))
    assert curves["P3", "S2"][-1] == pytest.approx(v[3, 2, 2:, -1].mean())
    assert np.isnan(curves["P4", "S2"][-1])
    assert cell_curves(fits(v, "rejected"), "ok") == []


def test_names_and_forces_of_what_differs() -> None:
    found = found_in(presses())
    ranges = found.ranges()
    assert ranges.of.tolist() == ["all specimens", "S0–S1", "S1–S2"]
    np.testing.assert_allclose(ranges.from_n, 2.0)
    np.testing.assert_allclose(ranges.to_n, 4.0)
    assert (ranges.p <= 0.05).all()
    assert (np.sign(ranges.statistic) == [1, -1, 1]).all()
    assert (ranges.high[1] < 0) & (ranges.low[2] > 0)
    np.testing.assert_allclose(found.differing(), np.array([2, 2, 0, 2]) / 3.5)


def test_the_table_by_force_holds_every_number_in_its_row() -> None:
    v = presses()
    found, tests = found_in(v), curve_tests(v.mean(axis=2))
    rows = found.by_force()
    assert rows.of[::BINS].tolist() == ["all specimens", "S0–S1", "S0–S2", "S1–S2", "S0", "S1", "S2"]
    np.testing.assert_array_equal(rows.from_n[:BINS], EDGES_N[:-1])
    np.testing.assert_array_equal(rows.to_n[-BINS:], EDGES_N[1:])
    np.testing.assert_array_equal(rows.statistic[rows.pair == -1], tests.f)
    np.testing.assert_array_equal(rows.statistic[rows.pair == 1], tests.pair_t[1])
    np.testing.assert_array_equal(rows.p[rows.pair == 2], tests.pair_p[2])
    np.testing.assert_allclose(rows.value[rows.of == "S2"], v.mean(axis=(0, 2))[2])
    np.testing.assert_allclose((rows.high - rows.low)[rows.of == "S2"] / 2, tests.half_width[2])
    np.testing.assert_allclose((rows.high - rows.low)[rows.pair == 0] / 2, tests.pair_half_width[0])
    assert np.isnan(rows.value[:BINS]).all()


def test_neighbours_are_neighbours_in_stiffness() -> None:
    found = found_in(presses())
    assert [found.pairs[i] for i in found.neighbours(STIFFNESS)] == [("S1", "S2"), ("S0", "S2")]
    assert [found.pairs[i] for i in found.neighbours({"S2": 1.0, "S0": 2.0})] == [("S0", "S2")]
    assert [found.pairs[i] for i in found.neighbours({"S2": 1.0})] == [("S0", "S1"), ("S1", "S2")]


def test_people_and_specimens_without_data_are_named() -> None:
    v = presses()
    v[2, 0] = np.nan
    v[:, 2, :, :] = np.where(np.arange(12)[:, None, None] < 3, v[:, 2], np.nan)
    found = found_in(v)
    assert found.specimens.tolist() == ["S0", "S1"]
    assert "P2" not in found.participants
    assert found.left_out == ("P2", "S2")


def test_one_recording_at_a_time_is_all_of_them() -> None:
    v = presses()
    parts = [cell_curves(fits(v[i : i + 1]), "ok") for i in range(12)]
    renamed = [dataclasses.replace(cell, participant=f"P{i}") for i, part in enumerate(parts) for cell in part]
    found, whole = compare_curves(renamed[::-1]), found_in(v)
    assert found.participants.tolist() == whole.participants.tolist()
    np.testing.assert_array_equal(found.tests.p, whole.tests.p)
    np.testing.assert_array_equal(found.tests.mean, whole.tests.mean)


def test_no_curve_at_all_says_why() -> None:
    for found in (compare_curves([]), found_in(np.full((3, 2, 4, BINS), np.nan)), found_in(presses(people=2))):
        assert found.tests.why
        assert found.ranges().of.size == 0
        assert found.left_out or not found.participants.size


def test_what_is_stored_is_read_back(tmp_path: Path) -> None:
    found = found_in(presses())
    artifacts.save(tmp_path / "curves", found)
    again = artifacts.load(tmp_path / "curves")
    assert again.tests.f_threshold == found.tests.f_threshold
    assert again.ranges().of.tolist() == found.ranges().of.tolist()
    np.testing.assert_array_equal(again.by_force().p, found.by_force().p)
