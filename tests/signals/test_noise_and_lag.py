"""Hum, rest level and lag: each is found as it was put in, and what is not there is not taken out."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa import arrays
from emg2vsa.signals import lag
from emg2vsa.signals.bias import line_change
from emg2vsa.signals.floor import floor_change, press_levels, subtract_floor
from emg2vsa.signals.hum import remove_hum, remove_touch_hum, touch_hum
from emg2vsa.signals.lag import UNKNOWN, Lag, curve_of, estimate_lag
from emg2vsa.signals.pairing import Clock

FS_HZ = 1000.0
N = 60_000
START = np.arange(0, N, 6000)
STOP = START + 2000


def hum(hz: float, amplitude: float, wander_hz: float = 0.0) -> np.ndarray:
    time_s = np.arange(N) / FS_HZ
    return amplitude * np.sin(2 * np.pi * np.cumsum(hz + wander_hz * np.sin(2 * np.pi * time_s / 30)) / FS_HZ + 0.3)


@pytest.mark.parametrize(("hz", "wander_hz"), [(50.0, 0.0), (49.93, 0.0), (60.04, 0.0), (50.02, 0.02)])
def test_hum_is_removed_wherever_the_mains_stands_and_wanders(hz: float, wander_hz: float) -> None:
    rng = np.random.default_rng(1)
    noise = rng.standard_normal(N)
    noise[np.arange(N) % 6000 > 2000] *= 20
    waves = hum(hz, 5.0, wander_hz) + hum(3 * hz, 2.0, 3 * wander_hz)
    (cleaned,), found = remove_hum((noise + waves,), FS_HZ, START, STOP)
    assert found is not None
    assert found.hz == pytest.approx(hz, abs=0.03 if wander_hz else 0.003)
    assert found.harmonics.tolist() == [1, 3]
    assert found.rms[0] == pytest.approx(np.sqrt((25 + 4) / 2), rel=0.05)
    left = cleaned - noise
    assert np.sqrt(np.mean(left**2)) < (0.2 if wander_hz else 0.1) * np.sqrt(np.mean(waves**2))


def test_without_hum_or_without_rests_the_samples_stay_as_they_are() -> None:
    for seed in range(20):
        noise = np.random.default_rng(seed).standard_normal(N)
        (cleaned,), found = remove_hum((noise,), FS_HZ, START, STOP)
        assert found is None
        assert cleaned is noise
    waves = hum(50.0, 5.0)
    assert remove_hum((waves,), FS_HZ, START[:1], STOP[:1])[1] is None
    none = np.empty(0, np.int64)
    assert remove_hum((waves,), FS_HZ, none, none)[1] is None
    assert remove_hum((waves,), 150.0, START, STOP)[1] is None


TOUCHED = np.arange(N) % 6000 > 2000
TOUCHES = TOUCHED.__getitem__
PRESSES = START + 2200, START + 5000


@pytest.mark.parametrize("share", [0.0, -0.5, 0.3])
def test_hum_that_is_gone_or_turned_while_touching_is_not_added_to_the_presses(share: float) -> None:
    noise = np.random.default_rng(4).standard_normal(N) * np.where(TOUCHED, 10.0, 1.0)
    waves = hum(50.02, 10.0) * np.where(TOUCHED, share, 1.0)
    (cleaned,), found = remove_hum((noise + waves,), FS_HZ, START, STOP, PRESSES, TOUCHES)
    assert found is not None
    assert found.absent.tolist() == [1]
    np.testing.assert_array_equal(cleaned[TOUCHED], (noise + waves)[TOUCHED])
    left = (cleaned - noise)[~TOUCHED]
    assert np.sqrt(np.mean(left**2)) < 0.5
    (kept,), _ = remove_hum((noise + waves,), FS_HZ, START, STOP, PRESSES, TOUCHES, only_absent=True)
    np.testing.assert_allclose(kept, cleaned)


def test_hum_of_rests_and_presses_leaves_both() -> None:
    noise = np.random.default_rng(4).standard_normal(N) * np.where(TOUCHED, 10.0, 1.0)
    (cleaned,), found = remove_hum((noise + hum(50.02, 10.0),), FS_HZ, START, STOP, PRESSES, TOUCHES)
    assert found is not None
    assert found.absent.size == 0
    assert np.sqrt(np.mean((cleaned - noise) ** 2)) < 0.5
    (kept,), _ = remove_hum((noise + hum(50.02, 10.0),), FS_HZ, START, STOP, PRESSES, TOUCHES, only_absent=True)
    np.testing.assert_array_equal(kept, noise + hum(50.02, 10.0))


@pytest.mark.parametrize("hz", [None, 50.0])
def test_hum_within_presses_is_measured_and_none_is_found_in_noise(hz: float | None) -> None:
    for seed in range(20):
        noise = 10 * np.random.default_rng(seed).standard_normal(N)
        assert touch_hum((noise,), FS_HZ, *PRESSES, hz)[0] == 0
    found = touch_hum((noise + hum(50.03, 5.0), noise), FS_HZ, *PRESSES, hz)
    assert found[0] == pytest.approx(5 / 2**0.5, rel=0.1)
    assert found[1] == 0
    assert touch_hum((noise,), FS_HZ, START[:0], STOP[:0], hz)[0] == 0


@pytest.mark.parametrize(("hz", "wander_hz", "size"), [(50.03, 0.0, 5.0), (60.0, 0.05, 20.0), (49.9, 0.02, 40.0)])
def test_hum_of_presses_alone_is_subtracted_where_it_is(hz: float, wander_hz: float, size: float) -> None:
    noise = np.random.default_rng(5).standard_normal(N) * np.where(TOUCHED, 10.0, 1.0)
    touching = TOUCHED | (np.arange(N) % 6000 > 5990)
    waves = (hum(hz, size, wander_hz) + 0.5 * hum(2 * hz, size, 2 * wander_hz)) * touching
    (cleaned, alone), rms = remove_touch_hum((noise + waves, noise), FS_HZ, *PRESSES, None, np.zeros_like)
    assert rms[0] == pytest.approx(size * np.sqrt(1.25 / 2), rel=0.1)
    assert rms[1] == 0
    assert alone is noise
    left = cleaned - noise
    inside = TOUCHED & (np.arange(N) < PRESSES[1][-1])
    assert np.sqrt(np.mean(left[inside] ** 2)) < 0.12 * np.sqrt(np.mean(waves[inside] ** 2)) + 0.3
    assert np.sqrt(np.mean(left[~TOUCHED] ** 2)) < 0.1 * size + 0.3


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_hum_that_grows_with_force_leaves_as_it_came(share: float) -> None:
    noise = np.random.default_rng(8).standard_normal(N) * np.where(TOUCHED, 5.0, 1.0)
    force_n = np.interp(np.arange(N) % 6000, [0, 2500, 2800, 3500], [0, 7.5, 7.5, 0])
    waves = hum(50.03, 20.0, 0.02) * (1 - share + share * force_n / 5) * (force_n > 0)
    (cleaned,), _ = remove_touch_hum((noise + waves,), FS_HZ, START + 200, START + 2300, None, lambda at: force_n[at])
    left = cleaned - noise
    # the release too, from which the next press may take no hum again
    for press in START.tolist():
        own = slice(press + 200, press + 3400)
        assert np.sqrt(np.mean(left[own] ** 2)) < 0.1 * np.sqrt(np.mean(waves[own] ** 2))


def test_without_hum_the_presses_stay_as_they_are() -> None:
    for seed in range(20):
        noise = np.random.default_rng(seed).standard_normal(N) * np.where(TOUCHED, 10.0, 1.0)
        (same,), rms = remove_touch_hum((noise,), FS_HZ, *PRESSES, None, np.zeros_like)
        assert same is noise
        assert rms[0] == 0


@pytest.mark.parametrize("size_s", [0.7, 2.5])
def test_one_press_of_noise_holds_no_hum(size_s: float) -> None:
    """Four standard errors of one piece, whose power scatters by all of itself, found hum in half of such records."""
    start = np.array([1000])
    stop = start + round(size_s * FS_HZ)
    false = 0
    for seed in range(300):
        noise = tuple(np.random.default_rng(seed).standard_normal((2, stop[0] + 1000)))
        false += remove_touch_hum(noise, FS_HZ, start, stop, None, np.zeros_like)[1].any()
    assert false <= 3
    time_s = np.arange(stop[0] + 1000) / FS_HZ
    hummed = noise[0] + np.sin(2 * np.pi * 50 * time_s)
    (_, _), rms = remove_touch_hum((hummed, noise[1]), FS_HZ, start, stop, None, np.zeros_like)
    assert rms[0] == pytest.approx(0.5**0.5, rel=0.2)
    assert rms[1] == 0


def envelopes(floor: float, presses: int = 200, n: int = 250) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Noisy envelopes of v = 18 + 9 ln F over a floor, the truth, forces and offsets."""
    rng = np.random.default_rng(3)
    force_n = np.tile(np.linspace(0.5, 7, n), presses)
    truth = 18 + 9 * np.log(force_n)
    noisy = np.sqrt(truth**2 + floor**2) * (1 + 0.15 * rng.standard_normal(truth.size))
    return noisy[None], truth, force_n, n * np.arange(presses + 1)


