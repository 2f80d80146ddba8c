"""EDF and BDF: files built byte by byte from the specification, files that edfio wrote, and MNE's reading of them."""

from __future__ import annotations

from pathlib import Path

import edfio
import mne
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from emg2vsa.errors import RecordingError
from emg2vsa.readers import edf_bdf
from emg2vsa.readers.front_door import inspect, open_recording, read


def fields(width: int, *values: object) -> bytes:
    return b"".join(str(value).encode("latin-1").ljust(width) for value in values)


def specified(kind: str, digital: NDArray[np.int64], physical: tuple[float, float], unit: str = "uV") -> bytes:
    """A file of two data records of half a second, by the text of the specification: signal "x", and a constant."""
    low, high = (-(2**15), 2**15 - 1) if kind == "edf" else (-(2**23), 2**23 - 1)
    width, per_record = (2 if kind == "edf" else 3), digital.size // 2
    version = fields(8, "0") if kind == "edf" else b"\xffBIOSEMI"
    header = version + fields(80, "X", "Startdate X X X X") + fields(8, "02.03.26", "10.11.12", 768) + fields(44, "")
    header += fields(8, 2, 0.5) + fields(4, 2)
    header += fields(16, "x", "constant") + fields(80, "", "") + fields(8, unit, "N")
    header += fields(8, physical[0], -10) + fields(8, physical[1], 10) + fields(8, low, low) + fields(8, high, high)
    header += fields(80, "", "") + fields(8, per_record, 1) + fields(32, "", "")
    records = (np.append(record, 0) for record in digital.reshape(2, per_record))
    return header + b"".join(int(v).to_bytes(width, "little", signed=True) for record in records for v in record)


