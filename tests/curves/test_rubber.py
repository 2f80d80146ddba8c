"""Laws of rubber: the cylinder's force, moduli that are found again, the law that is chosen, real silicone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.curves.force_range import fit_range, loading
from emg2vsa.curves.rubber import LAWS, STRAIN, Cylinder, Rubber, fit_rubber
from emg2vsa.readers.press_table import read_press_table
from emg2vsa.rig_file.silicone_kit import SILICONES

SIZE = Cylinder(50, 30)
SECOND = {"line": 1.0, "neo-hooke": 1.0, "yeoh": 15.0, "ogden": 4.0}


def pressed(law: str, modulus_kpa: float, size: Cylinder = SIZE, noise_n: float = 0.01, seed: int = 0) -> Rubber:
    depth = np.arange(-0.5, 11, 0.0167)
    noise = noise_n * np.random.default_rng(seed).standard_normal(depth.size)
    force = np.where(depth > 0, size.force_n(np.maximum(depth, 0), modulus_kpa, SECOND[law], law), 0.0) + noise
    return fit_rubber(*loading(depth, force)[:2], size, fit_range(depth, force, (0.5, 7.0), size.height_mm))


@pytest.mark.parametrize("law", LAWS)
def test_all_laws_start_with_young_s_modulus(law: str) -> None:
    small = 1e-5 * SIZE.height_mm
    area_m2 = np.pi / 4 * 0.05**2
    assert SIZE.force_n(np.array([small]), 20.0, SECOND[law], law)[0] == pytest.approx(20e3 * area_m2 * 1e-5, rel=1e-3)


def test_a_neo_hookean_cylinder_of_a_third_of_its_height() -> None:
    # Treloar 1975: sigma = E / 3 (s^-2 - s) on the area as cast, s = 2/3
    force = SIZE.force_n(np.array([10.0]), 12.0)
    assert force[0] == pytest.approx(np.pi / 4 * 50**2 * 4e-3 * (9 / 4 - 2 / 3))


def test_ends_that_cannot_slide_are_stiffer_by_the_shape_factor() -> None:
    bonded = Cylinder(50, 30, "bonded")
    assert bonded.n_per_mm_per_kpa / SIZE.n_per_mm_per_kpa == pytest.approx(1 + 2 * (50 / 120) ** 2)
    loose = pressed("neo-hooke", 20.0)
    assert pressed("neo-hooke", 20.0, bonded).modulus_kpa == pytest.approx(loose.modulus_kpa, rel=0.02)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("modulus_kpa", [15.0, 60.0])
def test_moduli_are_found_again_and_intervals_hold_them(law: str, modulus_kpa: float) -> None:
    held, near = [], SIZE.force_n(np.array([STRAIN * SIZE.height_mm]), modulus_kpa, SECOND[law], law)[0]
    over_strain = near / (STRAIN * SIZE.height_mm) / SIZE.n_per_mm_per_kpa
    for seed in range(20):
        found = pressed(law, modulus_kpa, seed=seed)
        fits = {each.law: each for each in found.laws}
        held.append(abs(fits[law].modulus_kpa - modulus_kpa) <= 3 * fits[law].modulus_se_kpa)
        assert found.modulus_kpa == pytest.approx(over_strain, rel=0.04)
        assert fits[law].left_n == pytest.approx(0.01, rel=0.2)
    assert np.mean(held) > 0.9


@pytest.mark.parametrize("law", ["line", "neo-hooke", "yeoh"])
def test_the_law_that_made_a_soft_press_fits_best(law: str) -> None:
    best = [min(pressed(law, 10.0, seed=seed).laws, key=lambda each: each.aicc) for seed in range(20)]
    assert [each.law for each in best].count(law) > 14


def test_a_press_that_is_too_shallow_has_no_modulus() -> None:
    depth = np.arange(-0.5, 1.2, 0.0167)
    force = SIZE.force_n(np.maximum(depth, 0), 60.0)
    found = fit_rubber(depth, force, SIZE, fit_range(depth, force, (0.5, 7.0)))
    assert np.isnan(found.modulus_kpa)
    assert fit_rubber(depth, -force, SIZE, fit_range(depth, -force, (0.5, 7.0))).laws == ()


def test_moduli_of_real_silicone_are_the_published_ones(shared_data: Callable[[str], Path]) -> None:
    folder = shared_data("phantoms")
    for silicone in SILICONES:
        moduli = []
        for path in folder.glob(f"{silicone.name}/*.csv"):
            table = read_press_table(path)
            press = fit_range(table.depth_mm, table.force_n, (0.5, 7.0), 30)
            moduli.append(fit_rubber(*loading(table.depth_mm, table.force_n)[:2], SIZE, press).modulus_kpa)
        assert len(moduli) == 5
        allowed = max(0.065, 2 * silicone.sd_kpa / silicone.modulus_kpa)
        assert abs(np.mean(moduli) / silicone.modulus_kpa - 1) < allowed, silicone.name