@pytest.mark.parametrize("floor", [0.0, 3.0, 8.0])
def test_the_floor_is_subtracted_without_bias(floor: float) -> None:
    noisy, truth, force_n, offsets = envelopes(floor)
    levels = press_levels(noisy, force_n, offsets)
    left = subtract_floor(noisy, levels, np.array([floor]))
    lowest = force_n < 0.8
    assert left[0, lowest].mean() == pytest.approx(truth[lowest].mean(), rel=0.012)
    assert left.mean() == pytest.approx(truth.mean(), rel=0.005)
    _, predicted = floor_change(levels, np.array([floor]), force_n, offsets)
    x = np.log(force_n[:250])
    seen = np.sqrt(truth[:250] ** 2 + floor**2)
    exact = np.polyfit(x, seen, 1, w=1 / truth[:250])[0] / 9 - 1
    assert np.mean(predicted) == pytest.approx(exact, abs=0.006)


def test_a_floor_above_the_signal_leaves_something_and_nothing_negative() -> None:
    noisy, _, force_n, offsets = envelopes(3.0, presses=3)
    levels = press_levels(noisy, force_n, offsets)
    left = subtract_floor(noisy, levels, np.array([100.0]))
    assert np.all(left >= 0)
    assert left.mean() == pytest.approx(levels.mean() / 2, rel=0.1)
    np.testing.assert_array_equal(subtract_floor(noisy, levels, np.array([np.nan])), noisy)


