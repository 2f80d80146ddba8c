"""Calibration files of ATI's DAQ transducers."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.ati import AXES, read_calibration
from emg2vsa.errors import DeviceError

# Two gauges of a Mini40 (SI-20-1, serial FT35366, published in NavidFeizi/ATI-FTsensor_NI-DAQ): Axis values, their
# scales, and the UserAxis values the same file gives for them.
AXIS = {
    "Fx": (0.29841, 31.42187),
    "Fy": (2.36988, 17.78588),
    "Fz": (18.38476, 1.10074),
    "Tx": (-0.41089, 2.09563),
    "Ty": (-37.04259, 0.87181),
    "Tz": (1.20197, -17.90391),
}
SCALE = {
    "Fx": 10.4365218978557,
    "Fy": 10.4365218978557,
    "Fz": 3.54463927320744,
    "Tx": 435.036051032724,
    "Ty": 435.036051032724,
    "Tz": 435.339135601372,
}
USER = {
    "Fx": (0.02859, 3.01076),
    "Fy": (0.22708, 1.70420),
    "Fz": (5.18664, 0.31054),
    "Tx": (0.00027, 0.01395),
    "Ty": (-0.08530, -0.01413),
    "Tz": (0.00276, -0.04113),
}
TRANSFORM = {"Dx": "0", "Dy": "0", "Dz": "0.0053594", "Rx": "0", "Ry": "0", "Rz": "0"}
UNITS = {"ForceUnits": "N", "TorqueUnits": "N-m", "DistUnits": "m", "OutputRange": "20", "OutputBipolar": "True"}


def written(path, *, user=USER, axis=AXIS, transform=TRANSFORM, gauges="6", **changes):
    """A calibration file of the published form."""

    def row(tag, name, values, more=""):
        padded = " ".join(f"{value:9.5f}" for value in (*values, 0, 0, 0, 0))
        return f'<{tag} Name="{name}" values="{padded} " max="{20 if name[0] == "F" else 1}"{more}/>'

    attributes = " ".join(f'{key}="{value}"' for key, value in (UNITS | changes).items() if value is not None)
    rows = [row("Axis", name, axis[name], f' scale="{SCALE[name]}"') for name in axis]
    rows.append("<BasicTransform " + " ".join(f'{key}="{value}"' for key, value in transform.items()) + "/>")
    rows += [row("UserAxis", name, user[name]) for name in user]
    path.write_text(
        f'<?xml version="1.0" encoding="utf-8"?>\n<!-- a comment -->\n<FTSensor  Serial="FT35366" BodyStyle="Mini40" '
        f'Family="DAQ" NumGages="{gauges}" CalFileVersion="1.1">\n<Calibration PartNumber="SI-20-1" {attributes}>\n'
        + "\n".join(rows)
        + "\n</Calibration></FTSensor>\n"
    )
    return path


def test_a_file_of_version_1_1(tmp_path):
    calibration = read_calibration(written(tmp_path / "ft.cal"))
    np.testing.assert_array_equal(calibration.wrench_per_volt[:, :2], [USER[name] for name in AXES])
    assert calibration.serial == "FT35366"
    assert calibration.range_v == (-10, 10)


def test_a_file_of_version_1_0_gives_the_same_matrix(tmp_path):
    matrix = read_calibration(written(tmp_path / "ft.cal", user={})).wrench_per_volt
    np.testing.assert_allclose(matrix[:, :2], [USER[name] for name in AXES], atol=6e-6)


def test_units_are_read_not_assumed(tmp_path):
    files = {
        "mm": {"TorqueUnits": "N-mm"},
        "lbf": {"ForceUnits": "lbf", "TorqueUnits": "lbf-in"},
    }
    read = {name: read_calibration(written(tmp_path / name, **changes)) for name, changes in files.items()}
    newton = read_calibration(written(tmp_path / "newton")).wrench_per_volt
    np.testing.assert_allclose(read["mm"].wrench_per_volt[3:], newton[3:] * 1e-3)
    np.testing.assert_allclose(read["lbf"].wrench_per_volt[:3], newton[:3] * 4.4482216152605)
    np.testing.assert_allclose(read["lbf"].wrench_per_volt[3:], newton[3:] * 0.1129848290276167)


def test_a_transform_in_millimetres(tmp_path):
    millimetres = written(tmp_path / "mm.cal", user={}, transform=TRANSFORM | {"Dz": "5.3594"}, DistUnits="mm")
    metres = written(tmp_path / "m.cal", user={})
    np.testing.assert_allclose(
        read_calibration(millimetres).wrench_per_volt, read_calibration(metres).wrench_per_volt, atol=1e-12
    )


def test_a_transform_along_x_turns_fz_into_ty(tmp_path):
    moved = written(tmp_path / "x.cal", user={}, transform=TRANSFORM | {"Dx": "0.1", "Dz": "0"})
    matrix = read_calibration(moved).wrench_per_volt
    straight = np.array([AXIS["Ty"], AXIS["Tz"]]) / [[SCALE["Ty"]], [SCALE["Tz"]]]
    # T - D x F with D along x: Ty gains Dx Fz, Tz loses Dx Fy
    np.testing.assert_allclose(matrix[4, :2], straight[0] + 0.1 * matrix[2, :2])
    np.testing.assert_allclose(matrix[5, :2], straight[1] - 0.1 * matrix[1, :2])


def test_unipolar_outputs(tmp_path):
    file = written(tmp_path / "ft.cal", OutputBipolar="False", OutputRange="5")
    assert read_calibration(file).range_v == (0, 5)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"ForceUnits": None}, "ForceUnits"),
        ({"TorqueUnits": "stone-m"}, "stone-m"),
        ({"OutputRange": "wide"}, "OutputRange"),
        ({"gauges": "8"}, "six gauges"),
        ({"user": {name: USER[name] for name in AXES if name != "Tz"}}, "UserAxis Tz"),
        ({"user": USER | {"Fy": (1.0, float("nan"))}}, "UserAxis Fy values"),
        ({"user": USER | {"Fy": (1.0,)}}, "six numbers"),
        ({"user": {}, "transform": TRANSFORM | {"Rz": "30"}}, "no rotation"),
    ],
)
def test_files_that_make_no_sense(tmp_path, changes, named):
    with pytest.raises(DeviceError, match=named):
        read_calibration(written(tmp_path / "ft.cal", **changes))


@pytest.mark.parametrize(("text", "named"), [("<FTSensor", "a .cal file"), ("<Other/>", "Other")])
def test_other_files(tmp_path, text, named):
    (tmp_path / "ft.cal").write_text(text)
    with pytest.raises(DeviceError, match=named):
        read_calibration(tmp_path / "ft.cal")


def test_no_file(tmp_path):
    with pytest.raises(DeviceError, match="Check the path"):
        read_calibration(tmp_path / "none.cal")
