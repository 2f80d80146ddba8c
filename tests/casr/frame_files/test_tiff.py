"""Multi-page TIFF files of every common kind."""

from __future__ import annotations

import tracemalloc

import cv2
import numpy as np
import pytest
import tifffile

from casr.errors import FramesError
from casr.frame_files import open_frames


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"bigtiff": True},
        {"byteorder": ">"},
        {"imagej": True},
        {"metadata": None},
        {"compression": "zlib"},
        {"compression": "zlib", "predictor": True},
        {"tile": (16, 16)},
        {"rowsperstrip": 5},
        {"truncate": True},
    ],
    ids=str,
)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_grey_stacks_come_back_exactly(tmp_path, frames, how, dtype):
    levels = frames.astype(dtype) * dtype(257 if dtype == np.uint16 else 1)
    tifffile.imwrite(tmp_path / "press.tif", levels, **({"photometric": "minisblack"} | how))
    sequence = open_frames(tmp_path / "press.tif")
    assert (sequence.name, len(sequence), sequence.shape) == ("press", 12, (24, 32))
    for index in (0, 11, 3, 4, 3, 10):
        np.testing.assert_array_equal(sequence[index], frames[index])


def test_colour_is_red_green_blue_in_the_file(tmp_path, frames):
    blue_green_red = np.stack([frames, frames // 2, frames // 4], axis=-1)
    tifffile.imwrite(tmp_path / "press.tif", blue_green_red[..., ::-1], photometric="rgb")
    sequence = open_frames(tmp_path / "press.tif")
    assert sequence.shape == (24, 32)
    np.testing.assert_array_equal(sequence[5], cv2.cvtColor(blue_green_red[5], cv2.COLOR_BGR2GRAY))


@pytest.mark.parametrize("n_frames", [12, 70])
def test_what_tifffile_does_not_decode_opencv_does(tmp_path, frames, n_frames):
    stack = np.resize(frames, (n_frames, 24, 32)) + np.arange(n_frames, dtype=np.uint8)[:, None, None]
    cv2.imwritemulti(str(tmp_path / "lzw.tif"), list(stack))
    with tifffile.TiffFile(tmp_path / "lzw.tif") as file:
        assert file.pages[0].compression == tifffile.COMPRESSION.LZW
    sequence = open_frames(tmp_path / "lzw.tif")
    assert len(sequence) == n_frames
    np.testing.assert_array_equal(list(sequence), stack)
    for index in (n_frames - 1, 0, 5, n_frames // 2):
        np.testing.assert_array_equal(sequence[index], stack[index])


def test_white_is_zero_means_what_it_says(tmp_path, frames):
    tifffile.imwrite(tmp_path / "press.tif", 255 - frames, photometric="miniswhite")
    np.testing.assert_array_equal(open_frames(tmp_path / "press.tif")[3], frames[3])


def test_frames_written_one_by_one(tmp_path, frames):
    with tifffile.TiffWriter(tmp_path / "press.tif") as file:
        for frame in frames:
            file.write(frame, photometric="minisblack", contiguous=True, metadata=None)
    np.testing.assert_array_equal(list(open_frames(tmp_path / "press.tif")), frames)


def test_a_damaged_page_is_named_and_the_others_are_read(tmp_path, frames):
    path = tmp_path / "press.tif"
    tifffile.imwrite(path, frames, photometric="minisblack", compression="zlib")
    with tifffile.TiffFile(path) as file:
        place = file.pages[7].dataoffsets[0]
    with path.open("r+b") as file:
        file.seek(place)
        file.write(b"\xff" * 40)
    sequence = open_frames(path)
    with pytest.raises(FramesError, match=r"press.tif, frame 7: expected an image"):
        sequence[7]
    np.testing.assert_array_equal(sequence[6], frames[6])
    np.testing.assert_array_equal(sequence[8], frames[8])


def test_a_file_cut_short_gives_the_frames_that_are_whole(tmp_path, frames):
    path = tmp_path / "press.tif"
    tifffile.imwrite(path, frames, photometric="minisblack")
    with tifffile.TiffFile(path) as file:
        place = file.pages[11].dataoffsets[0]
    path.write_bytes(path.read_bytes()[: place + 100])
    sequence = open_frames(path)
    np.testing.assert_array_equal(sequence[10], frames[10])
    with pytest.raises(FramesError, match=r"press.tif, frame 11|a frame from 0 to 10"):
        sequence[11]


def test_a_file_cut_short_before_its_second_page_says_so_in_the_error_alone(tmp_path, capfd):
    path = tmp_path / "press.tif"
    with tifffile.TiffWriter(path) as file:
        for _ in range(3):
            file.write(np.ones((24, 32), np.uint8), photometric="minisblack", contiguous=True, metadata=None)
    path.write_bytes(path.read_bytes()[:1500])
    with pytest.raises(FramesError, match="found one frame; the file is damaged or incomplete"):
        open_frames(path)
    assert capfd.readouterr().err == ""


def test_a_page_of_another_size_is_named(tmp_path, frames):
    with tifffile.TiffWriter(tmp_path / "press.tif") as file:
        file.write(frames[0], metadata=None)
        file.write(frames[1][:20], metadata=None)
        file.write(frames[2], metadata=None)
    sequence = open_frames(tmp_path / "press.tif")
    with pytest.raises(FramesError, match=r"press.tif, frame 1: expected 32 x 24 px .* found 32 x 20 px"):
        sequence[1]
    np.testing.assert_array_equal(sequence[2], frames[2])


@pytest.mark.parametrize("data", [b"", b"hello, no image", b"II*\0\x08\0\0\0", b"II*\0\xff\xff\0\0"])
def test_what_is_no_tiff(tmp_path, data):
    (tmp_path / "press.tif").write_bytes(data)
    with pytest.raises(FramesError, match=r"press.tif"):
        open_frames(tmp_path / "press.tif")


def test_one_page_is_no_sequence(tmp_path, frames):
    tifffile.imwrite(tmp_path / "press.tif", frames[0])
    with pytest.raises(FramesError, match="two frames or more, but found one frame"):
        open_frames(tmp_path / "press.tif")


@pytest.mark.parametrize(
    "levels",
    [lambda grey: np.float32(grey / 255), np.uint16, lambda grey: np.uint16(grey) * 16],
    ids=["0..1", "8", "12"],
)
def test_levels_that_do_not_use_the_range_are_refused(tmp_path, frames, levels):
    tifffile.imwrite(tmp_path / "press.tif", levels(frames), photometric="minisblack")
    with pytest.raises(FramesError, match="expected grey levels that use the range"):
        open_frames(tmp_path / "press.tif")


def test_memory_does_not_grow_with_the_number_of_frames(tmp_path):
    def peak_bytes(n_frames):
        path = tmp_path / f"{n_frames}.tif"
        tifffile.imwrite(path, np.full((n_frames, 100, 100), 9, np.uint8), photometric="minisblack")
        tracemalloc.start()
        for frame in open_frames(path):
            assert frame[0, 0] == 9
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak

    short = peak_bytes(100)
    # some 80 bytes a page for its place in the file, against 10 000 for its pixels
    assert peak_bytes(1000) < short + 1000 * 200
