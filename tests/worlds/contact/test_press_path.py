"""Whole presses: drives, schedules, and what stiffness can and cannot change."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from casr.specimens import SPECIMENS
from emg2vsa.devices.qbmove.springs import RAD_PER_TICK, SPRINGS, Springs
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.errors import DataError
from emg2vsa.worlds.contact import (
    ELASTIC,
    Drive,
    PressPaths,
    Relaxation,
    StiffnessSteps,
    in_series,
    simulate_presses,
)

MAKER_PRO = SPRINGS["qbmove-maker-pro"]
SOFT = Drive(springs=MAKER_PRO)
RELAXING = {"S1": 0.03, "S2": 0.04, "S3": 0.06, "S5": 0.12}
EDGES = np.append(np.arange(0.5, 6.9, 0.3), 7.0)
HUMAN_LIKE = {"S1": (39.1, 79.8), "S2": (35.1, 69.6), "S3": (29.7, 56.1), "S5": (21.6, 35.8)}
"Percent of the largest preset in the first and the last step."


def contact(name: str) -> PowerLaw:
    return PowerLaw(1 / (1 / 0.4 + 10 / SPECIMENS[name]))


def body(name: str, sensor: float = 0.15) -> Relaxation:
    return in_series(
        [(1 / 0.4, Relaxation.of_share(sensor)), (10 / SPECIMENS[name], Relaxation.of_share(RELAXING[name]))]
    )


def human_like(name: str) -> StiffnessSteps:
    """As a + b ln F between the ends of the specimen's profile."""
    low, high = HUMAN_LIKE[name]
    middle_n = (EDGES[1:] + EDGES[:-1]) / 2
    share = np.log(middle_n / middle_n[0]) / np.log(middle_n[-1] / middle_n[0])
    return StiffnessSteps(EDGES, (low + (high - low) * share) * 30 * RAD_PER_TICK)


def constant(percent: float) -> StiffnessSteps:
    return StiffnessSteps.constant(percent * 30 * RAD_PER_TICK)


def pressed(name: str, drive: Drive, *steps: StiffnessSteps, elastic: bool = False, step_s: float = 2e-3) -> PressPaths:
    relaxation = ELASTIC if elastic else body(name)
    return simulate_presses([contact(name)] * max(1, len(steps)), relaxation, drive, steps, step_s=step_s)


def test_a_rigid_elastic_press_is_the_power_law() -> None:
    law = contact("S1")
    paths = simulate_presses([law], ELASTIC, Drive())
    exact = [law.force_n(5.0 * time_s) for time_s in paths.time_s[:-1].tolist()]
    assert paths.force_n[:-1, 0] == pytest.approx(exact, rel=1e-9)
    assert paths.area_mm2[:-1, 0] == pytest.approx(law.area_mm2(exact), rel=1e-9)
    assert np.array_equal(paths.convolved_n, paths.force_n, equal_nan=True)
    seconds = (law.depth_mm(7.0) - law.depth_mm(0.5)) / 5
    assert paths.duration_s() == pytest.approx([seconds], abs=2e-5)


def test_springs_contact_and_friction_are_in_balance() -> None:
    paths = simulate_presses([contact("S3")], body("S3"), SOFT, [human_like("S3")], step_s=2e-3)
    ends = np.arange(0, paths.time_s.size, 40)
    mm_per_rad = math.degrees(0.2)
    preset = paths.preset_rad[:, 0]

    def pull_nm(ahead_rad: float, preset_rad: float) -> float:
        s = MAKER_PRO
        first = s.k1_nm * math.sinh(s.a1_per_rad * (ahead_rad + preset_rad))
        return first + s.k2_nm * math.sinh(s.a2_per_rad * (ahead_rad - preset_rad))

    start_rad = float(brentq(lambda ahead: pull_nm(ahead, preset[0]) - 0.01, -1.0, 1.0, xtol=1e-15))
    for k in ends[1:].tolist():
        way_mm = contact("S3").depth_mm(paths.convolved_n[k, 0])
        ahead_rad = start_rad + (5.0 * paths.time_s[k] - way_mm) / mm_per_rad
        needed_nm = paths.force_n[k, 0] * mm_per_rad / 1000 + 0.01
        assert pull_nm(ahead_rad, preset[k]) == pytest.approx(needed_nm, rel=1e-9)


