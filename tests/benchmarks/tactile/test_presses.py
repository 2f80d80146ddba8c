"""The comparison of whole presses on a small study."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import benchmarks.tactile
from benchmarks.tactile.chain_errors import ANGLES_DEG, STIFFNESS_N_MM, judge, recommendation, stiffness_errors
from benchmarks.tactile.press_scores import CHAINS, TRUE_AREA, PressScores, scored
from benchmarks.tactile.presses import failures, tables
from casr.contact_area import RULES
from casr.errors import SettingError
from casr.flow.estimate import ENGINES
from emg2vsa.worlds.tactile.contact import ContactWorld
from emg2vsa.worlds.tactile.settings import PressSettings, TimelineSettings

BEST = ("pin-affine", TRUE_AREA, "ode", "power")


@pytest.fixture(scope="module")
def press() -> PressScores:
    return scored(PressSettings(repetition=1, world=ContactWorld(), timeline=TimelineSettings(loading_s=1.0)))


def test_every_chain_of_a_press_is_scored(press: PressScores) -> None:
    assert not press.failures
    assert np.isfinite(list(press.casr.values())).all()
    assert set(press.time_s) == set(ENGINES)
    assert set(press.area_error_percent) == set(RULES)
    assert press.casr[BEST] == pytest.approx(press.true_casr["power"], rel=0.02)
    assert abs(press.growth_error_percent["pin-affine"]) < 3


def study(error: float = 1.0) -> list[PressScores]:
    """Two presses of every specimen and angle whose CASR follows an exponential law; one chain errs by a factor."""
    presses = []
    for angle in ANGLES_DEG:
        for stiffness in STIFFNESS_N_MM.tolist():
            for repetition in range(2):
                true = {"power": -np.log(stiffness / 10), "slope": 2.0, "paper": 3.0}
                chains = {chain: true[chain[3]] * (error if chain == CHAINS[0] else 2) for chain in CHAINS}
                presses.append(PressScores(stiffness, angle, repetition, true, chains))
    return presses


def test_exact_scores_of_an_exponential_world_cost_nothing() -> None:
    unknown, left_out = stiffness_errors(study(), None)
    assert [*unknown, *left_out] == pytest.approx([0.0] * 15, abs=1e-6)


def test_a_common_factor_on_casr_is_calibrated_away() -> None:
    results = study(error=1.1)
    found = judge(results, CHAINS[0], [0.0] * 3)
    assert found.casr_percent == pytest.approx([10.0] * 24)
    assert found.kappa_percent == pytest.approx([0.0] * 3, abs=1e-6)


def test_a_chain_that_failed_once_is_never_recommended() -> None:
    results = study()
    judged = [judge(results, chain, [0.0] * 3) for chain in CHAINS]
    assert recommendation(judged).count(", ".join(CHAINS[0])) == 3
    results[0].casr[CHAINS[0]] = float("nan")
    results[0].failures["hexagon"] = "no contact"
    judged = [judge(results, chain, [0.0] * 3) for chain in CHAINS]
    assert ", ".join(CHAINS[0]) not in recommendation(judged)
    assert failures(results) == ["hexagon failed on 1 of 24 presses: no contact"]


@pytest.mark.slow
def test_the_whole_study_runs_on_two_processes(tmp_path: Path) -> None:
    made = benchmarks.tactile.run("presses", tmp_path, n_repetitions=1, n_jobs=2)
    assert [table.name for table in made] == ["press_initial_area", "press_growth", "press_chains"]
    assert {path.name for path in tmp_path.iterdir()} >= {"presses.txt", "press_chains.csv"}
    for table in made:
        assert all(np.isfinite(cell) for row in table.rows for cell in row if isinstance(cell, float))


def test_tables_of_a_known_study() -> None:
    chains = tables(study())[-1]
    assert chains.rows[0][:4] == list(CHAINS[0])
    assert len(chains.rows) == len(CHAINS) + 1


@pytest.mark.parametrize(
    "wrong", [{"what": "all"}, {"what": "numerics", "n_seeds": 0}, {"what": "presses", "n_jobs": 0}]
)
def test_what_cannot_be_run_is_said(wrong: dict[str, object]) -> None:
    with pytest.raises(SettingError):
        benchmarks.tactile.run(**wrong)  # type: ignore[arg-type]