def test_presses_without_samples_or_change_have_their_mean_as_level() -> None:
    levels = press_levels(np.array([[1.0, 3.0, *[5.0] * 12]]), np.ones(14), np.array([0, 0, 2, 14]))
    np.testing.assert_allclose(levels, [[2.0, 2.0, *[5.0] * 12]])
    assert press_levels(np.empty((2, 0)), np.empty(0), np.zeros(1, np.int64)).shape == (2, 0)
    assert np.isnan(floor_change(np.ones((1, 2)), np.ones(1), np.ones(2), np.array([0, 2]))).all()


def session(lag_s: float, presses: int = 8) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """EMG, force that follows it by ``lag_s``, and the ends of the loading phases."""
    at = np.arange(presses) * 5.0 + 2.0
    knots = np.concatenate([[0.0], np.ravel(at[:, None] + [0, 2.5, 2.8, 3.4]), [presses * 5.0 + 2]])
    levels = np.concatenate([[0.0], np.tile([0.0, 7.5, 7.5, 0.0], presses), [0.0]])
    time_s = np.arange(0, knots[-1], 1 / FS_HZ)
    rng = np.random.default_rng(2)
    level = 2 + 12 * np.log1p(2 * np.interp(time_s + lag_s, knots, levels))
    return level * rng.standard_normal(time_s.size), np.interp(time_s, knots, levels), at + 2.4


@pytest.mark.parametrize("lag_s", [-0.5, 0.0, 0.06, 0.2, 1.3])
def test_the_lag_is_found_within_ten_milliseconds(lag_s: float) -> None:
    emg, force_n, stop_s = session(lag_s)
    clock = Clock(0.0, FS_HZ, emg.size)
    lag = estimate_lag((emg,), clock, force_n, clock, 0.5, stop_s)
    assert lag.lag_s == pytest.approx(lag_s, abs=0.01)
    assert lag.se_s < 0.008
    assert lag.certain == (lag_s != 0)
    later = estimate_lag((emg,), Clock(5.0, FS_HZ, emg.size), force_n, Clock(5.0, FS_HZ, emg.size), 0.5, stop_s + 5)
    assert later.lag_s == pytest.approx(lag.lag_s, abs=2e-3)


