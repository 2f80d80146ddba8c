"""Files of one solution: read as they are laid out, refused where they are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from casr.dome.tables import read_table
from casr.errors import SettingError
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
    with pytest.raises(SettingError, match="one array, and no archive"):
        read_table(tmp_path / "mine_k5.3_stick.npz")
    with pytest.raises(SettingError, match="a stiffness above 0 in its name"):
        read_table(write(tmp_path, arrays_of(5.3), "mine_k0_stick.npz"))


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 cut off", b"force_n,3"])
def test_a_file_that_is_no_table(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "mine_k5.3_stick.npz"
    path.write_bytes(content)
    with pytest.raises(SettingError, match="a table of a dome's contact"):
        read_table(path)
