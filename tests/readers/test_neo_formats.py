"""Files of neurophysiology programs: rates, units, scales and starts against what was written into made files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks import made_neurophysiology as made
from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import open_recording

pytest.importorskip("neo", reason="the extra formats is not installed")
N = 640


def test_channels_of_spike2_keep_their_rates_scales_and_units(tmp_path: Path) -> None:
    emg, force = made.counts(4 * N, 1), made.counts(N, 2)
    path = tmp_path / "made.smr"
    path.write_bytes(made.spike2({"EDC": (emg, 50, 5.0, " mV"), "Fz": (force, 200, 100.0, "N")}))
    name, opened = open_recording(path)
    assert name == "Spike2"
    one, other = opened.load([0, 1])
    assert (one.name, one.unit, one.fs_hz, one.start_s) == ("EDC", "mV", 2000.0, 0.0)
    assert (other.name, other.unit, other.fs_hz) == ("Fz", "N", 500.0)
    np.testing.assert_allclose(one.samples, emg * (5.0 / 6553.6), rtol=1e-6)
    np.testing.assert_allclose(other.samples, force * (100.0 / 6553.6), rtol=1e-6)


def test_a_pause_of_spike2_begins_a_channel_of_its_own(tmp_path: Path) -> None:
    emg = made.counts(4 * N, 1)
    path = tmp_path / "made.smr"
    path.write_bytes(made.spike2({"EDC": (emg, 50, 5.0, "mV")}, pause=100_000))
    opened = open_recording(path)[1]
    assert opened.contents.names == ("EDC", "EDC, segment 2")
    one, other = opened.load([0, 1])
    assert other.start_s == pytest.approx(2 * N / 2000 + 1.0, abs=1e-9)
    np.testing.assert_allclose(np.concatenate([one.samples, other.samples]), emg * (5.0 / 6553.6), rtol=1e-6)
    assert one.notes == ("EDC: 2 segments; each is a channel of its own.",)


@pytest.mark.parametrize("sweeps", [1, 2])
def test_gain_and_sweeps_of_axon(tmp_path: Path, sweeps: int) -> None:
    samples = np.column_stack([made.counts(N, 3), made.counts(N, 4)])
    path = tmp_path / "made.abf"
    path.write_bytes(made.axon(samples, 2000.0, sweeps))
    name, opened = open_recording(path)
    assert name == "Axon ABF"
    channels = opened.load(range(len(opened.contents.names)))
    assert [channel.name for channel in channels][::sweeps] == ["EDC", "Fz"]
    assert {(channel.unit, channel.fs_hz) for channel in channels} == {("mV", 2000.0), ("N", 2000.0)}
    assert [channel.start_s for channel in channels[:sweeps]] == [0.0, 2.0][:sweeps]
    for own, column, volts_per_unit in ((channels[:sweeps], 0, 0.01), (channels[sweeps:], 1, 0.5)):
        found = np.concatenate([channel.samples for channel in own])
        np.testing.assert_allclose(found, samples[:, column] * (10 / 32768 / volts_per_unit), rtol=1e-6)


def test_amplifier_and_board_of_intan(tmp_path: Path) -> None:
    emg, force = ((made.counts(N, seed).astype(np.int32) + 32768).astype(np.uint16) for seed in (5, 6))
    path = tmp_path / "made.rhd"
    path.write_bytes(made.intan(emg, force, 2000.0))
    name, opened = open_recording(path)
    assert name == "Intan"
    one, other = opened.load([0, 1])
    assert (one.name, one.unit, one.fs_hz) == ("EDC", "uV", 2000.0)
    assert (other.name, other.unit, other.fs_hz) == ("Fz", "V", 2000.0)
    np.testing.assert_allclose(one.samples, 0.195 * (emg.astype(float) - 32768), rtol=1e-6)
    np.testing.assert_allclose(other.samples, 50.354e-6 * force, rtol=1e-6)


def test_a_recording_of_open_ephys_is_read_by_its_structure(tmp_path: Path) -> None:
    samples = np.column_stack([made.counts(N, 7), made.counts(N, 8)])
    name, opened = open_recording(made.save_open_ephys(tmp_path / "experiment1" / "recording1", samples, 2000.0))
    assert name == "Open Ephys"
    one, other = opened.load([0, 1])
    assert (one.name, one.unit, one.fs_hz, one.start_s) == ("CH1", "uV", 2000.0, 0.25)
    assert (other.name, other.unit) == ("ADC1", "V")
    np.testing.assert_allclose(one.samples, 0.195 * samples[:, 0], rtol=1e-6)
    np.testing.assert_allclose(other.samples, 1.5e-4 * samples[:, 1], rtol=1e-6)


def test_unit_scale_and_start_of_plexon(tmp_path: Path) -> None:
    samples = made.counts(N, 9)
    path = tmp_path / "made.plx"
    path.write_bytes(made.plexon(samples, 1000))
    name, opened = open_recording(path)
    assert name == "Plexon"
    (channel,) = opened.load([0])
    assert (channel.name, channel.unit, channel.fs_hz, channel.start_s) == ("FP01", "mV", 1000.0, 0.1)
    np.testing.assert_allclose(channel.samples, samples * (5000 / 32768 / 100), rtol=1e-6)


def test_a_pause_of_plexon_is_refused_with_its_time(tmp_path: Path) -> None:
    path = tmp_path / "made.plx"
    path.write_bytes(made.plexon(made.counts(N, 9), 1000, pause=20_000))
    with pytest.raises(RecordingError, match=r"'FP01': expected a recording without pauses, but found 1 pauses, the "
                       r"first of 0.5 s after 0.42 s\. Export each part as CSV"):  # fmt: skip
        open_recording(path)


@pytest.mark.parametrize("name", ["a.smr", "a.abf", "a.rhd", "structure.oebin", "a.plx"])
def test_a_damaged_file_is_refused_in_words(tmp_path: Path, name: str) -> None:
    heads = {
        "a.smr": b"\x06\0(C) CED 87" + bytes(60), "a.abf": b"ABF2\0\0\6\2" + bytes(60),
        "a.rhd": b"\x02\x27\x91\xc6\2\0" + bytes(60), "structure.oebin": b'{"continuous": [{}]}',
        "a.plx": b"PLEX" + bytes(60),
    }  # fmt: skip
    (tmp_path / name).write_bytes(heads[name])
    with pytest.raises(RecordingError, match=r"expected (a file that neo can read|channels with samples)"):
        open_recording(tmp_path / name)
