"""Headerless number tables."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import inspect, load_named, open_recording, read

TIME = np.arange(400) / 1000.0
VALUES = np.stack([np.cos(np.arange(400.0)), np.arange(400.0) ** 2])


def write(tmp_path: Path, matrix: np.ndarray, separator: str, decimal: str = ".", head: str = "") -> Path:
    rows = [separator.join(f"{value:.9f}".replace(".", decimal) for value in row) for row in matrix]
    path = tmp_path / "rec.txt"
    path.write_text(head + "\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize(("separator", "decimal"), [(" ", "."), (",", "."), (";", ","), ("\t", ",")])
@pytest.mark.parametrize("word", ["row", "column"])
def test_orientation_and_spelling(tmp_path: Path, separator: str, decimal: str, word: str) -> None:
    matrix = np.stack([VALUES[0], TIME + 3.0, VALUES[1]])
    path = write(tmp_path, matrix if word == "row" else matrix.T, separator, decimal, "\n\n")
    recording = read(path, [f"{word} 1", f"{word} 3"])
    assert [(c.fs_hz, c.start_s, c.unit) for c in recording.channels] == [(1000.0, 3.0, "")] * 2
    np.testing.assert_allclose(recording.channels[0].samples, VALUES[0], atol=1e-9)
    np.testing.assert_allclose(recording.channels[1].samples, VALUES[1], atol=1e-9)
    assert "recognised by its even steps" in recording.notes[0]


def test_without_time_the_rate_must_be_stated(tmp_path: Path) -> None:
    path = write(tmp_path, VALUES, " ")
    assert [channel.name for channel in inspect(path)[1]] == [f"row {i + 1}" for i in range(len(VALUES))]
    with pytest.raises(RecordingError, match=r"no column of time. State it: fs_hz"):
        read(path, ["row 1"])
    _, opened = open_recording(path)
    assert load_named(opened, ["row 1"], [500.0])[0].fs_hz == 500.0
    count = write(tmp_path, np.stack([np.arange(400.0), VALUES[0]]).T, " ")  # a count is no time
    assert [channel.name for channel in inspect(count)[1]] == ["column 1", "column 2"]


def test_faults_name_their_line(tmp_path: Path) -> None:
    path = write(tmp_path, np.stack([TIME, VALUES[0]]), " ")
    text = path.read_text().split("\n")
    path.write_text(text[0] + "\n" + text[1] + " 7.0\n")
    with pytest.raises(RecordingError, match="line 2: expected 400 values, as in line 1, but found 401"):
        inspect(path)
    path.write_text(text[0] + "\n" + text[1].rpartition(" ")[0] + " abc\n")
    with pytest.raises(RecordingError, match="line 2: expected numbers, but found 'abc'"):
        inspect(path)


def test_real_grip_recording(shared_data) -> None:
    for file, first, largest in (("emg", 0.0366211, 2.17048), ("force", 23.5596, 97.9004)):
        channel = read(shared_data(f"emg/emg_force/novainstrumentation_{file}.txt"), ["row 2"]).channels[0]
        assert (channel.fs_hz, channel.start_s, channel.samples.size) == (1000.0, 0.0, 5000)
        assert channel.samples[0] == pytest.approx(first, rel=1e-5)
        assert channel.samples.max() == pytest.approx(largest, rel=1e-5)
