"""From pixels to millimetres, by hand and against OpenCV's projection; camera files."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from casr.camera import Camera, Sensor
from casr.errors import CameraError
from casr.frame_files import read_camera, write_camera

# a real pin camera of this kind (DigiTac v1.5), as published with its distortion
DIGITAC = Camera(
    width_px=640,
    height_px=480,
    fx_px=323.379,
    fy_px=342.300,
    cx_px=310.423,
    cy_px=247.103,
    depth_mm=22.0,
    distortion=(0.02626, -0.00521, -0.00257, -0.00089, -0.01473),
)


def test_equation_5_by_hand():
    camera = Camera(fx_px=300.0, fy_px=250.0, cx_px=100.0, cy_px=50.0, depth_mm=50.0)
    assert camera.mm_per_px == (50 / 300, 0.2)
    assert camera.mm2_per_px2 == pytest.approx(1 / 30, rel=1e-15)


def test_the_paper_s_hexagon_in_mm():
    # eqs (3) to (5): a = r cos 30 deg along y, l = 2 r sin 30 deg along x, area 3 l a
    camera, radius_px = Camera(fx_px=300.0, fy_px=250.0), 10.0
    x_mm, y_mm = camera.mm_per_px
    area_mm2 = 3 * (2 * radius_px * np.sin(np.pi / 6) * x_mm) * (radius_px * np.cos(np.pi / 6) * y_mm)
    corners = radius_px * np.exp(1j * np.arange(6) * np.pi / 3)
    x, y = corners.real * x_mm, corners.imag * y_mm
    assert abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2 == pytest.approx(area_mm2, rel=1e-12)


def test_undistortion_undoes_opencv_s_projection():
    x, y = np.meshgrid(np.linspace(-9.5, 9.5, 12), np.linspace(-7.5, 7.5, 12))
    points_mm = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, DIGITAC.depth_mm)])
    seen, _ = cv2.projectPoints(points_mm, np.zeros(3), np.zeros(3), DIGITAC.matrix, np.array(DIGITAC.distortion))
    seen_px = seen[:, 0, :]
    straight_px = DIGITAC.undistorted_px(seen_px)
    assert np.abs(seen_px - straight_px).max() > 0.3
    straight_mm = (straight_px - (DIGITAC.cx_px, DIGITAC.cy_px)) * DIGITAC.mm_per_px
    np.testing.assert_allclose(straight_mm, points_mm[:, :2], atol=1e-7)


def test_a_lost_pin_stays_lost_and_spoils_no_other():
    points_px = np.array([[10.0, 20.0], [np.nan, np.nan], [300.0, 200.0]])
    straight_px = DIGITAC.undistorted_px(points_px)
    assert np.isnan(straight_px[1]).all()
    np.testing.assert_array_equal(straight_px[[0, 2]], DIGITAC.undistorted_px(points_px[[0, 2]]))


def test_without_distortion_points_stay_where_they_are():
    points_px = np.array([[1.0, 2.0]])
    np.testing.assert_array_equal(Camera().undistorted_px(points_px), points_px)
    assert DIGITAC.undistorted_px(np.empty((0, 2))).shape == (0, 2)


def test_numbers_of_numpy_become_plain_ones():
    camera = Camera(width_px=np.int64(300), fx_px=np.float32(300), depth_mm=50, distortion=np.zeros(5))
    assert camera == Camera(distortion=(0.0,) * 5)
    assert hash(camera) == hash(Camera(distortion=(0.0,) * 5))
    assert type(camera.depth_mm) is float


def test_what_is_known_of_the_sensor_is_all_optional():
    assert Camera().sensor == Sensor()
    assert Sensor().known() == {}
    sensor = Sensor(pin_length_mm=np.float32(1.5), dome_radius_mm=20)
    assert sensor.known() == {"pin_length_mm": 1.5, "dome_radius_mm": 20.0}
    assert {type(value) for value in sensor.known().values()} == {float}
    assert hash(Camera(sensor=sensor)) == hash(Camera(sensor=Sensor(pin_length_mm=1.5, dome_radius_mm=20.0)))


REQUIRED = """[camera]
width_px = 640
height_px = 480
fx_px = 323.379
fy_px = 342.3
cx_px = 310.423
cy_px = 247.103
depth_mm = 22
"""
ABOVE_ZERO = st.floats(1e-300, 1e300)
ANY = st.floats(allow_nan=False, allow_infinity=False)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.builds(
        Camera,
        width_px=st.integers(1, 10**6),
        height_px=st.integers(1, 10**6),
        fx_px=ABOVE_ZERO,
        fy_px=ABOVE_ZERO,
        cx_px=ANY,
        cy_px=ANY,
        depth_mm=ABOVE_ZERO,
        distortion=st.sampled_from([0, 4, 5, 8]).flatmap(lambda n: st.tuples(*[ANY] * n)),
        frame_rate_hz=ABOVE_ZERO,
        sensor=st.builds(
            Sensor,
            pin_length_mm=st.none() | ABOVE_ZERO,
            dome_radius_mm=st.none() | ABOVE_ZERO,
            pin_length_sd_mm=st.none() | ABOVE_ZERO,
        ),
        depth_sd_mm=st.none() | ABOVE_ZERO,
    )
)
def test_what_is_written_is_read_back_exactly(tmp_path, camera):
    write_camera(tmp_path / "camera.toml", camera)
    assert read_camera(tmp_path / "camera.toml") == camera


def test_distortion_and_frame_rate_may_be_left_out(tmp_path):
    (tmp_path / "camera.toml").write_text(REQUIRED + "\n[rig]\nname = 'two'\n")
    camera = read_camera(tmp_path / "camera.toml")
    assert camera == Camera(640, 480, 323.379, 342.3, 310.423, 247.103, 22.0)


def test_what_is_known_of_the_sensor_is_read(tmp_path):
    (tmp_path / "camera.toml").write_text(REQUIRED + "[sensor]\npin_length_mm = 2\ndome_radius_mm = 20.0\n")
    assert read_camera(tmp_path / "camera.toml").sensor == Sensor(pin_length_mm=2.0, dome_radius_mm=20.0)


def test_a_table_sensor_is_written_only_when_something_is_known():
    assert "sensor" not in Camera().to_toml()
    assert Camera(sensor=Sensor(pin_length_mm=1.0)).to_toml().endswith("\n\n[sensor]\npin_length_mm = 1.0\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (REQUIRED + "depht_mm = 2.0\n", r"\[camera\] depht_mm: .* Did you mean depth_mm\?"),
        (REQUIRED + "serial = 2\n", r"found the unknown key serial. Remove it"),
        (REQUIRED.replace("fx_px", "fx"), r"found the unknown key fx. Did you mean fx_px\?"),
        (REQUIRED.replace("depth_mm = 22", ""), r"expected the keys depth_mm, "),
        (REQUIRED.replace("22", "'22'"), r"camera.toml, camera.depth_mm: expected a number above 0, but found '22'"),
        (REQUIRED.replace("640", "640.0"), r"camera.width_px: expected a whole number above 0, but found 640.0"),
        (REQUIRED.replace("22", "true"), r"camera.depth_mm: .* found True"),
        (REQUIRED + "distortion = [0.1]\n", r"camera.distortion: expected no or 4, 5"),
        (REQUIRED + "distortion = 'none'\n", r"camera.distortion: .* found 'none'"),
        (REQUIRED + "sensor = 2\n", r"\[camera\] sensor: .* found the unknown key sensor"),
        ("sensor = 2\n" + REQUIRED, r"expected a table \[sensor\], but found sensor = 2"),
        (REQUIRED + "depth_sd_mm = 0\n", r"camera.toml, camera.depth_sd_mm: expected a number above 0, but found 0"),
        (REQUIRED + "[sensor]\npin_length_sd_mm = 'small'\n", r"sensor.pin_length_sd_mm: .* found 'small'"),
        (REQUIRED + "[sensor]\npin_length = 2\n", r"\[sensor\] pin_length: .* Did you mean pin_length_mm\?"),
        (REQUIRED + "[sensor]\npin_length_mm = 0\n", r"camera.toml, sensor.pin_length_mm: expected a number above 0"),
        (
            REQUIRED + "[sensor]\ndome_radius_mm = nan\n",
            r"sensor.dome_radius_mm: expected a number above 0, but "
            r"found nan",
        ),
        (REQUIRED.replace("[camera]\n", ""), r"expected a table \[camera\], but found the keys width_px"),
        ("camera = 3\n", r"expected a table \[camera\]"),
        ("", r"found no keys"),
        ("[camera\n", r"expected a TOML file"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, text, message):
    (tmp_path / "camera.toml").write_text(text)
    with pytest.raises(CameraError, match=message):
        read_camera(tmp_path / "camera.toml")


def test_a_camera_file_that_is_not_there(tmp_path):
    with pytest.raises(CameraError, match="No such file"):
        read_camera(tmp_path / "camera.toml")
