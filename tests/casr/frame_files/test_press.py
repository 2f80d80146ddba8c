"""One press from disk, and the presses of a folder."""

from __future__ import annotations

import os
import subprocess
import sys

import cv2
import numpy as np
import pytest
import tifffile

from casr.camera import Camera
from casr.errors import CameraError, FramesError
from casr.frame_files import find_presses, open_frames, write_camera

LOG = "force_n,frame_index\n0,-1\n" + "".join(f"{k},{k}\n{k + 1},{k}\n" for k in range(12))


@pytest.fixture
def press(tmp_path, frames):
    """A press folder as the rig saves it."""
    folder = tmp_path / "S1_30deg"
    folder.mkdir()
    tifffile.imwrite(folder / "frames.tif", frames, photometric="minisblack")
    (folder / "force.csv").write_text(LOG)
    write_camera(folder / "camera.toml", Camera(width_px=32, height_px=24))
    return folder


def write_images(folder, frames):
    folder.mkdir(parents=True)
    for number, frame in enumerate(frames):
        cv2.imwrite(str(folder / f"{number}.png"), frame)


def test_a_press_folder_brings_its_force_and_camera(press, frames):
    sequence = open_frames(press)
    assert (sequence.name, sequence.notes) == ("S1_30deg", ())
    np.testing.assert_array_equal(sequence.force_n, [0.5, *range(1, 12)])
    assert sequence.camera == Camera(width_px=32, height_px=24)
    np.testing.assert_array_equal(list(sequence), frames)


def rows(force_n, times="{:.3f}"):
    """A log of five rows a frame; the first five come before it."""
    lines = "".join(f"{times.format(k / 100)},{force:.5f},{k // 5 - 1}\n" for k, force in enumerate(force_n))
    return "time_s,force_n,frame_index\n" + lines


def test_wild_rows_of_the_log_are_left_out(press):
    force = np.linspace(0, 6, 65)
    (press / "force.csv").write_text(rows(force))
    clean = open_frames(press)
    force[31:33] = 15
    (press / "force.csv").write_text(rows(force))
    found = open_frames(press)
    # a ramp of 0.47 N a frame; two rows fewer move the mean of their frame along it
    np.testing.assert_allclose(found.force_n, clean.force_n, atol=0.1)
    assert found.notes == ("2 of 65 rows of the force log are spikes (up to 15 N) and left out",)


def test_readings_with_times_go_along(press):
    (press / "force.csv").write_text(rows(np.linspace(0, 6, 65)))
    readings = open_frames(press).readings
    np.testing.assert_allclose(readings.frame_time_s, 0.045 + 0.05 * np.arange(12))
    np.testing.assert_allclose(readings.at_frames(0.05)[1:], readings.at_frames()[:-1], atol=1e-9)
    assert open_frames(press, force_rule="mean").readings is None
    (press / "force.csv").write_text(LOG)
    assert open_frames(press).readings is None


def test_a_log_in_millinewtons_is_refused_unless_it_says_so(press):
    log = rows(np.linspace(0, 6000, 65))
    (press / "force.csv").write_text(log)
    with pytest.raises(
        FramesError,
        match=r"force.csv: expected forces in N, 200 at most, but found 6000. Which unit "
        r"is it",
    ):
        open_frames(press)
    (press / "force.csv").write_text(log.replace("force_n", "force_mN"))
    assert np.nanmax(open_frames(press).force_n) == pytest.approx(5.578, abs=0.001)


def test_a_press_of_a_run_has_the_camera_of_the_run(press, monkeypatch):
    (press / "camera.toml").rename(press.parent / "camera.toml")
    assert open_frames(press).camera == Camera(width_px=32, height_px=24)
    monkeypatch.chdir(press)
    assert open_frames(".").camera == Camera(width_px=32, height_px=24)
    own = Camera(width_px=32, height_px=24, depth_mm=9.0)
    write_camera(press / "camera.toml", own)
    assert open_frames(press).camera == own
    write_camera(press.parent / "camera.toml", Camera(width_px=48, height_px=24))
    (press / "camera.toml").unlink()
    with pytest.raises(CameraError):
        open_frames(press)


def test_frames_in_a_folder_of_their_own(press, frames):
    (press / "frames.tif").unlink()
    write_images(press / "frames", frames)
    (press / "overview.png").write_bytes((press / "frames" / "0.png").read_bytes())
    sequence = open_frames(press)
    assert sequence.name == "S1_30deg"
    assert sequence.camera is not None
    np.testing.assert_array_equal(list(sequence), frames)


def test_files_given_stand_before_files_found(press, tmp_path):
    (tmp_path / "other.csv").write_text(LOG.replace("force_n", "force_filtered_n"))
    write_camera(tmp_path / "other.toml", Camera(width_px=32, height_px=24, depth_mm=9.0))
    sequence = open_frames(
        press, force=tmp_path / "other.csv", camera=tmp_path / "other.toml", column="force_filtered_n"
    )
    assert sequence.camera.depth_mm == 9.0
    np.testing.assert_array_equal(sequence.force_n, [0.5, *range(1, 12)])


