"""One contact that comes down at a tilt against Mindlin, friction and the mount."""

from __future__ import annotations

import math

import numpy as np
import pytest

from casr.specimens import SPECIMENS
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.errors import SettingError
from emg2vsa.worlds.contact import ELASTIC, ContactHistory, ConvolvedForce, Relaxation, area_share, in_series

STICKS = 1e6
SOFT = in_series([(0.4, Relaxation.of_share(0.3)), (0.6, Relaxation.of_share(0.1))])
SKIN = {"friction": 0.6, "friction_drop": 0.05, "mount_n_per_mm": 30.0}
LOOSE = {"friction": STICKS, "friction_drop": 0.0, "mount_n_per_mm": math.inf}


def contact(name: str, exponent: float = 0.25) -> PowerLaw:
    return PowerLaw(1 / (1 / 0.4 + 10 / SPECIMENS[name]), exponent=exponent)


def pressed(
    law: PowerLaw, body: Relaxation, angle_deg: float, way_mm: float = 2.0, steps: int = 400, **skin: float
) -> tuple[float, float]:
    """Normal and shear force at the end of an even way along an axis that stands at a tilt."""
    history, tilt, before_n, step_mm = (
        ContactHistory(body, **LOOSE | skin),
        math.radians(angle_deg),
        0.0,
        way_mm / steps,
    )
    for k in range(1, steps + 1):
        elastic_n = law.force_n(k * step_mm * math.cos(tilt))
        history.begin(step_mm / 5.0)
        slope = (elastic_n - before_n) / (step_mm * math.cos(tilt))
        forces, before_n = history.advance(elastic_n, slope, step_mm * math.sin(tilt)), elastic_n
    return forces


@pytest.mark.parametrize("angle_deg", [10.0, 45.0])
@pytest.mark.parametrize(("name", "exponent", "share"), [("S1", 0.25, 0.0), ("S5", 1 / 3, 0.0), ("S5", 0.25, 0.3)])
def test_a_straight_oblique_way_sticks_by_two_thirds_of_its_tangent(
    angle_deg: float, name: str, exponent: float, share: float
) -> None:
    """Whatever the bodies: their modulus, the radius law, relaxation (Mindlin and Deresiewicz 1953)."""
    normal_n, shear_n = pressed(contact(name, exponent), Relaxation.of_share(share), angle_deg)
    assert shear_n / normal_n == pytest.approx(2 / 3 * math.tan(math.radians(angle_deg)), rel=1e-12)


def test_from_the_critical_angle_on_it_slides_everywhere() -> None:
    critical_deg = math.degrees(math.atan(1.5 * 0.6))
    normal_n, shear_n = pressed(contact("S1"), ELASTIC, critical_deg - 0.1, friction=0.6)
    assert shear_n / normal_n == pytest.approx(2 / 3 * math.tan(math.radians(critical_deg - 0.1)), rel=1e-12)
    normal_n, shear_n = pressed(contact("S1"), ELASTIC, critical_deg + 0.1, friction=0.6)
    assert shear_n / normal_n == pytest.approx(0.6)


@pytest.mark.parametrize(("name", "mount"), [("S1", 5.0), ("S5", 5.0), ("S5", 20.0)])
def test_a_soft_mount_takes_its_share_of_the_way(name: str, mount: float) -> None:
    """Contact and mount in series along the whole way, by quadrature; a stiff mount is the limit."""
    law, way_mm = contact(name), 2.0
    nodes, weights = np.polynomial.legendre.leggauss(80)
    # the way is taken as y^4, so that the root at its start is smooth
    ways = way_mm * ((nodes + 1) / 2) ** 4
    steps = way_mm * 4 * ((nodes + 1) / 2) ** 3 / 2 * weights
    slopes = np.array([law.resistance(way * math.cos(math.pi / 4))[1] for way in ways.tolist()])
    exact = float(steps @ (math.sin(math.pi / 4) / (1 / (2 / 3 * slopes) + 1 / mount)))
    assert pressed(law, ELASTIC, 45, steps=2000, mount_n_per_mm=mount)[1] == pytest.approx(exact, rel=1e-6)
    normal_n, shear_n = pressed(law, ELASTIC, 45, mount_n_per_mm=1e9)
    assert shear_n / normal_n == pytest.approx(2 / 3, rel=1e-7)


