"""Six gauge voltages and a .cal file give the force."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import DeviceError, RecordingError
from emg2vsa.extraction.remedies import remedy_of
from emg2vsa.readers.roles import read_roles
from emg2vsa.settings import ChannelSettings, EmgChannelSettings, ForceChannelSettings

GAUGES = ("G0", "G1", "G2", "G3", "G4", "G5")
RNG = np.random.default_rng(5)
MATRIX = RNG.normal(0, 10, (6, 6))
VOLTS = RNG.normal(0, 1, (200, 6))


def calibration(path: Path) -> Path:
    rows = "".join(
        f'<UserAxis Name="{name}" values="{" ".join(f"{v:.9f}" for v in row)}" max="1"/>'
        for name, row in zip(("Fx", "Fy", "Fz", "Tx", "Ty", "Tz"), MATRIX, strict=True)
    )
    path.write_text(
        '<FTSensor Serial="FT1" NumGages="6"><Calibration ForceUnits="N" TorqueUnits="N-m" OutputRange="20" '
        f'OutputBipolar="True">{rows}</Calibration></FTSensor>'
    )
    return path


def recording(path: Path, volts: np.ndarray = VOLTS, unit: str = "V") -> Path:
    head = "time (s),EDC (mV)," + ",".join(f"{name} ({unit})" if unit else name for name in GAUGES)
    rows = [f"{i / 1000},{i % 7}," + ",".join(f"{v:.9f}" for v in row) for i, row in enumerate(volts)]
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def channels(**force: object) -> ChannelSettings:
    settings = ForceChannelSettings(**{"name": "Fz", "cal_file": "a.cal", "gauges": GAUGES, **force})  # type: ignore[arg-type]
    return ChannelSettings(emg={"EDC": EmgChannelSettings(name="EDC")}, force=settings)


@pytest.mark.parametrize(
    ("unit", "scale", "force"), [("V", 1.0, {}), ("mV", 1e3, {}), ("", 1000.0, {"volts_per_unit": 1e-3})]
)
def test_the_axis_is_the_matrix_times_the_gauges(tmp_path: Path, unit: str, scale: float, force: dict) -> None:
    cal, file = calibration(tmp_path / "a.cal"), recording(tmp_path / "r.csv", VOLTS * scale, unit)
    found = read_roles(file, None, channels(name="Fy", sign=-1, **force), cal_file=cal)
    np.testing.assert_allclose(found.force.samples, -(VOLTS @ MATRIX[1]), atol=1e-6)
    assert found.force.conversion == "six gauges x Fy of a.cal (serial FT1) = N; sign reversed"
    assert found.force.unit == "N"


def test_a_gauge_at_the_end_of_its_range_is_said(tmp_path: Path) -> None:
    volts = VOLTS.copy()
    volts[3:5, 2] = 10.0, 9.9951  # the last codes of a 16-bit and a 12-bit converter
    found = read_roles(recording(tmp_path / "r.csv", volts), None, channels(), cal_file=calibration(tmp_path / "a.cal"))
    assert "gauge G2: 2 samples at the end of its range (-10 to 10 V)" in "; ".join(found.notes)
    assert any(remedy_of(note).startswith("use a larger range") for note in found.notes)
    assert found.force.overloaded is not None
    assert np.flatnonzero(found.force.overloaded).tolist() == [3, 4]


def test_gauges_of_no_unit_and_missing_files_are_refused(tmp_path: Path) -> None:
    cal = calibration(tmp_path / "a.cal")
    file = recording(tmp_path / "r.csv", unit="")
    with pytest.raises(RecordingError, match="channel 'G0': expected a gauge in V or mV, but found no unit"):
        read_roles(file, None, channels(), cal_file=cal)
    with pytest.raises(RecordingError, match=r"expected the transducer's .cal file, but found none"):
        read_roles(file, None, channels())
    with pytest.raises(DeviceError, match="a calibration file"):
        read_roles(recording(tmp_path / "r.csv"), None, channels(), cal_file=tmp_path / "none.cal")
