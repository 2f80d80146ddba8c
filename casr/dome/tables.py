"""Finite-element solutions of a dome pressed on a specimen: the documented file of one solution.

A file is named ``<dome>_k<stiffness, N/mm, or rigid>_<friction>.npz``, or ``<dome>_k<stiffness>_h<mm>_<friction>.npz``
where specimens of several heights are told apart. Row 0 is the untouched state; arrays of T steps
and P nodes along the inside of the skin, from the pole outwards, in a frame that moves with the flange:

| key | shape | unit | meaning |
|---|---|---|---|
| force_n | T | N | normal force, rising |
| contact_radius_mm | T | mm | radius of the contact's edge, seen along the axis |
| edge_arc_mm | T | mm | where the edge is on the undeformed outside of the skin, as an arc from the pole |
| s_mm | P | mm | arc from the pole to each node on the undeformed inside |
| u_r_mm, u_z_mm | T, P | mm | displacement away from the axis, and along it towards the tip |
| tilt_rad | T, P | rad | rotation of the skin; positive turns the tips of pins away from the axis |

A number ``specimen_height_mm`` beside them is the thickness of the specimen; without it 25 mm. ``metadata`` is JSON:
that of ``casr dome`` names the table, the sensor's ``dome_radius_mm`` and the SHA-256 of the arrays.

The dome is a sphere of 20 mm radius with a skin of 1 mm; another size is the same dome in other millimetres.
"""

from __future__ import annotations

import hashlib
import json
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.errors import SettingError

Array = NDArray[np.float64]

OF_STEPS = ("force_n", "contact_radius_mm", "edge_arc_mm")
OF_NODES = ("u_r_mm", "u_z_mm", "tilt_rad")
SOLVER = "casr dome"
HEIGHT, USUAL_HEIGHT_MM = "specimen_height_mm", 25.0
SMOOTH_FROM_N = 0.02
LEAST_RADIUS_MM, LEAST_FORCE_N, LEAST_STEPS = 4.0, 0.5, 10
"""Smallest last radius and force of a contact, and fewest steps from ``SMOOTH_FROM_N`` on: less tells nothing of a
press.
"""
RANGES = {
    "force_n": (0.0, 1000.0), "contact_radius_mm": (0.0, 20.0), "edge_arc_mm": (0.0, 32.0), "s_mm": (0.0, 30.0),
    "u_r_mm": (-20.0, 20.0), "u_z_mm": (-20.0, 20.0), "tilt_rad": (-3.2, 3.2),
}  # fmt: skip
"Values that a table can hold."
FALL_MM, FIRST_ARC_MM = 0.5, 0.5
_NAME = re.compile(r"(?P<dome>[^_]+)_k(?P<stiffness>rigid|\d+(\.\d+)?)(_h[^_]+)?_(?P<friction>[^_]+)")
_DO = "See the layout in docs/reference/dome-tables.md."


@dataclass(frozen=True, eq=False)
class ContactTable:
    """One dome pressed on one specimen: T steps, P nodes; see the layout of the file.

    dome, friction : names. stiffness_n_per_mm, height_mm : of the specimen; inf and whatever for a rigid plate.
    motion : (T, P, 3) of u_r_mm, u_z_mm and tilt_rad. dome_radius_mm : of the sensor that it was solved for; NaN where
    the file does not say. solved : that sensor's dome, by the names of ``casr.dome.solver.press.Dome``.
    """

    dome: str
    stiffness_n_per_mm: float
    friction: str
    height_mm: float
    force_n: Array
    contact_radius_mm: Array
    edge_arc_mm: Array
    s_mm: Array
    motion: Array
    dome_radius_mm: float = float("nan")
    solved: Mapping[str, Any] = field(default_factory=dict)


