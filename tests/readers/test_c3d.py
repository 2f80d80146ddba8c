"""C3D through ezc3d: analogue channels and force plates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import inspect, read


@pytest.fixture
def written(tmp_path: Path) -> Path:
    import ezc3d

    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["ANALOG"]["RATE"]["value"] = [1000.0]
    file["parameters"]["ANALOG"]["LABELS"]["value"] = ["EDC", "EDC", "Fz"]
    file["parameters"]["ANALOG"]["UNITS"]["value"] = ["mV", "uV", "N"]
    file["data"]["points"] = np.zeros((4, 0, 50))
    file["data"]["analogs"] = np.arange(1500.0).reshape(1, 3, 500)
    path = tmp_path / "rec.c3d"
    file.write(str(path))
    return path


def test_units_names_and_rate(written: Path) -> None:
    edc, second, fz = read(written, ["EDC", "EDC #2", "Fz"]).channels
    np.testing.assert_allclose(edc.samples, 1e-3 * np.arange(500.0), rtol=1e-7)
    np.testing.assert_allclose(second.samples, 1e-6 * np.arange(500.0, 1000.0), rtol=1e-7)
    np.testing.assert_allclose(fz.samples, np.arange(1000.0, 1500.0), rtol=1e-7)
    assert [(c.fs_hz, c.unit) for c in (edc, second, fz)] == [(1000.0, "V"), (1000.0, "V"), (1000.0, "N")]


def test_truncated_file_is_noted(written: Path) -> None:
    content = written.read_bytes()
    written.write_bytes(content[: len(content) - 3 * 4 * 200])
    recording = read(written, ["EDC"])
    assert recording.channels[0].samples.size < 500
    assert "promises 500 samples a channel" in recording.notes[0]


def test_no_analogue_channels(tmp_path: Path) -> None:
    import ezc3d

    file = ezc3d.c3d()
    file["data"]["points"] = np.zeros((4, 0, 5))
    file.write(str(tmp_path / "empty.c3d"))
    with pytest.raises(RecordingError, match="expected analogue channels with a rate"):
        inspect(tmp_path / "empty.c3d")


def test_force_plate_channels_are_those_of_ezc3d(shared_data) -> None:
    import ezc3d

    path = shared_data("emg/c3d/btk_PiG_Motion-FlatFoot-Full.c3d")
    names = [c.name for c in inspect(path)[1]]
    assert names[-6:] == [f"plate {plate} {axis}" for plate in (1, 2) for axis in ("Fx", "Fy", "Fz")]
    plates = ezc3d.c3d(str(path), extract_forceplat_data=True)["data"]["platform"]
    recording = read(path, ["R_TA", "plate 1 Fz", "plate 2 Fx", "Fz1"])
    np.testing.assert_array_equal(recording.channel("plate 1 Fz").samples, plates[0]["force"][2])
    np.testing.assert_array_equal(recording.channel("plate 2 Fx").samples, plates[1]["force"][0])
    assert recording.channel("plate 1 Fz").samples.max() == pytest.approx(482.527, abs=1e-3)
    assert recording.channel("Fz1").samples.min() == pytest.approx(-482.527, abs=1e-3)  # the plate's own sign
    assert [(c.unit, c.fs_hz, c.samples.size, c.start_s) for c in recording.channels] == [
        (unit, 1000.0, 3150, pytest.approx(1.47)) for unit in ("V", "N", "N", "N")
    ]


def test_millivolts_of_a_real_file(shared_data) -> None:
    import ezc3d

    path = shared_data("emg/c3d/btk_1123x01EMG.c3d")
    channel = read(path, ["Right Tibialis Anterior"]).channels[0]
    stored = ezc3d.c3d(str(path))["data"]["analogs"][0, 2]
    np.testing.assert_allclose(channel.samples, stored * 1e-3, rtol=1e-15)
    assert channel.conversion == "mV x 0.001 = V"


def test_long_descriptions_of_kinarm_are_shortened_for_ezc3d(shared_data, tmp_path: Path) -> None:
    path = shared_data("emg/c3d/btk_BKINtechnologies.c3d")  # as it is, ezc3d takes gigabytes and does not end
    channels = inspect(path)[1]
    assert len(channels) == 20
    assert {(channel.fs_hz, channel.n_samples) for channel in channels} == {(1000.0, 5065)}
    angle, torque = read(path, ["Right_L1Ang", "a1_M1TorMSRD"]).channels
    stored = np.frombuffer(path.read_bytes()[31 * 512 :], "<f4").reshape(5065, 2 * 4 + 20)  # two points before them
    np.testing.assert_allclose(angle.samples, stored[:, 8 + 1], rtol=1e-6)
    np.testing.assert_allclose(torque.samples, stored[:, 8 + 16], rtol=1e-6)


def test_a_description_longer_than_its_parameter_is_refused_at_once(shared_data, tmp_path: Path) -> None:
    content = bytearray(shared_data("emg/c3d/btk_BKINtechnologies.c3d").read_bytes())
    content[content.index(b"\xa3Session identification numbers")] += 1
    (tmp_path / "damaged.c3d").write_bytes(content)
    with pytest.raises(RecordingError, match=r"lengths fit together, but found damage near byte 46\d\d"):
        inspect(tmp_path / "damaged.c3d")


def test_a_file_that_ezc3d_refuses(shared_data) -> None:
    with pytest.raises(RecordingError, match=r"a file that ezc3d refuses .The format is not standard"):
        inspect(shared_data("emg/c3d/btk_badParameterOffset.c3d"))
