"""Files of one solution; many on one grid: kept in a file, thinned, joined, and with a lab's own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from benchmarks.tactile.world_scores import without
from casr.dome.library import (
    DEFAULT_WORLD,
    DIGESTS,
    FAMILY,
    SHIPPED,
    Library,
    read_library,
    shipped,
    with_between,
    worlds,
)
from casr.dome.tables import read_table
from casr.errors import PassingError, SettingError
from tests.casr.dome.conftest import Arrays, arrays_of


def write(folder: Path, arrays: Arrays, name: str = "mine_k5.3_stick.npz") -> Path:
    np.savez(folder / name, **arrays)
    return folder / name


def test_a_table_reads_back(tmp_path: Path) -> None:
    arrays = arrays_of(5.3)
    table = read_table(write(tmp_path, arrays))
    assert (table.dome, table.stiffness_n_per_mm, table.friction) == ("mine", 5.3, "stick")
    np.testing.assert_array_equal(table.force_n, arrays["force_n"])
    np.testing.assert_array_equal(table.motion[..., 1], arrays["u_z_mm"])
    assert read_table(write(tmp_path, arrays, "mine_krigid_frictionless.npz")).stiffness_n_per_mm == np.inf


@pytest.mark.parametrize("name", ["mine.npz", "mine_k5,3_stick.npz", "mine_ksoft_stick.npz", "mine_k5.3.npz"])
def test_a_name_that_does_not_say_what_it_is(tmp_path: Path, name: str) -> None:
    with pytest.raises(SettingError, match=r"A_k5\.3_stick\.npz"):
        read_table(write(tmp_path, arrays_of(5.3), name))


def _set(key: str, index: object, value: float) -> Callable[[Arrays], None]:
    def change(arrays: Arrays) -> None:
        arrays[key] = arrays[key].copy()
        arrays[key][index] = value  # type: ignore[index]

    return change


SPOILT: dict[str, tuple[str, Callable[[Arrays], object]]] = {
    "a key is missing": ("tilt_rad", lambda arrays: arrays.pop("tilt_rad")),
    "a frame too few": ("u_z_mm", lambda arrays: arrays.update(u_z_mm=arrays["u_z_mm"][:-1])),
    "a node too few": ("u_r_mm", lambda arrays: arrays.update(u_r_mm=arrays["u_r_mm"][:, :-1])),
    "one number": ("force_n", lambda arrays: arrays.update(force_n=np.array(3.0))),
    "a NaN": ("edge_arc_mm", _set("edge_arc_mm", 3, np.nan)),
    "infinite": ("u_r_mm", _set("u_r_mm", (2, 2), np.inf)),
    "force falls": ("force_n", _set("force_n", 9, 0.0)),
    "nodes fall back": ("s_mm", _set("s_mm", 9, 0.0)),
    "radius falls": (
        "contact_radius_mm",
        lambda arrays: arrays.update(contact_radius_mm=arrays["contact_radius_mm"][::-1]),
    ),
    "metres": ("s_mm", lambda arrays: arrays.update(s_mm=arrays["s_mm"] * 1000)),
    "no pole": ("s_mm", lambda arrays: arrays.update(s_mm=np.linspace(5, 29, arrays["s_mm"].size))),
    "huge": ("u_r_mm", lambda arrays: arrays.update(u_r_mm=arrays["u_r_mm"] + 1e30)),
    "negative force": ("force_n", lambda arrays: arrays.update(force_n=arrays["force_n"] - 1)),
    "a press to milliNewtons": (
        "force_n: expected a press to 0.5 N",
        lambda arrays: arrays.update(force_n=arrays["force_n"] / 1000),
    ),
    "few steps": (
        "in 10 steps above",
        lambda arrays: arrays.update({key: arrays[key][::10] for key in arrays if key != "s_mm"}),
    ),
    "complex": ("complex numbers", lambda arrays: arrays.update(tilt_rad=arrays["tilt_rad"] + 1j)),
    "never touches": ("contact_radius_mm", _set("contact_radius_mm", slice(None), 0.0)),
}


@pytest.mark.parametrize("what", SPOILT)
def test_a_table_that_cannot_be_is_refused_by_its_key(tmp_path: Path, what: str) -> None:
    key, spoil = SPOILT[what]
    arrays = arrays_of(5.3)
    spoil(arrays)
    with pytest.raises(SettingError, match=key) as refused:
        read_table(write(tmp_path, arrays))
    assert "docs/reference/dome-tables.md" in refused.value.do


def test_one_array_is_no_table_and_no_specimen_has_no_stiffness(tmp_path: Path) -> None:
    np.save(tmp_path / "one.npy", np.zeros(9))
    (tmp_path / "one.npy").rename(tmp_path / "mine_k5.3_stick.npz")
    with pytest.raises(SettingError, match="no archive of arrays"):
        read_table(tmp_path / "mine_k5.3_stick.npz")
    with pytest.raises(SettingError, match="a stiffness above 0 in its name"):
        read_table(write(tmp_path, arrays_of(5.3), "mine_k0_stick.npz"))


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 cut off", b"force_n,3"])
def test_a_file_that_is_no_table(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "mine_k5.3_stick.npz"
    path.write_bytes(content)
    with pytest.raises(SettingError, match="a table of a dome's contact"):
        read_table(path)


STEP = 2e-4
"Of the motion in a file."
MOST = 32767 * STEP
"Of it; larger contacts than those that were computed may go beyond."


def test_a_library_is_kept_to_a_tenth_of_a_micrometre(tmp_path: Path, lab: Path) -> None:
    library = read_library(lab)
    path = tmp_path / "kept.npz"
    library.save(path)
    with np.load(path, allow_pickle=False) as kept:
        assert set(kept.files) == {field.name for field in fields(Library)}
        fits = np.clip(library.motion, -MOST, MOST)
        np.testing.assert_allclose(kept["motion"] * STEP, fits, rtol=0, atol=STEP / 2 * 1.01)
        for name in ("dome", "stiffness_n_per_mm", "friction", "radius_mm", "arc_mm", "computed_mm"):
            np.testing.assert_array_equal(kept[name], getattr(library, name))
        np.testing.assert_allclose(kept["force_n"], library.force_n, rtol=1e-6)


@pytest.mark.parametrize("name", [SHIPPED, DEFAULT_WORLD])
def test_no_motion_that_was_computed_is_cut_off_in_the_file(name: str) -> None:
    library = shipped(name)
    computed = library.radius_mm <= library.computed_mm[:, None]
    assert np.abs(library.motion[computed]).max() < MOST - STEP


def test_tables_come_back_from_the_grid() -> None:
    library = shipped(DEFAULT_WORLD)
    (row,) = np.flatnonzero((library.stiffness_n_per_mm == 5.3) & (library.friction == "stick"))
    arrays = arrays_of(5.3)
    force = np.interp([3.0, 6.0, 9.0], arrays["contact_radius_mm"], arrays["force_n"])
    np.testing.assert_allclose(np.interp([3.0, 6.0, 9.0], library.radius_mm, library.force_n[row]), force, rtol=1e-9)
    motion = library.only(np.array([row])).motion_at(np.array([5.0]), np.float64)[:, 0, :, 0]
    assert motion.shape == (3, library.radius_mm.size)


@pytest.mark.parametrize(("name", "within"), [("library/C_k1.1_stick", 0.03), ("library/G_k5.3_stick", 0.02),
                                              ("A_k5.3_stick", 0.02), ("A_krigid_frictionless", 0.02)])  # fmt: skip
def test_the_shipped_domes_are_near_those_of_another_program(
    shared_data: Callable[[str], Path], name: str, within: float
) -> None:
    other = read_table(shared_data("contact_fem") / f"{name}.npz")
    ours = shipped() if "/" in name else shipped(DEFAULT_WORLD)
    same = (ours.dome == other.dome) & (ours.stiffness_n_per_mm == other.stiffness_n_per_mm)
    (row,) = np.flatnonzero(same & (ours.friction == other.friction))
    at_n = (0.5, 1.0, 2.0, 4.0)
    areas = [
        np.interp(at_n, force_n, radius_mm) ** 2
        for force_n, radius_mm in ((ours.force_n[row], ours.radius_mm), (other.force_n, other.contact_radius_mm))
    ]
    np.testing.assert_allclose(*areas, rtol=within)


def test_between_domes_lie_means_and_between_stiffnesses_splines() -> None:
    ours, all_of_them = shipped(), worlds()
    assert ours.n_worlds == len(FAMILY) * 5 * 2
    assert set(all_of_them.dome.tolist()) >= {"C+J", "J+H", "I+G"}

    def row(library: Library, dome: str, stiffness: float) -> int:
        these = (library.dome == dome) & np.isclose(library.stiffness_n_per_mm, stiffness)
        return int(np.flatnonzero(these & (library.friction == "stick"))[0])

    mean = (ours.motion[row(ours, "J", 5.3)] + ours.motion[row(ours, "H", 5.3)]) / 2
    np.testing.assert_allclose(all_of_them.motion[row(all_of_them, "J+H", 5.3)], mean, rtol=0, atol=1e-6)
    known, halfway = [np.inf, 20.0, 5.3, 2.4, 1.1], 2 / (1 / 1.1 + 1 / 2.4)
    softness, motion = [1 / (1 + k / 3) for k in known], np.array([ours.motion[row(ours, "D", k)] for k in known])
    peer = CubicSpline(softness, motion, bc_type="natural")(1 / (1 + halfway / 3))
    np.testing.assert_allclose(all_of_them.motion[row(all_of_them, "D", halfway)], peer, rtol=0, atol=1e-5)


def test_where_a_dome_is_left_out_its_neighbours_are_joined() -> None:
    left = without("H")
    assert not any("H" in dome for dome in left.dome.tolist())
    assert "J+D" in left.dome.tolist()
    assert with_between(shipped()).n_worlds > left.n_worlds


def test_a_lab_adds_its_own_dome(lab: Path) -> None:
    both, ours = worlds(lab), worlds()
    assert both.n_worlds == ours.n_worlds + 5, "three stiffnesses, and two halfway between them"
    assert (both.dome == "mine").sum() == 5
    np.testing.assert_array_equal(both.motion[both.dome != "mine"], ours.motion)


def test_a_specimen_has_the_tables_of_its_height(tmp_path: Path) -> None:
    """Of tables on 5 and 20 mm that on 80/9 mm lies halfway over height^(-1/2); shipped ones are on 25 mm."""
    for height, of in ((5, 5.3), (20, 1.1)):  # the softer one stands for a thicker specimen
        np.savez(tmp_path / f"mine_k3_h{height}_stick.npz", **arrays_of(of), specimen_height_mm=np.array(height))
    np.savez(tmp_path / "mine_krigid_stick.npz", **arrays_of(np.inf))
    folder = str(tmp_path)
    own = {height: worlds(folder, height) for height in (5.0, 80 / 9, 20.3, 24.8)}
    soft = {height: np.flatnonzero(np.isfinite(each.stiffness_n_per_mm)) for height, each in own.items()}
    low, mid, high = (own[height].only(soft[height][:1]) for height in (5.0, 80 / 9, 20.3))
    assert mid.dome.tolist() == ["mine"]
    assert mid.height_mm.tolist() == [80 / 9]
    np.testing.assert_allclose(mid.motion, (low.motion + high.motion) / 2, atol=1e-5)
    np.testing.assert_allclose(mid.force_n, np.sqrt(low.force_n * high.force_n), rtol=1e-9)
    assert {"C", "mine"} <= set(own[80 / 9].dome.tolist()), "rigid plates have every height"
    assert set(own[24.8].dome[soft[24.8]].tolist()) == set(worlds().dome.tolist())
    for height in (4.0, 26.0):
        with pytest.raises(SettingError, match=r"on both sides of \d+ mm, but found heights of 5, 20, 25 mm"):
            worlds(folder, height)


def test_a_height_that_is_none_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "mine_k3_h0_stick.npz", **arrays_of(5.3), specimen_height_mm=np.array(0.0))
    with pytest.raises(SettingError, match="specimen_height_mm: expected a height above 0 mm, but found 0"):
        worlds(str(tmp_path))


def test_a_folder_without_tables_and_one_that_ends_too_early_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match="tables of domes"):
        worlds(tmp_path)
    arrays = arrays_of(5.3)
    short = arrays["s_mm"] < 20
    for key in ("u_r_mm", "u_z_mm", "tilt_rad"):
        arrays[key] = arrays[key][:, short]
    np.savez(tmp_path / "mine_k5.3_stick.npz", **arrays | {"s_mm": arrays["s_mm"][short]})
    with pytest.raises(SettingError, match=r"reaches 29\.5 mm") as refused:
        worlds(tmp_path / ".")
    assert "19.5 mm" in refused.value.found


def test_tables_other_than_those_that_casr_was_made_with_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """No key has them: a failure that is kept would outlast their repair."""
    monkeypatch.setitem(DIGESTS, SHIPPED, "0" * 64)
    with pytest.raises(PassingError, match=r"expected the tables that casr was made with.*Install casr again"):
        shipped.__wrapped__(SHIPPED)


def test_the_motion_at_an_arc_lies_between_those_beside_it() -> None:
    library = shipped()
    worlds, arc_mm = np.array([3, 1]), np.array([0.0, 2.3, 11.0, 1e3])
    found = library.only(worlds).motion_at(arc_mm, np.float64)
    assert found.shape == (3, 4, library.radius_mm.size, 2)
    at = np.minimum(arc_mm, library.arc_mm[-1])
    for k, world, radius in product(range(3), range(2), range(2, 5)):
        there = np.interp(at, library.arc_mm, library.motion[worlds[world], radius, :, k])
        np.testing.assert_allclose(found[k, :, radius, world], there, atol=1e-9)


def test_the_coarse_library_is_every_fourth_radius() -> None:
    library = shipped()
    arc_mm = np.array([1.0, 7.7])
    of_all = library.motion_at(arc_mm, np.float64)
    np.testing.assert_array_equal(library.coarse.motion_at(arc_mm, np.float64), of_all[:, :, ::4])
    np.testing.assert_array_equal(library.coarse.radius_mm, library.radius_mm[::4])