def test_the_mean_of_a_frames_rows_is_its_force_by_the_papers_rule(press):
    np.testing.assert_array_equal(open_frames(press, force_rule="mean").force_n, np.arange(12) + 0.5)


def test_a_file_of_frames_takes_nothing_that_was_not_given(press):
    sequence = open_frames(press / "frames.tif")
    assert (sequence.name, sequence.force_n, sequence.camera) == ("frames", None, None)


def test_frames_without_force_are_counted(press):
    (press / "force.csv").write_text("force_n,frame_index\n1,0\n2,5\n")
    sequence = open_frames(press)
    assert np.flatnonzero(np.isfinite(sequence.force_n)).tolist() == [0, 5]
    assert sequence.notes == ("10 of 12 frames have no force",)


def test_a_log_of_other_frames_says_how_many_there_are(press):
    (press / "force.csv").write_text(LOG + "9,12\n")
    with pytest.raises(FramesError, match=r"force.csv: expected frame indices from -1 to 11, for there are 12 frames"):
        open_frames(press)


def test_a_camera_of_another_size(press):
    write_camera(press / "camera.toml", Camera())
    with pytest.raises(CameraError, match="300 x 300 px, but found frames of 32 x 24 px"):
        open_frames(press)


def test_presses_of_a_folder_in_natural_order(press, tmp_path, frames):
    for number in (10, 9):
        write_images(tmp_path / "more" / f"press_{number}" / "frames", frames)
    tifffile.imwrite(tmp_path / "more" / "alone.tif", frames)
    np.save(tmp_path / "more" / "array.npy", frames)
    (tmp_path / "more" / "empty").mkdir()
    (tmp_path / "more" / "link").symlink_to(tmp_path)
    found = [path.relative_to(tmp_path).as_posix() for path in find_presses(tmp_path)]
    assert found == ["more/alone.tif", "more/array.npy", "more/press_9", "more/press_10", "S1_30deg"]
    for path in find_presses(tmp_path):
        np.testing.assert_array_equal(open_frames(path)[3], frames[3])


def test_a_press_is_found_as_itself(press):
    assert find_presses(press) == [press]
    assert find_presses(press / "frames.tif") == [press / "frames.tif"]


def test_a_folder_of_stacks_is_no_folder_of_frames(tmp_path, frames):
    for number in (1, 2):
        tifffile.imwrite(tmp_path / f"press_{number}.tif", frames, photometric="minisblack")
    assert len(find_presses(tmp_path)) == 2
    with pytest.raises(
        FramesError,
        match=r"the frames of one press, but found 2 sequences \(press_1.tif, "
        r"press_2.tif\)",
    ):
        open_frames(tmp_path)


@pytest.mark.parametrize("open_path", [open_frames, find_presses])
def test_nothing_there(tmp_path, open_path):
    with pytest.raises(FramesError, match=r"No such file"):
        open_path(tmp_path / "gone")
    with pytest.raises(FramesError, match=r"expected images .* found 0 other files and 0 folders"):
        open_path(tmp_path)
    (tmp_path / "notes.txt").write_text("x")
    with pytest.raises(FramesError, match=r"found 1 other files and 0 folders"):
        open_path(tmp_path)


@pytest.mark.parametrize("name", ["press.txt", "press", "1.png"])
def test_a_file_that_holds_no_sequence(tmp_path, name):
    (tmp_path / name).write_text("x")
    with pytest.raises(FramesError, match=r"a folder of images or a file ending in .tif"):
        open_frames(tmp_path / name)


def test_a_folder_that_may_not_be_read(press, monkeypatch):
    def refuse(path):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("os.scandir", refuse)
    with pytest.raises(FramesError, match=r"S1_30deg: .* Permission denied. Give yourself the right"):
        open_frames(press)


def test_tifffile_is_loaded_for_tiff_files_only(tmp_path, frames):
    np.save(tmp_path / "press.npy", frames)
    read = "import sys; from casr.frame_files import open_frames; open_frames(sys.argv[1])[1]"
    tell = f"{read}; print('tifffile' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", tell, tmp_path / "press.npy"], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"


def test_broken_frames_are_told_by_our_errors_alone(tmp_path, frames):
    for number, frame in enumerate(frames):
        whole = cv2.imencode(".bmp", frame)[1].tobytes()
        (tmp_path / "bmp").mkdir(exist_ok=True)
        (tmp_path / "bmp" / f"{number}.bmp").write_bytes(whole[: 500 if number == 1 else None])
    (tmp_path / "press.mp4").write_bytes(b"no video" * 50)
    code = """
import sys
from casr.errors import FramesError
from casr.frame_files import open_frames
for name in sys.argv[1:]:
    try:
        list(open_frames(name))
    except FramesError as error:
        print(error)
"""
    names = [str(tmp_path / name) for name in ("bmp", "press.mp4")]
    unset = {name: value for name, value in os.environ.items() if not name.startswith("OPENCV_")}
    done = subprocess.run([sys.executable, "-c", code, *names], capture_output=True, text=True, check=True, env=unset)
    assert "1.bmp, frame 1: expected an image" in done.stdout
    assert "press.mp4: expected a video" in done.stdout
    assert done.stderr == ""
