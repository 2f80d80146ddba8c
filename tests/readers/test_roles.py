"""Channels by role: units, gain, sign, and two files on one clock."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.roles import read_roles
from emg2vsa.settings import ChannelSettings, EmgChannelSettings, ForceChannelSettings


def write(tmp_path: Path, name: str, header: str, start: float = 0.0, n: int = 100, fs: float = 1000.0) -> Path:
    width = header.count(",")
    path = tmp_path / name
    rows = [",".join([f"{start + i / fs:.6f}", *[str(i + 1)] * width]) for i in range(n)]
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def wanted(force: ForceChannelSettings | None = None, **emg: EmgChannelSettings) -> ChannelSettings:
    emg = emg or {"EDC": EmgChannelSettings(name="e1"), "FDS": EmgChannelSettings(name="e2")}
    return ChannelSettings(emg=emg, force=force or ForceChannelSettings(name="Fz"))


def test_one_file(tmp_path: Path) -> None:
    path = write(tmp_path, "a.csv", "time (s),e1 (mV),e2 (uV),Fz (kN)")
    roles = read_roles(path, None, wanted())
    assert list(roles.emg) == ["EDC", "FDS"]
    assert roles.format == "CSV"
    np.testing.assert_allclose(roles.emg["EDC"].samples, 1e-3 * np.arange(1, 101))
    np.testing.assert_allclose(roles.emg["FDS"].samples, 1e-6 * np.arange(1, 101))
    np.testing.assert_allclose(roles.force.samples, 1e3 * np.arange(1, 101))
    assert [roles.emg["EDC"].unit, roles.force.unit] == ["V", "N"]


def test_gain_unit_and_sign_are_applied_and_written_down(tmp_path: Path) -> None:
    path = write(tmp_path, "a.csv", "time (s),e1,Fz (lbf)")
    settings = wanted(ForceChannelSettings(name="Fz", sign=-1), EDC=EmgChannelSettings(name="e1", unit="V", gain=1000))
    roles = read_roles(path, None, settings)
    assert roles.emg["EDC"].samples[0] == pytest.approx(1e-3)
    assert roles.emg["EDC"].conversion == "unit V by the study (the file states none); V as stored; / gain 1000"
    assert roles.force.samples[0] == pytest.approx(-4.4482216152605)
    assert roles.force.conversion == "lbf x 4.448221615 = N; sign reversed"


def test_a_stated_unit_replaces_that_of_the_file(tmp_path: Path) -> None:
    path = write(tmp_path, "a.csv", "time (s),e1 (V),Fz (N)")
    roles = read_roles(path, None, wanted(EDC=EmgChannelSettings(name="e1", unit="mV")))
    assert roles.emg["EDC"].samples[0] == pytest.approx(1e-3)
    assert "the file states V" in roles.emg["EDC"].conversion


def test_newtons_per_unit_for_what_is_no_force(tmp_path: Path) -> None:
    path = write(tmp_path, "a.csv", "time (s),e1 (mV),Fz (%)")
    settings = ForceChannelSettings(name="Fz", newtons_per_unit=2.5, sign=-1)
    force = read_roles(path, None, wanted(settings, EDC=EmgChannelSettings(name="e1"))).force
    assert (force.samples[1], force.conversion) == (-5.0, "% x 2.5 N per unit = N; sign reversed")


@pytest.mark.parametrize(
    ("header", "force", "message"),
    [
        (
            "time (s),e1,Fz (N)",
            ForceChannelSettings(name="Fz"),
            "channel 'e1': expected an EMG in V, mV or uV, but found no unit",
        ),
        ("time (s),e1 (N),Fz (N)", ForceChannelSettings(name="Fz"), "found unit 'N'"),
        ("time (s),e1 (mV),Fz", ForceChannelSettings(name="Fz"), "channel 'Fz': expected a force .*found no unit"),
        ("time (s),e1 (mV),Fz (%)", ForceChannelSettings(name="Fz"), "found unit '%'.*newtons_per_unit"),
        ("time (s),e1 (mV),Fz (N)", ForceChannelSettings(name="Fz", newtons_per_unit=2.0), "either a force unit or"),
        ("time (s),e1 (mV),Fz (N)", ForceChannelSettings(name="fz"), "channel 'fz': .*Did you mean 'Fz'"),
    ],
)
def test_faults(tmp_path: Path, header: str, force: ForceChannelSettings, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        read_roles(write(tmp_path, "a.csv", header), None, wanted(force, EDC=EmgChannelSettings(name="e1")))


def test_two_files_at_their_own_rates(tmp_path: Path) -> None:
    emg = write(tmp_path, "emg.csv", "time (s),e1 (mV),e2 (mV)")
    force = write(tmp_path, "force.csv", "time (s),Fz (N)", start=0.02, fs=200.0)
    roles = read_roles(emg, force, wanted())
    assert (roles.emg["FDS"].fs_hz, roles.force.fs_hz, roles.force.start_s) == (1000.0, 200.0, 0.02)


def test_two_files_that_do_not_overlap(tmp_path: Path) -> None:
    emg = write(tmp_path, "emg.csv", "time (s),e1 (mV),e2 (mV)")
    force = write(tmp_path, "force.csv", "time (s),Fz (N)", start=50.0)
    with pytest.raises(
        RecordingError,
        match=r"expected time in common with the force \(50 to 50.1 s in force.csv\), but found 0 to "
        r"0.1",
    ):
        read_roles(emg, force, wanted())


def test_two_formats_and_two_stated_starts(tmp_path: Path) -> None:
    edfio = pytest.importorskip("edfio")
    import datetime

    def bdf(name: str, label: str, unit: str, second: int) -> Path:
        signal = edfio.BdfSignal(np.arange(100.0), 100, label=label, physical_dimension=unit)
        edfio.Bdf([signal], starttime=datetime.time(10, 0, second)).write(tmp_path / name)
        return tmp_path / name

    settings = wanted(EDC=EmgChannelSettings(name="e1"))
    emg, late = bdf("emg.bdf", "e1", "uV", 0), bdf("force.bdf", "Fz", "N", 3)
    assert "taken as the same moment" in read_roles(emg, late, settings).notes[0]
    roles = read_roles(emg, write(tmp_path, "force.csv", "time (s),Fz (N)"), settings)
    assert (roles.format, roles.notes) == ("BDF + CSV", ())


def test_real_grip_recording_in_two_files(shared_data) -> None:
    folder = shared_data("emg/emg_force")
    settings = wanted(ForceChannelSettings(name="row 2", unit="N"), EDC=EmgChannelSettings(name="row 2", unit="mV"))
    roles = read_roles(folder / "novainstrumentation_emg.txt", folder / "novainstrumentation_force.txt", settings)
    assert roles.emg["EDC"].samples[0] == pytest.approx(0.0366211e-3)
    assert roles.force.samples.max() == pytest.approx(97.9004)


def test_real_emg_in_volts_with_force_plate(shared_data) -> None:
    path = shared_data("emg/c3d/btk_PiG_Motion-FlatFoot-Full.c3d")
    settings = wanted(ForceChannelSettings(name="plate 1 Fz"), TA=EmgChannelSettings(name="R_TA", gain=1000))
    roles = read_roles(path, None, settings)
    assert roles.force.samples.max() == pytest.approx(482.527, abs=1e-3)
    assert roles.emg["TA"].conversion == "V as stored; / gain 1000"


@pytest.mark.parametrize(("fs", "meant"), [(1.0, "milliseconds or a count"), (1e6, "Is the time in seconds")])
def test_a_time_in_another_unit_than_its_header_says(tmp_path: Path, fs: float, meant: str) -> None:
    path = write(tmp_path, "a.csv", "time (s),e1 (mV),e2 (mV),Fz (N)", fs=fs)
    with pytest.raises(RecordingError, match=f"channel 'e1': expected more than 10 .*{meant}"):
        read_roles(path, None, wanted())


def test_rates_are_stated_by_channel_where_a_file_has_none(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("e1_mV,Fz_N\n" + "".join(f"{i},{i}\n" for i in range(100)))
    settings = wanted(ForceChannelSettings(name="Fz", fs_hz=500), EDC=EmgChannelSettings(name="e1", fs_hz=1000))
    roles = read_roles(path, None, settings)
    assert (roles.emg["EDC"].fs_hz, roles.force.fs_hz) == (1000.0, 500.0)
    assert "e1: the file states no sampling rate; 1000 Hz as the study states." in roles.notes
    with pytest.raises(RecordingError, match="channel 'Fz': expected a sampling rate"):
        read_roles(path, None, wanted(EDC=EmgChannelSettings(name="e1", fs_hz=1000)))


def test_a_mass_is_no_force_but_says_which(tmp_path: Path) -> None:
    path = write(tmp_path, "a.csv", "time (s),e1 (mV),Fz (kg)")
    with pytest.raises(RecordingError, match=r"found unit 'kg'. kg is a mass; .* state unit = .kgf"):
        read_roles(path, None, wanted(EDC=EmgChannelSettings(name="e1")))


@pytest.mark.parametrize("n", [2, 5])
def test_a_record_too_short_for_any_filter_is_refused(tmp_path: Path, n: int) -> None:
    path = write(tmp_path, "a.csv", "time (s),e1 (mV),e2 (mV),Fz (N)", n=n)
    with pytest.raises(RecordingError, match=f"'e1': expected a recording of 6 samples or more, but found {n}"):
        read_roles(path, None, wanted())
    force = write(tmp_path, "force.csv", "time (s),Fz (N)", n=n)
    emg = write(tmp_path, "emg.csv", "time (s),e1 (mV),e2 (mV)")
    with pytest.raises(RecordingError, match=f"'Fz': expected a recording of 6 samples or more, but found {n}"):
        read_roles(emg, force, wanted())


def test_an_empty_record_and_an_infinite_sample_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="expected a header row and data, but found 1 filled lines"):
        read_roles(write(tmp_path, "a.csv", "time (s),e1 (mV),e2 (mV),Fz (N)", n=0), None, wanted())
    path = write(tmp_path, "b.csv", "time (s),e1 (mV),e2 (mV),Fz (N)")
    path.write_text(path.read_text().replace(",8,8,8\n", ",8,8,inf\n"))
    with pytest.raises(RecordingError, match=r"'Fz': expected finite samples, but found inf at sample 7 \(0.007 s"):
        read_roles(path, None, wanted())