def test_presets_follow_the_force_late_and_no_faster_than_motors_turn() -> None:
    paths = pressed("S1", SOFT, human_like("S1"), step_s=1e-3)
    preset, force, steps = paths.preset_rad[:, 0], paths.force_n[:, 0], human_like("S1")
    assert np.nanmax(np.diff(preset)) <= 3.75e-3 * (1 + 1e-9)
    for edge_n in (0.8, 3.2, 6.5):
        crossed = int(np.flatnonzero(force >= edge_n)[0])
        before, after = steps.preset_rad(edge_n - 0.01), steps.preset_rad(edge_n + 0.01)
        assert preset[crossed + 15] <= before + 1e-12
        assert preset[crossed + 15 + math.ceil((after - before) / 3.75e-3) + 1] >= after - 1e-12


def test_a_flat_schedule_is_the_constant() -> None:
    flat = StiffnessSteps(EDGES, np.full(EDGES.size - 1, 1500.0 * RAD_PER_TICK))
    paths = pressed("S2", SOFT, flat, constant(50))
    for table in (paths.force_n, paths.area_mm2, paths.preset_rad):
        assert np.array_equal(table[:, 0], table[:, 1], equal_nan=True)


def test_very_stiff_springs_are_a_rigid_motor() -> None:
    stiff = Drive(springs=Springs(2e4, 7.0, 2e4, 7.0, "made up"))
    one, other = pressed("S2", Drive()), pressed("S2", stiff, constant(50))
    assert other.force_n[:-1, 0] == pytest.approx(one.force_n[:-1, 0], rel=1e-4, abs=1e-6)
    assert other.rate_mm2_per_n() == pytest.approx(one.rate_mm2_per_n(), rel=1e-7)


def test_of_elastic_bodies_the_area_never_depends_on_stiffness() -> None:
    rigid = pressed("S1", Drive(), elastic=True)
    soft = pressed("S1", SOFT, constant(20), constant(80), human_like("S1"), elastic=True)
    assert np.ptp(soft.duration_s()) > 0.2
    for paths in (rigid, soft):
        known = np.isfinite(paths.force_n)
        assert paths.area_mm2[known] == pytest.approx(contact("S1").area_mm2(paths.force_n[known]), rel=1e-13)


def test_durations_by_stiffness() -> None:
    """Seconds from 0.5 to 7 N, to the two digits that were computed elsewhere."""
    found = {}
    for name in ("S1", "S5"):
        low, _ = HUMAN_LIKE[name]
        rigid = pressed(name, Drive(), elastic=True).duration_s().tolist()
        soft = pressed(name, SOFT, human_like(name), constant(low), constant(20), elastic=True).duration_s().tolist()
        found[name] = [round(seconds, 2) for seconds in rigid + soft]
    assert found == {"S1": [0.32, 0.34, 0.53, 0.65], "S5": [0.74, 0.94, 1.06, 1.06]}


def test_the_end_of_a_press_is_its_last_sample() -> None:
    paths = pressed("S1", SOFT, constant(20), constant(80))
    ends = [int(np.flatnonzero(np.isfinite(column))[-1]) for column in paths.force_n.T]
    assert paths.force_n[ends, [0, 1]].min() >= 7.0 > max(paths.force_n[end - 1, p] for p, end in enumerate(ends))
    assert max(ends) == paths.time_s.size - 1


def test_a_press_without_stiffness_or_without_end_is_refused() -> None:
    with pytest.raises(DataError, match="simulated presses: expected the stiffness of springs for each of 1 presses"):
        simulate_presses([contact("S1")], ELASTIC, SOFT)
    with pytest.raises(DataError, match=r"simulated press: expected 7 N within 0\.1 s, but found"):
        simulate_presses([contact("S1")], ELASTIC, Drive(), longest_mm=0.5)


def test_presets_below_and_above_the_steps_are_those_of_the_first_and_the_last() -> None:
    steps = StiffnessSteps(np.array([0.5, 3.0, 7.0]), np.array([0.1, 0.9]))
    presets = [steps.preset_rad(force) for force in (0.0, 0.5, 2.99, 3.0, 7.0, 9.0)]
    assert presets == [0.1, 0.1, 0.1, 0.9, 0.9, 0.9]
    assert [steps.next_n(force) for force in (0.0, 2.9, 3.0)] == [3.0, 3.0, math.inf]
