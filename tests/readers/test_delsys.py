"""Trigno Discover CSV in the versions seen.

Delsys EMGworks CSV, bare and verbose.
"""

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


FAST, SLOW = 27 / 0.0135, 2 / 0.0135  # Hz; Trigno sends whole samples in 13.5 ms


def bare(n: int = 54, end: str = "", label: str = "Avanti sensor 1: EMG 1") -> str:
    lines = [f'X[s],"{label}",X[s],"Load Cell: Fz [N]"']
    for i in range(n):
        slow = f"{i / SLOW:.7g},{i}" if i < n * SLOW / FAST else end or ","
        lines.append(f"{i / FAST:.7g},{i * 1e-6:.7g},{slow}")
    return "\n".join(lines) + "\n"


def verbose(n_stated: int = 54, fs_stated: float = FAST, start: float = 0.0) -> str:
    row = "Label: {} Sampling frequency: {:e} Number of points: {} start: {:e} Unit: {} Domain Unit: s"
    head = [
        row.format("Mini sensor 1: EMG 1", fs_stated, n_stated, start, "Volts"),
        row.format("Mini sensor 1: ACC.X 1", SLOW, 4, start, "g"),
        "Start Trigger Method: None",
        "Stop Trigger Method: None",
        "",
    ]
    return (
        "\n".join(head)
        + "\n"
        + bare(label="Mini sensor 1: EMG 1").replace("Load Cell: Fz [N]", "Mini sensor 1: ACC.X 1")
    )


@pytest.mark.parametrize("end", ["", "0,0"])
def test_bare_slow_channel_is_cut_at_blanks_and_at_zero_padding(tmp_path: Path, end: str) -> None:
    emg, force = read(write(tmp_path, bare(end=end)), ["Avanti sensor 1: EMG 1", "Load Cell: Fz"]).channels
    assert emg.fs_hz == pytest.approx(FAST, rel=1e-6)
    assert force.fs_hz == pytest.approx(SLOW, rel=1e-6)
    assert (emg.samples.size, force.samples.size) == (54, 4)
    np.testing.assert_allclose(emg.samples, np.arange(54) * 1e-6)
    assert (emg.unit, force.unit) == ("V", "N")


def test_bare_emg_is_in_volts_and_says_so(tmp_path: Path) -> None:
    assert "EMGworks writes EMG in V" in read(write(tmp_path, bare()), ["Avanti sensor 1: EMG 1"]).notes[0]


def test_decimal_commas(tmp_path: Path) -> None:
    path = write(tmp_path, bare().replace(",", ";").replace(".", ","))
    emg = read(path, [inspect(path)[1][0].name]).channels[0]
    assert emg.fs_hz == pytest.approx(FAST, rel=1e-6)
    assert emg.samples[-1] == pytest.approx(53e-6)


def test_verbose_statements_count(tmp_path: Path) -> None:
    recording = read(write(tmp_path, verbose()), ["Mini sensor 1: EMG 1", "Mini sensor 1: ACC.X 1"])
    emg, acc = recording.channels
    assert (emg.fs_hz, emg.unit, acc.unit, acc.samples.size) == (FAST, "V", "g", 4)
    assert recording.notes == ()


def test_verbose_file_cut_short_is_noted(tmp_path: Path) -> None:
    notes = read(write(tmp_path, verbose(n_stated=81141)), ["Mini sensor 1: EMG 1"]).notes
    assert notes == ("Mini sensor 1: EMG 1: the header promises 81141 samples, the file holds 54.",)


def test_verbose_rate_against_time_stamps(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="expected the stated rate, 1000 Hz, but found 2000 Hz by the time stamps"):
        read(write(tmp_path, verbose(fs_stated=1000.0)), ["Mini sensor 1: EMG 1"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (verbose().replace("Number of points: 54", "Number of points: many"), "line 1: expected Label"),
        (verbose().replace("Label: Mini sensor 1: ACC.X 1", "Label: Mini sensor 9: ACC.X 9"), "of the Label lines"),
        ("".join(verbose().splitlines(True)[:4]), "header row that begins with X"),
        ("X[s],A,X[s],B,C\n0,1,0,2,3\n", r"line 1, column 5: expected X\[s\], but found 'C'"),
    ],
)
def test_damaged_headers(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        inspect(write(tmp_path, text))


def test_real_bare_export(shared_data) -> None:
    path = shared_data("emg/delsys_csv/emgworks.csv")
    rates = {c.name: c.fs_hz for c in inspect(path)[1]}
    assert len(rates) == 69
    assert rates["Avanti sensor 1: EMG 1"] == pytest.approx(1925.926, rel=1e-6)
    assert rates["Avanti sensor 2: EMG 2"] == pytest.approx(17 / 0.0135, rel=1e-6)
    assert rates["Avanti sensor 1: ACC.X 1"] == pytest.approx(2 / 0.0135, rel=1e-6)
    assert rates["Analog Input adapter 12: Analog 12"] == pytest.approx(2222.2222, rel=1e-6)
    acc = read(path, ["Avanti sensor 1: ACC.X 1"]).channels[0]
    assert acc.samples[-1] == -1.233571


def test_real_verbose_export(shared_data) -> None:
    path = shared_data("emg/delsys_csv/emgio_emgworks_verbose_truncated.csv")
    recording = read(path, ["Mini sensor 10: EMG 10", "Mini sensor 11: GYRO.Z 11"])
    emg, gyro = recording.channels
    assert (emg.fs_hz, emg.samples.size, emg.unit) == (1259.259, 2519, "V")
    assert (gyro.fs_hz, gyro.samples.size, gyro.unit) == (148.1481, 297, "°/s")
    assert emg.samples[-1] == 0.0002955825
    assert "promises 81141 samples, the file holds 2519" in recording.notes[0]
