"""A sensor identified from presses of known specimens, the dome left out of the tables."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.kappa import CAMERA
from benchmarks.sensor import WORLDS, Sensor, errors, sensor
from casr.dome.library import MODULI_MPA
from casr.dome.solver.sensor_file import read_sensor
from casr.errors import SettingError
from casr.frame_files import read_camera
from casr.kappa.posterior import CONTRADICTED
from casr.kappa.sensor import QUANTITIES, IdentifiedSensor, identify_sensor


@pytest.fixture(scope="module")
def made() -> Sensor:
    return sensor(WORLDS[4], seed=1)


@pytest.fixture(scope="module")
def found(made: Sensor) -> IdentifiedSensor:
    return identify_sensor(made.presses, CAMERA, library=made.library)


def test_a_sensor_is_found_within_its_standard_errors(made: Sensor, found: IdentifiedSensor) -> None:
    assert (np.abs(errors(found, made.true)) < 2.5).all()
    assert tuple(found.quantities) == QUANTITIES
    assert all(each.told for each in found.quantities.values())
    x, y, pin, depth, *_ = found.quantities.values()
    assert max(x.sd, y.sd) < 0.35  # a pull along the surface moves pins much as another pole does
    assert pin.sd < 0.06
    assert depth.sd < 0.5
    assert (x.stated, pin.stated, depth.stated) == (149.5, 3.0, 50.0)


def test_less_of_the_motion_is_left_over_than_before(found: IdentifiedSensor) -> None:
    assert found.misfit < 0.5 * found.misfit_before
    assert found.fits
    assert found.dome == "H and D"
    assert found.notes == ()


def test_specimens_that_are_mixed_up_are_told_and_tell_no_sensor(made: Sensor, found: IdentifiedSensor) -> None:
    stated = sorted({each.stiffness_n_per_mm or np.inf for each in made.presses})
    other = dict(zip(stated, reversed(stated), strict=True))
    swapped = [replace(each, stiffness_n_per_mm=other[each.stiffness_n_per_mm or np.inf]) for each in made.presses]
    wrong = identify_sensor(swapped, CAMERA, library=made.library)
    assert found.contradicted < 1.6 < CONTRADICTED < wrong.contradicted
    assert not any(each.told for each in wrong.quantities.values())
    assert "so the sensor is not determined: check which specimen each press is of" in wrong.notes[0]
    assert any("N/mm as the other specimens tell it" in note for note in wrong.notes)


def test_the_file_is_one_of_a_camera_and_one_for_casr_dome(found: IdentifiedSensor, tmp_path: Path) -> None:
    file = tmp_path / "sensor.toml"
    file.write_text(found.to_toml(), encoding="utf-8")
    camera = read_camera(file)
    assert camera == found.camera
    quantities = found.quantities
    assert camera.cx_px == pytest.approx(quantities["pole_x_px"].value, rel=1e-4)
    assert camera.sensor.pin_length_sd_mm == pytest.approx(quantities["pin_length_mm"].sd, rel=0.05)
    assert camera.depth_sd_mm == pytest.approx(quantities["depth_mm"].sd, rel=0.05)
    dome = read_sensor(file)[0].pressing.dome
    assert dome.gel.modulus_mpa == pytest.approx(quantities["gel_modulus_mpa"].value, rel=0.01)
    assert (dome.radius_mm, dome.skin_mm) == (20.0, 1.0)


def test_the_pole_of_a_calibrated_lens_stays(made: Sensor) -> None:
    camera = replace(CAMERA, distortion=(1e-9, 0.0, 0.0, 0.0))
    found = identify_sensor(made.presses[:2], camera)
    assert found.camera.cx_px == CAMERA.cx_px
    assert abs(found.quantities["pole_x_px"].value - CAMERA.cx_px) > 1
    assert any("cx_px and cy_px stay" in note for note in found.notes)


def test_a_plate_without_forces_does_not_tell_moduli() -> None:
    made = sensor(WORLDS[1], seed=0, known=(np.inf,))
    found = identify_sensor([replace(each, force_n=None) for each in made.presses], CAMERA, library=made.library)
    assert [name for name, each in found.quantities.items() if not each.told] == ["skin_modulus_mpa", "gel_modulus_mpa"]
    assert found.quantities["skin_modulus_mpa"].sd > 0.9 * found.quantities["skin_modulus_mpa"].prior_sd
    assert any("do not tell skin_modulus_mpa, gel_modulus_mpa" in note for note in found.notes)
    assert any("rigid plate" in note for note in found.notes)


def test_what_camera_toml_states_with_a_small_error_stays(made: Sensor) -> None:
    pin_mm, depth_mm = made.true["pin_length_mm"], made.true["depth_mm"]
    sharp = replace(CAMERA.sensor, pin_length_mm=pin_mm, pin_length_sd_mm=0.001)
    camera = replace(CAMERA, depth_mm=depth_mm, depth_sd_mm=0.01, sensor=sharp)
    found = identify_sensor(made.presses[:2], camera, library=made.library)
    assert found.quantities["pin_length_mm"].value == pytest.approx(pin_mm, abs=0.003)
    assert found.quantities["pin_length_mm"].sd == pytest.approx(0.001, rel=0.01)
    assert not found.quantities["pin_length_mm"].told


def test_a_larger_dome_of_the_same_rubber_has_the_same_moduli(made: Sensor, found: IdentifiedSensor) -> None:
    larger = 1.25
    sensor_of = replace(CAMERA.sensor, pin_length_mm=3.0 * larger, dome_radius_mm=20.0 * larger)
    presses = [
        replace(each, force_n=each.force_n * larger**2, stiffness_n_per_mm=each.stiffness_n_per_mm * larger)
        for each in made.presses
        if each.force_n is not None and each.stiffness_n_per_mm is not None
    ]
    camera = replace(CAMERA, depth_mm=CAMERA.depth_mm * larger, sensor=sensor_of)
    # its errors are stated as large, for its length
    camera = replace(camera, sensor=replace(sensor_of, pin_length_sd_mm=0.4 * larger))
    other = identify_sensor(presses, camera, library=made.library)
    for name, each in other.quantities.items():
        factor = larger if name in ("pin_length_mm", "depth_mm") else 1.0
        if not name.startswith("pole"):
            assert each.value == pytest.approx(factor * found.quantities[name].value, rel=0.03), name
    assert other.skin_mm == pytest.approx(larger)


def test_tables_of_another_kind_of_dome_do_not_fit(made: Sensor) -> None:
    soft = made.library.only(np.flatnonzero(np.isin(made.library.dome, ("I", "G"))))
    found = identify_sensor(made.presses[:2] + made.presses[-2:], CAMERA, library=soft)
    assert not found.fits
    assert found.quantities["pin_length_mm"].sd > 0.5 * found.quantities["pin_length_mm"].prior_sd
    assert any("casr dome FILE" in note for note in found.notes)


def test_a_dome_of_a_labs_own_is_picked_where_it_fits_best(made: Sensor) -> None:
    of_another = sensor(WORLDS[2], seed=1)
    library = made.library.only(np.flatnonzero(np.isin(made.library.dome, ("C", "J", "E"))))
    library = replace(library, dome=np.where(library.dome == "E", "mine", library.dome))
    skin, gel = MODULI_MPA["E"]
    found = identify_sensor(of_another.presses[:3], CAMERA, library=library, own_domes={"mine": (1.2, skin, gel)})
    assert (found.dome, found.skin_mm) == ("mine", 1.2)
    assert found.quantities["skin_modulus_mpa"].value == pytest.approx(skin, rel=0.15)
    assert found.quantities["gel_over_skin"].value == pytest.approx(gel / skin)
    assert not found.quantities["gel_over_skin"].told
    assert "radius_mm = 20.2\n" in found.to_toml()  # outside a skin of 1.2 mm on the 19 mm on which pins stand
    unknown = identify_sensor(of_another.presses[:3], CAMERA, library=library)
    assert "skin_modulus_mpa" not in unknown.quantities
    assert "[dome]" not in unknown.to_toml()


def test_without_a_known_specimen_there_is_no_sensor(made: Sensor) -> None:
    with pytest.raises(SettingError, match="a known specimen, or a rigid plate"):
        identify_sensor([replace(each, stiffness_n_per_mm=None) for each in made.presses], CAMERA)
    with pytest.raises(SettingError, match="one press"):
        identify_sensor([], CAMERA)
