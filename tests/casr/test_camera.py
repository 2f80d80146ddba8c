"""From pixels to millimetres, by hand and against OpenCV's projection."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from casr.camera import Camera, Sensor
from casr.errors import CameraError

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


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("width_px", 0),
        ("width_px", 300.0),
        ("height_px", True),
        ("fx_px", -1.0),
        ("fy_px", "300"),
        ("cx_px", float("nan")),
        ("depth_mm", 0.0),
        ("frame_rate_hz", float("inf")),
        ("distortion", (0.1,)),
        ("distortion", (0.1, 0.2, "x", 0.0)),
        ("distortion", 0.1),
        ("distortion", "0000"),
        ("distortion", (0.1, 0.2, float("nan"), 0.0)),
    ],
)
def test_what_makes_no_camera_is_refused_by_name(key, value):
    with pytest.raises(CameraError, match=f"camera.{key}: expected"):
        Camera(**{key: value})


def test_what_is_known_of_the_sensor_is_all_optional():
    assert Camera().sensor == Sensor()
    assert Sensor().known() == {}
    sensor = Sensor(pin_length_mm=np.float32(1.5), dome_radius_mm=20)
    assert sensor.known() == {"pin_length_mm": 1.5, "dome_radius_mm": 20.0}
    assert {type(value) for value in sensor.known().values()} == {float}
    assert hash(Camera(sensor=sensor)) == hash(Camera(sensor=Sensor(pin_length_mm=1.5, dome_radius_mm=20.0)))


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("pin_length_mm", 0.0),
        ("pin_length_mm", "1.5"),
        ("dome_radius_mm", -20.0),
        ("dome_radius_mm", float("inf")),
        ("pin_length_mm", True),
        ("dome_radius_mm", 0),
        ("dome_radius_mm", float("nan")),
        ("pin_length_mm", (1.0,)),
    ],
)
def test_what_makes_no_sensor_is_refused_by_name(key, value):
    with pytest.raises(CameraError, match=f"sensor.{key}: expected"):
        Sensor(**{key: value})


def test_a_camera_takes_no_table_for_a_sensor():
    with pytest.raises(CameraError, match=r"camera.sensor: expected a Sensor, but found \{'pin_length_mm': 1.5\}"):
        Camera(sensor={"pin_length_mm": 1.5})
