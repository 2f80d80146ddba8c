"""A whole press: force, log, truth; any one can be made again alone, and frames need no memory."""

from __future__ import annotations

import json
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from casr.frames import FrameSequence, force_per_frame, loading_phase
from casr.spread import spread_rate
from emg2vsa.worlds.tactile import (
    ContactWorld,
    PressSettings,
    Scene,
    SimulatedFrames,
    SimulatedPress,
    TimelineSettings,
    casr_truth,
    simulate_press,
)


@pytest.fixture(scope="module")
def press() -> SimulatedPress:
    return simulate_press(PressSettings(angle_deg=30.0, repetition=2))


def test_force_rises_once_to_the_peak_and_falls(press: SimulatedPress) -> None:
    force, loading = press.truth.force_n, press.truth.loading_frames
    assert 55 <= len(loading) <= 66
    assert (np.diff(loading) == 1).all()
    assert (np.diff(force[loading]) > 0).all()
    assert force[loading[0] - 1] < 0.5 <= force[loading[0]]
    assert 6.9 < force[loading[-1]] <= 7
    assert (np.diff(force[loading[-1] + 1 :]) <= 0).all()
    assert force[-1] == 0
    assert not force[: press.settings.timeline.rest_frames].any()
    steps = np.diff(force[loading][force[loading] < 6.5])
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)
    assert steps[0] == pytest.approx(6.5 / 3 / 20, rel=0.05)


def test_log_rows_carry_the_last_saved_frame(press: SimulatedPress) -> None:
    log, frames = press.timeline, press.truth.time_s
    assert (log.log_frame_index == [np.sum(frames <= time) - 1 for time in log.log_time_s]).all()
    assert log.log_frame_index[0] == -1
    assert (np.bincount(log.log_frame_index[log.log_frame_index >= 0]) == 10).all()
    assert len(np.unique(log.log_frame_index)) == len(press.frames) + 1


def test_log_noise_has_the_stated_spread() -> None:
    noisy, quiet = (
        simulate_press(PressSettings(timeline=TimelineSettings(force_noise_n=n))).timeline for n in (0.01, 0)
    )
    noise = noisy.log_force_n - quiet.log_force_n
    assert noise.std() == pytest.approx(0.01, rel=0.1)
    assert quiet.log_force_n.min() == 0


@pytest.mark.parametrize(("rule", "lag_s"), [("exposure", 0.0), ("mean", 0.025)])
def test_force_is_that_at_the_frame_or_by_the_papers_mean_half_a_frame_later(
    press: SimulatedPress, rule: str, lag_s: float
) -> None:
    log = press.timeline
    force_n = force_per_frame(log.log_force_n, log.log_frame_index, len(press.frames), rule=rule)
    steady = press.truth.loading_frames[5:-5]
    lag_n = force_n[steady] - press.truth.force_n[steady]
    rate = np.diff(press.truth.force_n[steady])[0] * 20
    np.testing.assert_allclose(lag_n, rate * lag_s, atol=0.02)
    assert abs(lag_n.mean() - rate * lag_s) < 0.002


def test_loading_phase_found_in_the_log_is_the_true_one(press: SimulatedPress) -> None:
    sequence, log, true = press.sequence(), press.timeline, press.truth.loading_frames
    assert isinstance(sequence, FrameSequence)
    np.testing.assert_array_equal(
        sequence.force_n, force_per_frame(log.log_force_n, log.log_frame_index, len(press.frames))
    )
    np.testing.assert_array_equal(sequence[8], press.frames.read(8))
    found = loading_phase(sequence.force_n)
    assert found.rest < true[0]
    assert press.truth.force_n[found.rest] == 0
    assert abs(found.frames[0] - true[0]) <= 1
    assert abs(found.frames[-1] - true[-1]) <= 1


def test_every_frame_logged_at_first_contact_obeys_the_area_law() -> None:
    for repetition in range(40):
        one = simulate_press(PressSettings(repetition=repetition, world=ContactWorld()))
        first = np.flatnonzero(one.sequence().force_n >= 0.5)[0]
        assert one.truth.force_n[first] > one.settings.world.stick_force_n


def test_truth_agrees_with_itself() -> None:
    press = simulate_press(PressSettings(angle_deg=30.0, repetition=2, world=ContactWorld()))
    truth = press.truth
    loading = truth.loading_frames
    expected = press.settings.world.area_mm2(truth.force_n, press.settings.stiffness_n_per_mm, 30.0)
    np.testing.assert_allclose(truth.area_mm2, expected, rtol=1e-12)
    np.testing.assert_allclose(truth.area_px2, np.pi * truth.semi_axes_px.prod(axis=1), rtol=1e-12)
    np.testing.assert_allclose(truth.area_mm2, truth.area_px2 / 36, rtol=1e-12)
    assert truth.log_growth.sum() == pytest.approx(np.log(truth.area_mm2[loading[-1]] / truth.area_mm2[loading[0]]))
    np.testing.assert_allclose(truth.log_growth, 2 * np.log1p(truth.divergence / 2), rtol=1e-9)
    force = np.linspace(truth.force_n[loading[0]], truth.force_n[loading[-1]], 50_001)
    on_the_curve = truth.area_mm2[loading[-1]] * np.sqrt(force / force[-1])  # gamma of 0.25
    assert truth.casr_slope_mm2_per_n == pytest.approx(np.polyfit(force, on_the_curve, 1)[0], rel=1e-3)
    for rule, true in (("slope", truth.casr_slope_mm2_per_n), ("power", truth.casr_power_mm2_per_n)):
        found = spread_rate(truth.area_mm2[loading], truth.force_n[loading], rule=rule).value
        assert true == pytest.approx(found, rel=1e-4), rule
    assert truth.casr_paper_mm2_per_n == casr_truth(truth.area_mm2[loading], truth.force_n[loading], rule="paper")
    assert json.loads(json.dumps(truth.to_dict()))["area_mm2"] == truth.area_mm2.tolist()


@pytest.mark.parametrize("change", [{"repetition": 1}, {"seed": 1}, {"stiffness_n_per_mm": 5.32}, {"angle_deg": 30.0}])
def test_presses_differ_in_place_speed_start_and_brightness(change: dict[str, float]) -> None:
    base = PressSettings()
    one, other = simulate_press(base), simulate_press(replace(base, **change))
    landing = [np.subtract(p.scene.centre_px, p.scene.rim.centre_px)[1] for p in (one, other)]
    assert landing[0] != landing[1]
    assert one.truth.force_n[one.truth.loading_frames[0]] != other.truth.force_n[other.truth.loading_frames[0]]
    assert (one.scene.surface.pin_grey != other.scene.surface.pin_grey).all()


def test_landing_scatters_as_stated() -> None:
    world = ContactWorld()
    centres = [Scene(PressSettings(repetition=repetition, world=world)).centre_px for repetition in range(300)]
    off_mm = (np.array(centres) - 149.5) / 6
    np.testing.assert_allclose(off_mm.std(axis=0), 0.48, rtol=0.15)
    assert np.abs(off_mm).max() <= 1.0 + 1e-9


def test_a_long_press_needs_no_memory(press: SimulatedPress) -> None:
    long = SimulatedFrames(press.scene, np.resize(press.truth.force_n, 100_000))
    long.read(0)
    tracemalloc.start()
    for index in (5, 50_005, 99_999):
        long.read(index)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(long) == 100_000
    assert peak < 10e6
    with pytest.raises(IndexError):
        long.read(100_000)
