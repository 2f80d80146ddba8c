"""Domes of the library as one continuous family."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from casr.dome.library import FAMILY, shipped
from casr.errors import SettingError
from casr.kappa.estimate import of_tables
from casr.kappa.family import Family, Spline, families


def _tips(motion: NDArray[Any]) -> NDArray[Any]:
    """About how far tips of pins of 3 mm go outward."""
    return np.asarray(motion[..., 0] + 3 * motion[..., 2])


def test_weights_are_those_of_a_natural_spline_and_straight_beyond_its_ends() -> None:
    nodes, values = np.array([0.0, 0.1, 0.3, 0.34, 0.9]), np.array([1.0, -2.0, 0.5, 0.4, 3.0])
    spline, peer = Spline(nodes), CubicSpline(nodes, values, bc_type="natural")
    for at in (0.0, 0.05, 0.2, 0.32, 0.7, 0.9):
        assert spline.weights(at) @ values == pytest.approx(float(peer(at)), abs=1e-12)
    assert spline.weights(1.0) @ values == pytest.approx(float(peer(0.9) + 0.1 * peer(0.9, 1)), abs=1e-12)
    assert spline.weights(-0.1) @ values == pytest.approx(float(peer(0.0) - 0.1 * peer(0.0, 1)), abs=1e-12)


@pytest.mark.parametrize("friction", ["stick", "frictionless"])
def test_at_a_table_the_family_has_its_motion_and_its_force(friction: str) -> None:
    library = shipped()
    family = families(library)[0]
    for row in np.flatnonzero((library.dome == FAMILY[2]) & (library.friction == friction)):
        log_kappa0 = float(family.log_kappa0[2])
        z = 1 / (1 + library.stiffness_n_per_mm[row] / np.exp(log_kappa0))
        world = family.world(float(family.place[2]), z, float(friction == "stick"), log_kappa0)
        assert family.motion(world.motion) == pytest.approx(library.motion[row], abs=2e-4)
        assert np.exp(family.log_force(world)) == pytest.approx(library.force_n[row], rel=1e-6)


def test_a_dome_that_is_left_out_lies_between_its_neighbours() -> None:
    library, dome = shipped(), 3
    whole = families(library)[0]
    others = families(library.only(np.flatnonzero(library.dome != FAMILY[dome])))[0]
    row = int(np.flatnonzero((library.dome == FAMILY[dome]) & (library.friction == "stick")
                             & np.isclose(library.stiffness_n_per_mm, 5.3))[0])  # fmt: skip
    kappa0 = np.exp(whole.log_kappa0[dome])
    inside = (library.radius_mm >= 2.5) & (library.radius_mm <= 7)
    true = _tips(library.motion[row])[inside]
    z, left = 1 / (1 + 5.3 / kappa0), []
    for place in np.linspace(0, 1, 51).tolist():
        off = _tips(others.motion(others.world(place, z, 1.0, 0.0).motion))[inside] - true
        left.append(float(np.sqrt((off**2).mean() / (true**2).mean())))
    assert min(left) < 0.03
    assert min(left[0], left[-1]) > 4 * min(left)


def test_a_specimen_as_soft_as_can_be_leaves_the_dome_as_it_is() -> None:
    family = families(shipped())[0]
    assert np.abs(family.motion(family.world(0.4, 1.0 - 1e-9, 0.5, 0.0).motion)).max() < 1e-4


def test_tables_without_a_rigid_plate_are_refused() -> None:
    library = shipped()
    with pytest.raises(SettingError, match="rigid"):
        families(library.only(np.flatnonzero(np.isfinite(library.stiffness_n_per_mm))))


def test_of_several_heights_of_specimens_that_nearest_to_the_usual_counts() -> None:
    library = shipped()
    soft = library.only(np.flatnonzero(np.isfinite(library.stiffness_n_per_mm)))
    thin = replace(soft, height_mm=np.full(soft.n_worlds, 10.0), motion=2 * soft.motion)
    family, usual = (families(each)[0] for each in (thin.beside(library), library))
    weights = usual.world(0.4, 0.3, 1.0, 0.0).motion
    assert family.motion(weights) == pytest.approx(usual.motion(weights), abs=1e-6)


def test_a_lab_s_own_dome_is_a_family_of_one() -> None:
    library = shipped()
    own = library.only(np.flatnonzero(library.dome == FAMILY[1]))
    found = families(library.beside(replace(own, dome=np.full(own.n_worlds, "mine"))))
    assert [family.names for family in found] == [FAMILY, ("mine",)]
    assert isinstance(found[1], Family)
    assert found[1].log_kappa0[0] == pytest.approx(found[0].log_kappa0[1])


def test_own_tables_that_are_incomplete_are_named() -> None:
    """A dome of a lab's own without one friction on one specimen: the domes of casr still count, and a note says so."""
    library = shipped()
    mine = library.only(np.flatnonzero(library.dome == "H"))
    mine = replace(mine, dome=np.full(mine.dome.shape, "mine"))
    assert of_tables(library.beside(mine)) == []
    lacking = library.beside(mine.only(np.arange(1, mine.dome.size)))
    assert [family.names for family in families(lacking)] == [FAMILY]
    (note,) = of_tables(lacking)
    assert note.startswith("Tables of dome mine are not used")
