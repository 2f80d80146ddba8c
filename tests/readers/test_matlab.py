"""MATLAB files."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from emg2vsa.errors import PassingError, RecordingError
from emg2vsa.readers.front_door import inspect, read

EMG = np.arange(3000.0).reshape(3, 1000)


def save(tmp_path: Path, **variables: object) -> Path:
    path = tmp_path / "rec.mat"
    scipy.io.savemat(path, variables)
    return path


@pytest.mark.parametrize("transposed", [False, True])
def test_vectors_and_matrices(tmp_path: Path, transposed: bool) -> None:
    path = save(tmp_path, emg=EMG.T if transposed else EMG, Fz=np.ones(1000), fs=1000)
    assert [c.name for c in inspect(path)[1]] == ["emg[1]", "emg[2]", "emg[3]", "Fz"]
    recording = read(path, ["emg[3]", "Fz"])
    np.testing.assert_array_equal(recording.channels[0].samples, EMG[2])
    assert [(c.fs_hz, c.unit) for c in recording.channels] == [(1000.0, "")] * 2


def test_structs_and_integers(tmp_path: Path) -> None:
    path = save(tmp_path, rec={"EDC": np.arange(50, dtype=np.int16), "sampling_rate": np.uint16(2048), "note": "press"})
    channel = read(path, ["rec.EDC"]).channels[0]
    assert (channel.fs_hz, channel.samples.dtype, channel.samples[-1]) == (2048.0, np.float64, 49.0)


def test_rate_from_the_time_vector(tmp_path: Path) -> None:
    channel = read(save(tmp_path, EDC=np.ones(200), Time=7 + np.arange(200) / 500.0), ["EDC"]).channels[0]
    assert (channel.fs_hz, channel.start_s) == (500.0, 7.0)


def test_a_text_cell_of_equal_length_names_the_channels(tmp_path: Path) -> None:
    labels = np.array(["EDC [mV]", "FDS [mV]", "force [N]"], dtype=object).reshape(-1, 1)
    path = save(tmp_path, data=EMG, Description=labels, fs=1000)
    assert [(c.name, c.unit) for c in inspect(path)[1]] == [("EDC", "mV"), ("FDS", "mV"), ("force", "N")]
    named, numbered = read(path, ["FDS", "data[2]"]).channels
    np.testing.assert_array_equal(named.samples, EMG[1] * 1e-3)
    np.testing.assert_array_equal(numbered.samples, named.samples)


def test_a_text_cell_that_may_be_of_another_matrix_names_no_channels(tmp_path: Path) -> None:
    words = np.array(["FDS", "EDC", "rest"], dtype=object).reshape(-1, 1)
    for others in ({"conditions": words, "order": words}, {"conditions": words, "kinematics": EMG + 1}):
        path = save(tmp_path, emg=EMG, fs=1000, **others)
        assert [c.name for c in inspect(path)[1]][:3] == ["emg[1]", "emg[2]", "emg[3]"]
        assert "emg: its channels are numbered, for it is not clear" in "; ".join(read(path, ["emg[1]"]).notes)
    muscles = np.array(["EDC", "FDS", "FCR"], dtype=object).reshape(-1, 1)
    path = save(tmp_path, emg=EMG, fs=1000, labels=muscles, conditions=words)
    assert [c.name for c in inspect(path)[1]] == ["EDC", "FDS", "FCR"]


def test_a_vector_of_another_length_has_the_rate_and_time_of_its_own_name(tmp_path: Path) -> None:
    signals = {"EMG": np.ones(2000), "Fz": np.ones(200), "Fx": np.ones(400)}
    own = {"fs_Fz": 100, "t_Fx": 0.5 + np.arange(400) / 200}
    found = {c.name: c.fs_hz for c in inspect(save(tmp_path, fs=1000, **signals, **own))[1]}
    assert found == {"EMG": 1000, "Fz": 100, "Fx": 200}
    assert read(save(tmp_path, fs=1000, **signals, **own), ["Fx"]).channels[0].start_s == 0.5
    with pytest.raises(RecordingError, match="expected a sampling rate"):
        read(save(tmp_path, fs=1000, **signals), ["Fz"])
    with pytest.raises(RecordingError, match="the stated rate, 100 Hz, but found 200 Hz"):
        inspect(save(tmp_path, Fx=signals["Fx"], fs_Fx=100, t_Fx=own["t_Fx"]))


@pytest.mark.parametrize(
    ("variables", "message"),
    [
        ({"EDC": np.ones(50)}, "expected a sampling rate"),
        (
            {"EDC": np.ones(50), "fs": 1000, "time": np.arange(50) / 500.0},
            "expected the stated rate, 1000 Hz, but found 500 Hz",
        ),
        ({"EDC": np.ones(50), "fs": 1000, "srate": 500}, "expected one sampling rate"),
        ({"EDC": np.array([1.0, np.inf, 2.0]), "fs": 1000}, "found inf at sample 1"),
        ({"fs": 1000}, "expected numeric vectors"),
    ],
)
def test_faults(tmp_path: Path, variables: dict[str, object], message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        read(save(tmp_path, **variables), ["EDC"])


def test_damaged_file(tmp_path: Path) -> None:
    path = save(tmp_path, EDC=np.random.default_rng(0).normal(size=500), fs=1000)
    path.write_bytes(path.read_bytes()[:700])
    with pytest.raises(RecordingError, match="damaged"):
        inspect(path)


def test_version_73(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    pytest.importorskip("pymatreader")
    path = tmp_path / "v73.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in {"emg": EMG.T, "fs": np.array([[1000.0]])}.items():
            file.create_dataset(name, data=value).attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: test".ljust(116) + bytes(8) + b"\x00\x02IM")
    channel = read(path, ["emg[2]"]).channels[0]
    assert channel.fs_hz == 1000.0
    np.testing.assert_array_equal(channel.samples, EMG[1])


def test_version_73_without_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "v73.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: test".ljust(600))

    monkeypatch.setitem(sys.modules, "pymatreader", None)
    matlab = importlib.import_module("emg2vsa.readers.matlab")
    with pytest.raises(PassingError, match="needs the packages pymatreader and h5py"):
        matlab.open_recording(path)


def test_version_73_whose_library_is_broken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "v73.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: test".ljust(600))
    matlab = importlib.import_module("emg2vsa.readers.matlab")

    def broken(path: str) -> None:
        raise ImportError("libhdf5.so: cannot open shared object file")

    monkeypatch.setattr("pymatreader.read_mat", broken)
    with pytest.raises(ImportError, match="libhdf5"):  # the front door says which library, and what to do
        matlab.open_recording(path)


def test_real_openhdemg_file(shared_data) -> None:
    path = shared_data("emg/emg_force/openhdemg_otb_testfile_VL64_force.mat")
    infos = inspect(path)[1]
    assert sum(info.unit == "uV" for info in infos) == 64
    assert {info.fs_hz for info in infos} == {2048.0}
    name = "Vastus Lateralis - AUX 3 (Channel 1->1) - GR08MM1305 (1)"
    emg, force = read(path, [name, "acquired data"]).channels
    assert (emg.unit, emg.fs_hz, emg.start_s, emg.samples.size) == ("V", 2048.0, 7.0, 66560)
    assert emg.samples[0] == pytest.approx(10.172526e-6, rel=1e-7)
    assert (force.unit, force.samples.max()) == ("%(MVC)", pytest.approx(27.170013))
    assert read(path, ["Data[75]"]).channels[0].samples[0] == force.samples[0]
