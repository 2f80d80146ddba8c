from __future__ import annotations

import io
import zipfile

from emg2vsa.deposit.package import zip_bytes


def test_bytes_depend_on_names_and_contents_alone():
    assert zip_bytes({"b/c.txt": b"two", "a.txt": b"one"}) == zip_bytes({"a.txt": b"one", "b/c.txt": b"two"})
    assert zip_bytes({"a.txt": b"one"}) != zip_bytes({"a.txt": b"two"})


def test_an_archive_reads_back_sorted_without_times():
    archive = zipfile.ZipFile(io.BytesIO(zip_bytes({"b": b"2", "a": b"1"})))
    assert archive.testzip() is None
    assert [(entry.filename, entry.date_time) for entry in archive.infolist()] == [
        ("a", (1980, 1, 1, 0, 0, 0)),
        ("b", (1980, 1, 1, 0, 0, 0)),
    ]
    assert archive.read("b") == b"2"
