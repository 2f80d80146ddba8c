"""The convolved force against closed forms, and against a contact that keeps its whole history."""

from __future__ import annotations

import math

import numpy as np
import pytest

from emg2vsa.dome_contact import PowerLaw
from emg2vsa.errors import SettingError
from emg2vsa.worlds.contact import ELASTIC, ConvolvedForce, Relaxation, in_series
from emg2vsa.worlds.contact.relaxation import TAUS_S
from tests.worlds.contact.history_keeping import ElementRow, convolved_force_n, maxwell


def compliance(body: Relaxation, time_s: float | np.ndarray) -> np.ndarray:
    """J at times after a step of force."""
    branches = zip(body.branches, body.taus_s, strict=True)
    return np.asarray(body.instant - sum(each * np.expm1(-time_s / tau) for each, tau in branches))


SHARES = [0.01, 0.03, 0.12, 0.3, 0.6]


@pytest.mark.parametrize("share", SHARES)
def test_the_share_relaxes_between_a_tenth_and_ten_seconds(share: float) -> None:
    early, late = Relaxation.of_share(share).modulus([0.1, 10.0])
    assert 1 - late / early == pytest.approx(share, rel=1e-9)


@pytest.mark.parametrize("share", SHARES)
def test_the_compliance_is_1_after_a_second_and_its_inverse_is_the_modulus(share: float) -> None:
    body = Relaxation.of_share(share)
    assert compliance(body, 1.0) == pytest.approx(1.0, rel=1e-14)
    assert compliance(body, 0.0) == pytest.approx(1 / body.modulus(0.0), rel=1e-12)
    assert compliance(body, 1e5) == pytest.approx(1 / body.modulus(1e5), rel=1e-9)
    # a step of depth: the force that relaxes gives that depth again
    time_s = np.concatenate([[0.0], np.geomspace(1e-5, 20, 4000)])
    assert convolved_force_n(body, time_s, body.modulus(time_s))[1:] == pytest.approx(1.0, abs=2e-6)


@pytest.mark.parametrize("slope_n_per_s", [0.5, 20.0])
@pytest.mark.parametrize("step_s", [0.001, 0.005, 0.1])
def test_a_ramp_of_force_is_exact(slope_n_per_s: float, step_s: float) -> None:
    """g = J0 c t + sum of J_k c (t - tau_k (1 - exp(-t / tau_k)))."""
    body = in_series([(2.5, Relaxation.of_share(0.15)), (1.3, Relaxation.of_share(0.3))])
    time_s = np.arange(0, 1 + step_s / 2, step_s)
    exact = body.instant * time_s
    for branch, tau in zip(body.branches, body.taus_s, strict=True):
        exact = exact + branch * (time_s + tau * np.expm1(-time_s / tau))
    got = convolved_force_n(body, time_s, slope_n_per_s * time_s)
    assert got == pytest.approx(slope_n_per_s * exact, rel=1e-12, abs=1e-14)


def test_an_elastic_contact_follows_the_force_to_the_last_bit() -> None:
    rng = np.random.default_rng(18)
    time_s, force_n = np.cumsum(rng.uniform(0.001, 0.01, 300)), rng.uniform(0, 7, 300)
    assert Relaxation.of_share(0.0) is ELASTIC
    assert in_series([(2.5, ELASTIC), (1.3, ELASTIC)]) == ELASTIC
    assert np.array_equal(convolved_force_n(ELASTIC, time_s, force_n), force_n)
    assert ConvolvedForce([ELASTIC]).alpha_beta(0.001) == (0.0, 1.0)


@pytest.mark.parametrize(("step_s", "within"), [(0.005, 3e-6), (0.001, 1.1e-7)])
def test_a_ramp_of_depth_on_a_maxwell_body_is_dawsons_function(step_s: float, within: float) -> None:
    long_mpa, arm_mpa, tau_s, speed, end_s, radius = 0.3, 0.1, 0.3, 5.0, 0.4, 20.0
    # 6.108172512 of the formula in the module's source; the same by 30 digits of mpmath
    exact_n = 6.108172512
    body, after_1_s_mpa = maxwell(long_mpa, arm_mpa, tau_s)
    contact = PowerLaw(after_1_s_mpa, radius, 1 / 3)
    state = ConvolvedForce([body])
    for k in range(1, round(end_s / step_s) + 1):
        alpha, beta = state.alpha_beta(step_s)
        state.advance(step_s, (contact.force_n(speed * k * step_s) - alpha) / beta)
    assert state.force_n == pytest.approx([exact_n], rel=within)


