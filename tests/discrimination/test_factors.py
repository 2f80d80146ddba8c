"""Condition, angle and specimen together, on the runs of the experiment."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from emg2vsa.discrimination import discriminate
from emg2vsa.run_scores import RunScores


def test_the_experiments_factors(runs: tuple[RunScores, ...], stiffness_n_per_mm: dict[str, float]) -> None:
    """CASR rises with softness and falls with the angle, in every condition alike: what the made runs hold."""
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.not_positive == (0, 0)
    assert factors.constant == ()
    for found in (factors.casr, factors.area):
        assert found is not None
        assert found.n == 270
        assert found.empty_cells == 18  # constant stiffness at one angle only
        at = {name: i for i, name in enumerate(found.effects)}
        assert found.p[at["specimen"]] < 1e-50
        assert found.p[at["angle"]] < 1e-50
        assert found.omega2[at["specimen"]] > 0.9
        assert found.omega2[at["condition × angle × specimen"]] < 0.1
        assert (found.low <= found.omega2).all()
        assert (found.omega2 <= found.high).all()


def test_one_angle_is_no_factor(run_of: Callable[..., RunScores], stiffness_n_per_mm: dict[str, float]) -> None:
    runs = [run_of(s, 0.0, c) for c in ("high-stiffness", "modular") for s in ("S1", "S3", "S5")]
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.constant == ("angle",)
    assert factors.casr is not None
    assert factors.casr.effects == ("condition", "specimen", "condition × specimen")


def test_scores_without_a_logarithm_are_counted(
    run_of: Callable[..., RunScores], stiffness_n_per_mm: dict[str, float]
) -> None:
    runs = [run_of(s, 0.0, "modular") for s in ("S1", "S3", "S5")]
    casr = {name: values.copy() for name, values in runs[0].casr.items()}
    casr["front"][:2] = [-1e-3, 0.0]
    runs[0] = dataclasses.replace(runs[0], casr=casr)
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.not_positive == (0, 2)
    assert factors.casr is not None
    assert factors.casr.n == 28
    assert factors.area is not None
    assert factors.area.n == 30


@pytest.mark.parametrize("presses", [0, 1])
def test_runs_that_bear_no_model_have_none(
    run_of: Callable[..., RunScores], stiffness_n_per_mm: dict[str, float], presses: int
) -> None:
    runs = [run_of(s, 0.0, "modular", presses=1) for s in ("S1", "S3")]
    if not presses:
        runs = [dataclasses.replace(run, verdicts=("rejected",)) for run in runs]
    factors = discriminate(runs, stiffness_n_per_mm, "S_new").factors
    assert factors.casr is None
    assert factors.area is None
    assert np.all(np.array(factors.not_positive) == 0)


def test_claims_have_the_largest_p_of_what_they_need(
    runs: tuple[RunScores, ...], stiffness_n_per_mm: dict[str, float]
) -> None:
    found = discriminate(runs, stiffness_n_per_mm, "S_new")
    claims = list(found.claims.values())
    assert claims[1] == np.max(found.spread.worst_p)
    assert claims[0] == np.max(found.spread.groups.kruskal.p)
    assert all(0 <= p <= 1 for p in claims)