def test_a_dead_channel_or_a_short_record_has_no_lag() -> None:
    emg, force_n, stop_s = session(0.06)
    clock = Clock(0.0, FS_HZ, emg.size)
    idle = np.random.default_rng(0).standard_normal(emg.size)
    for channel, stops in ((np.zeros_like(emg), stop_s), (idle, stop_s), (emg[:3000], stop_s), (emg, stop_s[:0])):
        own = Clock(0.0, FS_HZ, channel.size)
        lag = estimate_lag((channel,), own, force_n, clock, 0.5, stops)
        assert np.isnan(lag.lag_s)
        assert not lag.certain
    assert not UNKNOWN.certain


@pytest.mark.parametrize(("lag_s", "presses", "certain"), [(0.06, 1, False), (0.3, 1, True), (0.3, 2, True)])
def test_one_press_has_a_lag_without_error_and_two_have_their_difference(lag_s: float, presses: int, certain: bool):
    emg, force_n, stop_s = session(lag_s, presses)
    clock = Clock(0.0, FS_HZ, emg.size)
    lag = estimate_lag((emg,), clock, force_n, clock, 0.5, stop_s)
    assert lag.lag_s == pytest.approx(lag_s, abs=0.015)
    assert (lag.se_s < 0.02) == (presses == 2)
    assert lag.certain == certain


def test_a_lag_that_a_muscle_may_make_is_told_to_a_share_of_itself() -> None:
    """What all presses share shows in no difference between them; clocks have no such share."""
    for lag_s, share in ((0.1, 0.3), (0.3, 0.3), (0.5, 0.0), (-0.1, 0.0)):
        expected = np.sqrt(0.002**2 + 0.005**2 + (share * lag_s) ** 2)
        assert Lag(lag_s, 0.002, 10).error_s == pytest.approx(expected)
    assert Lag(0.1, float("nan"), 1).error_s == pytest.approx(np.hypot(0.005, 0.03))


def test_slow_wander_of_the_electrode_leaves_the_lag() -> None:
    emg, force_n, stop_s = session(0.06)
    clock = Clock(0.0, FS_HZ, emg.size)
    wander = 2000 * np.sin(2 * np.pi * 0.3 * np.arange(emg.size) / FS_HZ)
    lag = estimate_lag((emg + wander,), clock, force_n, clock, 0.5, stop_s)
    assert lag.lag_s == pytest.approx(0.06, abs=0.01)
    assert lag.se_s < 0.008


@pytest.mark.parametrize("lag_s", [0.0, 0.06])
def test_muscles_that_are_quieter_on_release_feign_no_lag(lag_s: float) -> None:
    emg, force_n, stop_s = session(lag_s)
    falling = np.interp(np.arange(emg.size) / FS_HZ + lag_s, np.arange(emg.size) / FS_HZ, np.gradient(force_n)) < -1e-6
    clock = Clock(0.0, FS_HZ, emg.size)
    lag = estimate_lag((np.where(falling, 0.5, 1.0) * emg,), clock, force_n, clock, 0.5, stop_s)
    assert lag.lag_s == pytest.approx(lag_s, abs=0.02)  # together, rise and release say 42 and 105 ms
    assert lag.certain == (lag_s != 0)


def test_presses_that_do_not_share_one_lag_say_so() -> None:
    emg, force_n, stop_s = session(0.0, 12)
    clock = Clock(0.0, FS_HZ, emg.size)
    slow = Clock(0.0, FS_HZ / (1 + 1e-3), emg.size)
    drifting = estimate_lag((emg,), clock, force_n, slow, 0.5, stop_s * (1 + 1e-3))
    assert drifting.drift == pytest.approx(1e-3, rel=0.3)
    assert "ms a second" in drifting.differs
    parts = [session(lag_s, 3) for lag_s in (-0.1, 0.0, 0.1, 0.05)]
    emg, force_n = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    stops = np.concatenate([part[2] + k * parts[0][0].size / FS_HZ for k, part in enumerate(parts)])
    clock = Clock(0.0, FS_HZ, emg.size)
    apart = estimate_lag((emg,), clock, force_n, clock, 0.5, stops)
    assert apart.between_s > 0.03
    assert apart.differs
    assert not estimate_lag(*shared_lag()).differs


def test_lags_that_scatter_by_their_noise_are_not_said_to_differ() -> None:
    """The noise of the electrode hides the muscle, so that the lags of presses scatter by 30 ms where all are 0."""
    lags = []
    for seed in range(30):
        _, force_n, stop_s = session(0.0)
        level = np.hypot(2 + 12 * np.log1p(2 * force_n), 25)
        emg = level * np.random.default_rng(seed).standard_normal(force_n.size)
        clock = Clock(0.0, FS_HZ, emg.size)
        lags.append(estimate_lag((emg,), clock, force_n, clock, 0.5, stop_s))
    assert sum(lag.se_s * lag.pieces**0.5 > 0.03 for lag in lags) > 10
    assert sum(bool(lag.differs) for lag in lags) <= 1


