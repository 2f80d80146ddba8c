"""Control worlds: what a control sets, what contradicts it, and the artificial effects against their definitions."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from emg2vsa.devices.qbmove.springs import SPRINGS
from emg2vsa.errors import ScheduleError
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.controls import controlled, counterparts, effect_of, fixed_keys, stiffness_at
from emg2vsa.worlds.bench.press_draws import PressDraws
from emg2vsa.worlds.bench.probe import Touch
from emg2vsa.worlds.bench.settings import EmulatedSettings

STEPS_N = np.array([0.5, 0.8, 1.1, 1.4])


def schedule(specimen: str, stiffness: list[float], condition: str = "modular") -> Any:
    return SimpleNamespace(
        specimen=specimen, condition=condition, step_force_n=STEPS_N, stiffness_nm_per_rad=np.array(stiffness)
    )


def test_controls_set_their_world_and_nothing_else():
    for name in ("none", "N1", "N2", "N3", "P1", "P2", "P3", "P4"):
        settings = EmulatedSettings(control=name, seed=7, control_specimen="S3")
        made = controlled(settings)
        assert replace(made, **{key: getattr(settings, key) for key in fixed_keys(settings)}) == settings
        assert controlled(made) == made
    assert controlled(EmulatedSettings(control="N2")) == EmulatedSettings(control="N2")
    elastic = controlled(EmulatedSettings(control="N1"))
    assert {elastic.relaxation_of(name) for name in elastic.stiffness_n_per_mm} == {elastic.sensor_relaxation} == {0.0}
    assert elastic.mounting_stiffness_sd == EmulatedSettings().mounting_stiffness_sd
    timing = controlled(EmulatedSettings(control="P2"))
    assert (timing.camera_latency_sd_s, timing.camera_jitter_s) == (0.005, 0.005)
    assert (timing.sensor_relaxation, timing.relaxation_of("S5"), timing.mounting_stiffness_sd) == (0.1, 0.05, 0.0)


def test_schedules_are_swapped_from_both_ends_of_stiffness():
    by_stiffness = {"S1": 7.63, "S_new": 5.32, "S3": 3.35, "S5": 1.11}
    swapped = counterparts(("S1", "S3", "S5", "S_new"), by_stiffness)
    assert swapped == {"S1": "S5", "S5": "S1", "S_new": "S3", "S3": "S_new"}
    assert counterparts(("S1", "S3", "S5"), by_stiffness) == {"S1": "S5", "S5": "S1"}


def test_area_follows_the_stiffness_of_the_force_step_in_p1():
    pressed = schedule("S1", [0.5, 1.0, 2.0])
    effect = effect_of(EmulatedSettings(control="P1"), pressed, ())
    assert effect is not None
    for force_n, stiffness in ((0.1, 0.5), (0.6, 0.5), (0.8, 1.0), (1.3, 2.0), (7.0, 2.0)):
        assert stiffness_at(pressed, force_n) == stiffness
        assert effect.factor(force_n) == pytest.approx(stiffness**-0.05)
        assert effect.noise_sd(force_n) == 0
    rigid = effect_of(EmulatedSettings(control="P1"), None, ())
    assert rigid is not None
    assert rigid.factor(1.0) == 1.0
    assert effect_of(EmulatedSettings(), pressed, ()) is None


@pytest.mark.parametrize("skin", ["finite-elements", "sticking"])
def test_the_contact_that_is_seen_has_the_area_of_p1(skin):
    emulated = EmulatedSettings(control="P1", world="elastic", skin=skin)
    pressed = schedule("S3", [0.5, 1.0, 2.0])
    plain = PressDraws(emulated, "S3", 0.0, SPRINGS["qbmove-maker-pro"], RigSettings(), "run")
    seen = replace(plain, effect=effect_of(emulated, pressed, ())).seen(0)
    for force_n in (0.6, 1.0, 1.3, 5.0):
        touch = Touch(force_n, 0.0, force_n, 0.0)
        wanted = plain.seen(0).area_mm2(touch) * stiffness_at(pressed, force_n) ** -0.05
        assert seen.area_mm2(touch) == pytest.approx(wanted, rel=1e-4)
    assert seen.area_mm2(Touch()) == plain.seen(0).area_mm2(Touch())


def test_at_an_angle_the_effect_follows_the_force_down_the_axis():
    emulated = EmulatedSettings(control="P1", world="elastic", angle_sd_deg=0.0)
    plain = PressDraws(emulated, "S3", 45.0, SPRINGS["qbmove-maker-pro"], RigSettings(), "run")
    seen = replace(plain, effect=effect_of(emulated, schedule("S3", [0.5, 1.0, 2.0]), ())).seen(0)
    for normal_n, shear_n, stiffness in ((1.0, 0.0, 0.5), (1.0, 0.5, 1.0), (1.0, 0.6, 2.0)):
        touch = Touch(normal_n, shear_n, normal_n, 0.0)
        ratio = seen.area_mm2(touch) / plain.seen(0).area_mm2(touch)
        assert ratio == pytest.approx(stiffness**-0.05, rel=1e-4)


@pytest.mark.parametrize("specimen", ["S1", "S5"])
def test_the_largest_effect_of_p1_is_not_cut_off(specimen):
    """The softest step of the demo's schedules, 0.4 N m/rad, and the largest exponent."""
    emulated = EmulatedSettings(control="P1", control_exponent=0.2, world="elastic")
    plain = PressDraws(emulated, specimen, 0.0, SPRINGS["qbmove-maker-pro"], RigSettings(), "run")
    seen = replace(plain, effect=effect_of(emulated, schedule(specimen, [0.4] * 3), ())).seen(0)
    for force_n in (0.1, 3.0, 7.4):
        touch = Touch(force_n, 0.0, force_n, 0.0)
        assert seen.area_mm2(touch) == pytest.approx(plain.seen(0).area_mm2(touch) * 0.4**-0.2, rel=1e-4)


def test_the_area_is_as_noisy_as_the_stiffness_is_wrong_in_p4():
    emulated = EmulatedSettings(control="P4", control_specimen="S3", world="elastic")
    right = schedule("S3", [1.0, 1.0, 1.0])
    for stiffness, sd in (
        (1.0, 0.01),
        (2.0, 0.01 * (1 + 4 * math.log(2))),
        (0.5, 0.01 * (1 + 4 * math.log(2))),
        (9.0, 0.07),
    ):
        effect = effect_of(emulated, schedule("S1", [stiffness] * 3), (right,))
        assert effect is not None
        assert effect.noise_sd(1.0) == pytest.approx(sd)
        assert effect.factor(1.0) == 1.0
    rigid = effect_of(emulated, None, ())
    assert rigid is not None
    assert rigid.noise_sd(1.0) == pytest.approx(0.07)
    seen = PressDraws(emulated, "S1", 0.0, None, RigSettings(), "run", effect=rigid).seen(0)
    rng, touch = np.random.default_rng(0), Touch(3.0, 0.0, 3.0, 0.0)
    logs = np.log([seen.scene.area_mm2(seen.in_frame(touch, rng)) / seen.area_mm2(touch) for _ in range(400)])
    assert logs.std() == pytest.approx(0.07, rel=0.12)
    assert abs(logs.mean()) < 0.012
    with pytest.raises(ScheduleError, match="S3, modular: expected a schedule"):
        effect_of(emulated, right, ())
