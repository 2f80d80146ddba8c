"""Plain CSV in the spellings people export it in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import inspect, load_named, open_recording, read

TIME = np.arange(60) / 1000.0
EDC, FZ = np.sin(np.arange(60.0)), 0.1 + np.arange(60.0)


def table(header: str, separator: str = ",", decimal: str = ".", end: str = "\n") -> str:
    rows = [
        f"{t:.3f}{separator}{e:.9f}{separator}{f:.3f}".replace(".", decimal)
        for t, e, f in zip(TIME, EDC, FZ, strict=True)
    ]
    return end.join([header, *rows]) + end


def write(tmp_path: Path, text: str, encoding: str = "utf-8") -> Path:
    path = tmp_path / "rec.csv"
    path.write_bytes(text.encode(encoding))
    return path


def check(path: Path) -> None:
    recording = read(path, ["Fz", "EDC"])
    assert [(c.name, c.unit, c.fs_hz, c.start_s) for c in recording.channels] == [
        ("Fz", "N", 1000.0, 0.0),
        ("EDC", "V", 1000.0, 0.0),
    ]
    np.testing.assert_allclose(recording.channel("EDC").samples, EDC * 1e-3, atol=1e-12)
    np.testing.assert_allclose(recording.channel("Fz").samples, FZ, atol=1e-12)


@pytest.mark.parametrize(
    ("separator", "decimal"), [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), ("  ", ".")]
)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_separators_decimals_and_line_ends(tmp_path: Path, separator: str, decimal: str, end: str) -> None:
    header = separator.join(["time[s]", "EDC[mV]", "Fz[N]"])
    check(write(tmp_path, table(header, separator, decimal, end)))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
def test_encodings(tmp_path: Path, encoding: str) -> None:
    path = write(tmp_path, table("time (s),EDC (µV),Fz (N)"), encoding)
    np.testing.assert_allclose(read(path, ["EDC"]).channels[0].samples, EDC * 1e-6, atol=1e-15)


def test_quoted_decimal_commas_in_a_comma_separated_file(tmp_path: Path) -> None:
    rows = "\n".join(
        f'"{t:.3f}","{e:.9f}","{f:.3f}"'.replace(".", ",").replace('","', '";"')
        for t, e, f in zip(TIME, EDC, FZ, strict=True)
    )
    check(write(tmp_path, "time;EDC [mV];Fz [N]\n" + rows + "\n"))
    check(write(tmp_path, ("time,EDC [mV],Fz [N]\n" + rows + "\n").replace(";", ",")))


@pytest.mark.parametrize(
    "name", ["time", "Time", "t", "time_s", "time (s)", "X[s]", "Timestamp [s]", "t [s]", "Elapsed time (sec)"]
)
def test_names_of_the_time_column(tmp_path: Path, name: str) -> None:
    check(write(tmp_path, table(f"{name},EDC (mV),Fz (N)")))


def test_time_in_milliseconds(tmp_path: Path) -> None:
    text = "time_ms,EDC (mV)\n" + "".join(f"{i},{i}\n" for i in range(20))
    assert inspect(write(tmp_path, text))[1][0].fs_hz == 1000.0


def test_a_count_of_samples_is_no_time(tmp_path: Path) -> None:
    text = "time,EDC (mV)\n" + "".join(f"{i},{i}\n" for i in range(20))
    with pytest.raises(RecordingError, match="expected a time unit"):
        read(write(tmp_path, text), ["EDC"])


def test_seconds_taken_for_want_of_a_unit_are_noted(tmp_path: Path) -> None:
    assert "seconds were taken" in read(write(tmp_path, table("time,EDC (mV),Fz (N)")), ["EDC"]).notes[0]


def test_the_full_heading_names_a_channel_too(tmp_path: Path) -> None:
    channel = read(write(tmp_path, table("time,EDC (mV),Fz (N)")), ["EDC (mV)"]).channels[0]
    assert (channel.name, channel.unit) == ("EDC (mV)", "V")
    assert channel.conversion == "mV x 0.001 = V"


def test_repeated_names_become_unique(tmp_path: Path) -> None:
    assert [c.name for c in inspect(write(tmp_path, table("time,EMG (mV),EMG (mV)")))[1]] == ["EMG", "EMG #2"]


def test_other_units_stay_as_they_are(tmp_path: Path) -> None:
    recording = read(write(tmp_path, table("time,angle (deg),level")), ["angle", "level"])
    assert [(c.unit, c.conversion) for c in recording.channels] == [("deg", "deg as stored"), ("", "no unit stated")]


def test_a_channel_that_ends_early_is_cut_not_padded(tmp_path: Path) -> None:
    text = "time,EDC (mV),Fz (N)\n" + "".join(f"{i / 1000},{i},{i if i < 7 else ''}\n" for i in range(20))
    recording = read(write(tmp_path, text), ["EDC", "Fz"])
    assert [c.samples.size for c in recording.channels] == [20, 7]
    assert any("Fz: ends after 7 of 20 rows" in note for note in recording.notes)


def test_a_second_time_column_governs_the_columns_after_it(tmp_path: Path) -> None:
    rows = "".join(f"{i / 1000},{i},{i / 100 if i < 5 else ''},{10 * i if i < 5 else ''}\n" for i in range(40))
    recording = read(write(tmp_path, "time (s),EDC (mV),time (s),Fz (N)\n" + rows), ["EDC", "Fz"])
    assert [(c.fs_hz, c.samples.size) for c in recording.channels] == [(1000.0, 40), (100.0, 5)]
    assert recording.notes == ()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time (s),EDC (mV)\n", "1 filled lines"),
        ("time (s)\n0\n1\n", "channels beside the time"),
        ("time (s),EDC (mV)\n0,1\n0.001,abc\n0.002,3\n", r"line 3, column 'EDC': expected a number, but found 'abc'"),
        ("# note\ntime (s),EDC (mV)\n0,1\n\n0.001,1.2.3\n", r"line 5, column 'EDC': expected a number"),
        ("time (s),EDC (mV)\n0,1\n0.001,2,9\n", r"line 3: expected 2 cells, but found 3"),
        ("time (s),EDC (mV)\n0,1,0,2\n0,1,0,3\n", r"line 2: expected 2 cells, .*, but found 4. Separate .* by "
                                                  r"semicolons"),
        ("time (s);EDC (mV)\n0,1;1.5\n0,2;1.7\n", "decimal points and decimal commas"),
        ("time (s),EDC (mV)\n" + "0,1\n" * 99 + "0.099,1,5\n", r"line 101: expected 2 cells, but found 3"),
        ("time (s),EDC (mV)\n10:32:01.5,1\n10:32:01.6,1\nx,2\n", r"line 2, column 'time of EDC': expected a number"),
        ("time (s),EDC (mV)\n0,1\n0.001,2\n0.001,3\n0.002,4\n", "line 4: .*same stamp again"),
        ("time (s),EDC (mV)\n0,1\n0.001,2\n0.002,3\n0.009,4\n0.010,3\n", "line 5: .*a gap of 0.007 s"),
        ("time (s),EDC (mV)\n0,1\n0.001,\n0.002,nan\n0.003,3\n", r"'EDC': .*, but found nan at sample 1 \(0.001 s; 2 "
                    r"of 4"),
        ("time (s),EDC (mV)\n0,nan\n0.001,2\n0.002,-inf\n0.003,3\n", r"found -inf at sample 2 \(0.002 s; 1 of 4 sam"),
        ("time (s),EDC (mV)\n0,1\n0.001,2\n0.002,inf\n", r"found inf at sample 2 \(0.002 s"),
        ("time (s),EDC (mV)\n0,inf\n0.001,-inf\n0.002,1\n", r"found inf at sample 0 \(0 s; 2 of 3 samples"),
        ("time (s),EDC (mV)\n0,\n0.001,\n", "expected samples, but found none"),
        ("time (s),EDC (mV)\n0,1\n,2\n0.002,3\n", "line 3: expected a time stamp"),
    ],
)  # fmt: skip
def test_faults_say_where_and_what(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        read(write(tmp_path, text), ["EDC"])


def test_missing_samples_stay_and_are_counted(tmp_path: Path) -> None:
    text = "time (s),EDC (mV),FDS (mV)\n" + "".join(f"{i / 1000},{'' if i in (3, 5) else i},{i}\n" for i in range(9))
    recording = read(write(tmp_path, text), ["EDC", "FDS"])
    assert np.flatnonzero(np.isnan(recording.channel("EDC").samples)).tolist() == [3, 5]
    assert recording.channel("EDC").samples[4] == pytest.approx(4e-3)
    assert recording.notes == ("EDC: 2 of 9 samples are missing, the first at 0.003 s",)


def test_a_late_decimal_comma_is_seen(tmp_path: Path) -> None:
    text = "time (ms);EDC (mV)\n" + "".join(f"{i};{i}\n" for i in range(300)) + "300;0,5\n"
    assert read(write(tmp_path, text), ["EDC"]).channels[0].samples[-1] == pytest.approx(0.5e-3)


def test_faults_in_channels_not_asked_for_do_not_matter(tmp_path: Path) -> None:
    text = "time (s),EDC (mV),note\n0,1,ok\n0.001,2,bad\n"
    assert read(write(tmp_path, text), ["EDC"]).channels[0].samples.size == 2


def test_the_ati_log_without_time_wants_its_rate_stated(shared_data) -> None:
    path = shared_data("emg/ati/atusa_myo_mini45_raw_01.csv")
    assert all(np.isnan(channel.fs_hz) for channel in inspect(path)[1])
    with pytest.raises(RecordingError, match=r"no column of time. State it: fs_hz"):
        read(path, ["Fz"])
    _, opened = open_recording(path)
    (emg,) = load_named(opened, ["emg0"], [243.0])
    assert (emg.fs_hz, emg.samples[:2].tolist()) == (243.0, [0.0, -2.0])
    assert "243 Hz as the study states" in emg.notes[-1]


def test_a_stated_rate_that_contradicts_the_time_is_refused(tmp_path: Path) -> None:
    _, opened = open_recording(write(tmp_path, table("time (s),EDC (mV),Fz (N)")))
    with pytest.raises(RecordingError, match="the study states, 500 Hz, but found 1000 Hz by the file"):
        load_named(opened, ["EDC"], [500.0])


def test_units_at_the_end_of_names(tmp_path: Path) -> None:
    path = write(tmp_path, table("time_s,EDC_mV,Fz_N"))
    check(path)
    assert any("EDC_mV: the unit mV was taken" in note for note in read(path, ["EDC"]).notes)
    assert read(path, ["EDC_mV"]).channels[0].unit == "V"
    plain = write(tmp_path, table("time_s,EMG_n,load_cell"))
    assert [(c.name, c.unit) for c in inspect(plain)[1]] == [("EMG_n", None), ("load_cell", None)]
    mass = write(tmp_path, table("time_s,EDC (mV),Fz (kg)"))
    assert [(c.name, c.unit) for c in inspect(mass)[1]][1] == ("Fz", "kg")


@pytest.mark.parametrize(
    "content",
    [
        "MIT License\n\nCopyright 2020 Somebody\n",
        "name\ttype\tunits\nEMG1\tEMG\tV\n",
        "For tests; as they are.\n| 38 ch | 3.15 s |\n",
    ],
)
def test_text_is_no_recording(tmp_path: Path, content: str) -> None:
    (tmp_path / "README.md").write_text(content)
    with pytest.raises(RecordingError, match=r"expected a table of numbers .*, but found text, "):
        inspect(tmp_path / "README.md")


@pytest.mark.parametrize("fs_hz", [1500, 2000, 4000])
def test_a_time_rounded_to_milliseconds_gives_the_rate(tmp_path: Path, fs_hz: int) -> None:
    rows = "".join(f"{i / fs_hz:.3f},{i % 7}.5\n" for i in range(20001))
    channel = read(write(tmp_path, "time (s),EDC (mV)\n" + rows), ["EDC"]).channels[0]
    assert channel.fs_hz == pytest.approx(fs_hz, rel=2e-4)
    assert channel.samples.size == 20001


def test_a_repeated_row_is_no_rounding(tmp_path: Path) -> None:
    rows = "".join(f"{(i - (i > 50)) / 1000:.3f},{i % 7}.5\n" for i in range(200))
    with pytest.raises(RecordingError, match=r"same stamp again.* state fs_hz and remove the time column"):
        read(write(tmp_path, "time (s),EDC (mV)\n" + rows), ["EDC"])


@pytest.mark.parametrize("name", ["Zeit (s)", "Temps [s]", "tempo_s", "Tiempo (s)"])
def test_time_in_other_languages(tmp_path: Path, name: str) -> None:
    check(write(tmp_path, table(f"{name},EDC (mV),Fz (N)")))


@pytest.mark.parametrize("written", ["-nan(ind)", "1.#QNAN", "-", "null", "#N/A", "n/a"])
def test_missing_numbers_are_counted(tmp_path: Path, written: str) -> None:
    rows = "".join(f"{i / 1000:.3f},{written if i in (5, 6) else i}\n" for i in range(40))
    recording = read(write(tmp_path, "time (s),EDC (mV)\n" + rows), ["EDC"])
    assert np.flatnonzero(np.isnan(recording.channels[0].samples)).tolist() == [5, 6]
    assert any("2 of 40 samples are missing" in note for note in recording.notes)


def test_a_cell_too_many_in_a_file_with_quotes_is_refused(tmp_path: Path) -> None:
    rows = [f'"{i / 1000:.3f}","{i}"' for i in range(40)]
    rows[20] += ',"7"'
    with pytest.raises(RecordingError, match="line 22: expected 2 cells, but found 3"):
        read(write(tmp_path, "\n".join(['"time (s)","EDC (mV)"', *rows]) + "\n"), ["EDC"])


@pytest.mark.parametrize("sign", [".", ","])
def test_thousands_with_a_separator_are_refused(tmp_path: Path, sign: str) -> None:
    """ADC counts as a spreadsheet groups them; the first rows hold none above 999."""
    counts = [i * 7 for i in range(400)]
    rows = "".join(f"{i / 1000:.4f};".replace(".", sign) + f"{c:,}\n".replace(",", sign) for i, c in enumerate(counts))
    with pytest.raises(
        RecordingError, match=r"column 2: .* among whole numbers, which may be .*Export without thousands"
    ):
        read(write(tmp_path, "time (s);EDC (mV)\n" + rows), ["EDC"])
    whole = "".join(f"{i / 1000:.4f};{c}\n" for i, c in enumerate(counts))
    assert read(write(tmp_path, "time (s);EDC (mV)\n" + whole), ["EDC"]).channels[0].samples[-1] == 2.793


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_utf_16_without_a_mark(tmp_path: Path, encoding: str) -> None:
    check(write(tmp_path, table("time (s),EDC (mV),Fz (N)"), encoding))


# What stands around a table


INSTRUMENT = (
    'Instron Bluehill\nOperator,"Anna, K."\nSpecimen label,S1\nGauge length,30,mm\nDate,2026-05-02 10:00:00\n\n',
    "Subject: P01\nTrial 3 of 10\nSampling rate: 2000 Hz\n",
    'type,begin_time,frequency,count\n"record",0.00000,2000.4,42520\n\n',
    "words,more words\n1000\n",
)


@pytest.mark.parametrize("above", INSTRUMENT)
@pytest.mark.parametrize("units", [False, True])
@pytest.mark.parametrize(("separator", "decimal"), [(",", "."), (";", ","), ("\t", ".")])
def test_lines_above_the_names_and_a_row_of_units(
    tmp_path: Path, above: str, units: bool, separator: str, decimal: str
) -> None:
    header = "\n".join(["time,EDC,Fz", "s,mV,N"]) if units else "time (s),EDC (mV),Fz (N)"
    text = above.replace(",", separator) + table(header.replace(",", separator), separator, decimal)
    path = write(tmp_path, text)
    check(path)
    assert any("above the names" in note for note in read(path, ["EDC"]).notes)


@pytest.mark.parametrize("row", ["[s],[mV],[N]", "(s),(mV),(N)", "Seconds,Millivolts,Newtons", "sec,mV,N,"])
def test_a_row_of_units_under_the_names(tmp_path: Path, row: str) -> None:
    check(write(tmp_path, table(f"Time,EDC,Fz\n{row}")))


def test_keys_before_names_and_units(tmp_path: Path) -> None:
    rows = "\n".join(f"{i / 7:.3f}\t{i}" for i in range(20))
    head = "NO_OF_SAMPLES\t20\nFREQUENCY\t500\nCHANNEL_NAMES\tEMG 1\tFP1_Fz\nCHANNEL_UNITS\tmV\tN\n"
    (tmp_path / "a.tsv").write_text(f"{head}{rows}\n")
    _, opened = open_recording(tmp_path / "a.tsv")
    assert [(c.name, c.unit, c.fs_hz) for c in opened.describe()] == [("EMG 1", "mV", 500), ("FP1_Fz", "N", 500)]


@pytest.mark.parametrize("name", ["millis_ms", "since start (ms)"])
def test_a_first_column_that_rises_in_a_unit_of_time_is_a_clock(tmp_path: Path, name: str) -> None:
    rows = "\n".join(f"{81234 + 2 * i},{i % 3},{i % 5}" for i in range(20))
    (tmp_path / "a.csv").write_text(f"{name},EMG,Fz\n{rows}\n")
    assert [channel.fs_hz for channel in open_recording(tmp_path / "a.csv")[1].describe()] == [500, 500]
    (tmp_path / "b.csv").write_text(f"{name},EMG,Fz\n{rows.replace('81236', '81233')}\n")
    assert len(open_recording(tmp_path / "b.csv")[1].contents.names) == 3


def test_a_rate_stated_above_a_table_without_times(tmp_path: Path) -> None:
    rows = "".join(f"{i % 7}.5,{i}\n" for i in range(50))
    path = write(tmp_path, f"Sampling frequency [Hz]: 1,5 kHz\nEMG,Fz\nmV,N\n{rows}")
    recording = read(path, ["EMG", "Fz"])
    assert [(c.fs_hz, c.unit) for c in recording.channels] == [(1500.0, "V"), (1500.0, "N")]
    two = write(tmp_path, f"Sampling rate: 1000\nSampling rate: 2000\nEMG,Fz\nmV,N\n{rows}")
    with pytest.raises(RecordingError, match="expected a sampling rate"):
        read(two, ["EMG"])


def test_a_damaged_first_row_is_no_header(tmp_path: Path) -> None:
    rows = "".join(f"0.{i:03},{i}\n" for i in range(1, 30))
    with pytest.raises(RecordingError, match=r"line 2, column 'EDC': expected a number, but found 'oops'"):
        read(write(tmp_path, f"time (s),EDC (mV)\n0.000,oops\n{rows}"), ["EDC"])
    with pytest.raises(RecordingError, match=r"line 2.*expected a number"):
        read(write(tmp_path, f"time (s),EDC (mV)\nstart,oops\n{rows}"), ["EDC"])


# Time stamps


def stamped(form: str, start: str, n: int = 60, separator: str = ",") -> str:
    import pandas as pd

    times = pd.date_range(start, periods=n, freq="5ms")
    rows = [f"{time.strftime(form)[:-3]}{separator}{i}.25" for i, time in enumerate(times)]
    return "\n".join([f"Timestamp{separator}Fz (N)", *rows]) + "\n"


@pytest.mark.parametrize(
    "form", ["%Y-%m-%dT%H:%M:%S.%f", "%Y-%m-%d %H:%M:%S.%f", "%Y/%m/%d %H:%M:%S.%f", "%H:%M:%S.%f"]
)
@pytest.mark.parametrize("start", ["2026-05-02 10:00:00.125", "2026-05-02 23:59:59.900"])
def test_stamps_with_a_date_or_a_time_of_day_are_a_clock(tmp_path: Path, form: str, start: str) -> None:
    (channel,) = read(write(tmp_path, stamped(form, start)), ["Fz"]).channels
    assert channel.fs_hz == pytest.approx(200.0, rel=1e-9)
    assert channel.start_s == pytest.approx(36000.125 if "10:00" in start else 86399.9, abs=1e-6)
    assert channel.samples.size == 60


@pytest.mark.parametrize("zone", ["Z", "+00:00", " UTC"])
def test_stamps_may_name_their_zone_and_have_decimal_commas(tmp_path: Path, zone: str) -> None:
    text = stamped("%Y-%m-%dT%H:%M:%S.%f", "2026-05-02 10:00:00", separator=";").replace(".", ",")
    text = text.replace(";", f"{zone};").replace(f"Timestamp{zone}", "Timestamp")
    (channel,) = read(write(tmp_path, text), ["Fz"]).channels
    assert (channel.fs_hz, channel.start_s, channel.samples[1]) == (200.0, 36000.0, 1.25)


def test_a_gap_in_stamps_is_refused_with_its_line(tmp_path: Path) -> None:
    lines = stamped("%H:%M:%S.%f", "2026-05-02 10:00:00").splitlines()
    text = "\n".join(lines[:30] + lines[33:]) + "\n"
    with pytest.raises(RecordingError, match=r"line 31: expected one sample every 0.005 s, but found a gap of 0.02 s"):
        read(write(tmp_path, text), ["Fz"])


@pytest.mark.parametrize(
    ("cell", "said"), [("25:00:00.000", "expected a time stamp"), ("noon", "such as those above it, but found 'noon'")]
)
def test_a_wrong_stamp_is_refused_with_its_line(tmp_path: Path, cell: str, said: str) -> None:
    lines = stamped("%H:%M:%S.%f", "2026-05-02 10:00:00").splitlines()
    lines[55] = f"{cell},1"
    with pytest.raises(RecordingError, match=rf"line 56: .*{said}"):
        read(write(tmp_path, "\n".join(lines) + "\n"), ["Fz"])


def test_two_files_of_one_day_share_a_clock_and_of_two_days_do_not(tmp_path: Path) -> None:
    from emg2vsa.readers.roles import read_roles
    from emg2vsa.settings import ChannelSettings, EmgChannelSettings, ForceChannelSettings

    emg, force = EmgChannelSettings(name="Fz", unit="mV"), ForceChannelSettings(name="Fz")
    channels = ChannelSettings(emg={"EDC": emg}, force=force)
    one, later, other = tmp_path / "emg.csv", tmp_path / "force.csv", tmp_path / "next.csv"
    form = "%Y-%m-%d %H:%M:%S.%f"
    one.write_text(stamped(form, "2026-05-02 10:00:00").replace(" (N)", ""))
    later.write_text(stamped(form, "2026-05-02 10:00:00.100"))
    other.write_text(stamped(form, "2026-05-03 10:00:00.100"))
    found = read_roles(one, later, channels)
    assert found.force.start_s - found.emg["EDC"].start_s == pytest.approx(0.1, abs=1e-9)
    assert not any("began at" in note for note in found.notes)
    notes = read_roles(one, other, channels).notes
    assert any("EMG file states that it began at 2026-05-02, the force file at 2026-05-03" in note for note in notes)
