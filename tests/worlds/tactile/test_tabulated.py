"""The world of finite elements against the whole tables, and what it refuses."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from casr.camera import Camera, Sensor
from casr.contact_area.follow import contact_front
from casr.dome.library import DEFAULT_WORLD, SHIPPED, shipped, worlds
from casr.dome.tables import read_table
from casr.errors import SettingError
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.press_draws import PressDraws
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.tactile import PressSettings, Scene, TabulatedWorld, simulate_press

FORCES_N = np.array([0.3, 0.5, 1.0, 2.0, 3.0, 4.5])
CASES = [(1.1, "stick"), (5.3, "stick"), (20.0, "stick"), (1.1, "frictionless"), (5.3, "frictionless")]


def scene(world: TabulatedWorld | None = None, **settings: float) -> Scene:
    return Scene(PressSettings(world=world or TabulatedWorld(), **{"centre_sd_mm": 0.0, **settings}))  # type: ignore[arg-type]


@pytest.mark.parametrize(("kappa", "friction"), CASES)
def test_radius_and_pins_are_those_of_another_program(
    kappa: float, friction: str, shared_data: Callable[[str], Path]
) -> None:
    table = read_table(shared_data(f"contact_fem/A_k{kappa:g}_{friction}.npz"))
    seen = scene(TabulatedWorld(friction=friction), stiffness_n_per_mm=kappa)
    steps = [int(np.argmin(np.abs(table.force_n - force))) for force in FORCES_N]
    found = seen.settings.world.radius_mm(table.force_n[steps], kappa)
    np.testing.assert_allclose(found, table.contact_radius_mm[steps], rtol=0.02)
    # pins as levers on the skin of 19 mm, seen by a pinhole whose distance is that to the tip of the pin at the pole
    camera, length_mm, inner_mm = seen.settings.camera, 3.0, 19.0
    angle = np.deg2rad(np.arange(0.0, 45.0, 1.5))
    behind_mm = camera.depth_mm - (inner_mm - length_mm)

    def px(r: np.ndarray, z: np.ndarray) -> np.ndarray:
        return camera.fx_px * r / (behind_mm + z)

    tip_mm = inner_mm - length_mm
    rest = np.column_stack(
        [camera.cx_px + px(tip_mm * np.sin(angle), tip_mm * np.cos(angle)), 0 * angle + camera.cy_px]
    )
    for step in steps:
        u_r, u_z, tilt = (np.interp(inner_mm * angle, table.s_mm, table.motion[step, :, k]) for k in range(3))
        r = inner_mm * np.sin(angle) + u_r - length_mm * np.sin(angle - tilt)
        z = inner_mm * np.cos(angle) + u_z - length_mm * np.cos(angle - tilt)
        moved = seen.skin.moved_px(rest, seen.skin.state(float(table.force_n[step])))
        np.testing.assert_allclose(moved[:, 0], camera.cx_px + px(r, z), rtol=0, atol=0.1)
        np.testing.assert_allclose(moved[:, 1], camera.cy_px, rtol=0, atol=1e-9)


@pytest.mark.parametrize("friction", ["stick", "frictionless"])
def test_contacts_grow_with_force_and_with_softness(friction: str) -> None:
    world = TabulatedWorld(friction=friction)
    force = np.geomspace(0.01, 7.0, 60)
    radii = np.array([world.radius_mm(force, kappa) for kappa in (1.0, 1.11, 2.0, 3.35, 5.32, 7.63, 20.0, 200.0)])
    assert (np.diff(radii, axis=1) > 0).all()
    assert (np.diff(radii, axis=0) < 0).all()
    assert world.radius_mm(0.0, 3.35) == 0
    # below the first table along the power law of the first two
    least_n = float(world.solution(3.35)[0][0])
    shares = world.radius_mm(np.array([least_n / 100, least_n / 10, least_n]), 3.35)
    assert shares[0] / shares[1] == pytest.approx(shares[1] / shares[2], rel=1e-9)
    assert math.isnan(world.radius_mm(np.array([np.nan]), 3.35)[0])


def test_pins_move_without_jumps_and_rest_at_no_force() -> None:
    seen = scene(angle_deg=30.0)
    force = np.concatenate([[0.0], np.geomspace(1e-6, 7, 300)])
    steps = np.diff([seen.pins_px(each) for each in force.tolist()], axis=0)
    assert np.abs(steps).max() < 1.0
    np.testing.assert_array_equal(seen.pins_px(-0.1), seen.rest_px)


def test_a_tilt_turns_the_same_field_about_the_centre() -> None:
    flat, tilted = scene(), scene(angle_deg=30.0)
    assert tilted.area_mm2(2.0) == pytest.approx(flat.area_mm2(2.0), rel=1e-12)
    middle_mm = (tilted.contact(2.0).centre_px[0] - 149.5) / 6
    assert middle_mm == pytest.approx(16 * np.sin(np.deg2rad(30)), rel=0.1)


def test_the_first_skin_hardly_stretches_while_the_contact_grows() -> None:
    truth = simulate_press(PressSettings(stiffness_n_per_mm=5.32)).truth
    assert truth.log_growth.sum() > np.log(3.5)
    assert 0 < truth.skin_log_growth.sum() < 0.2
    assert truth.world == "tabulated, stick"
    assert any("turned about the dome's centre" in each for each in truth.assumptions)
    assert any("above 5 N" in each for each in truth.assumptions)


def test_a_softer_specimen_than_the_tables_know_is_refused() -> None:
    assert TabulatedWorld().radius_mm(1.0, 0.89) > 0
    with pytest.raises(SettingError, match=r"0\.88 N/mm or more"):
        scene(stiffness_n_per_mm=0.85)


def test_another_dome_is_pressed_by_its_name_and_a_labs_own_by_its_folder(shared_data: Callable[[str], Path]) -> None:
    soft, stiff = (TabulatedWorld(dome=dome, tables=SHIPPED).radius_mm(2.0, 3.35) for dome in ("C", "G"))
    assert soft > stiff
    full = TabulatedWorld(tables=str(shared_data("contact_fem")))
    assert full.radius_mm(2.0, 3.35) == pytest.approx(TabulatedWorld().radius_mm(2.0, 3.35), rel=0.005)


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Tables of a dome on specimens of 8 and 16 mm: dome A, whose contacts need 1.3 and 1.1 times the force."""
    folder, library = tmp_path_factory.mktemp("own"), shipped(DEFAULT_WORLD)
    for height_mm, force in ((8.0, 1.3), (16.0, 1.1)):
        for kappa in (1.1, 5.3):
            of_kappa = library.stiffness_n_per_mm == kappa
            (row,) = np.flatnonzero(of_kappa & (library.friction == "stick"))
            motion = library.motion[row].astype(np.float64)
            np.savez(
                folder / f"own_k{kappa:g}_h{height_mm:g}_stick.npz", force_n=force * library.force_n[row],
                contact_radius_mm=library.radius_mm, edge_arc_mm=library.edge_arc_mm[row], s_mm=library.arc_mm,
                u_r_mm=motion[..., 0], u_z_mm=motion[..., 1], tilt_rad=motion[..., 2], specimen_height_mm=height_mm,
            )  # fmt: skip
    return folder


