"""What comes back from each format through an independent reader, and how exactly."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import edfio
import ezc3d
import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from emg2vsa.errors import SettingError
from emg2vsa.settings import ChannelSettings, EmgChannelSettings, ForceChannelSettings
from emg2vsa.study import Study
from emg2vsa.worlds.people.plan import plan_study
from emg2vsa.worlds.people.recording import SyntheticRecording
from emg2vsa.worlds.people.study import simulate_study

Make = Callable[..., Study]
ODD_CHANNELS = ChannelSettings(
    emg={"EDC": EmgChannelSettings(name="Ch 1", gain=1000.0), "FDS": EmgChannelSettings(name="Ch 2", unit="mV")},
    force=ForceChannelSettings(name="Load", unit="kgf", sign=-1),
)


def made(study: Study, folder: Path, format: str) -> tuple[Path, SyntheticRecording]:
    """First file of the study, and the recording it holds."""
    simulated = simulate_study(study, folder, format=format)  # type: ignore[arg-type]
    settings, plan = plan_study(study)
    return simulated.recordings[0], plan[0].make(settings)


def assert_close(
    stored: NDArray[np.float64], true: NDArray[np.float64], *, of_range: float = 0, of_value: float = 0
) -> None:
    limit = of_range * 2 * np.max(np.abs(true)) + of_value * np.abs(true)
    assert stored.shape == true.shape
    assert np.all(np.abs(stored - true) <= limit)


def test_bdf_returns_samples_to_1e_7_of_their_range(study: Study, tmp_path: Path) -> None:
    path, recording = made(study, tmp_path, "bids")
    bdf = edfio.read_bdf(path)
    assert [signal.label for signal in bdf.signals] == ["EDC", "FDS", "Fz"]
    assert [signal.physical_dimension for signal in bdf.signals] == ["uV", "uV", "N"]
    assert [signal.sampling_frequency for signal in bdf.signals] == [1000.0] * 3
    assert_close(bdf.signals[0].data * 1e-6, recording.emg_v["EDC"], of_range=1e-7)
    assert_close(bdf.signals[1].data * 1e-6, recording.emg_v["FDS"], of_range=1e-7)
    assert_close(-bdf.signals[2].data, recording.force_n, of_range=1e-7)


def test_bdf_header_carries_date_and_cues(study: Study, tmp_path: Path) -> None:
    path, recording = made(study, tmp_path, "bids")
    bdf = edfio.read_bdf(path)
    scans = pd.read_csv(tmp_path / "sub-P01" / "sub-P01_scans.tsv", sep="\t")
    stated = scans.set_index("filename").loc[path.relative_to(tmp_path / "sub-P01").as_posix(), "acq_time"]
    assert f"{bdf.startdate}T{bdf.starttime}" == stated
    assert [note.text for note in bdf.annotations] == ["start", "stop"] * 2
    assert [note.onset for note in bdf.annotations][::2] == pytest.approx(recording.truth.presses.cue_start_s, abs=5e-4)
    events = pd.read_csv(path.with_name(path.name.replace("_emg.bdf", "_events.tsv")), sep="\t")
    assert events.onset.tolist() == [note.onset for note in bdf.annotations]


def test_csv_returns_samples_to_5e_9_of_their_value(study: Study, tmp_path: Path) -> None:
    path, recording = made(study, tmp_path, "csv")
    table = pd.read_csv(path)
    assert list(table) == ["time [s]", "EDC [V]", "FDS [V]", "Fz [N]"]
    assert_close(table["time [s]"].to_numpy(), np.arange(recording.force_n.size) / 1000, of_value=1e-12)
    assert_close(table["EDC [V]"].to_numpy(), recording.emg_v["EDC"], of_value=5.001e-9)
    assert_close(table["FDS [V]"].to_numpy(), recording.emg_v["FDS"], of_value=5.001e-9)
    assert_close(-table["Fz [N]"].to_numpy(), recording.force_n, of_value=5.001e-9)


def test_emgworks_returns_samples_to_5e_7_of_their_value(study: Study, tmp_path: Path) -> None:
    path, recording = made(study, tmp_path, "emgworks")
    assert path.read_text().partition("\n")[0] == 'X[s],"EDC",X[s],"FDS",X[s],"Fz"'
    table = pd.read_csv(path)
    assert list(table) == ["X[s]", "EDC", "X[s].1", "FDS", "X[s].2", "Fz"]
    for column in ("X[s]", "X[s].1", "X[s].2"):
        assert_close(table[column].to_numpy(), np.arange(recording.force_n.size) / 1000, of_value=1e-12)
    assert_close(table["EDC"].to_numpy(), recording.emg_v["EDC"], of_value=5.001e-7)
    assert_close(-table["Fz"].to_numpy(), recording.force_n, of_value=5.001e-7)


def test_c3d_returns_samples_to_6e_8_of_their_value(study: Study, tmp_path: Path) -> None:
    path, recording = made(study, tmp_path, "c3d")
    file = ezc3d.c3d(str(path))
    analog = file["parameters"]["ANALOG"]
    assert analog["LABELS"]["value"] == ["EDC", "FDS", "Fz"]
    assert analog["UNITS"]["value"] == ["V", "V", "N"]
    assert analog["RATE"]["value"][0] == 1000.0
    samples = file["data"]["analogs"][0]
    assert_close(samples[0], recording.emg_v["EDC"], of_value=6e-8)
    assert_close(samples[1], recording.emg_v["FDS"], of_value=6e-8)
    assert_close(-samples[2], recording.force_n, of_value=6e-8)


def test_gain_unit_and_sign_are_stored_as_the_study_undoes_them(study_with: Make, tmp_path: Path) -> None:
    path, recording = made(study_with(channels=ODD_CHANNELS), tmp_path, "csv")
    table = pd.read_csv(path)
    assert list(table) == ["time [s]", "Ch 1 [V]", "Ch 2 [mV]", "Load [kgf]"]
    assert_close(table["Ch 1 [V]"].to_numpy() / 1000, recording.emg_v["EDC"], of_value=1e-8)
    assert_close(table["Ch 2 [mV]"].to_numpy() / 1000, recording.emg_v["FDS"], of_value=1e-8)
    assert_close(table["Load [kgf]"].to_numpy() * -9.80665, recording.force_n, of_value=1e-8)


def test_declared_newtons_per_unit_leave_the_unit_open(study_with: Make, tmp_path: Path) -> None:
    force = ForceChannelSettings(name="Fz", newtons_per_unit=25.0)
    channels = ChannelSettings(emg=ODD_CHANNELS.emg, force=force)
    path, recording = made(study_with(channels=channels), tmp_path, "csv")
    table = pd.read_csv(path)
    assert list(table)[-1] == "Fz"
    assert_close(table["Fz"].to_numpy() * 25, recording.force_n, of_value=1e-8)


def test_a_unit_that_is_no_force_is_refused(study_with: Make, tmp_path: Path) -> None:
    channels = ChannelSettings(emg=ODD_CHANNELS.emg, force=ForceChannelSettings(name="Fz", unit="%MVC"))
    with pytest.raises(SettingError, match="newtons_per_unit"):
        simulate_study(study_with(channels=channels), tmp_path, format="csv")


@pytest.mark.parametrize("format", ["csv", "emgworks", "c3d"])
def test_other_rates(study_with: Make, tmp_path: Path, format: str) -> None:
    path, recording = made(study_with(fs_hz=1925.926, repetitions=1), tmp_path, format)
    if format == "c3d":
        file = ezc3d.c3d(str(path))
        assert file["parameters"]["ANALOG"]["RATE"]["value"][0] == pytest.approx(1925.926, rel=1e-6)
        assert 0 <= recording.force_n.size - file["data"]["analogs"].shape[2] < 10
    else:
        time_s = pd.read_csv(path).iloc[:, 0]
        assert (len(time_s) - 1) / time_s.iloc[-1] == pytest.approx(1925.926, rel=1e-6)


@pytest.mark.parametrize("name", ["Bagnoli sensor 1: EDC", "EDC µ"])
def test_bdf_refuses_a_label_it_cannot_hold(study_with: Make, tmp_path: Path, name: str) -> None:
    emg = {"EDC": EmgChannelSettings(name=name), "FDS": EmgChannelSettings(name="FDS")}
    channels = ChannelSettings(emg=emg, force=ForceChannelSettings(name="Fz"))
    with pytest.raises(SettingError, match="16 ASCII"):
        simulate_study(study_with(channels=channels), tmp_path, format="bids")


def test_bdf_refuses_a_fractional_rate(study_with: Make, tmp_path: Path) -> None:
    with pytest.raises(SettingError, match="whole"):
        simulate_study(study_with(fs_hz=1925.926), tmp_path, format="bids")
