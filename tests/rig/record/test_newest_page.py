"""The newest page of a TIFF that grows."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.errors import DeviceError
from emg2vsa.rig.record.press_recorder import TiffPages, newest_page


def images(count, shape):
    return np.random.default_rng(0).integers(0, 256, (count, *shape), dtype=np.uint8)


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