def signals(
    kind: str, n: int = 3000, seed: int = 0, unit: str = "uV"
) -> dict[str, tuple[NDArray[np.float64], int, str]]:
    rng = np.random.default_rng(seed)
    return {
        "EDC": (rng.normal(size=n) * 50, 1000, unit),
        "slow": (rng.normal(size=n // 10), 100, "C"),
        "Fz": (rng.normal(size=n) + 3, 1000, "N"),
    }


def write(path: Path, annotations: bool = False, **how) -> Path:
    kind = path.suffix[1:]
    file, signal = (edfio.Bdf, edfio.BdfSignal) if kind == "bdf" else (edfio.Edf, edfio.EdfSignal)
    made = [signal(x, fs, label=label, physical_dimension=u) for label, (x, fs, u) in signals(kind, **how).items()]
    file(made, annotations=[edfio.EdfAnnotation(0.5, None, "press")] if annotations else None).write(path)
    return path


def overwrite(path: Path, start: int, content: bytes) -> Path:
    data = bytearray(path.read_bytes())
    data[start : start + len(content)] = content
    path.write_bytes(data)
    return path


@pytest.mark.parametrize(("kind", "bits"), [("edf", 16), ("bdf", 24)])
def test_the_whole_integer_range_by_the_specification(tmp_path: Path, kind: str, bits: int) -> None:
    top = 2 ** (bits - 1)
    digital = np.array([-top, 1 - top, -1, 0, 1, 255, 256, top // 2, top - 2, top - 1])
    (tmp_path / "x").write_bytes(specified(kind, digital, (-200, 200)))
    recording = read(tmp_path / "x", ["x", "constant"])
    truth_v = 1e-6 * (-200 + (digital + top) * 400 / (2**bits - 1))
    np.testing.assert_allclose(recording.channel("x").samples, truth_v, rtol=1e-12, atol=1e-19)
    np.testing.assert_allclose(recording.channel("constant").samples, 10 / (2**bits - 1), rtol=1e-9)
    assert [channel.fs_hz for channel in recording.channels] == [10.0, 2.0]
    assert recording.notes == ()
    assert open_recording(tmp_path / "x")[1].contents.started == "10:11:12"  # the date is anonymised


@given(seed=st.integers(0, 2**32 - 1), kind=st.sampled_from(["edf", "bdf"]), annotations=st.booleans())
@settings(max_examples=20, deadline=None)
def test_samples_are_those_written(tmp_path_factory, seed: int, kind: str, annotations: bool) -> None:
    path = write(tmp_path_factory.mktemp("edf") / f"rec.{kind}", annotations, seed=seed)
    truth = signals(kind, seed=seed)
    steps = 2.0 ** (16 if kind == "edf" else 24) - 1
    for channel, factor in zip(read(path, ["Fz", "EDC", "slow"]).channels, (1.0, 1e-6, 1.0), strict=True):
        written, fs_hz, _ = truth[channel.name]
        # one step of the integers, and the range that the header rounds to eight characters
        tolerance = factor * (np.ptp(written) / steps + 1e-4)
        np.testing.assert_allclose(channel.samples, written * factor, rtol=0, atol=tolerance)
        assert channel.fs_hz == fs_hz
        assert channel.start_s == 0.0


@pytest.mark.parametrize(("kind", "reader"), [("edf", mne.io.read_raw_edf), ("bdf", mne.io.read_raw_bdf)])
def test_samples_are_those_of_mne(tmp_path: Path, kind: str, reader) -> None:
    path = write(tmp_path / f"rec.{kind}", annotations=True)
    theirs = reader(path, include=["EDC"], verbose="error").get_data()[0]  # in V
    (ours,) = read(path, ["EDC"]).channels
    np.testing.assert_allclose(ours.samples, theirs, rtol=1e-9, atol=1e-18)


@pytest.mark.parametrize("at_once", [1, 1000, 4100, 2**21])
@pytest.mark.parametrize("kind", ["edf", "bdf"])
def test_samples_read_piece_by_piece_are_those_of_edfio(
    tmp_path: Path, kind: str, at_once: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(edf_bdf, "_AT_ONCE", at_once)
    path = write(tmp_path / f"rec.{kind}", annotations=True, n=7000)
    theirs = {
        signal.label: signal.data for signal in (edfio.read_bdf if kind == "bdf" else edfio.read_edf)(path).signals
    }
    for channel in edf_bdf.open_recording(path).load([2, 0, 1]):
        np.testing.assert_array_equal(channel.samples, theirs[channel.name])
        assert channel.samples.flags.writeable


def test_a_file_that_has_become_shorter_since_it_was_opened(tmp_path: Path) -> None:
    opened = edf_bdf.open_recording(write(tmp_path / "rec.edf"))
    with (tmp_path / "rec.edf").open("r+b") as file:
        file.truncate(1024 + 2 * 2 * 2100)
    with pytest.raises(RecordingError, match="expected 3 data records, as when it was opened, but found 2"):
        opened.load([0])


def test_micro_sign_of_a_recorder_that_writes_latin_1(tmp_path: Path) -> None:
    (tmp_path / "x.edf").write_bytes(specified("edf", np.arange(10), (-1, 1), unit="µV"))
    assert read(tmp_path / "x.edf", ["x"]).channels[0].conversion == "uV x 1e-06 = V"


@pytest.mark.parametrize("kind", ["edf", "bdf"])
def test_start_within_the_second_is_kept(tmp_path: Path, kind: str) -> None:
    path = write(tmp_path / f"rec.{kind}", annotations=True)
    file = (edfio.read_bdf if kind == "bdf" else edfio.read_edf)(path)
    file.starttime = file.starttime.replace(microsecond=250_000)
    file.write(path)
    assert b"+0.25\x14\x14" in path.read_bytes()
    assert read(path, ["EDC"]).channels[0].start_s == 0.25


@pytest.mark.parametrize("content", [b"xx.xx.xx", b"        "])
def test_unreadable_start_is_noted(tmp_path: Path, content: bytes) -> None:
    recording = read(overwrite(write(tmp_path / "rec.edf"), 176, content), ["EDC"])
    assert recording.notes == ("The start of the recording cannot be read; time 0 is its first sample.",)


@pytest.mark.parametrize("kind", ["edf", "bdf"])
def test_incomplete_file_is_read_as_far_as_it_goes_and_noted(tmp_path: Path, kind: str) -> None:
    path = write(tmp_path / f"rec.{kind}")
    path.write_bytes(path.read_bytes()[:-100])
    recording = read(path, ["EDC"])
    np.testing.assert_allclose(recording.channels[0].samples, 1e-6 * signals(kind)["EDC"][0][:2000], atol=1e-8)
    assert recording.notes == (
        f"Incomplete data record at the end of the {kind.upper()} file. Data was truncated.",
        f"{kind.upper()} header indicates 3 data records, but file contains 2 records.",
    )


SIGNALS = 256 + 3 * (16 + 80 + 8)
"""Where the physical minima begin in a header of three signals."""


@pytest.mark.parametrize("kind", ["edf", "bdf"])
@pytest.mark.parametrize(
    ("start", "content", "message"),
    [
        (252, b"12x ", "cannot be read .*'12x '"),
        (252, b"500 ", "1024 bytes stated for 500 signals"),
        (184, b"999     ", "999 bytes stated for 3 signals"),
        (236, b"many    ", "cannot be read .*'many'"),
        (244, b"0       ", "found one that cannot be read"),
        (244, b"-1      ", "records of a positive duration.*found -1 s"),
        (244, b"nan     ", "records of a positive duration.*found nan s"),
        (SIGNALS + 3 * (8 * 4 + 80), b"0       ", "found 1 s, and 0 samples of a signal"),
        (SIGNALS + 3 * (8 * 4 + 80), b"-5      ", "found 1 s, and -5 samples of a signal"),
    ],
)
def test_damaged_headers(tmp_path: Path, kind: str, start: int, content: bytes, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        inspect(overwrite(write(tmp_path / f"rec.{kind}"), start, content))


@pytest.mark.parametrize("content", [None, b"abc     ", b"1e999   "])
def test_useless_calibration_is_refused_only_for_its_channel(tmp_path: Path, content: bytes | None) -> None:
    path = write(tmp_path / "rec.bdf")
    same_as_minimum = path.read_bytes()[SIGNALS : SIGNALS + 8]
    overwrite(path, SIGNALS + 24, content or same_as_minimum)
    assert read(path, ["Fz"]).channels[0].samples.size == 3000
    with pytest.raises(RecordingError, match="calibration with two different ends") as caught:
        read(path, ["EDC"])
    assert "channel 'EDC'" in caught.value.where


@pytest.mark.parametrize("kind", ["edf", "bdf"])
@pytest.mark.parametrize("n_bytes", [4 * 256 - 10, 4 * 256, 4 * 256 + 50])
def test_header_without_records(tmp_path: Path, kind: str, n_bytes: int) -> None:
    path = write(tmp_path / f"rec.{kind}")
    path.write_bytes(path.read_bytes()[:n_bytes])
    with pytest.raises(RecordingError, match="expected data records, but found none"):
        inspect(path)


def test_annotations_alone_are_no_recording(tmp_path: Path) -> None:
    edfio.Edf([], annotations=[edfio.EdfAnnotation(0, None, "press")]).write(tmp_path / "rec.edf")
    with pytest.raises(RecordingError, match="expected signals, but found annotations only"):
        inspect(tmp_path / "rec.edf")


@pytest.mark.parametrize("kind", ["edf", "bdf"])
def test_discontinuous_recording_is_refused(tmp_path: Path, kind: str) -> None:
    path = write(tmp_path / f"rec.{kind}", annotations=True)
    data = path.read_bytes()
    assert b"DF+C" in data
    assert b"+2\x14\x14" in data
    data = data.replace(b"DF+C", b"DF+D")
    path.write_bytes(data)
    assert read(path, ["EDC"]).channels[0].samples.size == 3000  # +D that has no gap is fine
    path.write_bytes(data.replace(b"+2\x14\x14", b"+7\x14\x14"))
    with pytest.raises(RecordingError, match=r"expected a continuous recording, but found .DF\+D, with gaps"):
        inspect(path)
    path.write_bytes(data.replace(b"+2\x14\x14", b"\0\0\0\0"))
    with pytest.raises(RecordingError, match=r"expected a continuous recording, but found .* unknown onset"):
        inspect(path)
