"""Readings that cannot be, and how late frames are, from when pins and force set off."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.frames import CameraLag, ForceReadings, camera_lag, check_newtons, frame_times_by_rows, note_on_spikes, spikes

TIME_S = np.arange(0, 4, 0.005)


def log(rate_n_s: float, noise_n: float, seed: int, peak_n: float = 7.0) -> np.ndarray:
    """Rest, rise, a sharp peak, fall and rest."""
    rise = rate_n_s * np.clip(TIME_S - 1.5, 0, None)
    force = np.minimum(rise, np.clip(2 * peak_n - rise, 0, None))
    return force + np.random.default_rng(seed).normal(0, noise_n, TIME_S.size)


@given(st.floats(-1, 2.3), st.floats(-4, -0.7), st.integers(0, 10_000))
def test_no_rise_or_peak_is_a_spike(log_rate, log_noise, seed):
    assert not spikes(log(10**log_rate, 10**log_noise, seed)).any()


@given(st.floats(-1, 1.5), st.integers(5, 790), st.integers(1, 2), st.floats(9, 20), st.integers(0, 10_000))
def test_one_or_two_wild_rows_are_found_and_no_other(log_rate, at, width, height_n, seed):
    force = log(10**log_rate, 0.01, seed)
    force[at : at + width] = height_n
    np.testing.assert_array_equal(np.flatnonzero(spikes(force)), np.arange(at, at + width))


@pytest.mark.parametrize(
    "force_n",
    [
        [0, 0, 0, 0, 3, 7, 3, 0, 0, 0],
        [0, 0, 0, 0, 0, 8, 8, 8, 8, 8],
        [0, 0.01, -0.01, 0, 0.2, 0.4, 0.6, 2, 4, 7, 5, 1, 0.2, 0],
        [0, 0, 0, 0, 9, 9, 9, 0, 0, 0],
        [0, 9, 0],
        [],
    ],
    ids=["tap", "step", "press", "three", "short", "empty"],
)
def test_what_a_press_may_do_in_a_few_frames(force_n):
    assert not spikes(force_n).any()


def test_missing_readings_are_passed_over():
    force = [0, 0, np.nan, 0.01, 12, np.nan, 0, 0, 0.01, 0, 0.01, 0]
    np.testing.assert_array_equal(np.flatnonzero(spikes(force)), [4])
    found = spikes(force)
    assert note_on_spikes(found, np.array(force), "of 12 rows") == (
        "1 of 12 rows is a spike (up to 12 N) and left out",
    )
    assert note_on_spikes(found & False, np.array(force), "of 12 rows") == ()


def test_a_real_grip_keeps_all_but_one_glitch(shared_data: Callable[[str], Path]):
    """5 s at 1000 Hz of 0 to 98 units; row 2539 falls by 2.7 for a millisecond amid steps of 0.06."""
    force = np.loadtxt(shared_data("emg/emg_force/novainstrumentation_force.txt"))[1]
    np.testing.assert_array_equal(np.flatnonzero(spikes(force)), [2539])
    for every in (5, 20, 50):
        assert not spikes(force[::every]).any(), "steep as it is at a frame's rate"


ROW_S = np.arange(0, 2.5, 0.005)
FRAME_S = np.arange(40) / 20 + 0.0213
PITCH = np.stack(np.meshgrid(np.arange(-5, 6), np.arange(-5, 6)), axis=-1).reshape(-1, 2) * 20.0


def force_at(time_s: np.ndarray, rate_n_s: float) -> np.ndarray:
    """A rise that sets in within 0.1 s, as a motor starts."""
    since = np.clip(time_s - 0.43, 0, None)
    return rate_n_s * (np.minimum(since, 0.1) ** 2 / 0.2 + np.maximum(since - 0.1, 0))


def seen(lag_s: float, *, power: float = 0.88, rate_n_s: float = 2.2, seed: int = 0) -> CameraLag:
    rng = np.random.default_rng(seed)
    readings = ForceReadings(ROW_S, 0.3 + force_at(ROW_S, rate_n_s) + rng.normal(0, 0.01, ROW_S.size), FRAME_S + lag_s)
    outwards = 0.02 * force_at(FRAME_S, rate_n_s)[:, None, None] ** power * PITCH
    pins_px = PITCH + outwards + rng.normal(0, 0.03, outwards.shape)
    return camera_lag(np.arange(40), pins_px, readings, zero_n=0.3, start_n=0.5)


@pytest.mark.parametrize("power", [0.8, 0.88, 0.95])
def test_a_known_lag_is_found_within_what_is_told(power):
    of_none = [seen(0.0, power=power, seed=seed) for seed in range(10)]
    for lag_s in (-0.1, 0.0, 0.02, 0.05, 0.1):
        found = [seen(lag_s, power=power, seed=seed) for seed in range(10)]
        error_s = np.array([lag.lag_s for lag in found]) - lag_s
        assert abs(error_s.mean()) < 0.02, "less than half a frame"
        assert error_s.std() < 0.012
        assert all(abs(error) < 2 * lag.sd_s for error, lag in zip(error_s, found, strict=True))
        assert np.median(np.abs(error_s - [lag.lag_s for lag in of_none])) < 0.002, "the same at every lag"
        if lag_s in (-0.1, 0.0, 0.1):
            assert all(lag.doubtful == bool(lag_s) for lag in found)


def test_pins_that_do_not_move_have_no_lag():
    readings = ForceReadings(ROW_S, 0.3 + force_at(ROW_S, 2.2), FRAME_S)
    found = camera_lag(np.arange(40), np.repeat(PITCH[None], 40, axis=0), readings, zero_n=0.3, start_n=0.5)
    assert found.lag_s is None
    assert "the pins do not move" in found.why


def test_a_lag_that_was_taken_off_is_no_doubt():
    assert CameraLag(0.1, 0.02, "", 0.05).doubtful
    assert not CameraLag(0.1, 0.02, "", 0.05, corrected_s=0.09).doubtful
    assert CameraLag(0.0, 0.02, "", 0.05, corrected_s=0.1).doubtful


def test_a_slow_press_tells_no_lag():
    found = seen(0.0, rate_n_s=0.6)
    assert found.lag_s is None
    assert "known to 0.0" in found.why


def test_pins_that_do_not_follow_the_force():
    rng = np.random.default_rng(0)
    readings = ForceReadings(ROW_S, force_at(ROW_S, 2.2), FRAME_S)
    still_px = PITCH + rng.normal(0, 0.03, (40, *PITCH.shape))
    backwards_px = PITCH + 0.02 * force_at(FRAME_S, 2.2)[::-1, None, None] * PITCH
    for pins_px in (still_px, backwards_px, np.full_like(still_px, np.nan), still_px[:3]):
        found = camera_lag(np.arange(len(pins_px)), pins_px, readings, zero_n=0.0, start_n=0.5)
        assert found.lag_s is None
        assert found.why
        assert not found.doubtful
    flat = ForceReadings(ROW_S, 0 * ROW_S, FRAME_S)
    assert "does not rise" in camera_lag(np.arange(40), backwards_px, flat, zero_n=0.0, start_n=0.5).why


@pytest.mark.parametrize("case", ["A_k1.1_stick", "A_k5.3_frictionless", "A_k20_stick", "A_krigid_stick"])
def test_finite_element_contacts(shared_data: Callable[[str], Path], case: str) -> None:
    """Pins 2 mm long, 3.2 mm apart, seen by a pinhole; how they move with the force comes from no formula."""
    table = np.load(shared_data(f"contact_fem/{case}.npz"))
    rng = np.random.default_rng(1)
    grid = np.array([(3.2 * (i + j / 2), 3.2 * np.sqrt(0.75) * j) for i in range(-6, 7) for j in range(-6, 7)])
    grid = grid[np.hypot(*grid.T) < 20]
    arc, way = np.hypot(*grid.T), grid / np.maximum(np.hypot(*grid.T), 1e-9)[:, None]

    def pins_px(force_n: float) -> np.ndarray:
        u_r, u_z, tilt, r0, z0 = (
            np.interp(arc, table["s_mm"], [np.interp(force_n, table["force_n"], row) for row in table[key].T])
            if table[key].ndim == 2
            else np.interp(arc, table["s_mm"], table[key])
            for key in ("u_r_mm", "u_z_mm", "tilt_rad", "r0_mm", "z0_mm")
        )
        r, z = r0 + u_r - 2 * np.sin(arc / 19 - tilt), z0 + u_z - 2 * np.cos(arc / 19 - tilt)
        return way * (420 * r / (50 + z))[:, None] + rng.normal(0, 0.03, grid.shape)

    n = 19  # up to 0.9 N
    frames_px = np.array([pins_px(force) for force in force_at(FRAME_S[:n], 2.2)])
    for lag_s in (0.0, 0.05, 0.1):
        noisy = force_at(ROW_S, 2.2) + rng.normal(0, 0.01, ROW_S.size)
        readings = ForceReadings(ROW_S, noisy, FRAME_S + lag_s)
        found = camera_lag(np.arange(n), frames_px, readings, zero_n=0.0, start_n=0.5)
        assert found.lag_s == pytest.approx(lag_s, abs=0.02)
        assert abs(found.lag_s - lag_s) < 2 * found.sd_s


def test_frames_between_rows():
    index = np.array([-1, -1, 0, 0, 0, 1, 3])
    np.testing.assert_array_equal(frame_times_by_rows(np.arange(7.0), index, 5), [1.5, 4.5, np.nan, 5.5, np.nan])


def test_forces_that_may_be_newtons():
    check_newtons(np.array([np.nan, -150.0, 199.0]), "log")
    check_newtons(np.array([]), "log")
