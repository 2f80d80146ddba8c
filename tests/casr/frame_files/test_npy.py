"""NumPy files."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from casr.errors import FramesError, ImageError
from casr.frame_files import npy, open_frames


@pytest.mark.parametrize("dtype", [np.uint8, ">u2", np.float32, np.float64])
def test_grey_stacks(tmp_path, frames, dtype):
    np.save(tmp_path / "press.npy", frames.astype(dtype) * np.array(257 if dtype == ">u2" else 1, dtype))
    sequence = open_frames(tmp_path / "press.npy")
    assert (sequence.name, len(sequence), sequence.shape) == ("press", 12, (24, 32))
    np.testing.assert_array_equal(list(sequence), frames)
    np.testing.assert_array_equal(sequence[2], frames[2])


def test_colour_stacks_are_blue_green_red(tmp_path, frames):
    np.save(tmp_path / "press.npy", np.stack([frames] * 3, axis=-1))
    sequence = open_frames(tmp_path / "press.npy")
    np.testing.assert_array_equal(sequence[5], frames[5])
    assert sequence.notes == ("colour frames are taken as blue, green, red",)


def test_a_frame_that_is_not_finite_is_named_and_the_others_are_read(tmp_path, frames):
    stack = frames.astype(np.float32)
    stack[4, 0, 0] = np.nan
    np.save(tmp_path / "press.npy", stack)
    sequence = open_frames(tmp_path / "press.npy")
    with pytest.raises(ImageError, match=r"press.npy, frame 4: expected finite grey levels"):
        sequence[4]
    np.testing.assert_array_equal(sequence[5], frames[5])


def test_a_file_cut_short_gives_the_frames_that_are_whole(tmp_path, frames):
    path = tmp_path / "press.npy"
    np.save(path, frames)
    path.write_bytes(path.read_bytes()[:-100])
    sequence = open_frames(path)
    np.testing.assert_array_equal(sequence[10], frames[10])
    with pytest.raises(FramesError, match=r"press.npy, frame 11: expected an image, but found 668 of 768 values"):
        sequence[11]


@pytest.mark.parametrize(
    "array",
    [
        np.zeros((24, 32, 3), np.uint8),
        np.zeros((24, 32), np.uint8),
        np.zeros((0, 24, 32), np.uint8),
        np.asfortranarray(np.zeros((4, 24, 32), np.uint8)),
        np.full((4, 24, 32), None),
        np.zeros((4, 24, 32, 2), np.uint8),
    ],
)
def test_arrays_that_are_no_stack_of_frames(tmp_path, array):
    np.save(tmp_path / "press.npy", array)
    with pytest.raises((FramesError, ImageError), match=r"press.npy.*expected"):
        open_frames(tmp_path / "press.npy")


@pytest.mark.parametrize("data", [b"", b"hello", b"\x93NUMPY\x01\x00"])
def test_what_is_no_npy(tmp_path, data):
    (tmp_path / "press.npy").write_bytes(data)
    with pytest.raises(FramesError, match=r"press.npy: expected an .npy file"):
        open_frames(tmp_path / "press.npy")


def test_an_npy_that_goes_away_is_named(tmp_path):
    with pytest.raises(FramesError, match=r"gone.npy: expected a file or folder that can be read"):
        npy.open_file(tmp_path / "gone.npy")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="peak memory is read from /proc")
def test_100_000_frames_stream_in_less_than_500_mb(tmp_path):
    path = tmp_path / "long.npy"
    # 1 GB of zeros, sparse: they take no room on the disk
    np.lib.format.open_memmap(path, mode="w+", dtype=np.uint8, shape=(100_000, 100, 100))
    count = "import sys; from casr.frame_files import open_frames; print(sum(1 for f in open_frames(sys.argv[1])))"
    # ru_maxrss would hold the size of the process that forked this one
    peak = "next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM'))"
    watched = f"{count}; print({peak})"
    done = subprocess.run([sys.executable, "-c", watched, str(path)], capture_output=True, text=True, check=True)
    n_frames, peak_kb = map(int, done.stdout.split())
    assert n_frames == 100_000
    assert peak_kb / 1e3 < 500
