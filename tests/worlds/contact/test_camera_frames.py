"""Frames of a simulated press, and the power law through them."""

from __future__ import annotations

import numpy as np
import pytest

from casr.spread import spread_rate
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.worlds.contact import ELASTIC, Drive, simulate_presses
from emg2vsa.worlds.contact.stiffness_effect import FrameErrors, frames_of, power_rates

LAW = PowerLaw(0.2624)
PATHS = simulate_presses([LAW], ELASTIC, Drive())


def frames(errors: FrameErrors, count: int = 200) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(4)
    return frames_of(PATHS, 0, rng.uniform(0, 0.05, count), errors, rng)


def test_frames_without_errors_lie_on_the_press() -> None:
    force, area = frames(FrameErrors())
    seen = np.isfinite(force)
    assert np.array_equal(seen, np.isfinite(area))
    assert force[seen].min() >= 0.5
    assert force[seen].max() <= 7.0
    assert seen.sum(axis=1).mean() == pytest.approx(20 * float(PATHS.duration_s()[0]), rel=0.02)
    assert area[seen] == pytest.approx(LAW.area_mm2(force[seen]), rel=1e-4)
    assert power_rates(force, area) == pytest.approx((LAW.area_mm2(7.0) - LAW.area_mm2(0.5)) / 6.5, rel=1e-4)


def test_a_delay_shows_an_earlier_contact_of_one_press_and_jitter_that_of_a_frame() -> None:
    clean, _ = frames(FrameErrors())
    late = {}
    for name in ("latency_sd_s", "jitter_s"):
        force, area = frames(FrameErrors(**{name: 0.005}))
        assert np.array_equal(force, clean, equal_nan=True)
        shown_s = np.interp(area, LAW.area_mm2(PATHS.force_n[:-1, 0]), PATHS.time_s[:-1])
        late[name] = np.interp(force, PATHS.force_n[:-1, 0], PATHS.time_s[:-1]) - shown_s
    assert np.nanstd(late["latency_sd_s"]) == pytest.approx(0.005, rel=0.15)
    assert np.nanmedian(np.nanstd(late["latency_sd_s"], axis=1)) < 1e-6
    assert np.nanmean(np.nanstd(late["jitter_s"], axis=1)) == pytest.approx(0.005, rel=0.15)


def test_the_rates_are_those_of_casr() -> None:
    force, area = frames(FrameErrors(area_share=0.01, force_n=0.01, latency_sd_s=0.005, jitter_s=0.005))
    ours, theirs = power_rates(force, area), []
    for f, a in zip(force, area, strict=True):
        theirs.append(spread_rate(a[np.isfinite(a)], f[np.isfinite(f)]).value)
    # casr draws areas far off towards the line, which few are
    assert np.median(np.abs(ours / np.array(theirs) - 1)) < 1e-9
    assert np.abs(ours / np.array(theirs) - 1).max() < 0.05
    assert ours.std() > 0.01 * ours.mean()


def test_too_few_frames_have_no_rate() -> None:
    nan = np.nan
    rates = power_rates(np.array([[1.0, nan], [nan, nan]]), np.array([[100.0, nan], [nan, nan]]))
    assert np.isnan(rates).all()
