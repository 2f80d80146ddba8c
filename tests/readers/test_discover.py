"""Trigno Discover CSV in the versions seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import inspect, read

EMG_HZ, ACC_HZ = 17 / 0.0135, 2 / 0.0135


def export(version: str, *rows: str, data: list[str]) -> str:
    """CRLF but for row 3, which ends in a bare line feed, as the program writes it."""
    head = [
        f"Application:, Trigno Discover ({version})\r",
        "Date/Time:, 12/6/2024 12:37:52 PM\r",
        "Collection Length (seconds):, 0.0270",
    ]
    return "\n".join([*head, *(row + "\r" for row in [*rows, *data])]) + "\n"


def plain(version: str = "1.7.0", n: int = 34) -> str:
    data = [f"{i}, {i if i < 4 else ' '}, {2 * i}, " for i in range(n)]
    return export(
        version, "EMG 01 (54717), , EMG 02 (55240), VO2 (0)", "sensor mode: 55, , sensor mode: 55, sensor mode: 0",
        "EMG 1 (mV), ACC X (G), EMG 1 (mV), Vent. (L/min)", "1259.2593 Hz, 148.1481 Hz, 1259.2593 Hz, -1 Hz", data=data,
    )  # fmt: skip


def time_series(extra_row: bool = False) -> str:
    data = [f"{i / EMG_HZ:.7f}, {i}, " + (f"{i / ACC_HZ:.7f}, {i}" if i < 4 else ", ") for i in range(34)]
    rows = [
        "1 (FDS) (81029)", "sensor mode: 45",
        "EMG 1 Time Series (s), EMG 1 (mV), ACC X Time Series (s), ACC X (G)", ", 1259.2593 Hz, , 148.1481 Hz",
    ]  # fmt: skip
    if extra_row:
        rows.append(", 0.000794 s, , 0.00675 s, Type, Name, Label, Time (s)")
        data[0] += ", General, M1, go now, 0.5"
    return export("1.6.4", *rows, data=data)


def write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "rec.csv"
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("version", ["1.5.0", "1.6.4", "1.7.0", "2.1.0"])
def test_each_column_is_its_own_series_under_its_sensor(tmp_path: Path, version: str) -> None:
    path = write(tmp_path, plain(version))
    assert [c.name for c in inspect(path)[1]] == [
        "EMG 01 (54717): EMG 1", "EMG 01 (54717): ACC X", "EMG 02 (55240): EMG 1", "VO2 (0): Vent.",
    ]  # fmt: skip
    first, acc, second = read(
        path, ["EMG 01 (54717): EMG 1", "EMG 01 (54717): ACC X", "EMG 02 (55240): EMG 1"]
    ).channels
    assert (first.fs_hz, acc.fs_hz, acc.samples.size, acc.unit) == (1259.2593, 148.1481, 4, "G")
    np.testing.assert_allclose(second.samples, 2e-3 * np.arange(34))
    assert second.conversion == "mV x 0.001 = V"


def test_a_device_without_a_rate_is_listed_and_refused_when_asked_for(tmp_path: Path) -> None:
    path = write(tmp_path, plain().replace(", \r", ", 5\r"))
    assert np.isnan(inspect(path)[1][3].fs_hz)
    with pytest.raises(RecordingError, match="expected a sampling rate"):
        read(path, ["VO2 (0): Vent."])


@pytest.mark.parametrize("extra_row", [False, True])
def test_time_series_export(tmp_path: Path, extra_row: bool) -> None:
    path = write(tmp_path, time_series(extra_row))
    emg, acc = read(path, ["1 (FDS) (81029): EMG 1", "1 (FDS) (81029): ACC X"]).channels
    assert (emg.fs_hz, emg.samples.size, acc.fs_hz, acc.samples.size) == (1259.2593, 34, 148.1481, 4)


def test_version_142_has_rates_without_decimals_and_no_units(tmp_path: Path) -> None:
    text = export(
        "1.4.2", "EMG 01 (54717), , ", "sensor mode: 55, , ", "EMG 1 (1259Hz), ACC X (148Hz), ACC Y (500Hz)",
        data=[f"{i}, {i}, {i}" for i in range(9)],
    )  # fmt: skip
    recording = read(write(tmp_path, text), [f"EMG 01 (54717): {name}" for name in ("EMG 1", "ACC X", "ACC Y")])
    assert [c.fs_hz for c in recording.channels] == [pytest.approx(EMG_HZ), pytest.approx(ACC_HZ), 500.0]
    assert recording.channels[0].unit == ""
    assert "1259.2593 Hz was used" in recording.notes[0]


def test_semicolons_and_decimal_commas(tmp_path: Path) -> None:
    text = plain().replace(", ", ";").replace(".", ",").replace("1,7,0", "1.7.0")
    text = "\n".join(line.replace(";2;", ";2,5;") for line in text.split("\n"))
    channel = read(write(tmp_path, text), ["EMG 02 (55240): EMG 1"]).channels[0]
    assert channel.fs_hz == 1259.2593
    assert channel.samples[1] == pytest.approx(2.5e-3)


def test_text_in_a_sample_cell(tmp_path: Path) -> None:
    with pytest.raises(
        RecordingError, match=r"line 17, column 'EMG 01 \(54717\): EMG 1': expected a number, but found 'lost'"
    ):
        read(write(tmp_path, plain().replace("\n9,", "\nlost,")), ["EMG 01 (54717): EMG 1"])


def test_header_only_and_no_modes(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="samples below the header"):
        inspect(write(tmp_path, export("1.7.0", "S", "sensor mode: 1", "EMG 1 (mV)", "1000 Hz", data=[])))
    with pytest.raises(RecordingError, match="row of sensor modes"):
        inspect(write(tmp_path, "Application:, Trigno Discover (9)\n1,2\n"))


@pytest.mark.parametrize(
    ("file", "count", "samples", "first_mv"),
    [("discover150.csv", 64, 250, -0.1371328), ("discover170.csv", 111, 200, 0.0018463)],
)
def test_real_exports(shared_data, file: str, count: int, samples: int, first_mv: float) -> None:
    path = shared_data(f"emg/delsys_csv/{file}")
    infos = inspect(path)[1]
    assert len(infos) == len({info.name for info in infos}) == count
    emg = read(path, [infos[0].name]).channels[0]
    assert (emg.fs_hz, emg.samples.size, emg.unit) == (1259.2593, samples, "V")
    assert emg.samples[0] == pytest.approx(first_mv * 1e-3, rel=1e-12)
