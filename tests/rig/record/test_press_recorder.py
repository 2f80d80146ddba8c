"""One press on disk: written as it happens, readable at any moment, its newest page."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys

import cv2
import numpy as np
import pytest
import tifffile

from casr.frame_files import open_frames, read_force_log
from emg2vsa.errors import DeviceError
from emg2vsa.rig.record.press_recorder import PressRecorder, TiffPages, newest_page

SHAPE = (25, 31)


def images(count, shape=SHAPE):
    rng = np.random.default_rng(0)
    return rng.integers(0, 256, (count, *shape), dtype=np.uint8)


def record(folder, frames, rows_per_frame=10):
    recorder = PressRecorder(folder, frames.shape[1:])
    recorder.force(0.0, 0.01)
    for index, image in enumerate(frames):
        assert recorder.frame(image, index / 20) == index
        for row in range(rows_per_frame):
            recorder.force((index * rows_per_frame + row + 1) / 200, index + row / 100)
    return recorder


def test_a_press_comes_back(tmp_path):
    frames = images(12)
    recorder = record(tmp_path / "press", frames)
    recorder.close()
    recorder.close()
    press = open_frames(tmp_path / "press", force_rule="mean")
    np.testing.assert_array_equal(list(press), frames)
    np.testing.assert_allclose(press.force_n, np.arange(12) + 0.045)
    log = read_force_log(tmp_path / "press" / "force.csv")
    assert log.frame_index[:2].tolist() == [-1, 0]
    np.testing.assert_allclose(log.time_s, np.arange(121) / 200)
    np.testing.assert_allclose(log.frame_time_s[[0, 1, -1]], [np.nan, 0.0, 11 / 20])


def test_it_is_readable_while_it_is_written(tmp_path):
    frames = images(6)
    recorder = PressRecorder(tmp_path / "press", SHAPE)
    for index, image in enumerate(frames):
        recorder.frame(image, index / 20)
        recorder.force(index / 20, 1.0)
        if index:
            np.testing.assert_array_equal(list(open_frames(tmp_path / "press")), frames[: index + 1])
    recorder.close()


@pytest.mark.parametrize("shape", [(24, 32), (25, 31)])
def test_other_programs_read_the_pages(tmp_path, shape):
    frames = images(5, shape)
    pages = TiffPages(tmp_path / "frames.tif", shape)
    for image in frames:
        pages.append(image)
    pages.close()
    with tifffile.TiffFile(tmp_path / "frames.tif") as file:
        np.testing.assert_array_equal([page.asarray() for page in file.pages], frames)
    read, by_opencv = cv2.imreadmulti(str(tmp_path / "frames.tif"), flags=cv2.IMREAD_UNCHANGED)
    assert read
    np.testing.assert_array_equal(by_opencv, frames)


KILLED = """
import os, sys
import numpy as np
from pathlib import Path
from emg2vsa.rig.record.press_recorder import PressRecorder
recorder = PressRecorder(Path(sys.argv[1]), (300, 300))
for index in range(1000):
    recorder.frame(np.full((300, 300), index % 251, np.uint8), index / 20)
    recorder.force(index / 20, index % 100)
    if index == 20:
        print("go", flush=True)
"""


# Windows has no pwrite
SYSTEMS = pytest.mark.parametrize("system", ["", "import os; del os.pwrite\n"], ids=["posix", "windows"])


@SYSTEMS
def test_killed_at_any_moment(tmp_path, system):
    for attempt in range(3):
        folder = tmp_path / f"press{attempt}"
        with subprocess.Popen([sys.executable, "-c", system + KILLED, str(folder)], stdout=subprocess.PIPE) as program:
            program.stdout.readline()
            program.kill()
        assert program.returncode == -signal.SIGKILL
        press = open_frames(folder)
        assert len(press) > 20
        assert all((press[index] == index % 251).all() for index in range(len(press)))
        log = read_force_log(folder / "force.csv")
        assert len(press) - len(log.force_n) in (0, 1)
        np.testing.assert_array_equal(log.frame_index % 100, log.force_n)


def test_without_pwrite_the_bytes_are_the_same(tmp_path, monkeypatch):
    frames = images(4)
    record(tmp_path / "posix", frames).close()
    monkeypatch.delattr(os, "pwrite")
    record(tmp_path / "windows", frames).close()
    for name in ("frames.tif", "force.csv"):
        assert (tmp_path / "windows" / name).read_bytes() == (tmp_path / "posix" / name).read_bytes()


def test_killed_between_page_and_link(tmp_path):
    frames = images(4)
    record(tmp_path / "press", frames).close()
    whole = (tmp_path / "press" / "frames.tif").read_bytes()
    page = (len(whole) - 8) // 4
    # the last page is there but for any part of it, and not linked yet
    link = 8 + 3 * page - 4
    for kept in (1, 100, page // 2, page - 1, page):
        cut = bytearray(whole[: 8 + 3 * page + kept])
        cut[link : link + 4] = bytes(4)
        (tmp_path / "frames.tif").write_bytes(cut)
        np.testing.assert_array_equal(list(open_frames(tmp_path / "frames.tif")), frames[:3])


FULL = """
import resource, signal, sys
import numpy as np
from pathlib import Path
from emg2vsa.errors import DeviceError
from emg2vsa.rig.record.press_recorder import PressRecorder
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (5100, resource.RLIM_INFINITY))
recorder = PressRecorder(Path(sys.argv[1]), (30, 30))
for index in range(10):
    recorder.force(index / 20, index)
    try:
        recorder.frame(np.full((30, 30), index, np.uint8), index / 20)
    except DeviceError as error:
        print(error)
        break
