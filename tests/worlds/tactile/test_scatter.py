"""What differs between presses that were meant to be alike: its size, and what a mounting shares."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from emg2vsa.worlds.tactile import REALISTIC, ContactWorld, PressSettings, Scatter, Scene, simulate_press

OF_MOUNTING = ("depth", "stiffness", "angle_deg")
OF_PRESS = ("area", "force_zero_n", "latency_s")


def drawn(**which: float) -> dict[str, float]:
    return asdict(REALISTIC.drawn(PressSettings(**{"angle_deg": 30.0, "world": ContactWorld()} | which)))  # type: ignore[arg-type]


def test_draws_have_the_stated_spread() -> None:
    many = [drawn(mounting=mounting, repetition=mounting) for mounting in range(2000)]
    stated = {
        "depth": 0.01, "stiffness": 0.02, "angle_deg": 0.5, "area": 0.015, "force_zero_n": 0.02, "latency_s": 0.005,
    }  # fmt: skip
    for name, sd in stated.items():
        values = np.array([each[name] for each in many])
        assert values.std() == pytest.approx(sd, rel=0.06), name
        middle = 1.0 if name in ("depth", "stiffness", "area") else 0.0
        assert abs(values.mean() - middle) < 4 * sd / np.sqrt(2000), name
    columns = np.array([[each[name] for name in stated] for each in many]).T
    assert np.abs(np.corrcoef(columns) - np.eye(6)).max() < 0.1, "each is drawn for itself"


def test_ten_presses_of_a_mounting_share_what_is_its_own_and_another_mounting_does_not() -> None:
    ten = [drawn(repetition=repetition) for repetition in range(10)]
    other = drawn(mounting=1)
    for name in OF_MOUNTING:
        assert len({each[name] for each in ten}) == 1
        assert other[name] != ten[0][name]
    for name in OF_PRESS:
        assert len({each[name] for each in ten}) == 10


def test_a_mounting_of_the_sensor_has_one_depth_with_all_specimens() -> None:
    soft, stiff, tilted = drawn(stiffness_n_per_mm=1.11), drawn(stiffness_n_per_mm=7.63), drawn(angle_deg=45.0)
    assert soft["depth"] == stiff["depth"] == tilted["depth"]
    assert soft["stiffness"] != stiff["stiffness"]
    assert tilted["stiffness"] == drawn()["stiffness"]
    assert tilted["angle_deg"] != drawn()["angle_deg"]


def test_without_scatter_a_mounting_changes_nothing() -> None:
    first, other = (simulate_press(PressSettings(repetition=1, mounting=mounting)) for mounting in (0, 7))
    assert set(asdict(first.scene.drawn).values()) == {0.0, 1.0}
    for name in ("log_time_s", "log_force_n", "log_frame_index", "frame_force_n"):
        np.testing.assert_array_equal(getattr(first.timeline, name), getattr(other.timeline, name))
    np.testing.assert_array_equal(first.frames.read(40), other.frames.read(40))
    np.testing.assert_array_equal(first.truth.area_mm2, other.truth.area_mm2)


@pytest.mark.parametrize("world", [None, ContactWorld()])
def test_the_truth_of_a_press_is_its_own(world: ContactWorld | None) -> None:
    settings = PressSettings() if world is None else PressSettings(world=world)
    meant = simulate_press(settings)
    uneven = simulate_press(replace(settings, scatter=Scatter(area_sd=0.05)))
    factor = uneven.scene.drawn.area
    assert uneven.truth.drawn["area"] == factor != 1
    np.testing.assert_allclose(uneven.truth.area_mm2, factor * meant.truth.area_mm2, rtol=1e-9)
    assert uneven.truth.casr_power_mm2_per_n == pytest.approx(factor * meant.truth.casr_power_mm2_per_n, rel=1e-9)
    softer = simulate_press(replace(settings, scatter=Scatter(stiffness_sd=0.1)))
    kappa = settings.stiffness_n_per_mm * softer.scene.drawn.stiffness
    asked = Scene(replace(settings, stiffness_n_per_mm=kappa))
    assert softer.scene.area_mm2(3.0) == pytest.approx(asked.area_mm2(3.0), rel=1e-12)


def test_a_depth_that_is_off_scales_the_contact_in_the_image_not_in_the_world() -> None:
    settings = PressSettings(centre_sd_mm=0.0, scatter=Scatter(depth_sd=0.05), world=ContactWorld())
    off, meant = Scene(settings), Scene(replace(settings, scatter=Scatter()))
    assert off.area_mm2(2.0) == pytest.approx(meant.area_mm2(2.0), rel=1e-12)
    scale = off.contact(2.0).area_px2 / meant.contact(2.0).area_px2
    assert scale == pytest.approx(off.drawn.depth**-2, rel=1e-9)
    assert simulate_press(settings).sequence().camera == settings.camera, "the scorer gets what camera.toml says"


def test_resting_force_and_delay_are_in_the_log_alone() -> None:
    settings = PressSettings()
    meant = simulate_press(settings)
    found = simulate_press(replace(settings, scatter=Scatter(force_zero_sd_n=0.1, latency_sd_s=0.02)))
    np.testing.assert_allclose(found.timeline.log_force_n - meant.timeline.log_force_n, found.scene.drawn.force_zero_n)
    np.testing.assert_array_equal(found.truth.force_n, meant.truth.force_n)
    np.testing.assert_array_equal(found.frames.read(30), meant.frames.read(30))
    counted = [int(np.argmax(each.timeline.log_frame_index == 40)) for each in (meant, found)]
    rows = settings.timeline.log_rate_hz * found.scene.drawn.latency_s
    assert abs(counted[1] - counted[0] - rows) <= 1


def test_jitter_moves_the_count_of_single_frames_and_keeps_their_order() -> None:
    found = simulate_press(PressSettings(scatter=Scatter(jitter_sd_s=0.01)))
    index = found.timeline.log_frame_index
    assert (np.diff(index) >= 0).all()
    assert len(set(np.bincount(index[index >= 0]).tolist())) > 3
