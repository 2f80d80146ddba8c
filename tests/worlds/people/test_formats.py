"""What comes back from each format: through an independent reader, and through the project's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import edfio
import ezc3d
import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from emg2vsa.errors import SettingError
from emg2vsa.readers.roles import read_roles
from emg2vsa.settings import ChannelSettings, EmgChannelSettings, ForceChannelSettings
from emg2vsa.study import Study
from emg2vsa.worlds.people.plan import plan_study
from emg2vsa.worlds.people.recording import SyntheticRecording
from emg2vsa.worlds.people.study import Format, simulate_study

Make = Callable[..., Study]
RELATIVE_ERROR = {"bids": 2e-7, "csv": 6e-9, "emgworks": 6e-7, "c3d": 7e-8}
"""Largest error of a sample over the largest sample of its channel."""


def channels(
    first: Mapping[str, object] | None = None, second: Mapping[str, object] | None = None, **force: object
) -> ChannelSettings:
    """EDC and FDS and a force; what is not given is plain."""
    return ChannelSettings(
        emg={
            "EDC": EmgChannelSettings(**{"name": "EDC", **(first or {})}),  # type: ignore[arg-type]
            "FDS": EmgChannelSettings(**{"name": "FDS", **(second or {})}),  # type: ignore[arg-type]
        },
        force=ForceChannelSettings(**{"name": "Fz", **force}),  # type: ignore[arg-type]
    )


PLAIN = channels({"unit": "V"}, {"unit": "V"}, unit="N", sign=-1)
AMPLIFIED = channels(
    {"name": "Bagnoli sensor 1: EDC", "unit": "mV", "gain": 1000.0},
    {"name": "Bagnoli sensor 2: FDS", "unit": "V", "gain": 100.0},
    name="Load Cell: Fz", unit="%MVC", newtons_per_unit=0.8,
)  # fmt: skip
ODD = {"first": {"name": "Ch 1", "gain": 1000.0}, "second": {"name": "Ch 2", "unit": "mV"}}


def made(study: Study, folder: Path, format: str) -> tuple[Path, SyntheticRecording]:
    """First file of the study, and the recording it holds."""
    simulated = simulate_study(study, folder, format=format)  # type: ignore[arg-type]
    settings, plan = plan_study(study)
    return simulated.recordings[0], plan[0].make(settings)


def assert_stored(
    stored: list[NDArray[np.float64]], recording: SyntheticRecording, *, of_range: float = 0, of_value: float = 0
) -> None:
    """EDC, FDS and the force, whose sign is turned."""
    for samples, true in zip(stored, (recording.emg_v["EDC"], recording.emg_v["FDS"], -recording.force_n), strict=True):
        assert samples.shape == true.shape
        assert np.all(np.abs(samples - true) <= of_range * 2 * np.max(np.abs(true)) + of_value * np.abs(true))


def test_bdf_returns_samples_to_1e_7_of_their_range_with_date_and_cues(study: Study, tmp_path: Path) -> None:
    path, recording = made(study, tmp_path, "bids")
    bdf = edfio.read_bdf(path)
    assert [signal.label for signal in bdf.signals] == ["EDC", "FDS", "Fz"]
    assert [signal.physical_dimension for signal in bdf.signals] == ["uV", "uV", "N"]
    assert [signal.sampling_frequency for signal in bdf.signals] == [1000.0] * 3
    stored = [signal.data * scale for signal, scale in zip(bdf.signals, (1e-6, 1e-6, 1), strict=True)]
    assert_stored(stored, recording, of_range=1e-7)
    scans = pd.read_csv(tmp_path / "sub-P01" / "sub-P01_scans.tsv", sep="\t")
    stated = scans.set_index("filename").loc[path.relative_to(tmp_path / "sub-P01").as_posix(), "acq_time"]
    assert f"{bdf.startdate}T{bdf.starttime}" == stated
    assert [note.text for note in bdf.annotations] == ["start", "stop"] * 2
    assert [note.onset for note in bdf.annotations][::2] == pytest.approx(recording.truth.presses.cue_start_s, abs=5e-4)
    events = pd.read_csv(path.with_name(path.name.replace("_emg.bdf", "_events.tsv")), sep="\t")
    assert events.onset.tolist() == [note.onset for note in bdf.annotations]


def test_tables_return_samples_and_times(study: Study, tmp_path: Path) -> None:
    path, recording = made(study, tmp_path / "csv", "csv")
    time_s, table = np.arange(recording.force_n.size) / 1000, pd.read_csv(path)
    assert list(table) == ["time [s]", "EDC [V]", "FDS [V]", "Fz [N]"]
    assert table["time [s]"].to_numpy() == pytest.approx(time_s, rel=1e-12)
    assert_stored([table[name].to_numpy() for name in list(table)[1:]], recording, of_value=5.001e-9)
    path, _ = made(study, tmp_path / "emgworks", "emgworks")
    assert path.read_text().partition("\n")[0] == 'X[s],"EDC",X[s],"FDS",X[s],"Fz"'
    table = pd.read_csv(path)
    for column in ("X[s]", "X[s].1", "X[s].2"):
        assert table[column].to_numpy() == pytest.approx(time_s, rel=1e-12)
    assert_stored([table[name].to_numpy() for name in ("EDC", "FDS", "Fz")], recording, of_value=5.001e-7)


def test_c3d_returns_samples_to_6e_8_of_their_value(study: Study, tmp_path: Path) -> None:
    path, recording = made(study, tmp_path, "c3d")
    file = ezc3d.c3d(str(path))
    analog = file["parameters"]["ANALOG"]
    assert analog["LABELS"]["value"] == ["EDC", "FDS", "Fz"]
    assert analog["UNITS"]["value"] == ["V", "V", "N"]
    assert analog["RATE"]["value"][0] == 1000.0
    assert_stored(list(file["data"]["analogs"][0]), recording, of_value=6e-8)


@pytest.mark.parametrize(
    ("force", "heading", "newtons"),
    [
        ({"name": "Load", "unit": "kgf", "sign": -1}, "Load [kgf]", 9.80665),
        ({"newtons_per_unit": 25.0, "sign": -1}, "Fz", 25.0),
    ],
)
def test_gain_unit_and_sign_are_stored_as_the_study_undoes_them(
    study_with: Make, tmp_path: Path, force: dict[str, object], heading: str, newtons: float
) -> None:
    path, recording = made(study_with(channels=channels(**ODD, **force)), tmp_path, "csv")  # type: ignore[arg-type]
    table = pd.read_csv(path)
    assert list(table) == ["time [s]", "Ch 1 [V]", "Ch 2 [mV]", heading]
    scales = (1e-3, 1e-3, newtons)
    assert_stored(
        [table[name].to_numpy() * scale for name, scale in zip(list(table)[1:], scales, strict=True)],
        recording, of_value=1e-8,
    )  # fmt: skip


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


@pytest.mark.parametrize(
    ("format", "given", "named"),
    [
        ("csv", {"channels": channels(unit="%MVC")}, r"force channel 'Fz', unit: .*newtons_per_unit"),
        ("bids", {"channels": channels({"name": "Bagnoli sensor 1: EDC"})}, "16 ASCII"),
        ("bids", {"channels": channels({"name": "EDC µ"})}, "16 ASCII"),
        ("bids", {"fs_hz": 1925.926}, r"simulation\.fs_hz: expected whole samples"),
        ("xls", {}, "format: expected bids or csv or emgworks or c3d"),
        ("csv", {"a_v": {"S1": 1e-5, "S2": 1e-5}}, "specimen S1.*Raise a_v"),
    ],
)
def test_what_cannot_be_written_is_refused(
    study_with: Make, tmp_path: Path, format: Format, given: dict[str, object], named: str
) -> None:
    with pytest.raises(SettingError, match=named):
        simulate_study(study_with(**given), tmp_path, format=format)


@pytest.mark.parametrize(
    ("format", "stored"),
    [*((format, PLAIN) for format in RELATIVE_ERROR), *((format, AMPLIFIED) for format in ("csv", "emgworks", "c3d"))],
)
def test_the_readers_return_what_was_simulated(
    study_with: Make, tmp_path: Path, format: Format, stored: ChannelSettings
) -> None:
    path, recording = made(study_with(channels=stored, repetitions=1, specimens=1, participants=1), tmp_path, format)
    read = read_roles(path, None, stored)
    assert [channel.unit for channel in (*read.emg.values(), read.force)] == ["V", "V", "N"]
    assert read.emg["EDC"].fs_hz == pytest.approx(1000.0, rel=1e-9)
    for true, channel in [(recording.force_n, read.force), *((recording.emg_v[m], read.emg[m]) for m in read.emg)]:
        assert channel.samples == pytest.approx(true, abs=RELATIVE_ERROR[format] * np.max(np.abs(true)))
