"""The section on all data together, and the laws beside the logarithm."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from emg2vsa.discrimination import discriminate
from emg2vsa.report.inputs import Runs
from emg2vsa.report.section import Content, rendered
from emg2vsa.report.sections.models import MODELS
from emg2vsa.report.study_report import contents
from emg2vsa.settings import DiscriminationSettings


@pytest.fixture(scope="module")
def whole(results, runs, stiffness_n_per_mm):
    tested = discriminate(runs, stiffness_n_per_mm, "S_new", DiscriminationSettings(resamples=200))
    return dataclasses.replace(results, runs=Runs(runs, tested))


@pytest.fixture(scope="module")
def content(whole) -> Content:
    return contents(whole)


def test_quantities_are_those_of_the_models(whole, content: Content) -> None:
    q, found = content.quantities, whole.people.hypotheses
    variances = found.tests.blocks.variances
    name = "hypotheses.over_people.mixed.sd_participants_v"
    assert [q[name], q[f"{name}.low"], q[f"{name}.high"]] == [
        each[0] for each in (variances.sd, variances.low, variances.high)
    ]
    assert q["hypotheses.trend.p"] == found.trend.p
    model = whole.runs.discrimination.factors.casr
    i = model.effects.index("condition × angle")
    assert q["runs.factors.casr.condition-angle.omega2"] == model.omega2[i]
    assert q["runs.factors.casr.condition-angle.omega2.high"] == model.high[i]
    assert q["fit.laws.leave_one_bin_out.power.p"] == found.laws.p[1, 1]
    together = {key: p for key, p in q.items() if key.startswith("claims.together.")}
    assert len(together) == 7
    assert together["claims.together.kept_pairs_within_participants.p_holm"] >= found.worst_p


def test_tables_hold_every_effect_claim_and_residual(whole, content: Content) -> None:
    rows = {name: len(content.tables[name].rows) for name in ("factors", "claims_together", "mixed_sd", "force_laws")}
    assert rows == {"factors": 14, "claims_together": 7, "mixed_sd": 3, "force_laws": 6}
    assert len(content.tables["mixed_residuals"].rows) == np.count_nonzero(whole.used)
    assert [row["participant"] for row in content.tables["trend"].rows] == ["P01", "P02", "P03"]


def test_the_figure_shows_every_residual_against_its_quantile_and_its_fitted_value(whole, content: Content) -> None:
    found = whole.people.hypotheses.tests.blocks.residuals
    normal, level = content.drawings["mixed_residuals"].figure.axes
    np.testing.assert_array_equal(normal.lines[-1].get_xydata(), np.column_stack([found.quantile, found.residual]))
    fitted = found.fitted * whole.scale.factor
    np.testing.assert_array_equal(level.lines[-1].get_xydata(), np.column_stack([fitted, found.residual]))
    assert whole.scale.label("Fitted b") == level.get_xlabel()
    text = rendered(MODELS, whole, content)
    assert "<summary>Residuals of the mixed model</summary>" in text
    assert text.count('role="img"') == 1


def test_the_text_says_what_survives(whole, content: Content) -> None:
    text = rendered(MODELS, whole, content)
    survive = sum(bool(row["survives"]) for row in content.tables["claims_together"].rows)
    assert f"{survive} of 7 claims" in text
    assert "t test over participants" in text


@pytest.mark.parametrize("part", ["people", "runs"])
def test_a_study_of_one_half_has_the_models_of_that_half(whole, part: str) -> None:
    half = dataclasses.replace(whole, people=None) if part == "runs" else dataclasses.replace(whole, runs=None)
    content = contents(half)
    assert ("mixed_sd" in content.tables) == ("mixed_residuals" in content.drawings) == (part == "people")
    assert bool(content.tables["factors"].rows) == (part == "runs")
    assert rendered(MODELS, half, content)
