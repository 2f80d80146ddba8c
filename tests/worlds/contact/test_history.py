"""The scalar recursion against a contact that keeps its whole history."""

from __future__ import annotations

import math

import numpy as np
import pytest

from emg2vsa.dome_contact import PowerLaw
from emg2vsa.worlds.contact import ConvolvedForce
from tests.worlds.contact.history_keeping import ElementRow, maxwell

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
