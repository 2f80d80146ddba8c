"""Presses by the recipe of the settings: paper mode to the letter, and what can be asked for in its place."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from casr.errors import FramesError, SettingError
from casr.flow.estimate import FlowSettings
from casr.frames import FrameSequence
from casr.scored import Score, ScoreSettings
from casr.scoring import score
from casr.specimens import SPECIMENS
from emg2vsa.run_scores import ALGORITHMS, RunScores
from emg2vsa.run_scores.press import Press
from emg2vsa.run_scores.score_run import score_run
from emg2vsa.settings import PAPER, RECIPES, RunSettings
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, TimelineSettings, simulate_press

PAPERS_STEPS = {"engine": "horn-schunck", "force_rule": "mean", "area_rule": "paper", "law": "paper", "rate": "paper"}
TIP_MM2 = 1300.0


def quick_press(specimen: str, **keys: Any) -> FrameSequence:
    timeline = TimelineSettings(loading_s=1.0)
    return simulate_press(PressSettings(stiffness_n_per_mm=SPECIMENS[specimen], timeline=timeline, **keys)).sequence()


def scored(sequence: FrameSequence, **keys: Any) -> RunScores:
    press = Press(1, sequence, "", np.empty(0), np.empty(0), mounting=3)
    settings = RunSettings(**keys)
    return score_run([press], settings, specimen="S5", angle_deg=0.0, condition="modular", simulated=True)


@pytest.fixture(scope="module")
def sequence() -> FrameSequence:
    return quick_press("S5")


@pytest.fixture(scope="module")
def run(sequence: FrameSequence) -> RunScores:
    return scored(sequence, **PAPER["runs"])


@pytest.fixture(scope="module")
def by_casr(sequence: FrameSequence) -> Score:
    settings = ScoreSettings(
        quantity="skin", flow=FlowSettings(engine="horn-schunck"), area_rule="paper", area_law="paper",
        rate_rule="paper",
    )  # fmt: skip
    return score(sequence.by_mean(), settings)


def test_paper_mode_is_the_papers_text() -> None:
    assert RunSettings(**PAPER["runs"]).recipe == RECIPES["paper"]
    assert RECIPES["paper"]._asdict() == PAPERS_STEPS | {"region": "contact"}


def test_paper_mode_has_the_numbers_of_casr(run: RunScores, by_casr: Score) -> None:
    assert by_casr.rate is not None
    assert run.casr["paper"][0] == pytest.approx(by_casr.rate.value, rel=1e-9)
    assert run.a_c0["paper"][0] == pytest.approx(by_casr.area[0], rel=1e-12)
    np.testing.assert_allclose(run.curves[0].area_mm2, by_casr.area, rtol=1e-9)
    assert run.pins_selected.tolist() == [by_casr.initial.selected.size]
    assert run.mounting.tolist() == [3]


def test_its_curve_and_rate_obey_the_printed_equations(run: RunScores, by_casr: Score, sequence: FrameSequence) -> None:
    force, area = run.curves[0].force_n, run.curves[0].area_mm2
    d_cum = by_casr.divergence.sum()
    np.testing.assert_allclose(area[1:], area[0] * np.exp(d_cum * force[1:]), rtol=1e-12)
    total, before = 0.0, 0.0
    for i in range(1, force.size):
        total += (area[i] - area[i - 1]) / (force[i] - before)
        before = force[i]
    assert run.casr["paper"][0] == pytest.approx(total, rel=1e-9)
    means = sequence.mean_force_n
    assert means is not None
    zero = np.median(means[:4])
    assert run.curves[0].first_n == pytest.approx(means[means - zero >= 0.5][0], abs=0.02)


def test_beside_another_algorithm_the_papers_has_the_pins_flow(run: RunScores, sequence: FrameSequence) -> None:
    by_front, by_pins = scored(sequence), scored(sequence, algorithm="paper", engine="pin-affine")
    for found in ("a_c0", "casr", "start_area"):
        assert getattr(by_front, found)["paper"] == pytest.approx(getattr(by_pins, found)["paper"], rel=1e-12)
        assert getattr(by_front, found)["front"] == pytest.approx(getattr(run, found)["front"], rel=1e-12)
    assert by_front.a_c0["paper"] == pytest.approx(run.a_c0["paper"], rel=1e-12)
    assert by_front.casr["paper"] == pytest.approx(run.casr["paper"], rel=0.5)


def test_the_circle_of_previous_work_has_the_papers_laws_beside_it(run: RunScores) -> None:
    assert run.a_c0["circle"][0] == pytest.approx(1256.77, rel=1e-4)
    # equation (1) takes it far beyond the pin array, which is no area of contact
    growth = run.curves[0].area_mm2[-1] / run.curves[0].area_mm2[0]
    assert run.over_array["circle"][0] == pytest.approx(growth, rel=0.01)
    assert growth > 2
    assert np.isnan(run.casr["circle"][0])


def test_a_press_in_which_no_pin_moved_has_n_0_whatever_scores_it(sequence: FrameSequence) -> None:
    for algorithm in ("paper", "front"):
        found = scored(sequence, algorithm=algorithm, threshold_px=50.0)
        assert found.verdicts == ("rejected" if algorithm == "paper" else "ok",)
        assert found.pins_selected.tolist() == [0]
        assert 0.5 <= found.first_n[0] < 1.5
        assert found.first_contact is None


def test_pins_are_counted_by_the_papers_recipe_whatever_scores_the_press(
    sequence: FrameSequence, run: RunScores
) -> None:
    by_front = scored(sequence)
    assert by_front.pins_selected.tolist() == run.pins_selected.tolist()
    assert by_front.first_n[0] == run.first_n[0] == run.curves[0].first_n
    assert by_front.first_contact is not None
    assert by_front.first_contact.selected.size == run.pins_selected[0]


def test_an_area_above_that_of_the_array_is_none(run: RunScores) -> None:
    stuck = scored(quick_press("S1", world=ContactWorld()), algorithm="paper")
    assert stuck.verdicts == ("ok",)
    assert 0 < stuck.a_c0["paper"][0] < TIP_MM2
    assert np.isnan(stuck.casr["paper"][0])
    assert stuck.curves[0].area_mm2.size == 0
    assert stuck.picture is None
    assert stuck.notes[0].startswith("algorithm paper: 1 press has no spread rate: expected at most the area of the")
    assert max(curve.area_mm2.max() for curve in run.curves) < TIP_MM2


def test_a_circle_is_the_arrays_own_and_may_grow(sequence: FrameSequence) -> None:
    found = scored(sequence, algorithm="circle")
    assert found.verdicts == ("ok",)
    assert found.curves[0].area_mm2[-1] > found.a_c0["circle"][0] > 1200


@pytest.mark.parametrize(
    ("keys", "asked"),
    [
        ({"algorithm": "edge", "engine": "dis"}, {"flow": FlowSettings(engine="dis")}),
        ({"algorithm": "hexagon", "rate": "slope"}, {"area_rule": "hexagon", "rate_rule": "slope"}),
        (
            {"algorithm": "edge", "engine": "dis", "region": "image"},
            {"flow": FlowSettings(engine="dis"), "region": "image"},
        ),
    ],
)
def test_every_key_is_casrs_option(sequence: FrameSequence, keys: dict[str, Any], asked: dict[str, Any]) -> None:
    found = scored(sequence, **keys)
    alone = score(sequence, ScoreSettings(quantity="skin", **asked))
    assert alone.rate is not None
    assert found.casr[keys["algorithm"]][0] == pytest.approx(alone.rate.value, rel=1e-9)
    np.testing.assert_allclose(found.curves[0].area_mm2, alone.area, rtol=1e-9)


def test_the_front_takes_another_force(sequence: FrameSequence) -> None:
    by_mean = scored(sequence, force_rule="mean")
    assert sequence.mean_force_n is not None
    zero = np.median(sequence.mean_force_n[:4])
    assert np.abs(sequence.mean_force_n[:, None] - zero - by_mean.curves[0].force_n).min(axis=0).max() < 0.01
    assert by_mean.casr["front"][0] != scored(sequence).casr["front"][0]


def test_a_press_without_a_log_of_rows_has_no_mean_force(sequence: FrameSequence) -> None:
    bare = replace(sequence, mean_force_n=None)
    with pytest.raises(FramesError, match="expected a force log whose rows carry the index of the frame"):
        bare.by_mean()
    found = scored(bare)
    assert found.verdicts == ("ok",)
    assert any(
        note.startswith("algorithm paper: 1 press has no spread rate: expected a force log") for note in found.notes
    )
    assert scored(bare, algorithm="paper").verdicts == ("rejected",)


def test_only_the_papers_algorithm_itself_needs_numba(sequence: FrameSequence, monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(settings: FlowSettings) -> None:
        raise SettingError(
            "flow engine horn-schunck", wanted="the package numba", found="no such package", do="Get it."
        )

    monkeypatch.setattr("casr.flow.estimate.dense_flow", absent)
    found = scored(sequence)
    assert all(np.isfinite(found.casr[name][0]) for name in ALGORITHMS)
    (reason,) = scored(sequence, algorithm="paper").reasons
    assert reason.endswith("flow engine horn-schunck: expected the package numba, but found no such package. Get it.")
