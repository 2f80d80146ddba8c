"""The solver of tables against Hertz, against other elements, against differences, and its command; coarse meshes."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from casr.camera import Camera
from casr.cli import main
from casr.contact_area.library_front import worlds_for
from casr.dome.tables import read_table
from casr.errors import CameraError, SettingError

pytest.importorskip("skfem", reason="needs the extra solver: scikit-fem")

from casr.dome.kappa import PUNCH_MM, punch_on_half_space_mm, punch_on_thin_layer_mm
from casr.dome.solver.bodies import Bodies, Inverted, Rubber, Stopped, block
from casr.dome.solver.cases import AREA_AT_N, areas_mm2, dome_radius_mm, solve
from casr.dome.solver.contact import Contact, Grip
from casr.dome.solver.press import Dome, Pressed, Pressing, Specimen, press
from casr.dome.solver.punch import punch_on_block_mm
from casr.dome.solver.sensor_file import KEYS, read_sensor

SKIN_OVER_GEL = Dome(20.0, 1.0, Rubber(0.8), Rubber(0.03))
COARSE = Pressing(SKIN_OVER_GEL, Specimen(None), force_n=2.0, mesh_mm=1.0, step_mm=0.2)
SOFT = replace(COARSE, specimen=Specimen(Rubber(5.3 / 41.8)))
SENSOR = """
[dome]
name = "mine"
radius_mm = 40
skin_mm = 2
skin_modulus_mpa = 0.8
gel_modulus_mpa = 0.03
[specimen]
radius_mm = 70
stiffness_n_per_mm = []
friction = ["frictionless"]
[solve]
force_n = 8
mesh_mm = 2
"""


@pytest.fixture(scope="module")
def soft() -> Pressed:
    return press(SOFT)


def two_bodies() -> tuple[Bodies, Contact, np.ndarray]:
    """A block on another, bent at random so that every term of the contact counts."""
    lower = block(np.linspace(0, 3, 4), np.linspace(-1, 0, 2), lambda r, z: (r, z))
    upper = block(np.linspace(0, 4, 4), np.linspace(0, 1, 2), lambda r, z: (r, z))
    bodies = Bodies([(each, [Rubber(1.0)] * len(each.nodes)) for each in (lower, upper)])
    face = upper.line(1, 0.0) + len(lower.place)
    contact = Contact(lower.line(1, 0.0), face, bodies.place, 5.0, np.inf)
    moved = np.random.default_rng(1).normal(0, 0.02, bodies.size)
    moved[: 2 * len(lower.place)][1::2] += 0.05
    return bodies, contact, moved


def test_forces_and_their_slopes_are_those_of_the_energy() -> None:
    bodies, contact, moved = two_bodies()
    held = contact.touched(contact.opposite(moved)) + np.linspace(-0.01, 0.01, contact.size)
    grip = Grip(held, np.full(contact.size, 0.004), np.full(contact.size, 0.006))  # some slip

    def energy(at: np.ndarray) -> float:
        return bodies.energy(at) + contact.resistance(contact.opposite(at), grip)[0]

    def force(at: np.ndarray) -> np.ndarray:
        _, dofs, own, _ = contact.resistance(contact.opposite(at), grip)
        return bodies.resistance(at)[0] + np.bincount(dofs.ravel(), own.ravel(), at.size)

    way = np.random.default_rng(2).normal(size=moved.size)
    step = 1e-6 * way
    assert (energy(moved + step) - energy(moved - step)) / 2e-6 == pytest.approx(force(moved) @ way, rel=1e-7)
    _, values = bodies.resistance(moved)
    _, dofs, _, bent = contact.resistance(contact.opposite(moved), grip)
    assert len(dofs) == 12  # points in touch
    slope = np.bincount(bodies.rows, values * way[bodies.columns], way.size)
    slope += np.bincount(dofs.ravel(), np.einsum("pij,pj->pi", bent, way[dofs]).ravel(), way.size)
    assert (force(moved + step) - force(moved - step)) / 2e-6 == pytest.approx(slope, rel=1e-6, abs=1e-6)


def test_a_body_inside_out_is_refused() -> None:
    bodies, _, moved = two_bodies()
    moved[1::2] = -1.5 * bodies.place[:, 1]
    with pytest.raises(Inverted):
        bodies.resistance(moved)


def test_a_ball_of_one_rubber_follows_hertz() -> None:
    """Within 4 % of the radius at a / R < 0.1, where the mesh has some four elements in the contact."""
    rubber = Rubber(0.5)
    found = press(Pressing(Dome(20.0, 1.0, rubber, rubber), Specimen(None), force_n=0.5, mesh_mm=0.4))
    at = found.force_n > 0.2
    hertz = np.cbrt(0.75 * found.force_n[at] * 20.0 * (1 - rubber.poisson**2) / rubber.modulus_mpa)
    assert found.contact_radius_mm[at] == pytest.approx(hertz, rel=0.04)


def test_a_dome_on_a_plate_is_that_of_other_elements(shared_data: Callable[[str], Path]) -> None:
    """Tables of four-node elements of an eighth of a millimetre, by another program."""
    found = press(replace(COARSE, mesh_mm=0.6))
    known = read_table(shared_data("contact_fem") / "A_krigid_frictionless.npz")
    at_n = (1.0, 2.0)
    radius = np.interp(at_n, known.force_n, known.contact_radius_mm)
    assert areas_mm2(found, at_n) == pytest.approx(np.pi * radius**2, rel=0.02)
    step = int(np.argmin(np.abs(found.force_n - 2.0)))
    row = int(np.argmin(np.abs(known.contact_radius_mm - found.contact_radius_mm[step])))
    for axis, name in enumerate(("u_r_mm", "u_z_mm")):
        other = np.interp(found.s_mm, known.s_mm, known.motion[row, :, axis])
        assert np.abs(getattr(found, name)[step] - other)[found.s_mm < 25].max() < 0.2


def test_forces_balance_and_all_work_is_stored(soft: Pressed) -> None:
    assert soft.unbalance < 1e-6
    assert soft.unstored < 5e-5  # points that touch within a step
    assert press(replace(SOFT, force_n=1.0, step_mm=0.025)).unstored < 5e-6


def test_a_rigid_ball_on_a_layer_is_that_of_another_program() -> None:
    """ContactMechanics: linear, by FFT. Both are coarse here; finer ones agree to 1.2 % (benchmarks.dome_solver)."""
    pytest.importorskip("ContactMechanics", reason="is in the test extra, on Linux")
    from benchmarks.dome_solver import layer_area_mm2, others_area_mm2

    (area,) = layer_area_mm2(4.0, [0.8], mesh_mm=0.5)
    assert area == pytest.approx(others_area_mm2(0.8, 4.0, points=192), rel=0.02)


@pytest.mark.slow
def test_a_softer_specimen_and_a_finer_mesh(soft: Pressed) -> None:
    (hard,) = areas_mm2(press(COARSE), [1.5])
    (area,) = areas_mm2(soft, [1.5])
    (fine,) = areas_mm2(press(replace(SOFT, mesh_mm=0.5)), [1.5])
    assert area > 1.15 * hard
    assert area == pytest.approx(fine, rel=0.05)


def test_skin_that_sticks_takes_the_specimen_along(soft: Pressed) -> None:
    stuck = press(replace(SOFT, friction=np.inf))
    assert stuck.unbalance < 1e-6
    assert stuck.force_n[-1] > 1.005 * np.interp(stuck.depth_mm[-1], soft.depth_mm, soft.force_n)
    assert stuck.contact_radius_mm[-1] < np.interp(stuck.force_n[-1], soft.force_n, soft.contact_radius_mm)


def test_kappa_over_the_modulus_under_the_punch() -> None:
    block_mm, thin_mm = (punch_on_block_mm(35.0, height, 0.49) for height in (25.0, 5.0))
    assert block_mm == pytest.approx(41.8, rel=0.02)  # of four-node elements, 1 mm deep
    assert punch_on_block_mm(1000.0, 1000.0, 0.0) == pytest.approx(punch_on_half_space_mm(PUNCH_MM), rel=0.01)
    assert punch_on_block_mm(35.0, 2.5, 0.4995) == pytest.approx(punch_on_thin_layer_mm(PUNCH_MM, 2.5), rel=0.02)
    assert thin_mm > 2 * block_mm


def test_kappa_by_each_way_is_that_of_the_same_rubber(tmp_path: Path) -> None:
    sensor = tmp_path / "sensor.toml"
    moduli = []
    for way, kappa in (("punch", 4.129), ("plate", 15.394), ("bonded plate", 30.48)):
        said = SENSOR.replace("radius_mm = 70", f'radius_mm = 35\nstiffness_by = "{way}"')
        said = said.replace("radius_mm = 40\n", "radius_mm = 20\n").replace("skin_mm = 2", "skin_mm = 1")
        sensor.write_text(said.replace("= []", f"= [{kappa}]"), encoding="utf-8")
        case, _ = read_sensor(sensor)
        rubber = case.pressing.specimen.rubber
        assert rubber is not None
        moduli.append(rubber.modulus_mpa)
    assert moduli == pytest.approx([0.1] * 3, rel=1e-3)


def test_specimens_of_several_heights_have_their_tables(tmp_path: Path) -> None:
    sensor = tmp_path / "sensor.toml"
    text = SENSOR.replace("radius_mm = 70", "radius_mm = 70\nheight_mm = [50, 20]").replace("= []", "= [20]")
    sensor.write_text(text.replace("force_n = 8", "force_n = 1.5"), encoding="utf-8")
    cases = read_sensor(sensor)
    assert [each.name.removesuffix("_frictionless") for each in cases] == [
        "mine_k20_h20",
        "mine_k20_h50",
        "mine_krigid",
    ]
    thin_mpa, thick_mpa = (each.modulus_mpa for case in cases if (each := case.pressing.specimen.rubber))
    assert thin_mpa < 0.8 * thick_mpa
    (solved,) = solve(cases[:1], tmp_path, jobs=1)
    assert not solved.stopped
    with np.load(tmp_path / "mine_k20_h20_frictionless.npz") as table:
        assert table["specimen_height_mm"] == pytest.approx(10.0)  # of a dome of 20 mm


def test_one_dome_in_other_lengths_and_moduli_has_one_solution() -> None:
    """A quarter of the size and 16 times as stiff: the same forces, a 16th of the areas."""
    known = press(replace(COARSE, mesh_mm=2.0))
    small = Dome(5.0, 0.25, Rubber(12.8), Rubber(0.48))
    found = press(replace(COARSE, dome=small, mesh_mm=0.5))
    np.testing.assert_allclose(found.force_n, known.force_n, rtol=1e-9)
    np.testing.assert_allclose(4 * found.contact_radius_mm, known.contact_radius_mm, rtol=1e-7)
    np.testing.assert_allclose(4 * found.u_r_mm, known.u_r_mm, rtol=0, atol=1e-8)


def test_an_unreachable_force_is_told() -> None:
    with pytest.raises(Stopped, match=r"N at 12\.\d mm of depth: the flange has moved 60% of the dome's radius"):
        press(replace(SOFT, specimen=Specimen(Rubber(1e-3)), force_n=50.0, mesh_mm=2.0, step_mm=1.0))


def test_a_table_in_millimetres_of_20_is_read_and_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sensor, out = tmp_path / "sensor.toml", tmp_path / "out"
    sensor.write_text(SENSOR, encoding="utf-8")
    page = tmp_path / "page.html"
    words = ["dome", str(sensor), "--out", str(out), "--page", str(page), "--json"]
    assert main(words) == 0
    said = json.loads(capsys.readouterr().out)["tables"][0]
    assert said["table"] == "mine_krigid_frictionless"
    assert not said["was_there"]
    drawn = page.read_text(encoding="utf-8")
    assert drawn.count("<svg") == 4
    assert f"<td>{said['table']}</td>" in drawn
    table = read_table(out / "mine_krigid_frictionless.npz")
    twin = press(replace(COARSE, force_n=2.0))  # the same dome of half the size bears a quarter of the force
    at = np.array([0.5, 1.0, 1.5])
    radius = np.interp(4 * at, table.force_n, table.contact_radius_mm)
    assert radius == pytest.approx(np.interp(at, twin.force_n, twin.contact_radius_mm), rel=0.01)
    before = (out / "mine_krigid_frictionless.npz").stat().st_mtime_ns
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["tables"][0]["was_there"]
    assert (out / "mine_krigid_frictionless.npz").stat().st_mtime_ns == before
    whole = (out / "mine_krigid_frictionless.npz").read_bytes()
    (out / "mine_krigid_frictionless.npz").write_bytes(whole[: len(whole) // 2])
    monkeypatch.setattr("casr.dome.solver.cases.press", cache(press))  # two files are made anew, of one more solution
    assert main(words) == 0  # half a file is none
    with np.load(out / "mine_krigid_frictionless.npz") as kept:
        arrays = dict(kept)
    np.savez_compressed(out / "mine_krigid_frictionless.npz", **arrays | {"u_z_mm": -arrays["u_z_mm"]})
    with pytest.raises(SettingError, match="as casr dome wrote it, but found changed arrays"):
        read_table(out / "mine_krigid_frictionless.npz")
    assert main(words) == 0  # nor is a changed one
    assert (out / "mine_krigid_frictionless.npz").read_bytes() == whole
    (out / "mine_k20_frictionless.npz").write_bytes(whole)
    with pytest.raises(SettingError, match="but found that of mine_krigid_frictionless"):
        read_table(out / "mine_k20_frictionless.npz")
    (out / "mine_k20_frictionless.npz").unlink()
    with pytest.raises(CameraError, match=r"dome_radius_mm: expected 40 mm, as the tables in .* but found 20 mm"):
        worlds_for(Camera(), str(out), None)
    capsys.readouterr()
    assert said["dome_radius_mm"] == pytest.approx(40.0)
    digest = read_sensor(sensor)[0].digest
    assert read_sensor(_changed(sensor, "skin_mm = 2", "skin_mm = 2.5"))[0].digest != digest
    assert main(words) == 2
    assert "tables of one dome by the name mine, but found another, skin_mm 2.0" in capsys.readouterr().err


def test_a_thick_skin_keeps_its_angles_and_its_area_in_the_millimetres_of_tables(tmp_path: Path) -> None:
    sensor = tmp_path / "sensor.toml"
    text = SENSOR.replace("skin_mm = 2", "skin_mm = 4").replace('["frictionless"]', '["frictionless", 0.3]')
    sensor.write_text(text, encoding="utf-8")
    case, rough = read_sensor(sensor)
    both = {each.case.name: each for each in solve([case, rough], tmp_path, jobs=2)}
    solved = both[case.name]
    assert both["mine_krigid_mu0.3"].said["area_mm2"]["4.0"] < solved.said["area_mm2"]["4.0"]
    table = read_table(tmp_path / f"{case.name}.npz")
    assert dome_radius_mm(case) == pytest.approx(36 * 20 / 19)
    said = solved.said
    assert said["area_error"] == sum(said["area_error_of"].values()) > min(said["area_error_of"].values()) > 0
    hard = areas_mm2(press(replace(case.pressing, penalty=8.0)), AREA_AT_N)
    assert list(said["area_mm2"].values()) == pytest.approx(hard, rel=said["area_error"])
    assert table.s_mm[-1] == pytest.approx(19 * np.pi / 2)
    scale = dome_radius_mm(case) / 20
    area = np.pi * (scale * np.interp(4.0, table.force_n, table.contact_radius_mm)) ** 2
    assert area == pytest.approx(solved.said["area_mm2"]["4.0"], rel=1e-3)
    assert 0.9 < table.edge_arc_mm[-1] / (20 * np.arcsin(table.contact_radius_mm[-1] * scale / 40)) < 1.1


def _changed(path: Path, old: str, new: str) -> Path:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


def test_without_the_extra_its_name_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "skfem", None)
    (tmp_path / "sensor.toml").write_text(SENSOR, encoding="utf-8")
    assert main(["dome", str(tmp_path / "sensor.toml"), "--out", str(tmp_path / "out"), "--jobs", "1"]) == 2
    assert 'pip install ".[solver]" in the folder of the sources' in capsys.readouterr().err


def test_a_case_that_stops_is_named_and_leaves_the_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("casr.dome.solver.press.DEEPEST", 0.16)
    sensor, out = tmp_path / "sensor.toml", tmp_path / "out"
    sensor.write_text(SENSOR.replace("= []", "= [1]"), encoding="utf-8")
    assert main(["dome", str(sensor), "--out", str(out), "--jobs", "1"]) == 1
    said = capsys.readouterr().out
    assert "mine_k1_frictionless      not solved: " in said
    assert "mm of depth: the flange has moved 16% of the dome's radius. Set [solve] force_n to " in said
    assert [path.name for path in out.iterdir()] == ["mine_krigid_frictionless.npz"]


def test_a_table_of_no_use_and_names_that_cannot_be_written_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sensor, out = tmp_path / "sensor.toml", tmp_path / "out"
    kilopascals = SENSOR.replace("_mpa = 0.8", "_mpa = 800").replace("_mpa = 0.03", "_mpa = 30")
    sensor.write_text(kilopascals, encoding="utf-8")
    assert main(["dome", str(sensor), "--out", str(out), "--jobs", "1"]) == 1
    assert "Of no use, with an error above 20%: mine_krigid_frictionless.\nCheck the units" in capsys.readouterr().out
    assert main(["dome", str(sensor), "--out", str(sensor)]) == 2
    assert "--out: expected a folder, but found" in capsys.readouterr().err
    assert main(["dome", str(sensor), "--page", str(tmp_path)]) == 2
    assert "--page: expected a file, but found" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('name = "mine"', 'name = "my_dome"', "dome.name: expected a word of"),
        ('name = "mine"', "", "dome.name: expected a word of at most 40 letters without spaces, '_', '.', '/'"),
        ('name = "mine"', f'name = "{"m" * 41}"', "dome.name: expected a word of at most 40 letters"),
        ("radius_mm = 40", "radius_mm = -1", "dome.radius_mm: expected a number from 2 to 200, but found -1"),
        ("skin_mm = 2", "skin_mm = 21", "dome.skin_mm: expected a number from 0.05 to 20"),
        ("skin_mm = 2", "skin_mm = 20", "dome.skin_mm: expected a skin thinner than half the radius"),
        ("skin_modulus_mpa = 0.8", "skin_modulus_mpa = nan", "dome.skin_modulus_mpa: expected"),
        ("gel_modulus_mpa = 0.03", "gel_modulus_kpa = 30", "Did you mean gel_modulus_mpa?"),
        ("gel_modulus_mpa = 0.03", "gel_modulus_mpa = 0.03\ngel_poisson = 0.5", "dome.gel_poisson: expected"),
        ("gel_modulus_mpa = 0.03", "gel_modulus_mpa = 0.03\nskin_poisson = true", "dome.skin_poisson: expected"),
        ("radius_mm = 70", "radius_mm = 30", "specimen.radius_mm: expected at least the dome's radius, 40"),
        ("radius_mm = 70", "height_mm = 0", "specimen.height_mm: expected"),
        ("radius_mm = 70", "height_mm = []", "specimen.height_mm: expected a number from 0.5 to 1000, or a list"),
        ("radius_mm = 70", "height_mm = [10, 10]", "specimen.height_mm: expected"),
        ("radius_mm = 70", 'stiffness_by = "thumb"', "stiffness_by: expected one of punch, plate, bonded plate, but"),
        ("radius_mm = 70", "poisson = 0.5", "specimen.poisson: expected"),
        ("stiffness_n_per_mm = []", "stiffness_n_per_mm = [1, 1]", "stiffness_n_per_mm: expected a list of numbers"),
        ("stiffness_n_per_mm = []", "stiffness_n_per_mm = []\nrigid = false", "specimen: expected one stiffness"),
        ("stiffness_n_per_mm = []", "rigid = 1", "specimen.rigid: expected true or false"),
        ('["frictionless"]', '["sticky"]', "specimen.friction: expected a list of frictionless, stick"),
        ('["frictionless"]', '[["stick"]]', "specimen.friction: expected a list of frictionless, stick"),
        ("stiffness_n_per_mm = []", "stiffness_n_per_mm = [1, 1.0]", "each once, but found [1, 1.0]"),
        ("stiffness_n_per_mm = []", "stiffness_n_per_mm = [5.3, 5.30000001]", "each once, but found [5.3, 5.3"),
        ("stiffness_n_per_mm = []", "stiffness_n_per_mm = [inf]", "a list of numbers from 0.05 to 1000"),
        ("force_n = 8", "force_n = 0", "solve.force_n: expected a number from 0.5 to 50"),
        ("mesh_mm = 2", "mesh_mm = 3", "solve.mesh_mm: expected a number from 0.05 to 2"),
        ("[solve]", "[solver]", "expected only dome, specimen, solve, but found solver. Did you mean solve?"),
        ("[solve]", "[[solve]]", "solve: expected a table [solve]"),
        ("[solve]", "[solve", "expected a file in TOML"),
    ],
)
def test_what_is_wrong_with_a_file_is_told(tmp_path: Path, old: str, new: str, said: str) -> None:
    sensor = tmp_path / "sensor.toml"
    sensor.write_text(SENSOR, encoding="utf-8")
    with pytest.raises(SettingError) as error:
        read_sensor(_changed(sensor, old, new))
    assert said in str(error.value)


def test_the_module_shows_every_key() -> None:
    import casr.dome.solver.sensor_file as module

    shown = str(module.__doc__)
    assert all(f"\n{key} = " in shown for keys in KEYS.values() for key in keys)
