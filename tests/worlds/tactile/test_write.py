"""A press on disk holds what was simulated, whole or not at all."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tifffile

from casr.errors import FramesError
from casr.frame_files import open_frames, read_force_log
from emg2vsa.worlds.tactile import (
    PressSettings,
    SimulatedFrames,
    SimulatedPress,
    TimelineSettings,
    simulate_press,
    write_press,
)

SHORT = TimelineSettings(loading_s=0.4)


@pytest.fixture(scope="module")
def press() -> SimulatedPress:
    return simulate_press(
        PressSettings(timeline=SHORT, camera=replace(PressSettings().camera, distortion=(0.01, -0.02, 0.0, 0.001)))
    )


@pytest.fixture(scope="module")
def folder(press: SimulatedPress, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_press(press, tmp_path_factory.mktemp("presses") / "one")


def test_overwrites_only_when_asked_and_only_presses(press: SimulatedPress, tmp_path: Path) -> None:
    folder = write_press(press, tmp_path / "p")
    before = (folder / "frames.tif").read_bytes()
    other = simulate_press(PressSettings(timeline=SHORT, repetition=1))
    with pytest.raises(FramesError, match="expected a new folder, but found an existing folder"):
        write_press(other, folder)
    assert (folder / "frames.tif").read_bytes() == before
    write_press(other, folder, overwrite=True)
    assert (folder / "frames.tif").read_bytes() != before
    precious = tmp_path / "precious"
    precious.mkdir()
    (precious / "thesis.txt").write_text("draft")
    with pytest.raises(FramesError, match=r"truth\.json"):
        write_press(press, precious, overwrite=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["p", "precious"]


def test_a_failed_write_keeps_what_was_there(
    press: SimulatedPress, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_press(press, tmp_path / "p")
    before = (folder / "force.csv").read_bytes()

    def fail(self: SimulatedFrames, index: int) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(SimulatedFrames, "read", fail)
    for name in ("p", "q"):
        with pytest.raises(OSError, match="disk full"):
            write_press(press, tmp_path / name, overwrite=True)
    assert (folder / "force.csv").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["p"]


def test_what_was_written_reads_back(press: SimulatedPress, folder: Path, tmp_path: Path) -> None:
    frames = tifffile.imread(folder / "frames.tif")
    np.testing.assert_array_equal(frames, [press.frames.read(i) for i in range(len(press.frames))])
    with tifffile.TiffFile(folder / "frames.tif") as tiff:
        assert tiff.pages[0].compression == 1
    log = read_force_log(folder / "force.csv")
    np.testing.assert_allclose(log.time_s, press.timeline.log_time_s, rtol=0, atol=1e-12)
    np.testing.assert_allclose(log.force_n, press.timeline.log_force_n, rtol=0, atol=5.1e-7)
    np.testing.assert_array_equal(log.frame_index, press.timeline.log_frame_index)
    sequence = open_frames(folder)
    assert (len(sequence), sequence.camera) == (len(press.frames), press.settings.camera)
    np.testing.assert_allclose(sequence.force_n, press.sequence().force_n, rtol=0, atol=1e-6)
    document = json.loads((folder / "truth.json").read_text())
    assert document["truth"]["casr_slope_mm2_per_n"] == press.truth.casr_slope_mm2_per_n
    assert document["truth"]["loading_frames"] == press.truth.loading_frames.tolist()
    assert document["settings"]["world"]["dome"] == "A"
    again = write_press(simulate_press(press.settings), tmp_path / "again")
    for path in folder.iterdir():
        assert path.read_bytes() == (again / path.name).read_bytes()
