"""What no simulated press can be, and which setting its message names."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from casr.camera import Camera, Sensor
from casr.errors import InputError
from emg2vsa.worlds.tactile import (
    Appearance,
    ContactWorld,
    PressPlan,
    PressSettings,
    Scatter,
    Scene,
    Skin,
    TabulatedWorld,
    TimelineSettings,
    casr_truth,
)


def on(sensor: Sensor) -> Scene:
    return Scene(replace(PressSettings(), camera=Camera(sensor=sensor)))


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Appearance(noise_grey=-1.0), "appearance: expected grey levels"),
        (lambda: Appearance(n_missing=-1), "numbers of 0 or more"),
        (lambda: Appearance(background_grey=300.0), "grey levels from 0 to 255"),
        (lambda: Skin(rings=0), "skin: expected sizes above 0, a ring or more"),
        (lambda: Skin(edge_px=0.0), "skin: expected sizes above 0"),
        (lambda: Skin(pitch_px=30.0), r"skin\.pitch_px: expected 6 rings of pins inside .* an outermost pin at 180 px"),
        (lambda: Scatter(depth_sd=-0.1), "depth_sd: expected a number from 0 to 0.1"),
        (lambda: Scatter(area_sd=math.nan), "area_sd"),
        (lambda: Scatter(angle_sd_deg=9.0), "angle_sd_deg: expected a number from 0 to 5"),
        (lambda: Scatter(jitter_sd_s=0.5), "jitter_sd_s"),
        (lambda: PressSettings(stiffness_n_per_mm=0.0), "a stiffness above 0"),
        (lambda: PressSettings(angle_deg=90.0), "an angle from 0 to below 90 degrees, .* but found 3.35, 90.0, 0.5"),
        (lambda: PressSettings(centre_sd_mm=-0.1), "a spread from 0"),
        (
            lambda: PressSettings(seed=-1),
            "seed, repetition, mounting: expected numbers of 0 .* found -1, 0, 0",
        ),
        (lambda: PressSettings(repetition=-1), "found 0, -1, 0"),
        (lambda: PressSettings(mounting=-1), "found 0, 0, -1"),
        (lambda: TimelineSettings(peak_n=0.4), "a peak force above the 0.5 N at which loading starts"),
        (lambda: TimelineSettings(loading_s=0.0), "timeline: expected times and rates above 0"),
        (lambda: TimelineSettings(rest_frames=0), "a rest frame or more"),
        (lambda: TimelineSettings(speed_share=1.0), "speed_share below 1"),
        (lambda: TimelineSettings(rounding_s=2.0), "rounding_s: expected at most half of loading_s, 1.5 s"),
        (lambda: ContactWorld(tip_radius_mm=0), "tip_radius_mm"),
        (lambda: ContactWorld(sensor_modulus_mpa=math.nan), "sensor_modulus_mpa"),
        (lambda: ContactWorld(lever_ratio=1.0), "lever_ratio, exponent: expected a ratio below 1"),
        (lambda: ContactWorld(exponent=1.1), "an exponent of at most 1"),
        (lambda: TabulatedWorld(friction="glue"), "dome, friction: .* but found A glue"),
        (lambda: TabulatedWorld(dome="Z"), "found Z stick"),
        (lambda: TabulatedWorld(tables="nowhere/at/all"), "nowhere"),
        (lambda: PressPlan(specimens=("S1", "S9")), "--specimens: expected specimens of the paper, .* but found S9"),
        (lambda: PressPlan(angles=(0.0, 90.0)), "--angles: expected degrees from 0 to below 90, but found 0, 90"),
        (lambda: PressPlan(force_max_n=0.5), "--force-max-n: expected more than the force of first contact, 0.5 N"),
        (
            lambda: PressPlan(stick_force_n=1.0),
            "--stick-force-n: expected it with --world stick, .* found --world tab",
        ),
        (
            lambda: PressPlan(domes="mine", world="front"),
            "--domes: expected them with --world tab.* found --world front",
        ),
        (lambda: PressPlan(dome_radius_mm=25.0), "--dome-radius-mm: expected it with --domes, but found 25 without"),
        (lambda: PressPlan(specimen_height_mm=10.0), "--specimen-height-mm: expected it with --domes"),
        (lambda: PressPlan(domes="mine", dome_radius_mm=0.5), "--dome-radius-mm: expected 1 to 1000 mm, but found 0.5"),
        (lambda: PressPlan(domes="nowhere").presses(), "nowhere: expected tables of domes"),
        (lambda: on(Sensor()), "pin_length_mm, on a dome of 20 mm or with tables of its own"),
        (lambda: on(Sensor(pin_length_mm=3.0, dome_radius_mm=25.0)), "pin_length_mm"),
        (lambda: casr_truth([1, 2], [1, 2], rule="ols"), "rule: expected slope or paper, but found 'ols'"),
    ],
)
def test_what_cannot_be_is_named(make: Callable[[], object], named: str) -> None:
    with pytest.raises(InputError, match=named):
        make()
