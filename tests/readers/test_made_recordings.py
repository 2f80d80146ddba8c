"""Formats, or cases of them, of which no public file exists: the recordings here are made by code."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import scipy.io

from benchmarks import made_recordings as made
from emg2vsa.errors import RecordingError
from emg2vsa.extraction.remedies import remedy_of
from emg2vsa.readers.front_door import open_recording, read
from emg2vsa.readers.opened import OpenRecording, StoredChannel
from emg2vsa.readers.roles import read_roles
from emg2vsa.settings import ChannelSettings, EmgChannelSettings, ForceChannelSettings

N = made.N


def _written(folder: Path, content: bytes, name: str = "made.bin") -> Path:
    (folder / name).write_bytes(content)
    return folder / name


def _opened(folder: Path, content: bytes, name: str = "made.bin") -> OpenRecording:
    return open_recording(_written(folder, content, name))[1]


def _channel(opened: OpenRecording, name: str) -> StoredChannel:
    return opened.load([opened.contents.names.index(name)])[0]


# HPF


def test_groups_of_an_hpf_file_keep_their_own_rates(tmp_path: Path) -> None:
    opened = _opened(tmp_path, made.hpf())
    assert [(c.name, c.unit, c.fs_hz, c.n_samples) for c in opened.describe()] == [
        ("EMG 1.1", "Volts", 1000, N), ("EMG 1.2", "Volts", 1000, N), ("ACC 2.1", "g", 500, N // 2),
    ]  # fmt: skip
    for name, n, seed in (("EMG 1.1", N, 1), ("EMG 1.2", N, 2), ("ACC 2.1", N // 2, 3)):
        np.testing.assert_array_equal(_channel(opened, name).samples, made.wave(n, seed).astype("f4"))


def test_a_cut_hpf_file_is_read_up_to_its_last_whole_chunk(tmp_path: Path) -> None:
    groups = {1: (1000.0, 1000.0, (made.wave(N, 1),))}
    opened = _opened(tmp_path, made.hpf(groups)[:-700])  # the index and a part of the last chunk of 16 samples
    assert opened.describe()[0].n_samples == 80
    assert "ends inside the chunk" in opened.contents.notes[0]
    assert "samples in it were left out" in opened.contents.notes[0]


@pytest.mark.parametrize(("more", "notes"), [(16, ()), (15, ("The file is incomplete: it ends inside the chunk at",))])
def test_the_smallest_chunk_of_an_hpf_file_is_its_head_alone(tmp_path: Path, more: int, notes: tuple[str, ...]) -> None:
    found = _opened(tmp_path, made.hpf() + struct.pack("<qq", 0x6000, 16)[:more]).contents.notes
    assert len(found) == len(notes)
    assert all(note.startswith(start) for note, start in zip(found, notes, strict=True))


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        (b"<DataType>Float<", b"<DataType>Int16<", "type 'Int16'"),
        (b"<DataIndex>1<", b"<DataIndex>7<", "no samples of 'EMG 1.2'"),
        (b"<DataIndex>1<", b"<DataIndex>x<", "found 'x'"),
        (b"</ChannelInformationData>", b"<ChannelInformationData/>", "no XML"),
        (struct.pack("<iqi", 1, 40, 2), struct.pack("<iqi", 1, 41, 2), "those from 41 on"),
        (struct.pack("<qq", 0x3000, 512), struct.pack("<qq", 0x3000, 3), "a chunk of kind 12288 and 3 bytes"),
    ],
)
def test_a_damaged_hpf_file_is_refused(tmp_path: Path, old: bytes, new: bytes, found: str) -> None:
    content = made.hpf()
    assert old in content
    with pytest.raises(RecordingError, match=found):
        _opened(tmp_path, content.replace(old, new, 1))


# DEMG


def test_a_cut_demg_file_says_how_much_it_holds(tmp_path: Path) -> None:
    opened = _opened(tmp_path, made.demg()[: -43 - 4 * 16])  # the marker behind the samples, and 16 samples
    assert opened.describe()[0].n_samples == N - 16
    assert opened.contents.notes == (
        f"The header promises {N} samples a channel, the file holds {N - 16}: it is incomplete.",
    )
    np.testing.assert_allclose(_channel(opened, "Ch 2").samples, (2 * np.arange(N - 16) + 1) * 10 / 65536 / 1000)


def test_a_gain_of_the_converter_is_said_and_not_applied(tmp_path: Path) -> None:
    assert "gain of the converter, 2," in _channel(_opened(tmp_path, made.demg(ad_gain=2.0)), "Ch 1").notes[0]


@pytest.mark.parametrize("version", [1, 2, 4])
def test_other_versions_of_demg_are_refused(tmp_path: Path, version: int) -> None:
    with pytest.raises(RecordingError, match=f"expected a DEMG file of version 3, but found version {version}"):
        _opened(tmp_path, made.demg(version=version))


def test_a_demg_header_that_ends_early_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="expected a whole DEMG header"):
        _opened(tmp_path, made.demg()[:400])


# Delsys .mat export


@pytest.mark.parametrize("cell", [False, True])
def test_a_delsys_mat_export_has_names_rates_and_no_padding(tmp_path: Path, cell: bool) -> None:
    fast, slow = made.save_delsys_mat(tmp_path / "made_delsys_export.mat", cell)
    name, opened = open_recording(tmp_path / "made_delsys_export.mat")
    assert name == "MATLAB"
    assert [(c.name, c.unit, c.fs_hz) for c in opened.describe()] == [
        ("Muscle: EMG 1", "V", 2148.14819336), ("Muscle: ACC.X 2", None, 148.14814758),
    ]  # fmt: skip
    np.testing.assert_array_equal(_channel(opened, "Muscle: EMG 1").samples, fast)
    np.testing.assert_array_equal(_channel(opened, "Muscle: ACC.X 2").samples, slow)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"Fs": np.array([[1000.0], [148.148]])}, "1000 Hz in Fs, 2148.15 Hz by Time"),
        ({"Fs": np.array([[2148.148]])}, "2 Channels, 1 Fs"),
        ({"Data": "text"}, "variable 'Data': expected a matrix of numbers"),
    ],
)
def test_a_delsys_mat_export_that_contradicts_itself_is_refused(tmp_path: Path, change: dict, found: str) -> None:
    made.save_delsys_mat(tmp_path / "a.mat")
    variables = {k: v for k, v in scipy.io.loadmat(tmp_path / "a.mat").items() if not k.startswith("__")}
    scipy.io.savemat(tmp_path / "a.mat", variables | change)
    with pytest.raises(RecordingError, match=found):
        open_recording(tmp_path / "a.mat")


# OpenSignals


def test_lost_samples_are_missing_and_the_time_goes_on(tmp_path: Path) -> None:
    for bitalino, name in ((False, "CH1"), (True, "A1")):
        channel = _channel(_opened(tmp_path, made.opensignals(lost=True, bitalino=bitalino)), name)
        assert channel.samples.size == N
        np.testing.assert_array_equal(np.flatnonzero(np.isnan(channel.samples)), [10, 11, 12])
        assert channel.samples[13] == 513
        assert "3 samples were lost, the first after 0.009 s" in channel.notes[0]


def test_counts_become_volts_by_the_gain_that_the_study_states(tmp_path: Path) -> None:
    """biosignalsplux gives (counts / 2^16 - 1/2) x 3 mV for EMG; force comes from a Net F/T in a second file."""
    emg = _written(tmp_path, made.opensignals(), "made_opensignals.txt")
    force = _written(tmp_path, made.net_ft(), "made_net_ft.csv")
    with pytest.raises(
        RecordingError, match=r"expected an EMG in V, mV or uV, but found unit 'counts'; OpenSignals stores counts"
    ):
        read_roles(emg, force, _roles(unit=None, gain=1.0))
    roles = read_roles(emg, force, _roles(unit="V", gain=2**16 * 1000 / 3))
    np.testing.assert_allclose(roles.emg["EDC"].samples, (500 + np.arange(N)) * 3e-3 / 65536, rtol=1e-12)
    np.testing.assert_allclose(roles.force.samples, 1 + np.arange(N) / 1000, rtol=1e-12)


def _roles(unit: Literal["V"] | None, gain: float) -> ChannelSettings:
    emg = {"EDC": EmgChannelSettings(name="CH1", unit=unit, gain=gain)}
    return ChannelSettings(emg=emg, force=ForceChannelSettings(name="Fz"))


def test_a_counter_that_stands_still_is_not_followed(tmp_path: Path) -> None:
    content = made.opensignals().decode().splitlines()
    stuck = [*content[:50], *("\t".join(["146", *line.split("\t")[1:]]) for line in content[50:])]
    channel = _channel(_opened(tmp_path, ("\n".join(stuck) + "\n").encode()), "CH2")
    assert channel.samples.size == N
    assert not np.isnan(channel.samples).any()
    assert "the rows were counted instead" in channel.notes[0]


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ('"sampling rate": 1000', '"sampling rate": 0', "0 as the sampling rate of 00:07"),
        ('"CH2"], "label"', '"CH2", "CH3"], "label"', "expected 5 cells, as the header names, but found 5"),
        ('# {"', "# {", "no JSON"),
        ("# EndOfHeader", "# Other", "no line 3"),
        ('"column": [', '"columnz": [', "None as the columns of"),
    ],
)
def test_a_damaged_opensignals_header_is_refused(tmp_path: Path, old: str, new: str, found: str) -> None:
    content = made.opensignals().decode()
    assert old in content
    with pytest.raises(RecordingError, match=found):
        _opened(tmp_path, content.replace(old, new).encode())


def test_devices_of_one_hdf5_file_keep_their_own_rates(tmp_path: Path) -> None:
    pytest.importorskip("h5py")
    made.save_opensignals_hdf5(tmp_path / "made_two_devices.h5")
    opened = open_recording(tmp_path / "made_two_devices.h5")[1]
    assert [(c.name, c.fs_hz, c.n_samples) for c in opened.describe()] == [
        ("00:A: channel_3", 1000, N + 2), ("00:B: channel_1", 500, N // 2 + 2),
    ]  # fmt: skip
    assert np.flatnonzero(np.isnan(_channel(opened, "00:B: channel_1").samples)).tolist() == [10, 11]


def test_an_hdf5_file_of_another_program_is_refused(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["x"] = np.zeros(9)
    with pytest.raises(RecordingError, match=r"expected an HDF5 file of OpenSignals.*found groups 'x'"):
        open_recording(tmp_path / "a.h5")


@pytest.mark.parametrize("beside", [(), ("00:A", "00:B")], ids=["alone", "beside devices"])
def test_a_group_of_another_program_is_no_device(tmp_path: Path, beside: tuple[str, ...]) -> None:
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "made_two_devices.h5"
    made.save_opensignals_hdf5(path)
    with h5py.File(path, "a") as file:
        file["analysis/peaks"] = np.zeros(9)
        for device in ("00:A", "00:B"):
            if device not in beside:
                del file[device]
    if beside:
        assert [c.name for c in open_recording(path)[1].describe()] == ["00:A: channel_3", "00:B: channel_1"]
    else:
        with pytest.raises(RecordingError, match=r"expected an HDF5 file of OpenSignals.*found groups 'analysis'"):
            open_recording(path)


# TDMS and XDF


def test_groups_of_a_tdms_file_keep_their_rates_and_starts(tmp_path: Path) -> None:
    pytest.importorskip("nptdms")
    made.save_tdms(tmp_path / "made_two_groups.tdms", unrated=True)
    opened = open_recording(tmp_path / "made_two_groups.tdms")[1]
    emg, force, unrated = (_channel(opened, name) for name in ("EMG box: EDC", "Fz", "Plate: EDC"))
    assert (emg.unit, emg.fs_hz, emg.start_s, emg.samples.size) == ("mV", 2000.0, 0.0, 4 * N)
    assert (force.unit, force.fs_hz) == ("N", 500.0)
    assert force.start_s == pytest.approx(0.011, abs=1e-12)
    assert np.isnan(unrated.fs_hz)
    assert "no wf_increment" in unrated.notes[0]
    assert len(opened.contents.names) == 3
    assert any(note.startswith("words: holds no numbers") for note in opened.contents.notes)
    np.testing.assert_array_equal(force.samples, made.wave(N, 2))


def test_an_index_beside_a_tdms_file_is_not_read(tmp_path: Path) -> None:
    """No key holds it; npTDMS would take names, rates and places of samples from it."""
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "a.tdms"
    made.save_tdms(path)
    before = open_recording(path)[1]
    other = nptdms.ChannelObject("G", "other", np.arange(9.0))
    with nptdms.TdmsWriter(str(tmp_path / "b.tdms"), index_file=True) as writer:
        writer.write_segment([other])
    (tmp_path / "b.tdms_index").rename(tmp_path / "a.tdms_index")
    assert nptdms.TdmsFile.open(path).groups()[0].name == "G"
    after = open_recording(path)[1]
    assert after.describe() == before.describe()
    for one, same in zip(before.load([0, 1]), after.load([0, 1]), strict=True):
        np.testing.assert_array_equal(one.samples, same.samples)


def test_streams_of_an_xdf_file_keep_their_rates_and_times(tmp_path: Path) -> None:
    pytest.importorskip("pyxdf")
    opened = _opened(tmp_path, made.xdf(uneven=True), "made_streams.xdf")
    assert opened.contents.names == ("EMG: EDC", "EMG: FDS", "Force: 1", "Events: 1")
    assert opened.contents.notes == ("Markers: 1 markers (texts), which are no channel.", "Empty: the stream is empty.")
    fds, force = (_channel(opened, name) for name in ("EMG: FDS", "Force: 1"))
    np.testing.assert_array_equal(fds.samples, made.wave(5 * N, 2).astype("f4"))
    np.testing.assert_array_equal(force.samples, made.wave(N // 2, 3))
    assert (fds.unit, fds.fs_hz, fds.start_s) == ("uV", pytest.approx(500), pytest.approx(3))
    assert (force.unit, force.fs_hz, force.start_s) == (None, pytest.approx(50), pytest.approx(3.05))
    with pytest.raises(
        RecordingError,
        match=r"'Events: 1': expected evenly spaced time stamps.* found a gap of 0.25 "
        r"s",
    ):
        _channel(opened, "Events: 1")


@pytest.mark.parametrize(
    ("lost", "bursty"),
    [(0, False), (20, False), (100, False), (900, False), (0, True), (100, True), (900, True)],
)
def test_lost_samples_of_an_xdf_stream_end_a_segment(tmp_path: Path, lost: int, bursty: bool) -> None:
    """Stamps jitter by 0.2 ms; or packets of 32 samples come up to 15 ms late, and one after 0.4 s."""
    pytest.importorskip("pyxdf")
    rng, n, at = np.random.default_rng(lost), 12000, 5120
    true_s = 50 + np.arange(n) / 1000
    late_s = np.repeat(rng.uniform(0, 0.015, n // 32), 32) if bursty else rng.normal(0, 2e-4, n)
    late_s[8000:8032] += 0.4 * bursty
    kept = np.r_[0:at, at + lost : n]
    opened = _opened(tmp_path, made.xdf_stream((true_s + late_s)[kept], kept.astype(float)), "lost.xdf")
    channels = opened.load(range(len(opened.contents.names)))
    assert len(channels) == (2 if lost else 1)
    assert channels[-1].samples[0] == (at + lost if lost else 0)
    for channel in channels:
        found_s = channel.start_s + np.arange(channel.samples.size) / channel.fs_hz
        assert np.abs(found_s - true_s[channel.samples.astype(int)] - 0.0075 * bursty).max() < (
            0.02 if bursty else 0.001
        )
        assert bool(lost) == any("2 segments" in note for note in channel.notes)


def test_rate_and_start_of_an_xdf_stream_keep_their_digits_on_a_clock_that_began_days_ago() -> None:
    xdf = pytest.importorskip("emg2vsa.readers.xdf", exc_type=ImportError)
    rate_hz, start_s, said = xdf._fitted("EMG", 2.0**20 + np.arange(20_000) / 2048, 2048.0)
    assert rate_hz == pytest.approx(2048, rel=1e-14)
    assert (start_s, said) == (2.0**20, ())


def test_an_xdf_rate_that_its_stamps_deny_is_said(tmp_path: Path) -> None:
    pytest.importorskip("pyxdf")
    opened = _opened(tmp_path, made.xdf_stream(np.arange(5000) / 997, np.arange(5000.0)), "slow.xdf")
    channel = _channel(opened, "EMG: 1")
    assert channel.fs_hz == pytest.approx(997, rel=1e-6)
    assert channel.notes == ("EMG: 1000 Hz stated, 997 Hz by its time stamps; the latter counts.",)
    assert remedy_of(channel.notes[0])


# LabVIEW


@pytest.mark.parametrize("x_columns", ["No", "One", "Multi"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_the_x_columns_of_labview_files(tmp_path: Path, x_columns: str, decimal: str) -> None:
    opened = _opened(tmp_path, made.lvm(x_columns, 1, decimal=decimal))
    for name, unit, seed in (("EMG", "Volts", 1), ("Force", "Newtons", 2)):
        channel = _channel(opened, name)
        assert (channel.unit, channel.start_s) == (unit, 0.0)
        assert channel.fs_hz == pytest.approx(1000, rel=1e-9)
        np.testing.assert_array_equal(channel.samples, made.wave(N, seed))


def test_segments_of_a_labview_file_join_or_stand_alone(tmp_path: Path) -> None:
    joined = _channel(_opened(tmp_path, made.lvm(segments=3)), "EMG")
    np.testing.assert_array_equal(joined.samples, made.wave(N, 1))
    assert joined.notes == ()
    apart = _opened(tmp_path, made.lvm(segments=3, gap_s=1.0))
    assert [n for n in apart.contents.names if n.startswith("EMG")] == ["EMG", "EMG, segment 2", "EMG, segment 3"]
    assert "EMG: 3 segments, with gaps of 1 s after" in _channel(apart, "EMG").notes[0]
    third = _channel(apart, "EMG, segment 3")
    assert third.start_s == pytest.approx(2 * (1.0 + N // 3 * 1e-3), abs=1e-9)
    np.testing.assert_array_equal(third.samples, made.wave(N, 1)[2 * (N // 3) :])


@pytest.mark.parametrize(("delta_x", "gap_s"), [("0,001", 0.01), ("0,00098", 0.3)])
def test_a_coarse_delta_x_hides_no_gap(tmp_path: Path, delta_x: str, gap_s: float) -> None:
    content = made.lvm(segments=2, gap_s=gap_s).decode().replace("0,001000\t0,001000", f"{delta_x}\t{delta_x}")
    assert f"Delta_X\t{delta_x}" in content
    opened = _opened(tmp_path, content.encode())
    assert [name for name in opened.contents.names if name.startswith("EMG")] == ["EMG", "EMG, segment 2"]


@pytest.mark.parametrize("delta_x", ["0,001E+999", "1,0E-320", "0,0", "-0,001"])
def test_a_delta_x_that_is_no_step_leaves_the_rate_unknown(tmp_path: Path, delta_x: str) -> None:
    content = made.lvm(segments=1).decode().replace("0,001000\t0,001000", f"{delta_x}\t{delta_x}")
    assert f"Delta_X\t{delta_x}" in content
    assert np.isnan(_opened(tmp_path, content.encode()).describe()[0].fs_hz)


def test_a_labview_file_that_ends_before_it_promised_says_so(tmp_path: Path) -> None:
    content = made.lvm(segments=1).decode().rstrip().splitlines(keepends=True)
    channel = _channel(_opened(tmp_path, "".join(content[:-6]).encode()), "EMG")
    assert "promises 96 samples, 90 follow" in channel.notes[0]


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("Decimal_Separator\t,", "Decimal_Separator\t;", "Decimal_Separator ';'"),
        ("Channels\t2", "Channel\t2", "no line 'Channels'"),
        ("X_Value\tEMG", "EMG", "expected a row of names that begins with X_Value"),
        ("***End_of_Header***", "***", "End_of_Header"),
        ("\t0,", "\t0,1x", "expected a number, but found '0.1x"),
    ],
)
def test_a_damaged_labview_file_is_refused(tmp_path: Path, old: str, new: str, found: str) -> None:
    content = made.lvm(segments=1).decode()
    assert old in content
    with pytest.raises(RecordingError) as caught:
        _opened(tmp_path, content.replace(old, new).encode())
    assert found in str(caught.value).replace("0,1x", "0.1x")


# Vicon, EVaRT, Net F/T


def test_a_vicon_export_starts_at_its_first_frame_and_ends_at_its_block(tmp_path: Path) -> None:
    opened = _opened(tmp_path, made.vicon())
    force = _channel(opened, "Fz")
    assert (force.unit, force.fs_hz, force.start_s) == ("N", 400.0, 0.1)
    assert force.samples.size == N
    assert opened.contents.aliases["EMG box: EMG2"] == 1


def test_a_vicon_export_with_a_gap_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"line 15: .*found frame 13, sub frame 2 after frame 13, 0"):
        _opened(tmp_path, made.vicon(skipped_row=9))


def test_counts_of_an_evart_file_become_mv_by_range_and_bits(tmp_path: Path) -> None:
    channel = _channel(_opened(tmp_path, made.evart(12)), "Fz")
    np.testing.assert_allclose(channel.samples, np.arange(N) * 2 * 10000 / 4096)
    assert "checked for 16 bits only" in channel.notes[0]
    with pytest.raises(RecordingError, match="found no BitDepth"):
        _opened(tmp_path, made.evart().replace(b"BitDepth:\t16", b"BitDepth:\t"))


def test_a_labchart_text_states_rate_and_units_above_its_rows(tmp_path: Path) -> None:
    opened = _opened(tmp_path, made.labchart())
    emg, force = (_channel(opened, name) for name in ("EMG", "Kraft"))
    assert [(each.unit, each.fs_hz, each.samples.size) for each in (emg, force)] == [("mV", 2000, N), ("N", 2000, N)]
    np.testing.assert_allclose(force.samples, made.wave(N, 2))
    assert "decimal comma" in opened.contents.notes[0]
    named = made.labchart().replace(b"Range=", b"UnitName=\tV\tkN\nRange=")
    assert [_channel(_opened(tmp_path, named), name).unit for name in ("EMG", "Kraft")] == ["V", "kN"]


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (made.labchart(blocks=2), "several blocks. Export each block"),
        (made.labchart(interval="0,0 s"), "'0,0 s' as the interval"),
        (made.labchart(interval="5 apples"), "'5 apples' as the interval"),
        (made.labchart().replace(b"ChannelTitle=\tEMG\tKraft", b"ChannelTitle=\t"), "0 channel titles"),
        (made.labchart().partition(b"0,000000")[0], "2 channel titles and no rows"),
    ],
)
def test_a_damaged_labchart_text_is_refused(tmp_path: Path, content: bytes, found: str) -> None:
    with pytest.raises(RecordingError, match=f"expected a text that LabChart exported, but found {found}"):
        _opened(tmp_path, content)


@pytest.mark.parametrize("counts", [True, False])
def test_net_ft_counts_and_values_give_the_same_newtons(tmp_path: Path, counts: bool) -> None:
    opened = _opened(tmp_path, made.net_ft(counts, lost=True))
    force = _channel(opened, "Fz")
    assert (force.unit, force.fs_hz, force.samples.size) == ("N", 7000, N)
    assert np.flatnonzero(np.isnan(force.samples)).tolist() == [10, 11, 12]
    expected = 1 + np.arange(N) / 1000
    np.testing.assert_allclose(force.samples[13:], expected[13:], rtol=1e-12)
    assert ("counts / 1000 = N" if counts else "written in N already") in force.notes[-1]


def test_a_net_ft_file_without_its_scale_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="found None as Counts per Unit Force"):
        _opened(tmp_path, made.net_ft().replace(b"Counts per Unit Force", b"Counts"))


# C3D of other systems


def test_a_c3d_file_that_ezc3d_refuses_is_read_by_the_second_reader(tmp_path: Path) -> None:
    pytest.importorskip("c3d")
    recording = read(_written(tmp_path, made.c3d_sgi(), "made_sgi.c3d"), ["EMG", "Fz"])
    np.testing.assert_allclose(recording.channels[0].samples, np.arange(80) * 1e-3)
    assert (recording.channels[1].unit, recording.channels[1].fs_hz) == ("N", 400.0)
    assert "ezc3d does not read this file" in recording.notes[0]


def test_a_c3d_file_that_neither_reads_is_refused_in_the_words_of_the_first(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="MIPS"):
        open_recording(_written(tmp_path, made.c3d_sgi()[:600], "made_cut.c3d"))


# Texts that are cut


@pytest.mark.parametrize(
    "name", [n for n in made.MADE if n.endswith((".txt", ".csv", ".lvm", ".anc")) if "lost" not in n]
)
def test_a_text_cut_in_mid_number_loses_that_line(tmp_path: Path, name: str) -> None:
    whole = made.MADE[name]()
    if name.startswith("nexus"):
        whole = made.vicon(trajectories=False)
    if name.endswith(".lvm"):
        whole = whole.rstrip() + b"\r\n"
    one, other = (_opened(tmp_path, content, name) for content in (whole, whole.rstrip()[:-1]))
    assert any("no line end" in note for note in other.contents.notes)
    last = len(one.contents.names) - 1 if "gap" in name else 0
    a, b = one.load([last])[0].samples, other.load([last])[0].samples
    np.testing.assert_array_equal(b, a[: b.size])
    assert a.size - b.size == 1


def test_a_cut_last_row_of_channels_in_rows_loses_its_last_value(tmp_path: Path) -> None:
    rows = "\n".join(" ".join(f"{v:.6e}" for v in row) for row in (np.arange(50) / 1000, made.wave(50)))
    opened = _opened(tmp_path, rows[:-3].encode(), "a.txt")
    np.testing.assert_array_equal(_channel(opened, "row 2").samples, made.wave(50)[:49])
    assert any("last value was left out" in note for note in opened.contents.notes)


@pytest.mark.parametrize(
    ("module", "content", "said"),
    [
        ("nptdms", b"TDSm" + bytes(100), r'npTDMS.*pip install "\.\[formats\]" in the folder of the sources\.$'),
        (
            "neo",
            b"\x09\0(C) CED 87" + bytes(60),
            r'neo, which reads Spike2.*\[formats\]" in the folder of the sources\. Or: In Spike2: File > Export',
        ),
    ],
)
def test_a_package_that_is_not_installed_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, content: bytes, said: str
) -> None:
    from casr.decoder_process import end_child

    (tmp_path / "hidden").mkdir()
    (tmp_path / "hidden" / f"{module}.py").write_text(f"raise ImportError('No module named {module}')")
    path = _written(tmp_path, content, "a.dat")
    end_child()
    monkeypatch.syspath_prepend(str(tmp_path / "hidden"))  # the child searches where this process does
    try:
        with pytest.raises(RecordingError, match=f"expected the package {said}"):
            open_recording(path)
    finally:
        end_child()
