"""Times of samples against the truth of devices that are simulated with all that delays an arrival."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from benchmarks.session_sources import DELAY_S, FRAME_HZ, POLL_S, arrivals
from emg2vsa.session.sample_clock import MOST_BINS, SampleClock


def clock_of(blocks: Iterable[tuple[int, int, float]], fs_hz: float, **options: float) -> SampleClock:
    clock = SampleClock(fs_hz, quantum=26, **options)
    for block in blocks:
        clock.add(*block)
    return clock


def errors_s(clock: SampleClock, truth: np.ndarray) -> np.ndarray:
    times_s = clock.time_s(truth[:, 0].astype(np.int64))
    np.testing.assert_allclose([clock.time_s(int(index)) for index in truth[::97, 0]], times_s[::97], atol=1e-12)
    return times_s - truth[:, 1] - DELAY_S


@pytest.mark.parametrize("ppm", [0, 40, -80])
@pytest.mark.parametrize(("duration_s", "within_s"), [(5, 1e-3), (20, 5e-4), (120, 2e-4)])
def test_bursts_jitter_drift_and_a_busy_computer(ppm: int, duration_s: float, within_s: float) -> None:
    fs_hz = 26 * FRAME_HZ * (1 + ppm * 1e-6)
    for seed in range(4):
        busy = [(0.3 * duration_s, 0.3), (0.6 * duration_s, 0.3)]
        blocks, truth = arrivals(seed, duration_s, fs_hz, busy=busy)
        clock = clock_of(blocks, 26 * FRAME_HZ)
        off_s, report = errors_s(clock, truth), clock.report()
        assert np.abs(off_s).max() < within_s
        assert report.se_s is not None
        assert report.rate_hz is not None
        assert report.rate_se_hz is not None
        assert np.abs(off_s).max() < 2 * report.se_s
        assert abs(report.rate_hz - fs_hz) < 4 * report.rate_se_hz
        assert (report.missing, report.gaps) == (0, 2)
        assert 0.3 < report.longest_gap_s < 0.3 + 1 / FRAME_HZ + POLL_S + 2e-3
        assert clock.problems() == ()


def test_what_the_rate_error_means() -> None:
    """The standard error is that of the rates found, over 40 devices."""
    fs_hz, errors, stated = 26 * FRAME_HZ, [], []
    for seed in range(40):
        report = clock_of(arrivals(seed, 20, fs_hz)[0], fs_hz).report()
        errors.append((report.rate_hz or 0) - fs_hz)
        stated.append(report.rate_se_hz or 0)
    assert 0.4 < np.sqrt(np.mean(np.square(errors))) / np.mean(stated) < 1.5


@pytest.mark.parametrize(("true", "stated", "percent"), [(26, 27, "-3.7 %"), (27, 26, "+3.8 %")])
def test_26_samples_of_a_frame_taken_for_27(true: int, stated: int, percent: str) -> None:
    blocks, truth = arrivals(1, 20, true * FRAME_HZ, frame=true)
    clock = SampleClock(stated * FRAME_HZ)
    told_s = None
    for block in blocks:
        clock.add(*block)
        if told_s is None and clock.problems():
            told_s = block[2]
    assert told_s is not None
    assert told_s < 4
    assert percent in clock.problems()[0]
    assert np.abs(errors_s(clock, truth)).max() < 5e-4
    assert clock.report().missing == 0


@pytest.mark.parametrize("at_s", [0.5, 1.5, 2.7, 3.2, 10.0, 28.0])
@pytest.mark.parametrize("frames", [1, 3, 40])
def test_frames_that_nobody_told_to_be_lost(at_s: float, frames: int) -> None:
    fs_hz = 26 * FRAME_HZ * (1 + 3e-5)
    lost_s = frames / FRAME_HZ
    blocks, truth = arrivals(7, 30, fs_hz, lost=[(at_s, lost_s)])
    clock = clock_of(blocks, 26 * FRAME_HZ)
    assert clock.report().missing == 26 * frames
    assert f"About {26 * frames} samples" in " ".join(clock.problems())
    # where the loss lies within the first seconds is known to 0.1 s
    settled = truth[(truth[:, 1] < at_s - 0.1) | (truth[:, 1] > at_s + lost_s + 0.15)]
    assert np.abs(errors_s(clock, settled)).max() < 1e-3


def test_two_losses_and_what_lies_between() -> None:
    fs_hz = 26 * FRAME_HZ
    blocks, truth = arrivals(3, 60, fs_hz, lost=[(10, 20 / FRAME_HZ), (40, 1 / FRAME_HZ)])
    clock = clock_of(blocks, fs_hz)
    assert clock.report().missing == 21 * 26
    assert np.abs(errors_s(clock, truth)).max() < 5e-4


@pytest.mark.parametrize(
    ("share", "burst", "jitter_s"), [(0.02, 1, 1e-3), (0.05, 1, 5e-3), (0.05, 5, 1e-3), (0.1, 1, 1e-3)]
)
def test_frames_lost_at_random_are_no_rate(share: float, burst: int, jitter_s: float) -> None:
    """A crystal that errs by 60 ppm; what was lost in the last second is not known yet."""
    fs_hz, duration_s = 26 * FRAME_HZ * (1 + 6e-5), 40.0
    for seed in range(2):
        frames = np.flatnonzero(np.random.default_rng(seed).random(int(duration_s * FRAME_HZ)) < share / burst)
        lost = [((frame + 0.5) / FRAME_HZ, burst / FRAME_HZ) for frame in frames.tolist()]
        blocks, truth = arrivals(seed, duration_s, fs_hz, lost=lost, jitter_s=jitter_s)
        clock = clock_of(blocks, 26 * FRAME_HZ)
        report, off_s = clock.report(), errors_s(clock, truth)
        known = truth[:, 1] < duration_s - 1.5
        assert report.rate_hz == pytest.approx(fs_hz, rel=1.5e-4)
        assert np.mean(np.abs(off_s[known]) > 3e-3) < 0.05
        assert np.abs(np.median(off_s[known])) < 2.5e-3
        assert sum(n for _, n in clock.timing(0, 10**9).lost) == report.missing


@pytest.mark.parametrize("busy_s", [1.5, 2.5, 4.0])
def test_a_start_that_is_late_bends_no_rate(busy_s: float) -> None:
    """A computer that is 50 ms late in the first seconds of a short sitting, as after a resume."""
    fs_hz = 26 * FRAME_HZ
    for seed, duration_s in ((0, 6.0), (1, 10.0), (2, 20.0)):
        blocks, truth = arrivals(seed, duration_s, fs_hz)
        late = [(first, n, arrived_s + 0.05 * (arrived_s < busy_s)) for first, n, arrived_s in blocks]
        clock = clock_of(sorted(late, key=lambda each: each[2]), fs_hz)
        assert np.abs(errors_s(clock, truth)).max() < 2e-3
        assert clock.report().missing == 0


def test_a_rate_that_is_stated_wrongly_is_no_loss() -> None:
    """2 000 Hz typed for 1 925.93."""
    blocks, truth = arrivals(2, 30, 26 * FRAME_HZ)
    clock = SampleClock(2000.0, quantum=27)
    for block in blocks:
        clock.add(*block)
    assert clock.report().missing == 0
    assert clock.problems() == ("The device states 2000.00 samples a second and sends 1925.93 (-3.7 %).",)
    assert np.abs(errors_s(clock, truth)).max() < 5e-4


@pytest.mark.parametrize(
    ("stated", "jitter_s", "percent"),
    [(1111.11, 1e-3, "+73.3 %"), (1777.78, 2e-2, "+8.3 %"), (1916.34, 5e-3, "+0.5 %")],
)
def test_a_device_that_sends_faster_than_stated_is_found(stated: float, jitter_s: float, percent: str) -> None:
    """Also where arrivals scatter by more than a frame."""
    blocks, truth = arrivals(2, 30, 26 * FRAME_HZ, jitter_s=jitter_s)
    clock = SampleClock(stated, quantum=round(0.0135 * stated))
    for block in blocks:
        clock.add(*block)
    assert percent in " ".join(clock.problems())
    assert (clock.report().missing, clock.uneven) == (0, False)
    assert np.abs(errors_s(clock, truth)).max() < 3e-3


def test_frames_that_come_twice_are_told() -> None:
    first, clock = 0, SampleClock(26 * FRAME_HZ, quantum=26)
    for number, (_, n, arrived_s) in enumerate(arrivals(2, 30, 26 * FRAME_HZ)[0]):
        twice = 26 * (number % 97 in (5, 50, 61))
        clock.add(first, n + twice, arrived_s)
        first += n + twice
    assert clock.uneven
    assert "some come twice" in clock.problems()[0]


@pytest.mark.parametrize("every", [10, 20, 40])
def test_frames_lost_evenly_are_no_rate(every: int) -> None:
    """A rate of whole samples in a frame it would not be, or its steps show."""
    lost = [((frame - 0.5) / FRAME_HZ, 1 / FRAME_HZ) for frame in range(every, int(40 * FRAME_HZ), every)]
    clock = clock_of(arrivals(1, 40, 26 * FRAME_HZ, lost=lost)[0], 26 * FRAME_HZ)
    assert clock.report().rate_hz == pytest.approx(26 * FRAME_HZ, rel=1e-4)
    assert clock.report().missing == pytest.approx(26 * len(lost), rel=0.05)


@pytest.mark.parametrize("ppm", [-95, -300, -1000])
def test_a_slow_crystal_is_no_loss(ppm: int) -> None:
    clock = SampleClock(26 * FRAME_HZ, quantum=26)
    for block in arrivals(1, 120, 26 * FRAME_HZ * (1 + 1e-6 * ppm), jitter_s=4e-3)[0]:
        clock.add(*block)
        assert clock.report().missing == 0


def test_a_way_that_is_longer_for_a_time_is_no_loss() -> None:
    fs_hz = 26 * FRAME_HZ
    blocks, truth = arrivals(5, 40, fs_hz)
    slow = [(first, n, arrived_s + 0.03 * (15 < arrived_s < 20)) for first, n, arrived_s in blocks]
    clock = SampleClock(fs_hz, quantum=26)
    seen = set()
    for block in sorted(slow, key=lambda each: each[2]):
        clock.add(*block)
        seen.add(clock.report().missing)
    assert seen == {0, 52}
    assert clock.report().missing == 0
    assert np.abs(errors_s(clock, truth)).max() < 5e-4


def test_losses_that_the_source_numbers_are_not_told_twice() -> None:
    fs_hz = 1000.0
    clock = SampleClock(fs_hz)
    for block in range(2000):
        first = 10 * block + (500 if block >= 1000 else 0)
        clock.add(first, 10, (first + 9) / fs_hz + 0.001)
    assert clock.report().missing == 0
    assert clock.report().gaps == 1
    assert clock.time_s(20_000) == pytest.approx(20.001, abs=1e-6)


def test_an_hour_in_a_memory_that_does_not_grow() -> None:
    """At 74 bursts a second, with a device's clock that wanders by 2 ms from its mean rate."""
    fs_hz = 26 * FRAME_HZ * (1 + 2e-5)
    blocks, truth = arrivals(11, 3600, fs_hz, wander=2e-3)
    clock = SampleClock(26 * FRAME_HZ, quantum=26)
    most = 0
    for block in blocks:
        clock.add(*block)
        most = max(most, len(clock._xs))
    assert most <= MOST_BINS
    report = clock.report()
    assert report.se_s is not None
    assert 5e-4 < report.se_s < 4e-3
    assert np.abs(errors_s(clock, truth)).max() < 2 * report.se_s + 1e-3
    assert report.missing == 0


