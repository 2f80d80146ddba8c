"""Every file of ../shared/data/emg opens with the values that its line in SOURCES.md states, or is refused by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import open_recording
from emg2vsa.readers.opened import OpenRecording


@dataclass(frozen=True)
class Stated:
    """channels : number. values : (channel, sample) to (value as stored, tolerance)."""

    format: str
    channels: int
    values: dict[tuple[str, int], tuple[float, float]]
    fs_hz: float
    n: int
    unit: str | None


FILES = {
    "anc/btk_Res16bits.anc": Stated(
        "EVaRT ANC", 81,
        {
            ("R Tibialis Ant", 0): (111 * 2 * 5000 / 65536, 1e-9), ("F1X", 0): (-7 * 2 * 10000 / 65536, 1e-9),
            ("R Gastrocnemius Med", 0): (372 * 2 * 5000 / 65536, 1e-9),
        },
        1000, 1000, "mV",
    ),
    "c3d/btk_BKINtechnologies.c3d": Stated(
        "C3D", 20,
        {
            ("Right_L1Ang", 0): (0.540080, 1e-6), ("Right_L1Ang", 1): (0.540134, 1e-6),
            ("Right_L1Vel", 0): (0.060291, 1e-6), ("a1_M1TorMSRD", 0): (3.315430, 1e-6),
        },
        1000, 5065, "Rad/s**2",
    ),
    "c3d/btk_1123x01EMG.c3d": Stated("C3D", 8, {}, 1000, 4564, "mV"),
    "c3d/btk_PiG_Motion-FlatFoot-Full.c3d": Stated("C3D", 38 + 6, {}, 1000, 3150, "N"),
    "delsys_csv/discover150.csv": Stated("Trigno Discover CSV", 64, {}, 1259.2593, 250, "mV"),
    "delsys_csv/discover170.csv": Stated("Trigno Discover CSV", 111, {}, 1259.2593, 200, "mV"),
    "delsys_csv/emgio_emgworks_verbose_truncated.csv": Stated("EMGworks CSV", 14, {}, 1259.259, 2519, "V"),
    "delsys_csv/emgworks.csv": Stated("EMGworks CSV", 69, {}, 1925.92636, 200, "V"),
    "delsys_native/btk_Run34_EDC_FCR_BIC_TRI.hpf": Stated(
        "HPF", 40,
        {
            ("R TRAPEZIUS MIDDLE FIBERS: ACC X 1", 10): (0.3238856, 1e-7),
            ("R TRAPEZIUS MIDDLE FIBERS: ACC Y 1", 10): (1.326369, 1e-6),
            ("R TRAPEZIUS MIDDLE FIBERS: ACC Z 1", 10): (-3.640687, 1e-6),
            ("R EXTENSOR DIGITORUM: ACC X 3", 10): (-2.818379, 1e-6),
            ("L BICEPS BRACHII: ACC X 8", 10): (-2.339089, 1e-6),
        },
        2000, 10752, "Volts",
    ),
    "delsys_native/btk_Set1_Rep2_v3.emg": Stated(
        "DEMG", 8,
        {
            ("EMG Ch1", 0): (1.6327e-5, 1e-9), ("EMG Ch3", 29999): (3.4180e-5, 1e-9),
            ("EMG Ch6", 12000): (3.4180e-5, 1e-9), ("EMG Ch8", 59999): (4.3945e-5, 1e-9),
        },
        2000, 60000, "V",
    ),
    "emg_force/novainstrumentation_emg.txt": Stated("text matrix", 1, {}, 1000, 5000, None),
    "emg_force/novainstrumentation_force.txt": Stated("text matrix", 1, {}, 1000, 5000, None),
    "emg_force/openhdemg_otb_testfile_VL64_force.mat": Stated("MATLAB", 75, {}, 2048, 66560, "uV"),
    "labview/ladisk_long_single_header_multi_ch.lvm": Stated(
        "LabVIEW LVM", 3,
        {("F", 0): (0.05253, 0), ("m_1", 0): (0.234571, 0), ("m_2", 16383): (0.263686, 0), ("F", 16383): (0.052073, 0)},
        1 / 0.000977, 16384, "g",
    ),
    "labview/ladisk_short.lvm": Stated(
        "LabVIEW LVM", 2,
        {("Excitation (Trigger)", 0): (0.914018, 0), ("Response (Trigger)", 9): (1.212775, 0)}, 25600, 10, "Newtons",
    ),
    "labview/nptdms_raw1.tdms": Stated(
        "TDMS", 7,
        {("First  Channel", 0): (-0.18402661, 1e-8), ("First  Channel", 1999): (0.00091556, 1e-8)},
        50000, 2000, "Volts",
    ),
    "opensignals/bsnb_emg_bursts.h5": Stated(
        "OpenSignals HDF5", 2, {("PORT3_CHN1", 0): (32718, 0), ("PORT3_CHN1", 28518): (33082, 0)},
        1000, 28519, "counts",
    ),
    "opensignals/bsnb_raw_3ch_2018_7_4.txt": Stated(
        "OpenSignals text", 4, {("CH1", 0): (32208, 0), ("CH2", 0): (33144, 0), ("CH3", 0): (38252, 0)},
        1000, 17850, None,
    ),
    "opensignals/bsnb_two_devices_sync_cable_acoustic.txt": Stated(
        "OpenSignals text", 4,
        {("00:07:80:4D:2E:AD: CH1", 0): (32682, 0), ("00:07:80:3B:46:58: CH1", 0): (32489, 0)}, 1000, 20250, None,
    ),
    "opensignals/opensignalsreader_bitalino_SampleECG.txt": Stated(
        "OpenSignals text", 5, {("A2", 0): (496, 0), ("I1", 0): (1, 0), ("O2", 0): (0, 0)}, 1000, 22350, None,
    ),
    "vicon_csv/pyomeca_analogs_first2000.csv": Stated(
        "Vicon ASCII", 38,
        {("EMG1", 0): (-2.61e-5, 0), ("EMG2", 0): (-4.02e-5, 0), ("EMG1", 1999): (-4.0395e-4, 0), ("EMG12", 7): (0, 0)},
        2000, 2000, "V",
    ),
    "xdf/xdfmodules_minimal.xdf": Stated(
        "XDF", 3, {("SendDataC: 1", 0): (192, 0), ("SendDataC: 3", 1): (32, 0)}, 10, 9, None,
    ),
    "xdf/xdfmodules_clock_resets.xdf": Stated("XDF", 16, {}, 93.2387887, 12876, None),
    "ati/atusa_myo_mini45_raw_01.csv": Stated(  # no rate: the study states it
        "CSV", 9, {("Fz", 0): (4, 0), ("Fz", 1): (1022, 0), ("emg7", 0): (17, 0)}, np.nan, 12154, None,
    ),
    "bids/emg_IndependentMod/sub-01/emg/sub-01_task-grasping_emg.edf": Stated("EDF", 6, {}, 2000, 2000, "uV"),
}  # fmt: skip
"""format, channels, stated values, and rate, samples and unit of the first channel."""
REFUSED = {
    "c3d/btk_badParameterOffset.c3d": "The format is not standard",
    "bids/emg_IndependentMod/dataset_description.json": "found a JSON file",
}


def _opened(path: Path) -> tuple[str, OpenRecording]:
    if path.suffix in (".tdms", ".xdf", ".h5"):
        pytest.importorskip({".tdms": "nptdms", ".xdf": "pyxdf", ".h5": "h5py"}[path.suffix])
    return open_recording(path)


@pytest.mark.parametrize("relative", FILES)
def test_a_file_opens_with_the_values_its_source_states(shared_data, relative: str) -> None:
    path, stated = shared_data(f"emg/{relative}"), FILES[relative]
    name, opened = _opened(path)
    channels = opened.describe()
    assert (name, len(channels)) == (stated.format, stated.channels)
    assert channels[0].fs_hz == pytest.approx(stated.fs_hz, rel=1e-8, nan_ok=True)
    assert (channels[0].n_samples, channels[0].unit) == (stated.n, stated.unit)
    for (channel, sample), (value, tolerance) in stated.values.items():
        (stored,) = opened.load([opened.contents.names.index(channel)])
        assert abs(stored.samples[sample] - value) <= tolerance, (channel, sample)


@pytest.mark.parametrize("relative", REFUSED)
def test_a_file_that_is_refused_says_why(shared_data, relative: str) -> None:
    with pytest.raises(RecordingError, match=REFUSED[relative]):
        open_recording(shared_data(f"emg/{relative}"))


def test_no_file_of_the_folder_is_left_out(shared_data) -> None:
    folder = shared_data("emg")
    texts = (".md", ".json", ".tsv")
    found = {
        str(path.relative_to(folder)) for path in folder.rglob("*")
        if path.is_file() and "LICENSE" not in path.name and path.suffix not in texts
    }  # fmt: skip
    assert found <= {*FILES, *REFUSED}


def test_the_segments_of_a_stream_with_a_clock_reset_keep_their_times(shared_data) -> None:
    """SOURCES.md: t = 810.0298..1383.1843 s, a gap of 273.88 s between samples 12875 and 12876."""
    path = shared_data("emg/xdf/xdfmodules_clock_resets.xdf")
    _, opened = _opened(path)
    first, second = opened.load([opened.contents.names.index(n) for n in ("BioSemi: 1", "BioSemi: 1, segment 2")])
    ends = [c.start_s + (c.samples.size - 1) / c.fs_hz for c in (first, second)]
    assert first.start_s == pytest.approx(810.0298, abs=1e-4)
    assert ends[1] == pytest.approx(1383.1843, abs=1e-3)
    assert second.start_s - ends[0] == pytest.approx(273.88, abs=5e-3)
    assert first.samples.size + second.samples.size == 27815
    assert any("175 markers" in note for note in opened.contents.notes)
    assert any("2 segments" in note for note in first.notes)


def test_a_clock_offset_of_a_stream_is_applied(shared_data) -> None:
    _, opened = _opened(shared_data("emg/xdf/xdfmodules_minimal.xdf"))
    assert opened.load([0])[0].start_s == pytest.approx(5.0, abs=1e-6)  # 5.1 is stored


def test_sensor_rates_are_said_beside_the_stored_ones(shared_data) -> None:
    _, opened = _opened(shared_data("emg/delsys_native/btk_Run34_EDC_FCR_BIC_TRI.hpf"))
    emg, acc = opened.load([0, 1])
    assert not emg.notes
    assert "148.148 Hz" in acc.notes[0]
    assert opened.contents.started == "2013/12/12 14:32:53.3326516"


def test_kinarm_files_say_the_same_through_both_readers_of_c3d(shared_data) -> None:
    c3d_second = pytest.importorskip("emg2vsa.readers.c3d_second")
    path = shared_data("emg/c3d/btk_BKINtechnologies.c3d")
    _, first = open_recording(path)
    second = c3d_second.open_recording(path)
    assert second.contents.names == first.contents.names
    for a, b in zip(first.load(range(20)), second.load(range(20)), strict=True):
        assert (a.unit, a.fs_hz, a.start_s) == (b.unit, b.fs_hz, b.start_s)
        np.testing.assert_array_equal(a.samples, b.samples)
