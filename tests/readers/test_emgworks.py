"""Delsys EMGworks CSV, bare and verbose."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import inspect, read

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


def write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "rec.csv"
    path.write_bytes(text.encode())
    return path


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
