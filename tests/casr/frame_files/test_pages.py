"""Folders of images."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from casr.errors import FramesError
from casr.frame_files import find_presses, open_frames


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
