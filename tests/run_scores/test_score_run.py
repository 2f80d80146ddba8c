"""Presses scored as a run: every algorithm from one pass, and a bad press stops no other.

The kinesthetic cue of a press.

n of Algorithm 1 against a second implementation, written from the paper's text.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.tactile.algorithm_1 import first_contact, mask_centroids, selected_pins
from casr.contact_area import initial_area
from casr.errors import PassingError
from casr.frames import FrameSequence
from casr.pins import PinTracker
from casr.scored import ScoreSettings
from casr.scoring import score
from casr.specimens import SPECIMENS
from casr.spread import fit_power_laws
from emg2vsa.run_scores import ALGORITHMS, PICTURED_N, RunScores
from emg2vsa.run_scores.domes import NO_DOMES, Domes, notes_on_height
from emg2vsa.run_scores.press import Press
from emg2vsa.run_scores.score_run import score_run
from emg2vsa.settings import RunSettings
from emg2vsa.worlds.tactile import PressSettings, SimulatedFrames, SimulatedPress, TimelineSettings, simulate_press

SETTINGS = RunSettings()


@pytest.fixture(scope="module")
def simulated() -> SimulatedPress:
    return simulate_press(PressSettings())


@pytest.fixture(scope="module")
def sequence(simulated: SimulatedPress) -> FrameSequence:
    return simulated.sequence()


def press(frames: FrameSequence | None, repetition: int = 1, problem: str = "") -> Press:
    force = np.linspace(0, 7, 40)
    return Press(repetition, frames, problem, force, 5 + force / 2)


def scored(*presses: Press, settings: RunSettings = SETTINGS, domes: Domes = NO_DOMES) -> RunScores:
    return score_run(presses, settings, specimen="S3", angle_deg=30.0, condition="modular", simulated=True, domes=domes)


@pytest.fixture(scope="module")
def run(sequence: FrameSequence) -> RunScores:
    return scored(press(sequence), press(None, 2, "frames.tif: cut off"), press(replace(sequence, force_n=None), 3))


def test_a_good_press_has_casrs_own_numbers(run, sequence):
    alone = score(sequence, ScoreSettings(force_stop_n=None))
    assert run.casr["front"][0] == pytest.approx(alone.rate.value, rel=0.02)
    assert run.casr["edge"][0] == pytest.approx(alone.skin.rate.value, rel=0.02)
    assert run.a_c0["edge"][0] == pytest.approx(alone.skin.area[0], rel=1e-12)
    assert run.name == "S3_30_modular"
    assert run.area_unit == "mm2"


def test_an_offset_of_the_force_is_taken_off_once(run, sequence):
    force = 0.3 + np.linspace(0, 7, 40)
    logged = Press(1, replace(sequence, force_n=sequence.force_n + 0.3), "", force, 5 + (force - 0.3) / 2)
    found = scored(logged)
    assert found.casr["edge"][0] == pytest.approx(run.casr["edge"][0], rel=1e-9)
    np.testing.assert_allclose(found.curves[0].force_n, run.curves[0].force_n, atol=1e-9)
    assert found.indent_n_per_mm[0] == pytest.approx(run.indent_n_per_mm[0])
    assert any("which is taken off" in note for note in found.notes)


def test_a_specimen_of_a_height_without_tables_is_refused(run, sequence):
    usual, thin = (scored(press(sequence), domes=Domes(None, height)) for height in (25.0, 10.0))
    assert usual.casr["front"][0] == run.casr["front"][0]
    assert thin.verdicts == ("rejected",)
    assert "expected tables of one dome, stiffness and friction on both sides of 10 mm" in thin.reasons[0]


def test_a_press_to_check_is_named_in_the_notes(simulated, sequence):
    held = SimulatedFrames(simulated.scene, np.minimum(simulated.truth.force_n, 3.0))
    found = scored(press(replace(sequence, source=held)))
    assert found.verdicts == ("ok",)
    assert found.notes[0].startswith(f"check {held.name}: the pins stand still from frame")


@pytest.mark.parametrize("rule", ["hexagon", "circle", "paper"])
def test_other_algorithms_have_their_own_initial_area(run, sequence, rule):
    alone = score(sequence if rule != "paper" else sequence.by_mean(), ScoreSettings())
    area = initial_area(alone.rest, alone.contact_px, camera=sequence.camera, rule=rule).area_mm2
    assert run.a_c0[rule][0] == pytest.approx(area)
    if rule != "paper":
        ratio = run.casr[rule][0] / run.casr["edge"][0]
        assert ratio == pytest.approx(run.a_c0[rule][0] / run.a_c0["edge"][0])


def test_scored_by_another_algorithm_the_numbers_are_the_same(run, sequence):
    by_hexagons = scored(press(sequence), settings=RunSettings(algorithm="hexagon"))
    for name in ALGORITHMS:
        assert by_hexagons.casr[name][0] == pytest.approx(run.casr[name][0], rel=1e-9, nan_ok=True), name


def test_presses_that_cannot_be_scored_stay_with_their_reason(run):
    assert run.verdicts == ("ok", "rejected", "rejected")
    assert run.reasons[0] == ""
    assert run.reasons[1] == "frames.tif: cut off"
    assert "no force log" in run.reasons[2]
    for name in ALGORITHMS:
        assert np.isnan(run.a_c0[name][1:]).all()
    assert [curve.force_n.size > 0 for curve in run.curves] == [True, False, False]


def test_frames_that_may_be_readable_another_time_leave_no_score_that_would_be_kept(sequence, monkeypatch):
    """A video decoder that the system killed says nothing about the press."""

    def killed(*_args):
        raise PassingError("press", wanted="frames", found="a decoder that was killed", do="Run again.")

    monkeypatch.setattr(SimulatedFrames, "read", killed)
    with pytest.raises(PassingError):
        scored(press(sequence))


def test_force_over_indentation_comes_from_the_log(run):
    assert run.indent_n_per_mm[0] == pytest.approx(2.0, rel=1e-6)


def test_the_picture_is_the_frame_nearest_to_one_newton_with_the_outline_of_its_area(run, sequence):
    picture = run.picture
    assert picture.image.shape == (300, 300)
    every = np.concatenate([curve.force_n for curve in run.curves])
    assert abs(picture.force_n - PICTURED_N) == pytest.approx(np.abs(every - PICTURED_N).min())
    at = [np.flatnonzero(curve.force_n == picture.force_n) for curve in run.curves]
    assert picture.area_mm2 in [run.curves[i].area_mm2[j] for i, places in enumerate(at) for j in places]
    x, y = picture.outline_px.T
    enclosed_px2 = abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2
    assert enclosed_px2 * sequence.camera.mm2_per_px2 == pytest.approx(picture.area_mm2, rel=0.15)


def test_the_area_where_loading_begins_lies_on_the_power_law(run, simulated):
    area, force_n = run.curves[0].area_mm2, run.curves[0].force_n
    assert force_n[0] >= run.curves[0].first_n > 0.5
    law, truth = fit_power_laws(area, force_n).law, simulated.truth
    assert run.start_area["front"][0] == pytest.approx(law.area(0.5), rel=1e-6)
    assert run.a_c0["front"][0] == pytest.approx(law.area(run.curves[0].first_n), rel=0.02)
    true = fit_power_laws(truth.area_mm2[truth.loading_frames], truth.force_n[truth.loading_frames]).law
    assert run.start_area["front"][0] == pytest.approx(true.area(0.5), rel=0.06)
    growth = run.start_area["edge"][0] / run.a_c0["edge"][0]
    assert run.start_area["circle"][0] / run.a_c0["circle"][0] == pytest.approx(growth)
    assert run.start_area["paper"][0] == run.a_c0["paper"][0] > 0


def test_the_area_where_loading_begins_hangs_on_no_first_frame(run, sequence):
    early = (sequence.force_n > 0.1) & (sequence.force_n < 1.2)
    later = replace(sequence, force_n=np.where(early, np.nan, sequence.force_n))
    found = scored(press(later))
    assert found.a_c0["front"][0] > 1.2 * run.a_c0["front"][0]
    assert found.start_area["front"][0] == pytest.approx(run.start_area["front"][0], rel=0.05)


def test_a_press_that_turned_back_early_is_not_scored(sequence):
    short = replace(sequence, force_n=np.where(sequence.force_n > 5, np.nan, sequence.force_n))
    found = scored(press(short))
    assert found.verdicts == ("rejected",)
    assert "a load up to stop_n (--stop-n), 7 N, or 80% of it, but found at most 5 N" in found.reasons[0]


def test_where_no_edge_is_found_hexagons_are_no_stand_in(sequence, monkeypatch):
    monkeypatch.setattr("casr.contact_area.rules._within_edge", lambda motion, camera: "the fit explains 12 %")
    found = scored(press(sequence), settings=RunSettings(algorithm="edge"))
    assert found.verdicts == ("rejected",)
    assert "No contact edge: the fit explains 12 %" in found.reasons[0]
    by_hexagons = scored(press(sequence), settings=RunSettings(algorithm="hexagon"))
    assert by_hexagons.verdicts == ("ok",)
    assert np.isnan(by_hexagons.a_c0["edge"][0])


def test_loading_ends_at_the_largest_force_where_f_max_falls_between_two_frames(sequence):
    low = replace(sequence, force_n=np.where(sequence.force_n > 6.5, np.nan, sequence.force_n))
    assert scored(press(low)).verdicts == ("ok",)


def test_the_most_frequent_reason_counts_alike_what_differs_by_press_and_number(run):
    reasons = (
        "",
        "a/press-1: expected a force for every frame, but found no force log. Do.",
        "a/press-2: expected a press that reaches 5.6 N, but found 3.1 N at most. Do.",
        "a/press-3: expected a press that reaches 5.6 N, but found 2.2 N at most. Do.",
    )
    assert replace(run, reasons=reasons).most_frequent_reason == reasons[2]
    assert replace(run, reasons=("", "")).most_frequent_reason == ""


def test_a_run_without_a_scored_press_has_the_unit_of_its_camera():
    assert scored(replace(press(None, 1, "cut off"), area_unit="px2")).area_unit == "px2"
    assert scored(press(None, 1, "cut off")).area_unit == "mm2"


QUICK = TimelineSettings(loading_s=1.0)
PRESSES = list(product(("S1", "S3", "S5"), (0.0, 45.0), range(5)))

Pair = tuple[NDArray[np.uint8], NDArray[np.uint8]]


@pytest.fixture(scope="module")
def pairs() -> list[Pair]:
    """The static frame and the first in contact of 30 presses."""
    return [
        first_contact(
            simulate_press(
                PressSettings(
                    stiffness_n_per_mm=SPECIMENS[specimen], angle_deg=angle, repetition=repetition, timeline=QUICK
                )
            ).sequence()
        )
        for specimen, angle, repetition in PRESSES
    ]


def test_n_is_that_of_a_second_implementation(pairs: list[Pair]) -> None:
    rng = np.random.default_rng(3)
    found, again, apart = [], [], []
    for rest, contact in pairs:
        tracker = PinTracker()
        pins, moved = tracker.start(rest), tracker.step(contact)
        found.append(initial_area(pins, moved, rule="paper").selected.size)
        seen = moved[np.isfinite(moved).all(axis=1)]
        again.append(selected_pins(rng.permutation(pins.centroids_px), rng.permutation(seen)))
        apart.append(selected_pins(mask_centroids(rest), mask_centroids(contact)) - found[-1])
    assert found == again
    assert min(found) < 10 < 20 < max(found)
    # a mask of its own moves centroids by a tenth of a pixel, and whole pixels turn that into a pin more or less; into
    # several in a press whose pins move alike, by just the threshold
    assert np.median(apart) == 0
    assert np.count_nonzero(np.abs(apart) <= 1) >= 27


def test_pins_that_move_by_more_than_half_a_pitch_find_no_other_partner() -> None:
    rest = np.array([[10.0, 10.0], [30.0, 10.0], [50.0, 10.0]])
    moved = rest + np.array([[0.0, 2.0], [0.0, 3.0], [12.0, 0.0]])
    assert selected_pins(rest, moved[::-1]) == 2


def test_a_specimen_of_another_height_than_the_tables_is_told() -> None:
    assert notes_on_height(None) == notes_on_height(25.0) == notes_on_height(23.0) == ()
    (note,) = notes_on_height(10.0)
    assert "10 mm high" in note
    assert "domes under [runs]" in note
