"""EDF and BDF, decoded here and by edfio, and the side files of BIDS-EMG."""

from __future__ import annotations

import json
from pathlib import Path

import edfio
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emg2vsa.errors import RecordingError
from emg2vsa.readers import inspect, read


def signals(kind: str, n: int = 3000, seed: int = 0, unit: str = "uV") -> list[edfio.BdfSignal] | list[edfio.EdfSignal]:
    rng = np.random.default_rng(seed)
    make = edfio.BdfSignal if kind == "bdf" else edfio.EdfSignal
    return [
        make(rng.normal(size=n) * 50, 1000, label="EDC", physical_dimension=unit),
        make(rng.normal(size=n // 10), 100, label="slow", physical_dimension="C"),
        make(rng.normal(size=n) + 3, 1000, label="Fz", physical_dimension="N"),
    ]


def write(path: Path, annotations: bool = False, **how) -> Path:
    kind = path.suffix[1:]
    marks = [edfio.EdfAnnotation(0.5, None, "press")] if annotations else None
    (edfio.Bdf if kind == "bdf" else edfio.Edf)(signals(kind, **how), annotations=marks).write(path)
    return path


@given(seed=st.integers(0, 2**32 - 1), kind=st.sampled_from(["edf", "bdf"]), annotations=st.booleans())
@settings(max_examples=20, deadline=None)
def test_samples_are_those_of_edfio(tmp_path_factory, seed: int, kind: str, annotations: bool) -> None:
    path = write(tmp_path_factory.mktemp("edf") / f"rec.{kind}", annotations, seed=seed)
    theirs = {s.label: s for s in (edfio.read_bdf if kind == "bdf" else edfio.read_edf)(path).signals}
    for channel, factor in zip(read(path, ["Fz", "EDC", "slow"]).channels, (1.0, 1e-6, 1.0), strict=True):
        np.testing.assert_allclose(channel.samples, theirs[channel.name].data * factor, rtol=1e-15)
        assert channel.fs_hz == theirs[channel.name].sampling_frequency


def test_the_whole_24_bit_range(tmp_path: Path) -> None:
    digital = np.array([-(2**23), -(2**23) + 1, -1, 0, 1, 255, 256, 65535, 65536, 2**23 - 1], dtype=np.int32)
    signal = edfio.BdfSignal.from_digital(digital, 10, label="x", physical_range=(-(2**23), 2**23 - 1))
    edfio.Bdf([signal]).write(tmp_path / "x.bdf")
    np.testing.assert_array_equal(read(tmp_path / "x.bdf", ["x"]).channels[0].samples, digital)


@pytest.mark.parametrize("suffix", ["edf", "bdf"])
def test_incomplete_file_is_read_as_far_as_it_goes_and_noted(tmp_path: Path, suffix: str) -> None:
    path = write(tmp_path / f"rec.{suffix}")
    path.write_bytes(path.read_bytes()[:-100])
    recording = read(path, ["EDC"])
    assert recording.channels[0].samples.size == 2000
    assert "promises 3 data records, the file holds 2" in recording.notes[0]


@pytest.mark.parametrize(
    ("start", "content", "message"),
    [
        (252, b"12x ", "number of signals"),
        (252, b"500 ", "wanted a header of 500 signals"),
        (244, b"0       ", "duration of a data record"),
        (184, b"999     ", "header size of 1024 bytes"),
        (256 + 3 * (16 + 80 + 8), b"abc     ", "physical min of signal 1 'EDC'"),
        (256 + 3 * (16 + 80 + 8 * 5 + 80), b"0       ", "samples of signal 1 'EDC'"),
    ],
)
def test_damaged_header_fields_are_named(tmp_path: Path, start: int, content: bytes, message: str) -> None:
    path = write(tmp_path / "rec.bdf")
    data = bytearray(path.read_bytes())
    data[start : start + len(content)] = content
    path.write_bytes(data)
    with pytest.raises(RecordingError, match=message):
        inspect(path)


def test_flat_calibration_is_refused_only_for_its_channel(tmp_path: Path) -> None:
    path = write(tmp_path / "rec.bdf")
    data = bytearray(path.read_bytes())
    at = 256 + 3 * (16 + 80 + 8)
    data[at + 24 : at + 32] = data[at : at + 8]
    path.write_bytes(data)
    assert read(path, ["Fz"]).channels[0].samples.size == 3000
    with pytest.raises(RecordingError, match="calibration with two different ends"):
        read(path, ["EDC"])


def test_header_without_records(tmp_path: Path) -> None:
    path = write(tmp_path / "rec.edf")
    path.write_bytes(path.read_bytes()[: 4 * 256])
    with pytest.raises(RecordingError, match="wanted data records; found none"):
        inspect(path)


def test_discontinuous_recording_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "rec.edf", annotations=True)
    data = path.read_bytes()
    assert b"EDF+C" in data
    assert b"+2\x14\x14" in data
    path.write_bytes(data.replace(b"EDF+C", b"EDF+D"))
    assert read(path, ["EDC"]).channels[0].samples.size == 3000  # +D that has no gap is fine
    path.write_bytes(data.replace(b"EDF+C", b"EDF+D").replace(b"+2\x14\x14", b"+7\x14\x14"))
    with pytest.raises(
        RecordingError, match="data record 3: wanted a continuous recording; found a jump from 1 to 7 s"
    ):
        inspect(path)


def bids(tmp_path: Path, rows: str, unit: str = "uV", **emg: object) -> Path:
    folder = tmp_path / "sub-01" / "emg"
    folder.mkdir(parents=True)
    (tmp_path / "dataset_description.json").write_text("{}")
    (tmp_path / "task-press_emg.json").write_text(json.dumps({"SamplingFrequency": 500, "TaskName": "press"}))
    (folder / "sub-01_task-press_channels.tsv").write_text(rows)
    if emg:
        (folder / "sub-01_task-press_emg.json").write_text(json.dumps(emg))
    return write(folder / "sub-01_task-press_emg.bdf", unit=unit)


HEAD = "name\ttype\tunits\tsampling_frequency\tstatus\tstatus_description\n"


def test_bids_unit_counts_only_where_the_header_has_none(tmp_path: Path) -> None:
    path = bids(
        tmp_path,
        HEAD + "EDC\tEMG\tmV\t1000\tgood\tn/a\nslow\tTEMP\tC\t100\tgood\tn/a\n",
        unit="",
        SamplingFrequency=1000,
    )
    recording = read(path, ["EDC"])
    assert recording.channels[0].conversion == "mV x 0.001 = V"
    assert recording.notes == ()


def test_bids_notes(tmp_path: Path) -> None:
    path = bids(tmp_path, HEAD + "EDC\tEMG\tV\t2000\tbad\tcable\nFz\tMISC\tN\t1000\tgood\tn/a\n")
    recording = read(path, ["EDC", "Fz"])
    assert recording.channel("EDC").conversion == "uV x 1e-06 = V"
    said = "\n".join(recording.notes)
    assert "_emg.json states 500 Hz, the file 1000 Hz" in said  # inherited from the root of the data set
    assert "header states uV, channels.tsv V; the header counts" in said
    assert "marks this channel bad (cable)" in said
    assert "channels.tsv states 2000 Hz" in said
    assert "Fz" not in said


def test_bids_voltage_against_force_leaves_the_unit_open(tmp_path: Path) -> None:
    recording = read(bids(tmp_path, HEAD + "EDC\tMISC\tN\tn/a\tgood\tn/a\n"), ["EDC"])
    assert recording.channels[0].unit == ""
    assert any("different quantities" in note for note in recording.notes)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("channel\tunits\nEDC\tV\n", "a column 'name'"),
        (HEAD + "EDC\tEMG\tV\tfast\n", "line 2, column 'sampling_frequency'"),
    ],
)
def test_damaged_side_files(tmp_path: Path, rows: str, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        inspect(bids(tmp_path, rows))


def test_real_bids_example(shared_data) -> None:
    path = shared_data("emg/bids/emg_IndependentMod/sub-01/emg/sub-01_task-grasping_emg.edf")
    theirs = edfio.read_edf(path)
    assert [(c.name, c.unit, c.fs_hz, c.n_samples) for c in inspect(path)[1]] == [
        (f"EMG{i}", "uV", 2000.0, 2000) for i in range(1, 7)
    ]
    recording = read(path, ["EMG4"])
    np.testing.assert_allclose(recording.channels[0].samples, theirs.get_signal("EMG4").data * 1e-6, rtol=1e-15)
    assert "channels.tsv V; the header counts" in recording.notes[0]
