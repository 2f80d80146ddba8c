"""Every press weighs its specimen: kappa by force over depth, another specimen named, and a run ended by it."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.rig.plans import modular_plan, rigid_plan
from benchmarks.specimen_witness import Case, press
from casr.specimens import SPECIMENS
from emg2vsa.dome_contact import ElasticDome
from emg2vsa.rig.executor.specimen_witness import SpecimenWitness
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.rig_settings import RigSettings

TURN_S, SPEED_MM_PER_S, FROM_MM, REST = 0.005, 5.0, 3.0, 10
CREEP = 0.025
"""Stiffness over time, to a power: 1 after 1 s."""


def loaded(
    plan: RunPlan, kappa: float, *, gain: float = 1.0, share: float = 0.0, noise_n: float = 0.0
) -> tuple[SpecimenWitness, list[float | None]]:
    """A press of relaxing bodies on a slope, and what the witness says in each turn of the loading. ``share`` : of the
    normal force, by which the skin is held along the slope."""
    witness, contact, rng = SpecimenWitness(plan, RigSettings()), ElasticDome().on(kappa), np.random.default_rng(1)
    sin, cos = (each(math.radians(plan.angle_deg)) for each in (math.sin, math.cos))
    step_mm = SPEED_MM_PER_S * TURN_S
    approach = np.arange(0.0, contact.depth_mm(0.5) / cos, step_mm)
    depths_mm = np.r_[approach, np.full(REST, approach[-1]), approach[-1] + step_mm * np.arange(1, 600)]
    elastic_n = [contact.force_n(depth_mm * cos) for depth_mm in depths_mm]
    since_s = TURN_S * (np.arange(len(depths_mm)) + 0.5)
    normals_n = np.convolve(np.diff(elastic_n, prepend=0.0), since_s**-CREEP)[: len(depths_mm)]
    said: list[float | None] = []
    for turn, (depth_mm, normal_n) in enumerate(zip(depths_mm, normals_n, strict=True), start=-approach.size - REST):
        along_n, across_n = normal_n * (cos + share * sin), normal_n * abs(sin - share * cos)
        felt_n = gain * along_n + noise_n * rng.standard_normal()
        if felt_n > plan.f_max_n:
            break
        if turn >= -REST:
            loaded_s = None if turn < 0 else turn * TURN_S
            said.append(witness.read(felt_n, gain * across_n, FROM_MM + depth_mm, loaded_s))
    return witness, said[REST:]


@pytest.mark.parametrize(("angle_deg", "share"), [(0.0, 0.0), (30.0, 0.0), (30.0, 0.38), (45.0, 0.6)])
@pytest.mark.parametrize("name", ["S1", "S3", "S5"])
def test_a_press_tells_kappa_whatever_the_skin_holds(name: str, angle_deg: float, share: float) -> None:
    plan = modular_plan(1, specimen=name, angle_deg=angle_deg)
    witness, said = loaded(plan, SPECIMENS[name], share=share)
    kappa = witness.kappa()
    assert kappa is not None
    assert kappa.low < SPECIMENS[name] < kappa.high
    assert kappa.kappa == pytest.approx(SPECIMENS[name], rel=0.05)
    assert witness.doubt() is None
    assert max(abs(each) for each in said if each is not None) < 0.1


def test_another_specimen_is_named() -> None:
    plan = modular_plan(1, specimen="S1", others_n_per_mm={"S3": 3.35, "S2": 5.32, "same": 5.32})
    witness, _ = loaded(plan, 5.32)
    doubt = witness.doubt() or ""
    assert doubt.startswith("this presses like S2 or same (5")
    assert "not S1, 7.63 N/mm" in doubt
    witness, _ = loaded(plan, 1.5)
    assert (witness.doubt() or "").startswith("this presses like another specimen (1.")


def test_a_rigid_body_is_told_as_one() -> None:
    witness, _ = loaded(modular_plan(1, specimen="S1"), 300.0)
    kappa = witness.kappa()
    assert kappa is not None
    assert kappa.high == math.inf
    assert str(kappa).endswith("to rigid")


@pytest.mark.parametrize("gain", [0.2, 0.5, 0.7, 1.4])
def test_a_wrong_gain_speaks_early(gain: float) -> None:
    _, said = loaded(rigid_plan(1, specimen="S1"), SPECIMENS["S1"], gain=gain)
    first = next(turn for turn, each in enumerate(said) if each and abs(each) > RigSettings().guards.specimen_share)
    true_n = ElasticDome().on(SPECIMENS["S1"])
    assert true_n.force_n(true_n.depth_mm(0.5) + SPEED_MM_PER_S * TURN_S * first) < 4.0


def test_noise_is_no_other_specimen() -> None:
    _, said = loaded(modular_plan(1, specimen="S1"), SPECIMENS["S1"], noise_n=0.2)
    assert max(abs(each) for each in said if each is not None) < RigSettings().guards.specimen_share


def test_who_knows_nothing_says_nothing() -> None:
    unknown = replace(modular_plan(1, specimen="S1"), stiffness_n_per_mm=None)
    witness, said = loaded(unknown, 7.63)
    assert set(said) == {None}
    assert witness.kappa() is not None
    assert witness.doubt() is None
    plate, said = loaded(replace(rigid_plan(1, specimen="S1"), plate=True), 7.63)
    assert set(said) == {None}
    assert (plate.kappa(), plate.doubt()) == (None, None)


def test_a_press_too_weak_to_tell_tells_nothing() -> None:
    witness, _ = loaded(modular_plan(1, specimen="S5", f_max_n=1.8), SPECIMENS["S5"])
    assert (witness.kappa(), witness.doubt()) == (None, None)


@pytest.mark.parametrize("actuator", ["qbmove", "rigid", "dynamixel"])
@pytest.mark.parametrize(("told", "on"), [("S1", "S1"), ("S5", "S5"), ("S1", "S2"), ("S2", "S1"), ("S5", "S1")])
def test_on_the_emulated_rig(actuator: Any, told: str, on: str, tmp_path: Path) -> None:
    ended = press(Case(actuator, told, on, 0.0, 1), tmp_path / "run")
    (row,) = csv.DictReader((tmp_path / "run" / "presses.csv").read_text().splitlines())
    if told == on:
        assert (ended.how, row["verdict"]) == ("completed", "ok")
        assert float(row["kappa_low_n_per_mm"]) < SPECIMENS[on] < float(row["kappa_high_n_per_mm"])
    elif "S5" in (told, on):
        assert (ended.how, ended.cause, ended.retracted) == ("guard", "specimen", True)
        assert (ended.peak_force_n or 0.0) < 4.0
        assert row["kappa_n_per_mm"] == ""
    else:
        assert (ended.how, row["verdict"]) == ("completed", "doubtful")
        assert row["why"].startswith(f"this presses like {on} (")
