"""The picture of a record: spectra as SciPy has them, and the extremes of every column."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from emg2vsa import arrays
from emg2vsa.signals.overview import emg_overview, spectra

FS_HZ = 1000.0
BOUNDS = np.array([[0, 250], [300, 549], [100, 2600], [2600, 9999], [4000, 4000]])


@pytest.mark.parametrize("length", [250, 251])
@pytest.mark.parametrize("at_once", [1, 1000, 2**17])
def test_spectra_of_pieces_are_those_of_welch(monkeypatch: pytest.MonkeyPatch, at_once: int, length: int) -> None:
    monkeypatch.setattr(arrays, "AT_ONCE", at_once)
    samples = 1 + np.random.default_rng(0).standard_normal((2, 10_000))
    found = spectra(tuple(samples), BOUNDS, length, FS_HZ)
    for row, x in zip(found, samples, strict=True):
        for own, (i, j) in zip(row, BOUNDS.tolist(), strict=True):
            if j - i < length:
                assert np.isnan(own).all()
                continue
            step = length // 2
            _, expected = signal.welch(x[i:j], FS_HZ, nperseg=length, noverlap=length - step, detrend="constant")
            one_sided = slice(1, -1 if length % 2 == 0 else None)
            np.testing.assert_allclose(own[one_sided], expected[one_sided], rtol=1e-9)


def test_a_record_shorter_than_a_segment_has_no_spectrum() -> None:
    assert np.isnan(spectra((np.ones(100),), np.array([[0, 100]]), 250, FS_HZ)).all()


@pytest.mark.parametrize("at_once", [1, 1000, 2**17])
def test_columns_hold_the_extremes_and_the_mean_rectified_value(monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    monkeypatch.setattr(arrays, "AT_ONCE", at_once)
    x = np.random.default_rng(1).standard_normal(10_010)
    found = emg_overview((x, -2 * x), FS_HZ, 0.0, BOUNDS, BOUNDS[:1])
    assert found.step_s == 0.026
    for column in range(10_010 // 26):
        own = x[26 * column : 26 * column + 26]
        assert found.low_v[:, column].tolist() == [own.min(), -2 * own.max()]
        assert found.high_v[:, column].tolist() == [own.max(), -2 * own.min()]
        rectified = np.abs(own - own.mean()).mean()
        assert found.mean_v[:, column] == pytest.approx([rectified, 2 * rectified], rel=1e-12)
    assert found.low_v.shape == (2, 385)