def test_the_fixed_delay_is_taken_off() -> None:
    blocks, truth = arrivals(2, 10, 26 * FRAME_HZ)
    clock = clock_of(blocks, 26 * FRAME_HZ, delay_s=0.048)
    assert np.abs(errors_s(clock, truth) + 0.048).max() < 1e-3


def test_before_the_first_block_and_after_few() -> None:
    clock = SampleClock(1000.0, delay_s=0.01)
    assert np.isnan(clock.time_s(0))
    assert clock.report().rate_hz is None
    clock.add(0, 0, 0.5)
    assert np.isnan(clock.time_s(0))
    clock.add(0, 10, 1.0)
    assert clock.time_s(9) == pytest.approx(0.99)
    assert clock.time_s(np.array([0, 19])) == pytest.approx([0.981, 1.0])
    assert (clock.report().se_s, clock.problems()) == (None, ())


@pytest.mark.parametrize(("shape", "mean_s"), [(1, 0.02), (4, 0.02)])
def test_delays_that_scatter_are_no_losses(shape: int, mean_s: float) -> None:
    fs_hz = 26 * FRAME_HZ
    for seed in range(3):
        true_s = np.arange(1, 9000) / FRAME_HZ
        delays_s = np.random.default_rng(seed).gamma(shape, mean_s / shape, len(true_s))
        arrived_s = np.maximum.accumulate(true_s + delays_s)
        clock = clock_of([(26 * k, 26, float(at_s)) for k, at_s in enumerate(arrived_s)], fs_hz * (1 - 1e-4))
        assert (clock.report().missing, clock.problems()) == (0, ())
        off_s = clock.time_s(26 * np.arange(1, 9000) - 1) - true_s
        assert np.abs(off_s).max() < 4e-3


