"""Folders of images, and NumPy files."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from casr.errors import FramesError, ImageError
from casr.frame_files import find_presses, open_frames, pages


def write_pages(folder, frames, pattern="{}_flat_0.png"):
    folder.mkdir(parents=True, exist_ok=True)
    for number, frame in enumerate(frames, 1):
        assert cv2.imwrite(str(folder / pattern.format(number)), frame)
    return folder


@pytest.mark.parametrize("suffix", ["png", "PNG", "bmp", "tif", "tiff"])
def test_frames_come_in_the_order_of_their_numbers(tmp_path, frames, suffix):
    sequence = open_frames(write_pages(tmp_path / "press", frames, "{}_R100_0." + suffix))
    assert (sequence.name, len(sequence), sequence.shape, sequence.notes) == ("press", 12, (24, 32), ())
    np.testing.assert_array_equal(list(sequence), frames)


def test_every_number_of_the_name_counts(tmp_path, frames):
    folder = tmp_path / "press"
    write_pages(folder, frames[:3], "run2_{}.png")
    write_pages(folder, frames[3:6], "run10_{}.png")
    np.testing.assert_array_equal(list(open_frames(folder)), frames[:6])


def test_jpeg_is_read_with_a_word_on_its_errors(tmp_path, frames):
    sequence = open_frames(write_pages(tmp_path / "press", frames, "{}.jpg"))
    assert any("JPEG" in note for note in sequence.notes)
    assert len(sequence) == 12


@pytest.mark.parametrize("dtype", [np.uint16, np.float32])
def test_deep_and_colour_pages(tmp_path, frames, dtype):
    scale = 257 if dtype == np.uint16 else 1
    deep = frames.astype(dtype) * dtype(scale)
    colour = np.stack([deep] * 3, axis=-1)
    for name, stack in (("grey", deep), ("colour", colour)):
        sequence = open_frames(write_pages(tmp_path / name, stack, "{}.tif"))
        np.testing.assert_allclose(sequence[11], frames[11], atol=1e-3)


def test_other_and_hidden_files_are_left_out_with_a_note(tmp_path, frames):
    folder = write_pages(tmp_path / "press", frames)
    (folder / ".DS_Store").write_text("x")
    (folder / "._1_flat_0.png").write_text("x")
    (folder / "notes.txt").write_text("x")
    sequence = open_frames(folder)
    assert len(sequence) == 12
    assert sequence.notes == ("3 files beside the frames are not read: .DS_Store, ._1_flat_0.png, notes.txt",)


def test_a_frame_of_another_size_is_named(tmp_path, frames):
    folder = write_pages(tmp_path / "press", frames)
    cv2.imwrite(str(folder / "5_flat_0.png"), frames[4][:20])
    sequence = open_frames(folder)
    with pytest.raises(FramesError, match=r"5_flat_0.png, frame 4: expected 32 x 24 px .* found 32 x 20 px"):
        sequence[4]
    np.testing.assert_array_equal(sequence[5], frames[5])


@pytest.mark.parametrize(("left", "found"), [(0, "an empty file"), (300, "300 bytes that do not decode")])
def test_a_broken_frame_is_named_and_the_others_are_read(tmp_path, frames, left, found):
    folder = write_pages(tmp_path / "press", frames)
    broken = folder / "5_flat_0.png"
    broken.write_bytes(broken.read_bytes()[:left])
    sequence = open_frames(folder)
    with pytest.raises(FramesError, match=rf"5_flat_0.png, frame 4: expected an image, but found {found}"):
        sequence[4]
    np.testing.assert_array_equal(sequence[5], frames[5])


def test_a_frame_that_may_not_be_read_is_named(tmp_path, frames, monkeypatch):
    folder = write_pages(tmp_path / "press", frames)
    sequence = open_frames(folder)

    def refuse(self):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.read_bytes", refuse)
    with pytest.raises(FramesError, match=r"5_flat_0.png: .* Permission denied. Give yourself the right"):
        sequence[4]


def test_frames_of_two_kinds_are_not_mixed(tmp_path, frames):
    folder = write_pages(tmp_path / "press", frames)
    write_pages(folder, frames[:1], "overview.jpg")
    with pytest.raises(FramesError, match="expected frames of one kind, but found JPEG and PNG"):
        open_frames(folder)


def test_only_the_first_frame_is_decoded_on_opening(tmp_path, frames, monkeypatch):
    folder = write_pages(tmp_path / "press", frames)
    decoded = []
    imdecode = cv2.imdecode
    monkeypatch.setattr(cv2, "imdecode", lambda data, flags: decoded.append(data.tobytes()) or imdecode(data, flags))
    sequence = open_frames(folder)
    assert set(decoded) == {(folder / "1_flat_0.png").read_bytes()}
    decoded.clear()
    sequence[7]
    assert decoded == [(folder / "8_flat_0.png").read_bytes()]


def test_real_flat_press(shared_data):
    sequence = open_frames(shared_data("tactile/tactip127_flat_press_640x480"))
    assert (len(sequence), sequence.shape) == (91, (480, 640))
    assert [set(np.unique(sequence[k])) <= {0, 255} for k in (0, 45, 90)] == [True] * 3
    rest, deepest = (sequence[k].astype(float) for k in (0, 90))
    assert np.abs(sequence[1] - rest).mean() < 0.2 * np.abs(deepest - rest).mean()


def test_real_colour_frames_of_331_pins(shared_data):
    sequence = open_frames(shared_data("tactile/tactip331_raw_640x480"))
    assert (len(sequence), sequence.shape) == (16, (480, 640))
    assert all(frame.dtype == np.uint8 and frame.ndim == 2 for frame in sequence)


def test_real_shapes_are_one_sequence_each(shared_data):
    presses = find_presses(shared_data("tactile/tactip127_shapes_300x300"))
    assert [press.name for press in presses] == ["cuboid", "cylinderR4", "cylinderR8", "prism"]
    for press in presses:
        sequence = open_frames(press)
        assert (sequence.name, len(sequence), sequence.shape) == (press.name, 25, (300, 300))


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
        pages.open_file(tmp_path / "gone.npy")


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
