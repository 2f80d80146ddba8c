"""Section "Can stiffness help?": every number of it comes from the stage's result."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.section import rendered
from emg2vsa.report.sections.stiffness import STIFFNESS
from emg2vsa.report.study_report import contents, numbers_and_tables
from emg2vsa.stiffness_effect import StiffnessEffect

CONDITIONS = ("high-stiffness", "modular", "constant-min", "all-20")


def effect(*, best: int = 3, swaps: bool = True) -> StiffnessEffect:
    """Four conditions of S1, S2 and S5, with numbers that nothing else gives."""
    contrast = np.array([[0.5, 0.5, 0.5, 0.5], [0.51, 0.5131, 0.509, 0.505], [0.53, 0.5371, 0.52, 0.511]])
    rate = 10 * np.exp(np.stack([0 * contrast, 0.1 + 0 * contrast, contrast], axis=1))
    frame_sum = np.array([[100.0, 110, 120, 130], [119, 131, 141, 151], [301, 403, 299, 288]])
    swapped = frame_sum.copy()
    swapped[1, 1] = 93.5 if swaps else 130.9
    d = np.array([1.71, 2.03, 3.14, 3.02])
    d[best] = 4.4
    return StiffnessEffect(
        specimens=("S1", "S2", "S5"), conditions=CONDITIONS, materials=("elastic", "assumed", "lossy sensor"),
        pair=("S1", "S2"), duration_s=np.array([[0.3, 0.35, 0.5, 0.6], [0.4, 0.5, 0.6, 0.7], [0.7, 0.9, 1.0, 1.1]]),
        rate=rate, frame_sum=frame_sum, frame_sum_swapped=swapped, rate_swapped=rate[0],
        timing_cv=np.full((2, 4), 0.03), timing_d=d, specimen_share=np.array([0.3, 0.4, 0.8]),
        area_power=np.full(3, 0.5),
    )  # fmt: skip


def table(results: StudyResults, name: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO("".join(numbers_and_tables(results).tables[name].csv()))))


def page(results: StudyResults) -> str:
    return " ".join(rendered(STIFFNESS, results, contents(results)).split())


def test_tables_hold_the_numbers_of_the_stage(results: StudyResults) -> None:
    told = replace(results, stiffness=effect())
    rows = table(told, "stiffness_effect")
    assert [row["condition"] for row in rows] == [*CONDITIONS[:3], "constant, 20 % for all"]
    assert [float(row["frame_sum"]) for row in rows] == pytest.approx([3.01, 403 / 110, 299 / 120, 288 / 130])
    assert [float(row["gain_percent"]) for row in rows] == pytest.approx(100 * np.expm1([0, 0.0031, -0.001, -0.005]))
    assert [float(row["timing_d"]) for row in rows] == [1.71, 2.03, 3.14, 4.4]
    assert [float(row["neighbour_swapped"]) for row in rows] == pytest.approx([1.19, 0.85, 141 / 120, 151 / 130])
    assert float(rows[0]["presses"]) == np.inf
    assert float(rows[1]["presses"]) == pytest.approx(31.396 * (0.03 / 0.0031) ** 2, rel=1e-4)
    sd = results.study.calibration.mounting_sd_percent / 100
    assert float(rows[1]["mountings"]) == pytest.approx(31.396 * (sd / 0.0031) ** 2, rel=1e-4)
    assert float(rows[2]["gain_lossy_percent"]) == pytest.approx(100 * np.expm1(-0.01))


def test_quantities_have_the_same_numbers(results: StudyResults) -> None:
    found = numbers_and_tables(replace(results, stiffness=effect())).quantities
    assert found["stiffness.modular.contrast_gain.assumed_percent"] == pytest.approx(100 * np.expm1(0.0031))
    assert found["stiffness.modular.frame_sum.neighbour_swapped"] == pytest.approx(0.85)
    assert found["stiffness.timing.best"] == "all-20"
    assert found["stiffness.frame_sum.swaps_order"] is True
    longer = np.log(0.9 / 0.7)
    assert found["stiffness.modular.creep_exponent_needed"] == pytest.approx(np.log(1.2) / (0.5 * 0.8 * longer))


def test_sentences_say_what_the_numbers_say(results: StudyResults) -> None:
    said = page(replace(results, stiffness=effect()))
    assert "swapped schedules swap S1 and S2" in said
    assert "the softest constant stiffness is best" in said
    assert "less than mountings scatter" in said
    other = page(replace(results, stiffness=effect(best=1, swaps=False)))
    assert "swapped schedules swap" not in other
    assert "softest constant stiffness is best" not in other


def test_a_study_without_the_stage_has_no_section(results: StudyResults) -> None:
    assert results.stiffness is None
    found = contents(results)
    assert "stiffness_effect" not in found.tables
    assert not [key for key in found.quantities if key.startswith("stiffness.")]