def test_own_tables_are_pressed_on_the_specimens_height(own: Path) -> None:
    world = TabulatedWorld(tables=str(own))
    assert world.dome == "own"
    usual = TabulatedWorld().radius_mm(2.0, 5.3)
    assert world.radius_mm(1.3 * 2.0, 5.3, 8.0) == pytest.approx(usual, rel=0.01)
    assert world.radius_mm(1.1 * 2.0, 5.3, 16.0) == pytest.approx(usual, rel=0.01)
    shallow, between, high = (float(world.radius_mm(2.0, 5.3, height)) for height in (8.0, 12.0, 16.0))
    assert shallow < between < high
    assert scene(world, stiffness_n_per_mm=5.3, specimen_height_mm=12.0).area_mm2(2.0) == pytest.approx(
        np.pi * between**2, rel=1e-9
    )
    with pytest.raises(SettingError, match=r"the height of the specimen, .* none, and tables of 8, 16 mm"):
        scene(world)
    with pytest.raises(SettingError, match=r"specimen_height_mm: expected .* on both sides of 25 mm, but found"):
        scene(world, specimen_height_mm=25.0)


def test_a_single_table_is_pressed_at_its_stiffness_alone(own: Path, tmp_path: Path) -> None:
    name = "own_k5.3_h8_stick.npz"
    (tmp_path / name).write_bytes((own / name).read_bytes())
    alone = TabulatedWorld(tables=str(tmp_path))
    assert alone.radius_mm(2.0, 5.3) == pytest.approx(TabulatedWorld(tables=str(own)).radius_mm(2.0, 5.3, 8.0))
    with pytest.raises(SettingError, match=r"5\.3 N/mm, as the only table has, but found 6"):
        scene(alone, stiffness_n_per_mm=6.0)


def test_own_tables_stand_for_a_dome_of_the_sensors_radius(own: Path) -> None:
    """A sensor larger by a fourth in everything shows the same picture of an area larger by its square, and is scored
    so."""
    small, large = (
        Scene(
            PressSettings(
                world=TabulatedWorld(tables=str(own)), stiffness_n_per_mm=5.3, centre_sd_mm=0.0,
                specimen_height_mm=8.0 * size,
                camera=Camera(depth_mm=50.0 * size, sensor=Sensor(3.0 * size, 20.0 * size)),
            )
        )
        for size in (1.0, 1.25)
    )  # fmt: skip
    np.testing.assert_allclose(large.pins_px(2.0), small.pins_px(2.0), rtol=0, atol=1e-9)
    assert large.area_mm2(2.0) == pytest.approx(1.25**2 * small.area_mm2(2.0), rel=1e-9)
    assert large.contact(2.0).semi_axes_px == pytest.approx(small.contact(2.0).semi_axes_px)
    forces = np.linspace(1.0, 4.5, 8).tolist()
    pins_px = np.array([large.pins_px(force) for force in forces])
    front = contact_front(large.rest_px, pins_px, large.settings.camera, worlds(str(own), 8.0))
    np.testing.assert_allclose(front.area, [large.area_mm2(force) for force in forces], rtol=0.02)


def test_the_emulated_rig_presses_own_tables_by_the_height_of_its_specimens(own: Path) -> None:
    bench = EmulatedSettings(world="elastic", domes=str(own), dome_radius_mm=25.0, height_mm={"S2": 12.0})
    pressed = PressDraws(bench, "S2", 0.0, None, RigSettings()).scene(0)
    assert pressed.settings.camera.sensor.dome_radius_mm == 25
    radius_mm = TabulatedWorld(tables=str(own)).radius_mm(2.0, pressed.settings.stiffness_n_per_mm, 12.0 / 1.25)
    assert pressed.area_mm2(2.0) == pytest.approx(np.pi * (1.25 * float(radius_mm)) ** 2, rel=1e-9)
    assert bench.document()["domes"] == own.name