def test_a_slip_loses_twice_what_friction_loses() -> None:
    history = ContactHistory(ELASTIC, friction=0.6, friction_drop=0.05, mount_n_per_mm=math.inf)

    def shear_n(way_mm: float, normal_n: float = 2.0) -> float:
        history.begin(0.001)
        return history.advance(normal_n, 4.5, way_mm)[1]

    assert shear_n(0.1) == pytest.approx(2 / 3 * 4.5 * 0.1)
    assert history.way_mm == pytest.approx(0.1)
    assert shear_n(5.0) == pytest.approx(0.5 * 2.0)
    assert history.way_mm == pytest.approx(0.5 * 2.0 / (2 / 3 * 4.5))
    # back the other way it sticks first
    assert shear_n(-0.01) == pytest.approx(0.5 * 2.0 - 2 / 3 * 4.5 * 0.01)
    assert shear_n(-5.0) == pytest.approx(-0.5 * 2.0)
    assert shear_n(0.01, 0.0) == 0.0
    history.reset()
    assert history.way_mm == 0.0


@pytest.mark.parametrize("body", [SOFT, ELASTIC])
def test_the_normal_force_is_the_convolved_one_and_looking_changes_nothing(body: Relaxation) -> None:
    """Over steps that stick, slip, let go and begin anew, looked at several times before they are taken."""
    history, unseen, normal = ContactHistory(body, **SKIN), ContactHistory(body, **SKIN), ConvolvedForce([body])
    rng, seen, elastic_n = np.random.default_rng(3), {"stuck": 0, "slid": 0, "apart": 0}, 0.0
    for k in range(600):
        step_s = float(rng.choice([0.001, 0.0009999999999998899, 0.03]))
        elastic_n = max(0.0, elastic_n + float(rng.normal(0.05 if k % 150 < 100 else -0.2, 0.05)))
        slope, way_mm = 1 + elastic_n, float(rng.normal(0.002 * (k % 60), 0.01))
        history.begin(step_s)
        unseen.begin(step_s)
        alpha, beta = normal.alpha_beta(step_s)
        for asked_n in (elastic_n + 0.1, elastic_n):
            assert history.forces(asked_n, slope, way_mm)[0] == max(0.0, float((asked_n - alpha[0]) / beta[0]))
        normal_n, shear_n = history.advance(elastic_n, slope, way_mm)
        assert unseen.advance(elastic_n, slope, way_mm) == (normal_n, shear_n)
        assert abs(shear_n) <= 0.6 * normal_n
        normal.advance(step_s, np.array([normal_n]))
        seen["apart" if normal_n == 0 else "stuck" if abs(shear_n) < 0.5 * normal_n - 1e-12 else "slid"] += 1
        if k % 150 == 149:
            elastic_n, normal = 0.0, ConvolvedForce([body])
            history.reset()
            unseen.reset()
    assert min(seen.values()) > 10, seen


def test_shear_shrinks_the_contact_by_a_tenth_at_most() -> None:
    shares = [area_share(shear_n, normal_n, 0.6) for shear_n, normal_n in ((0.0, 0.0), (0.6, 2.0), (-1.2, 2.0))]
    assert shares == pytest.approx([1, 0.975, 0.9])
    assert area_share(0.0, 2.0, 0.0) == 1.0


@pytest.mark.parametrize(
    ("skin", "named"),
    [
        ({"friction": -0.1}, "friction: expected a coefficient of 0 or more"),
        ({"friction": math.nan}, "friction: expected a coefficient of 0 or more"),
        ({"friction": 0.1, "friction_drop": 0.06}, "friction: expected .* but found 0.1, less 0.06 in sliding"),
        ({"friction": 0.6, "mount_n_per_mm": 0.0}, "mount_n_per_mm: expected a number above 0, but found 0.0"),
    ],
)
def test_friction_and_mounts_that_cannot_be_are_refused(skin: dict[str, float], named: str) -> None:
    with pytest.raises(SettingError, match=named):
        ContactHistory(ELASTIC, **LOOSE | skin)
