"""Shear force of a tilted probe against Mindlin, friction and the mount."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from casr.specimens import SPECIMENS
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.errors import SettingError
from emg2vsa.worlds.contact import (
    ELASTIC,
    Drive,
    Relaxation,
    Shear,
    Tilt,
    area_share,
    area_share_of_one,
    in_series,
    simulate_presses,
)

STICKS = 1e6


def contact(name: str, exponent: float = 0.25) -> PowerLaw:
    return PowerLaw(1 / (1 / 0.4 + 10 / SPECIMENS[name]), exponent=exponent)


def ratio_at_7_n(law: PowerLaw, body: Relaxation, **tilt: Any) -> float:
    paths = simulate_presses([law], body, Drive(), tilt=Tilt(**tilt), step_s=0.005)
    return float((paths.at_forces(paths.shear_n, [7.0]) / paths.at_forces(paths.normal_n, [7.0]))[0, 0])


@pytest.mark.parametrize("angle_deg", [10.0, 30.0, 45.0])
@pytest.mark.parametrize("name", ["S1", "S5"])
@pytest.mark.parametrize(("exponent", "share"), [(0.25, 0.0), (1 / 3, 0.0), (0.25, 0.3)])
def test_a_straight_oblique_way_sticks_by_two_thirds_of_its_tangent(
    angle_deg: float, name: str, exponent: float, share: float
) -> None:
    """Whatever the bodies: their modulus, the radius law, relaxation (Mindlin and Deresiewicz 1953)."""
    ratio = ratio_at_7_n(contact(name, exponent), Relaxation.of_share(share), angle_deg=angle_deg, friction=STICKS)
    assert ratio == pytest.approx(2 / 3 * math.tan(math.radians(angle_deg)), rel=1e-12)


def test_from_the_critical_angle_on_it_slides_everywhere() -> None:
    critical_deg = math.degrees(math.atan(1.5 * 0.6))
    held = ratio_at_7_n(contact("S1"), ELASTIC, angle_deg=critical_deg - 0.1, friction=0.6)
    assert held == pytest.approx(2 / 3 * math.tan(math.radians(critical_deg - 0.1)), rel=1e-12)
    assert ratio_at_7_n(contact("S1"), ELASTIC, angle_deg=critical_deg + 0.1, friction=0.6) == pytest.approx(0.6)


@pytest.mark.parametrize(
    ("angle_deg", "friction", "percent"),
    [(30, 0.3, -7.7), (30, STICKS, -9.5), (45, 0.3, -12.3), (45, 0.6, -20.9), (45, STICKS, -22.5)],
)
def test_friction_takes_normal_force_and_area_away(angle_deg: float, friction: float, percent: float) -> None:
    law = contact("S1")
    ratio = ratio_at_7_n(law, ELASTIC, angle_deg=angle_deg, friction=friction)
    tangent = math.tan(math.radians(angle_deg))
    # the same force along the axis: P (1 + ratio tan) with friction, P without
    assert 100 * (float(law.area_mm2(7 / (1 + ratio * tangent)) / law.area_mm2(7.0)) - 1) == pytest.approx(
        percent, abs=0.06
    )


@pytest.mark.parametrize("name", ["S1", "S5"])
@pytest.mark.parametrize("mount", [5.0, 20.0])
def test_a_soft_mount_takes_its_share_of_the_way(name: str, mount: float) -> None:
    """Contact and mount in series along the whole way, by quadrature."""
    law = contact(name)
    paths = simulate_presses(
        [law], ELASTIC, Drive(), tilt=Tilt(angle_deg=45, friction=STICKS, mount_n_per_mm=mount), step_s=5e-4
    )
    last = paths.time_s.size - 1
    nodes, weights = np.polynomial.legendre.leggauss(80)
    # the way is taken as y^4, so that the root at its start is smooth
    ways = 5.0 * paths.time_s[last] * ((nodes + 1) / 2) ** 4
    steps = 5.0 * paths.time_s[last] * 4 * ((nodes + 1) / 2) ** 3 / 2 * weights
    slopes = np.array([law.resistance(way * math.cos(math.pi / 4))[1] for way in ways.tolist()])
    exact = float(steps @ (math.sin(math.pi / 4) / (1 / (2 / 3 * slopes) + 1 / mount)))
    assert paths.shear_n[last, 0] == pytest.approx(exact, rel=1e-6)


def test_a_rigid_mount_is_the_limit_of_stiff_ones() -> None:
    stiff = ratio_at_7_n(contact("S1"), ELASTIC, angle_deg=45, friction=STICKS, mount_n_per_mm=1e9)
    assert stiff == pytest.approx(2 / 3, rel=1e-7)


def test_a_slip_loses_twice_what_friction_loses() -> None:
    shear = Shear(ELASTIC, 0.0, friction=0.6, friction_drop=0.05)
    assert shear.advance(0.001, 0.1, 4.5, 2.0) == pytest.approx(2 / 3 * 4.5 * 0.1)
    assert shear.way_mm == pytest.approx(0.1)
    assert shear.advance(0.001, 5.0, 4.5, 2.0) == pytest.approx(0.5 * 2.0)
    assert shear.way_mm == pytest.approx(0.5 * 2.0 / (2 / 3 * 4.5))
    # back the other way it sticks first
    assert shear.advance(0.001, -0.01, 4.5, 2.0) == pytest.approx(0.5 * 2.0 - 2 / 3 * 4.5 * 0.01)
    assert shear.advance(0.001, -5.0, 4.5, 2.0) == pytest.approx(-0.5 * 2.0)
    assert shear.advance(0.001, 0.01, 4.5, 0.0) == 0.0
    shear.reset()
    assert (shear.force_n, shear.way_mm) == (0.0, 0.0)


def test_many_contacts_shear_as_each_alone() -> None:
    body = in_series([(2.5, Relaxation.of_share(0.15)), (1.9, Relaxation.of_share(0.04))])
    settings: dict[str, float] = {"friction": 0.6, "friction_drop": 0.05, "mount_n_per_mm": 30.0}
    together = Shear(body, np.zeros(2), **settings)
    alone = [Shear(body, 0.0, **settings) for _ in range(2)]
    for k in range(1, 20):
        way, normal = np.array([0.02, 0.3]), np.array([0.1 * k, 0.2 * k])
        got = together.advance(0.01, way, np.array([3.0, 4.0]), normal)
        each = [
            shear.advance(0.01, w, slope, n)
            for shear, w, slope, n in zip(alone, way.tolist(), (3.0, 4.0), normal.tolist(), strict=True)
        ]
        assert got.tolist() == each
    assert together.way_mm.tolist() == [shear.way_mm for shear in alone]


def test_shear_shrinks_the_contact_by_a_tenth_at_most() -> None:
    assert area_share([0.0, 0.6, -1.2, 0.0], [0.0, 2.0, 2.0, 3.0], 0.6).tolist() == pytest.approx([1, 0.975, 0.9, 1])
    assert float(area_share(0.0, 2.0, 0.0)) == 1.0


@pytest.mark.parametrize("friction", [0.0, 0.57])
def test_the_share_of_one_contact_is_that_of_many_to_the_last_bit(friction: float) -> None:
    normal_n = np.append(0.0, np.random.default_rng(2).uniform(0, 8, 2000))
    shear_n = np.random.default_rng(3).uniform(-0.6, 0.6, normal_n.size) * normal_n
    of_one = [area_share_of_one(q, p, friction) for q, p in zip(shear_n.tolist(), normal_n.tolist(), strict=True)]
    assert of_one == area_share(shear_n, normal_n, friction).tolist()


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"friction": -0.1}, "friction: expected a coefficient of 0 or more"),
        ({"friction": math.nan}, "friction: expected a coefficient of 0 or more"),
        ({"friction": 0.1, "friction_drop": 0.06}, "friction: expected .* but found 0.1, less 0.06 in sliding"),
        ({"friction": 0.6, "mount_n_per_mm": 0.0}, "mount_n_per_mm: expected a number above 0, but found 0.0"),
    ],
)
def test_friction_and_mounts_that_cannot_be_are_refused(settings: dict[str, float], named: str) -> None:
    with pytest.raises(SettingError, match=named):
        Shear(ELASTIC, 0.0, **settings)
