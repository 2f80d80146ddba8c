"""Camera files."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from casr.camera import Camera, Sensor
from casr.errors import CameraError
from casr.frame_files import read_camera, write_camera

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
        ),
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