def test_many_contacts_at_once_are_each_alone_and_as_alpha_and_beta_say() -> None:
    bodies = [Relaxation.of_share(0.2), Relaxation.of_share(0.3), ELASTIC]
    together, alone = ConvolvedForce(bodies), [ConvolvedForce([body]) for body in bodies]
    for step_s, row in ((0.01, [0.5, 1.0, 2.0]), (0.01, [3.0, 2.0, 1.0]), (0.02, [7.0, 0.0, 0.5])):
        forces = np.array(row)
        alpha, beta = together.alpha_beta(step_s)
        got = together.advance(step_s, forces)
        assert got == pytest.approx(alpha + beta * forces, rel=1e-14)
        assert got.tolist() == [float(one.advance(step_s, forces[k : k + 1])[0]) for k, one in enumerate(alone)]


def test_bodies_in_series_add_their_compliances() -> None:
    sensor, specimen = Relaxation.of_share(0.15), Relaxation.of_share(0.04)
    both = in_series([(2.5, sensor), (10 / 5.32, specimen)])
    time_s = np.array([0.001, 0.1, 1.0, 30.0])
    alone = (2.5 * compliance(sensor, time_s) + 10 / 5.32 * compliance(specimen, time_s)) / (2.5 + 10 / 5.32)
    assert compliance(both, time_s) == pytest.approx(alone, rel=1e-14)
    assert both.taus_s == TAUS_S


@pytest.mark.parametrize("share", [-0.01, 0.81, math.nan, math.inf])
def test_a_share_that_cannot_be_is_refused(share: float) -> None:
    with pytest.raises(SettingError, match=r"relaxation: expected a share of the force, 0 to 0\.8, but found"):
        Relaxation.of_share(share)


LONG, ARM, TAU = 0.3, 0.1, 0.3


def test_the_reference_unloads_as_ting_solved_it() -> None:
    """Down at 5 mm/s for 0.4 s, up at 5 mm/s for 0.1 s (Ting 1966): at t1 = 0.293127 s the edge was there before."""
    row = ElementRow(LONG, ARM, TAU, exponent=1 / 3, widest_mm=math.sqrt(20 * 2.0), count=6000)
    step_s = 0.001
    for k in range(1, 501):
        force_n = row.advance(step_s, 5.0 * step_s * min(k, 800 - k))
        if k == 400:
            assert force_n == pytest.approx(6.108172512, rel=2e-6)
    assert force_n == pytest.approx(3.54474, rel=2e-5)
    assert row.edge_mm() == pytest.approx(math.sqrt(20 * 5 * 0.293127), abs=2 * math.sqrt(40) / 6000)


def forces(name: str, time_s: float) -> float:
    if name == "ramp":
        return 14.0 * time_s
    if name == "hold":
        return 7.0 * min(1.0, time_s / 0.2)
    return 7.0 * (time_s / 0.5) ** 1.3 * (1 + 0.12 * math.sin(12 * time_s))


@pytest.mark.parametrize("name", ["ramp", "hold", "uneven"])
@pytest.mark.parametrize("exponent", [0.25, 1 / 3])
def test_in_first_loading_the_area_is_that_of_1500_elements(name: str, exponent: float) -> None:
    body, after_1_s_mpa = maxwell(LONG, ARM, TAU)
    law, state = PowerLaw(after_1_s_mpa, exponent=exponent), ConvolvedForce([body])
    row = ElementRow(LONG, ARM, TAU, exponent=exponent, widest_mm=1.1 * float(law.radius_mm(8.5)))
    step_s, ratios, guess_mm = 0.004, [], 0.05
    for k in range(1, 126):
        force_n = forces(name, k * step_s)
        guess_mm = row.depth_for(step_s, force_n, max(guess_mm, row.depth_mm * 1.001))
        row.advance(step_s, guess_mm)
        area_mm2 = float(law.area_mm2(state.advance(step_s, np.array([force_n])))[0])
        if force_n > 0.5:
            ratios.append(area_mm2 / (math.pi * row.radius_mm(row.depth_mm) ** 2))
    assert np.array(ratios) == pytest.approx(1.0, abs=1e-4)