recorder.force(1.0, 99.0)
"""


@pytest.mark.skipif(not hasattr(resource, "RLIMIT_FSIZE"), reason="needs a limit on file sizes")
@SYSTEMS
def test_a_full_disk_is_told_and_costs_nothing_recorded(tmp_path, system):
    done = subprocess.run(
        [sys.executable, "-c", system + FULL, str(tmp_path / "press")], capture_output=True, text=True, check=True
    )
    assert "room for 1014 bytes" in done.stdout
    press = open_frames(tmp_path / "press")
    assert [int(frame[0, 0]) for frame in press] == [0, 1, 2, 3, 4]
    assert read_force_log(tmp_path / "press" / "force.csv").frame_index[-1] == 4


def test_a_press_is_never_written_over(tmp_path):
    record(tmp_path / "press", images(2)).close()
    with pytest.raises(DeviceError, match=r"force\.csv"):
        PressRecorder(tmp_path / "press", SHAPE)


def test_a_folder_that_cannot_be(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(DeviceError, match="a new file to record to"):
        PressRecorder(tmp_path / "file" / "press", SHAPE)


@pytest.mark.parametrize(
    "image", [np.zeros((31, 25), np.uint8), np.zeros(SHAPE, np.float32), np.zeros((*SHAPE, 3), np.uint8)]
)
def test_images_of_another_kind(tmp_path, image):
    recorder = PressRecorder(tmp_path / "press", SHAPE)
    with pytest.raises(DeviceError, match="31 x 25 px"):
        recorder.frame(image, 0.0)


def test_a_full_tiff_is_told(tmp_path):
    pages = TiffPages(tmp_path / "frames.tif", SHAPE)
    # a hole stands for the pages before
    pages._file.size_bytes = 2**32 - 800
    with pytest.raises(DeviceError, match="less than 4 GiB"):
        pages.append(images(1)[0])


@pytest.mark.parametrize("shape", [(25, 31), (12, 16), (1, 1)])
def test_it_is_the_page_written_last(tmp_path, shape):
    path = tmp_path / "frames.tif"
    pages = TiffPages(path, shape)
    assert newest_page(path) is None
    for image in images(5, shape):
        pages.append(image)
        np.testing.assert_array_equal(newest_page(path), image)


def test_half_a_page_behind_it_does_not_matter(tmp_path):
    path = tmp_path / "frames.tif"
    pages = TiffPages(path, (25, 31))
    first, second = images(2, (25, 31))
    pages.append(first)
    whole = path.read_bytes()
    pages.append(second)
    added = path.read_bytes()[len(whole) :]
    for cut in (*range(0, len(added), 31), len(added) - 1):
        path.write_bytes(whole + added[:cut])
        np.testing.assert_array_equal(newest_page(path), first)


def test_the_pages_between_are_not_visited(tmp_path):
    path = tmp_path / "frames.tif"
    pages = TiffPages(path, (12, 16))
    taken = images(50, (12, 16))
    for image in taken:
        pages.append(image)
    length = path.stat().st_size // 50
    with path.open("r+b") as file:
        file.seek(2 * length)
        file.write(b"?" * (47 * length))
    np.testing.assert_array_equal(newest_page(path), taken[-1])


@pytest.mark.parametrize("content", [b"", b"II", b"time_s,force_n\n", b"II*\0\x08\0\0\0", b"II*\0\xff\xff\xff\x7f"])
def test_another_file_is_refused(tmp_path, content):
    path = tmp_path / "frames.tif"
    path.write_bytes(content)
    with pytest.raises(DeviceError, match="expected a TIFF of the rig"):
        newest_page(path)


def test_no_file_is_refused(tmp_path):
    with pytest.raises(DeviceError, match="No such file"):
        newest_page(tmp_path / "frames.tif")
