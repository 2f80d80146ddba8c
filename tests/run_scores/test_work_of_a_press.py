"""What a press costs: each frame is decoded once, and no algorithm follows pins that another one has followed."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from casr.counts import counting
from casr.frame_files import open_frames
from casr.frames import FrameSequence
from casr.pins import PinTracker
from casr.specimens import SPECIMENS
from emg2vsa.pipeline.profile import StageProfile
from emg2vsa.run_folders.presses import read_presses
from emg2vsa.run_scores import RunScores
from emg2vsa.run_scores.counted_pins import counted_pins
from emg2vsa.run_scores.press import Press
from emg2vsa.run_scores.score_run import score_run
from emg2vsa.settings import RunSettings
from emg2vsa.worlds.tactile import PressSettings, TimelineSettings, simulate_press, write_press


class Counted:
    """Frames of a press, and how often each is read."""

    def __init__(self, sequence: FrameSequence) -> None:
        self.name, self.shape, self._source = sequence.name, sequence.shape, sequence.source
        self.read_of: Counter[int] = Counter()

    def __len__(self) -> int:
        return len(self._source)

    def read(self, index: int) -> np.ndarray:
        self.read_of[index] += 1
        return self._source.read(index)


@pytest.fixture(scope="module")
def sequence() -> FrameSequence:
    timeline = TimelineSettings(loading_s=1.0)
    return simulate_press(PressSettings(stiffness_n_per_mm=SPECIMENS["S3"], timeline=timeline)).sequence()


def scored(sequence: FrameSequence, force_n: tuple[float, float] = (0.5, 7.0)) -> RunScores:
    press = Press(1, sequence, "", np.empty(0), np.empty(0))
    settings = RunSettings(force_n=force_n)
    return score_run([press], settings, specimen="S3", angle_deg=0.0, condition="modular", simulated=True)


def test_all_algorithms_of_a_press_decode_a_frame_once(sequence: FrameSequence) -> None:
    source = Counted(sequence)
    found = scored(replace(sequence, source=source))
    assert found.verdicts == ("ok",)
    assert all(np.isfinite(rates).all() for rates in found.casr.values())
    assert set(source.read_of.values()) == {1}
    assert len(source.read_of) < len(sequence)


def test_algorithm_1_counts_pins_that_were_followed_already(
    sequence: FrameSequence, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: Counter[str] = Counter()
    for name in ("start", "step"):
        own = getattr(PinTracker, name)

        def counting(tracker: PinTracker, image: np.ndarray, name: str = name, own=own) -> object:
            calls[name] += 1
            return own(tracker, image)

        monkeypatch.setattr(PinTracker, name, counting)
    found = scored(sequence)
    assert found.first_contact is not None
    # from rest, for the lag, the front and the paper's forces: all begin with one frame
    assert calls["start"] == 1
    calls.clear()
    assert scored(sequence, force_n=(0.5, 40.0)).verdicts == ("rejected",)
    assert calls.total() == 0


def test_pins_counted_of_a_scored_press_are_those_counted_alone(sequence: FrameSequence) -> None:
    together, alone = scored(sequence).first_contact, counted_pins(sequence, RunSettings(), 1)
    assert together is not None
    assert alone is not None
    for name in ("frames", "force_n", "rest_px", "contact_px", "selected"):
        np.testing.assert_array_equal(getattr(together, name), getattr(alone, name))


def test_decoded_frames_are_counted_where_they_are_decoded(tmp_path: Path) -> None:
    timeline = TimelineSettings(loading_s=1.0)
    press = simulate_press(PressSettings(stiffness_n_per_mm=SPECIMENS["S3"], timeline=timeline))
    folder = write_press(press, tmp_path / "S3_0_modular" / "press-001")
    with counting() as counts:
        (found,) = read_presses([folder.parent])
        scores = score_run(
            [found], RunSettings(), specimen="S3", angle_deg=0.0, condition="modular", simulated=True
        )  # fmt: skip
    assert scores.verdicts == ("ok",)
    assert counts["frames in folder"] == len(press.frames)
    # two recipes score the press, and both look at most of its loading
    assert len(scores.curves[0].force_n) < counts["frames decoded"] < counts["frames in folder"]
    assert "frames decoded again" not in counts
    with counting() as again:
        opened = open_frames(folder)
        for index in (0, 3, 3):
            opened[index]
    assert again["frames decoded"] == 2
    assert again["frames decoded again"] == 1  # the first frame is kept


def test_a_profile_says_how_many_frames_nobody_asked_for() -> None:
    profiled = StageProfile(counts=Counter({"frames in folder": 30, "frames decoded": 18, "frames decoded again": 2}))
    assert profiled.counted["frames not decoded"] == 12
    assert "frames not decoded" not in StageProfile(counts=Counter({"fits": 3})).counted