def read_table(path: Path) -> ContactTable:
    """Read one solution. SettingError for a file that is not laid out as above."""
    named = _NAME.fullmatch(path.stem)
    if named is None:
        wanted = "a name like A_k5.3_stick.npz: dome, stiffness in N/mm or 'rigid', friction"
        raise SettingError(str(path), wanted=wanted, found=path.name, do=_DO)
    try:
        if not zipfile.is_zipfile(path):
            raise ValueError("no archive of arrays")
        with np.load(path, allow_pickle=False) as kept:
            arrays = {key: _real(kept[key]) for key in (*OF_STEPS, "s_mm", *OF_NODES)}
            height_mm = float(kept[HEIGHT]) if HEIGHT in kept else USUAL_HEIGHT_MM
            said = json.loads(str(kept["metadata"])) if "metadata" in kept else {}
            ours = isinstance(said, dict) and said.get("solver") == SOLVER
            changed = ours and said.get("arrays") != digest(dict(kept))
    except (OSError, EOFError, KeyError, TypeError, ValueError, zipfile.BadZipFile) as error:
        raise SettingError(str(path), wanted="a table of a dome's contact", found=str(error), do=_DO) from error
    if changed or (ours and said.get("case") != path.stem):
        wanted, found = (
            "the table as casr dome wrote it",
            "changed arrays" if changed else f"that of {said.get('case')}",
        )
        raise SettingError(str(path), wanted=wanted, found=found, do="Solve it again, or give it its name again.")
    _check(path, arrays)
    if not 0 < height_mm < np.inf:
        raise SettingError(f"{path}, {HEIGHT}", wanted="a height above 0 mm", found=f"{height_mm:g}", do=_DO)
    stiffness = np.inf if named["stiffness"] == "rigid" else float(named["stiffness"])
    if not stiffness > 0:
        raise SettingError(str(path), wanted="a stiffness above 0 in its name", found=named["stiffness"], do=_DO)
    return ContactTable(
        dome=named["dome"], stiffness_n_per_mm=stiffness, friction=named["friction"], height_mm=height_mm,
        force_n=arrays["force_n"], contact_radius_mm=arrays["contact_radius_mm"], edge_arc_mm=arrays["edge_arc_mm"],
        s_mm=arrays["s_mm"],
        motion=np.stack([arrays[key] for key in OF_NODES], axis=-1),
        dome_radius_mm=float(said["dome_radius_mm"]) if ours else float("nan"),
        solved=said.get("pressing", {}).get("dome", {}) if ours else {},
    )  # fmt: skip


def digest(arrays: Mapping[str, Any]) -> str:
    """SHA-256 of all arrays of a file but its metadata."""
    told = hashlib.sha256()
    for name in sorted(set(arrays) - {"metadata"}):
        told.update(name.encode() + np.ascontiguousarray(arrays[name], dtype=np.float64).tobytes())
    return told.hexdigest()


def _real(array: NDArray[Any]) -> Array:
    if np.iscomplexobj(array):
        raise ValueError("complex numbers")
    return np.asarray(array, dtype=np.float64)


def _check(path: Path, arrays: dict[str, Array]) -> None:
    steps, nodes = arrays["force_n"].shape, arrays["s_mm"].shape
    shapes = dict.fromkeys(OF_STEPS, steps) | dict.fromkeys(OF_NODES, steps + nodes) | {"s_mm": nodes}
    for key, shape in shapes.items():
        array = arrays[key]
        if array.shape != shape or not np.isfinite(array).all() or min(array.shape, default=0) < 5:
            found = f"shape {array.shape}" + ("" if np.isfinite(array).all() else " with values that are not finite")
            wanted = f"finite numbers of shape {shape}, five steps and nodes at least"
            raise SettingError(f"{path}, {key}", wanted=wanted, found=found, do=_DO)
    for key in ("force_n", "s_mm"):
        if not (np.diff(arrays[key]) > 0).all():
            raise SettingError(f"{path}, {key}", wanted="rising values", found="values that do not rise", do=_DO)
    if not (np.diff(arrays["contact_radius_mm"]) >= -FALL_MM).all():
        wanted = "a contact that grows with the force"
        raise SettingError(f"{path}, contact_radius_mm", wanted=wanted, found="values that fall", do=_DO)
    for key, (low, high) in RANGES.items():
        found_low, found_high = float(arrays[key].min()), float(arrays[key].max())
        if found_low < low or found_high > high:
            wanted = f"values from {low:g} to {high:g}, as in a dome of 20 mm"
            raise SettingError(f"{path}, {key}", wanted=wanted, found=f"{found_low:.3g} to {found_high:.3g}", do=_DO)
    if arrays["s_mm"][0] > FIRST_ARC_MM:
        wanted = f"arcs from the pole on, {FIRST_ARC_MM:g} mm at most"
        raise SettingError(f"{path}, s_mm", wanted=wanted, found=f"{arrays['s_mm'][0]:.3g}", do=_DO)
    force_n = arrays["force_n"]
    if force_n[-1] < LEAST_FORCE_N or (count := int((force_n >= SMOOTH_FROM_N).sum())) < LEAST_STEPS:
        wanted = f"a press to {LEAST_FORCE_N:g} N at least, in {LEAST_STEPS} steps above {SMOOTH_FROM_N:g} N"
        found = f"{force_n[-1]:.3g} N" if force_n[-1] < LEAST_FORCE_N else f"{count} steps"
        raise SettingError(f"{path}, force_n", wanted=wanted, found=found, do=_DO)
    reached_mm = float(arrays["contact_radius_mm"].max())
    if reached_mm < LEAST_RADIUS_MM:
        wanted = f"a contact that reaches {LEAST_RADIUS_MM:g} mm"
        raise SettingError(f"{path}, contact_radius_mm", wanted=wanted, found=f"{reached_mm:.3g} mm", do=_DO)
