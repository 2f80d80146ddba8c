"""The contact law and the spread rate it implies."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import ContactWorld, casr_truth

FORCE_N = np.linspace(0.5, 7, 60)


def test_one_third_is_hertz() -> None:
    world = ContactWorld(exponent=1 / 3)
    modulus = world.modulus_mpa(3.35)
    hertz = (3 * FORCE_N * world.tip_radius_mm / (4 * modulus)) ** (1 / 3)
    np.testing.assert_allclose(world.radius_mm(FORCE_N, 3.35), hertz, rtol=1e-12)


def test_sensor_and_specimen_are_in_series() -> None:
    world = ContactWorld()
    assert world.modulus_mpa(1e9) == pytest.approx(world.sensor_modulus_mpa, rel=1e-6)
    assert world.modulus_mpa(8.0) == pytest.approx(1 / (1 / 0.4 + 1 / 0.8), rel=1e-12)


def test_no_pressing_no_contact() -> None:
    np.testing.assert_array_equal(ContactWorld().area_mm2([-0.02, 0.0], 3.35), [0.0, 0.0])


@given(st.floats(0.3, 20), st.floats(0.1, 10), st.floats(0, 80))
def test_area_grows_with_force_and_softness_and_shrinks_with_angle(
    force_n: float, stiffness: float, angle_deg: float
) -> None:
    area = ContactWorld().area_mm2
    here = area(force_n, stiffness, angle_deg)
    assert area(force_n * 1.1, stiffness, angle_deg) > here > area(force_n, stiffness * 1.1, angle_deg)
    assert here > area(force_n, stiffness, angle_deg + 5)


@pytest.mark.parametrize("rule", ["slope", "paper"])
def test_spread_rate_falls_with_stiffness_and_with_angle(rule: str) -> None:
    area = ContactWorld().area_mm2
    rates = np.array([
        [casr_truth(area(FORCE_N, kappa, angle_deg), FORCE_N, rule=rule) for kappa in SPECIMENS.values()]
        for angle_deg in (0, 30, 45)
    ])  # fmt: skip
    assert np.all(np.diff(rates, axis=1) > 0)
    assert np.all(np.diff(rates, axis=0) < 0)


def test_truth_by_hand() -> None:
    force = np.array([0.5, 1.0, 2.0, 4.0])
    assert casr_truth(10 + 3 * force, force) == pytest.approx(3, rel=1e-12)
    # (2) with F_0 = 0: (14 - 10) / (1 - 0) + (20 - 14) / (3 - 1)
    assert casr_truth([10, 14, 20], [0.5, 1.0, 3.0], rule="paper") == pytest.approx(7.0, rel=1e-12)