@pytest.mark.parametrize("jitter_s", [1e-4, 1e-3, 2e-3, 3e-3, 5e-3, 0.02])
def test_stamps_that_are_early_and_late(jitter_s: float) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        last = 10 * np.arange(1, 12_001) - 1
        true_s = last / 1000.15
        stamps_s = true_s + rng.normal(0, jitter_s, len(last))
        stamps_s[3000] -= 5.0
        stamps_s[30] -= 0.2
        clock = SampleClock(1000.0, stamped=True)
        for index, stamp_s in zip(last.tolist(), stamps_s.tolist(), strict=True):
            clock.add(index - 9, 10, stamp_s)
        assert (clock.report().missing, clock.problems()) == (0, ())
        off_s = np.abs(clock.time_s(last) - true_s)[1000:].max()
        assert off_s < 1e-4 + 0.1 * jitter_s


def test_samples_lost_between_stamps_are_counted() -> None:
    """Seven samples every 30 s; a jitter of 0.2 ms."""
    rng = np.random.default_rng(1)
    gone = (np.arange(24_000) // 3000) * 7
    last = 10 * np.arange(1, 24_001) - 1
    true_s = (last + gone) / 1000.0
    clock = SampleClock(1000.0, stamped=True)
    for index, stamp_s in zip(last.tolist(), (true_s + rng.normal(0, 2e-4, len(last))).tolist(), strict=True):
        clock.add(index - 9, 10, stamp_s)
    assert clock.report().missing == 49
    off_s = np.abs(clock.time_s(last) - true_s)
    assert np.median(off_s) < 2e-4
    assert np.mean(off_s > 1e-3) < 0.01


def test_a_rate_that_changes_is_in_the_uncertainty() -> None:
    """From 0 to 40 ppm over 10 minutes."""
    k = np.arange(1, 60_001)
    true_s = k * 0.01
    arrived_s = true_s + 20e-6 * true_s**2 / 600 + 1e-3
    clock = SampleClock(1000.0)
    for index, at_s in zip((10 * k - 1).tolist(), arrived_s.tolist(), strict=True):
        clock.add(index - 9, 10, at_s)
    off_s = np.abs(clock.time_s(10 * k - 1) - arrived_s)
    assert np.abs(off_s).max() < 2 * (clock.report().se_s or 0)
