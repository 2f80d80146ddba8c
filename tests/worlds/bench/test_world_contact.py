"""Probe on specimen: the published laws, the camera's contact, the tilt."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from emg2vsa.curves.rubber import Cylinder
from emg2vsa.dome_contact import ElasticDome
from emg2vsa.errors import SettingError
from emg2vsa.worlds.bench.probe import PlateContact, Probe, WorldSettings


def probe(**settings: Any) -> Probe:
    return Probe(WorldSettings(**settings))


def test_the_gear_moves_the_probe() -> None:
    down = probe(mm_per_degree=0.2, gap_mm=4.0)
    assert down.position_mm(math.radians(90)) == pytest.approx(18.0)
    assert down.touch_rad == pytest.approx(math.radians(20))
    assert down.elastic_touch(math.radians(19.999)).normal_n == 0.0 < down.elastic_touch(math.radians(20.001)).normal_n


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 45.0])
def test_the_force_stands_on_the_surface(angle_deg: float) -> None:
    tilted = probe(angle_deg=angle_deg, mm_per_degree=0.2, gap_mm=4.0)
    touch = tilted.elastic_touch(math.radians(30))
    (along_x, along_y, along_z), normal_n = tilted.force_n(touch), touch.normal_n
    assert math.degrees(math.atan2(along_x, along_z)) == pytest.approx(angle_deg)
    assert (along_y, math.hypot(along_x, along_z)) == (0.0, pytest.approx(normal_n))
    # 2 mm down the axis are so much along the normal
    depth_mm = 2.0 * math.cos(math.radians(angle_deg))
    assert normal_n == pytest.approx(ElasticDome().on(3.35).force_n(depth_mm))


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 45.0])
def test_the_work_of_the_shaft_is_kept_in_the_contact(angle_deg: float) -> None:
    tilted = probe(angle_deg=angle_deg)
    touch, deep = tilted.touch_rad, tilted.touch_rad + 0.4
    nodes, weights = np.polynomial.legendre.leggauss(60)
    angles = touch + (nodes + 1) / 2 * (deep - touch)
    work_j = (
        (deep - touch) / 2 * sum(weight * tilted.torque_nm(at)[0] for at, weight in zip(angles, weights, strict=True))
    )
    depth_mm = 0.4 * math.degrees(0.2) * math.cos(math.radians(angle_deg))
    # F = (k d)^(4/3) over d
    assert work_j == pytest.approx(tilted.elastic_touch(deep).normal_n * depth_mm / 1000 / (1 + 4 / 3), rel=1e-6)


@pytest.mark.parametrize("angle_deg", [0.0, 45.0])
def test_the_torque_grows_as_it_says(angle_deg: float) -> None:
    tilted = probe(angle_deg=angle_deg)
    for above in (0.01, 0.3, 1.0):
        at = tilted.touch_rad + above
        by_difference = (tilted.torque_nm(at + 1e-6)[0] - tilted.torque_nm(at - 1e-6)[0]) / 2e-6
        assert tilted.torque_nm(at)[1] == pytest.approx(by_difference, rel=1e-6)


@pytest.mark.parametrize("angle_deg", [90.0, -1.0, math.nan])
def test_an_angle_that_cannot_be_is_refused(angle_deg: float) -> None:
    with pytest.raises(SettingError, match=r"^angle_deg: expected 0 to below 90 degrees"):
        WorldSettings(angle_deg=angle_deg)


@pytest.mark.parametrize("height_mm", [10.0, 30.0])
def test_a_plate_on_a_specimen_of_a_height_is_a_neo_hookean_cylinder(height_mm: float) -> None:
    cylinder, depths = Cylinder(50.0, height_mm), np.linspace(0, 0.8 * height_mm, 50)
    contact = PlateContact(3.35, height_mm)
    exact = cylinder.force_n(depths, 3.35 / cylinder.n_per_mm_per_kpa)
    assert [contact.force_n(depth) for depth in depths.tolist()] == pytest.approx(exact, rel=1e-12)
    assert contact.resistance(1e-9)[1] == pytest.approx(3.35)  # kappa is that of first contact
    assert contact.force_n(0.3 * height_mm) > 1.3 * PlateContact(3.35).force_n(0.3 * height_mm)


@pytest.mark.parametrize("depth_mm", [1.0, 5.0, 7.999, 8.001, 10.0, 1e6])
def test_its_force_grows_as_it_says_at_any_depth(depth_mm: float) -> None:
    contact, step = PlateContact(3.35, 10.0), 1e-7 * depth_mm
    by_difference = (contact.force_n(depth_mm + step) - contact.force_n(depth_mm - step)) / (2 * step)
    assert contact.resistance(depth_mm)[1] == pytest.approx(by_difference, rel=1e-5)
    assert contact.resistance(-depth_mm) == (0.0, 0.0)