def ramp(lag_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """ln F now and when a force that is so late is there, in the window, of four presses of 3 s; and their offsets."""
    time_s = np.linspace(0.2, 2.8, 300)
    now, late = np.log(2.5 * time_s), np.log(2.5 * (time_s + lag_s))
    return np.tile(now, 4), np.tile(late, 4), 300 * np.arange(5)


@pytest.mark.parametrize("lag_s", [0.06, 0.17])
def test_what_a_lag_does_to_b_depends_on_the_curve(lag_s: float) -> None:
    now, late, offsets = ramp(lag_s)
    curves = {"log": lambda x: 20 + 10 * x, "straight": lambda x: 4 + 6 * np.exp(x)}
    change = {}
    for name, curve in curves.items():
        level = curve(late) * np.repeat([1.0, 1.3, 1.1, 0.8], 300)
        read, true = curve_of(late, level, offsets, (late, now))
        change[name] = line_change(now, read, now, true, level, offsets)[1]
        exact = line_change(now, curve(late), now, curve(now), level, offsets)[1]
        np.testing.assert_allclose(change[name], exact, atol=1e-9)
    # on an even ramp a late force is one less by a constant, which the intercept of a straight line takes
    np.testing.assert_allclose(change["straight"], 0, atol=1e-9)
    assert np.all(change["log"] < -0.05)


def test_curves_that_fall_differ_or_are_two_are_taken_as_the_logarithm() -> None:
    now, late, offsets = ramp(0.06)
    straight, bent = 4 + 6 * np.exp(late), 40 * late + 60 - 6 * np.exp(late)
    differing = np.where(np.arange(1200) % 600 < 300, straight, bent)
    for level, own in ((50 - np.exp(late), offsets), (differing, offsets), (straight, offsets[:3])):
        read, true = curve_of(late[: own[-1]], level[: own[-1]], own, (late, now))
        np.testing.assert_array_equal(read, late)
        np.testing.assert_array_equal(true, now)
    assert not np.array_equal(curve_of(late, straight, offsets, (late,))[0], late)


def shared_lag() -> tuple[tuple[np.ndarray], Clock, np.ndarray, Clock, float, np.ndarray]:
    emg, force_n, stop_s = session(0.06)
    clock = Clock(0.0, FS_HZ, emg.size)
    return (emg,), clock, force_n, clock, 0.5, stop_s


def test_slopes_are_compared_on_their_own_axes() -> None:
    """Three times the slope on an axis of twice the length: a ratio of 1.5, in each press."""
    true_x = np.concatenate((np.linspace(0, 1, 20), np.linspace(0, 3, 30)))
    true_y, offsets = 2 + 0.5 * true_x, np.array([0, 20, 50])
    ratio = 1 + line_change(2 * true_x, 1 + 3 * true_y, true_x, true_y, np.ones(50), offsets)[1]
    np.testing.assert_allclose(ratio, 1.5, rtol=1e-12)


@pytest.mark.parametrize("n", [400, 407, 20_003])
@pytest.mark.parametrize("spans", [np.empty((0, 2), np.int64), np.array([[90, 300], [12_000, 12_400]])])
def test_activity_taken_in_parts_is_that_of_the_whole(monkeypatch: pytest.MonkeyPatch, n: int, spans) -> None:
    channels = tuple(5 + np.random.default_rng(2).standard_normal((2, n)))
    moved = [spans[spans[:, 0] < n]] * 2
    whole = lag._activity(channels, 10, 1000.0, moved)
    monkeypatch.setattr(arrays, "AT_ONCE", 130)
    np.testing.assert_allclose(lag._activity(channels, 10, 1000.0, moved), whole, rtol=1e-9)
    if not spans.size:
        apart = [x - [x[max(i - 50, 0) : i + 51].mean() for i in range(n)] for x in channels]
        steps = np.sum(np.abs(apart), axis=0)[: n // 10 * 10].reshape(-1, 10).mean(axis=1)
        np.testing.assert_allclose(whole, np.convolve(steps, np.full(5, 0.2), "same"), rtol=1e-9)
