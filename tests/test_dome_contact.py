"""Power law and adhesion against their formulas."""

from __future__ import annotations

import math

import numpy as np
import pytest

from emg2vsa.dome_contact import PowerLaw
from emg2vsa.errors import SettingError
from emg2vsa.worlds.contact import adhesive_force_n

FORCES = [0.01, 0.5, 3.0, 7.0]


@pytest.mark.parametrize("exponent", [0.2, 0.25, 1 / 3])
def test_the_area_is_that_of_the_power_law(exponent: float) -> None:
    modulus_mpa, radius_mm = 0.2624, 20.0
    exact = [
        math.pi * radius_mm**2 * (3 * force / (4 * modulus_mpa * radius_mm**2)) ** (2 * exponent) for force in FORCES
    ]
    assert PowerLaw(modulus_mpa, radius_mm, exponent).area_mm2(FORCES) == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("exponent", [0.2, 0.25, 1 / 3])
def test_depth_and_radius_are_pure_geometry(exponent: float) -> None:
    """h(a) = (2R/3) / (1 - n) (a/R)^(1/n - 1), whatever the modulus."""
    for modulus_mpa in (0.087, 0.262):
        law = PowerLaw(modulus_mpa, 20.0, exponent)
        for force in FORCES:
            ratio = float(law.radius_mm(force)) / 20
            depth_mm = 40 / 3 / (1 - exponent) * ratio ** (1 / exponent - 1)
            assert law.depth_mm(force) == pytest.approx(depth_mm, rel=1e-12)
            assert law.force_n(depth_mm) == pytest.approx(force, rel=1e-12)


@pytest.mark.parametrize("exponent", [0.2, 0.25, 1 / 3])
def test_the_force_grows_by_the_radius_that_is_seen(exponent: float) -> None:
    """dF/dd = 2 E* a."""
    law = PowerLaw(0.26, 20.0, exponent)
    for depth_mm in (0.1, 1.0, 5.0):
        force_n, growth = law.resistance(depth_mm)
        assert (force_n, growth) == (law.force_n(depth_mm), pytest.approx(2 * 0.26 * float(law.radius_mm(force_n))))


def test_nothing_presses_without_a_force() -> None:
    assert PowerLaw(0.26).area_mm2([-1.0, 0.0]).tolist() == [0.0, 0.0]
    assert [PowerLaw(0.26).resistance(depth_mm) for depth_mm in (-1e9, -1e-12, 0.0)] == [(0.0, 0.0)] * 3


def test_adhesion_is_the_radius_of_johnson_kendall_and_roberts() -> None:
    """Their balance of energy: F = 4 E* a^3 / 3R - sqrt(8 pi w E* a^3), solved for a."""
    modulus_mpa, radius_mm, adhesion = 0.26, 20.0, 20.0
    hertz = PowerLaw(modulus_mpa, radius_mm, 1 / 3)
    radii = hertz.radius_mm([adhesive_force_n(force, adhesion) for force in FORCES])
    balance = 4 * modulus_mpa * radii**3 / (3 * radius_mm)
    adhesion_n_per_mm = adhesion * 1e-6
    balance -= np.sqrt(8 * math.pi * adhesion_n_per_mm * modulus_mpa * radii**3)
    assert balance == pytest.approx(FORCES, rel=1e-12)


@pytest.mark.parametrize("adhesion", [5.0, 20.0, 45.0])
def test_adhesion_adds_the_same_share_of_area_to_all_specimens(adhesion: float) -> None:
    adhering = [adhesive_force_n(force, adhesion) for force in FORCES]
    shares = [law.area_mm2(adhering) / law.area_mm2(FORCES) for law in (PowerLaw(0.087), PowerLaw(0.262))]
    assert shares[0] == pytest.approx(shares[1], rel=1e-13)
    assert np.all(shares[0] > 1)


def test_without_adhesion_the_force_is_the_same_to_the_last_bit() -> None:
    forces = np.random.default_rng(3).uniform(0, 7, 50).tolist()
    assert [adhesive_force_n(force, 0.0) for force in forces] == forces


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"modulus_mpa": 0.0}, "modulus_mpa: expected a number above 0, but found 0.0"),
        ({"modulus_mpa": math.nan}, "modulus_mpa: expected a number above 0, but found nan"),
        ({"modulus_mpa": 0.2, "tip_radius_mm": -1.0}, "tip_radius_mm: expected a number above 0"),
        ({"modulus_mpa": 0.2, "exponent": 1.0}, "exponent: expected a number between 0 and 1, but found 1.0"),
    ],
)
def test_a_contact_that_cannot_be_is_refused(settings: dict[str, float], named: str) -> None:
    with pytest.raises(SettingError, match=named):
        PowerLaw(**settings)
