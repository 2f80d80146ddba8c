"""A sensor's file: its dome, the specimens and frictions that tables are wanted of, and how finely to solve.

Tables ``[camera]`` and ``[sensor]``, which are those of camera.toml, may stand in the same file.

```toml
[dome]
name = "mine"           # no "_" in it: it is the first word of the tables' names
radius_mm = 20.0        # outside
skin_mm = 1.0
skin_modulus_mpa = 0.8
gel_modulus_mpa = 0.03
skin_poisson = 0.49     # these two and all below may be left out
gel_poisson = 0.49

[specimen]              # a cylinder bonded to a rigid plate
radius_mm = 35.0
height_mm = 25.0        # or several: [10.0, 25.0]
poisson = 0.49
stiffness_n_per_mm = [1.1, 2.4, 5.3, 20.0]
stiffness_by = "punch"  # or "plate", "bonded plate": what they were measured with
rigid = true            # also a rigid plate
friction = ["frictionless", "stick"]  # or a number: Coulomb's

[solve]
force_n = 5.0
mesh_mm = 0.5           # size of elements in the contact
```
"""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from difflib import get_close_matches
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from casr.dome.kappa import plate_on_cylinder_mm
from casr.dome.solver.bodies import Rubber
from casr.dome.solver.press import Dome, Pressing, Specimen
from casr.dome.solver.punch import punch_on_block_mm
from casr.errors import SettingError

Check = tuple[str, Callable[[Any], bool]]


def _number(low: float, high: float) -> Check:
    def good(value: Any) -> bool:
        return isinstance(value, int | float) and not isinstance(value, bool) and low <= value <= high

    return f"a number from {low:g} to {high:g}", good


_POISSON = _number(0.0, 0.4995)
_STIFF = _number(0.05, 1000.0)
_COULOMB = _number(0.01, 10.0)
_NAME: Check = (
    "a word of at most 40 letters without spaces, '_', '.', '/' and '\\'",
    lambda value: (
        isinstance(value, str) and 0 < len(value) <= 40 and value.isprintable() and not set(value) & set("_/\\ .")
    ),
)
FRICTIONS = {"frictionless": 0.0, "stick": np.inf}


def _is_word(value: Any) -> bool:
    return isinstance(value, str) and value in FRICTIONS


def _called(value: Any) -> str:
    """The specimen as the name of a table writes it."""
    return value if isinstance(value, str) else f"{value:g}"


def _list_of(what: str, good: Callable[[Any], bool]) -> Check:
    def all_good(value: Any) -> bool:
        return isinstance(value, list) and all(map(good, value)) and len(set(map(_called, value))) == len(value)

    return f"a list of {what}, each once", all_good


_HEIGHT = _number(0.5, 1000)[1]
_HEIGHTS: Check = (
    "a number from 0.5 to 1000, or a list of such, each once",
    lambda x: _HEIGHT(x) or (bool(x) and _list_of("", _HEIGHT)[1](x)),
)
LENGTHS: dict[str, Callable[[float, float, float], float]] = {
    "punch": punch_on_block_mm,
    "plate": lambda radius_mm, height_mm, _: plate_on_cylinder_mm(radius_mm, height_mm),
    "bonded plate": lambda radius_mm, height_mm, _: plate_on_cylinder_mm(radius_mm, height_mm, bonded=True),
}
"""Kappa over the modulus, mm, of a cylinder of this radius, height and Poisson's ratio, by what pressed it."""
KEYS: dict[str, dict[str, tuple[Any, Check]]] = {
    "dome": {
        "name": (None, _NAME), "radius_mm": (None, _number(2, 200)), "skin_mm": (None, _number(0.05, 20)),
        "skin_modulus_mpa": (None, _number(1e-4, 1000)), "gel_modulus_mpa": (None, _number(1e-4, 1000)),
        "skin_poisson": (0.49, _POISSON), "gel_poisson": (0.49, _POISSON),
    },
    "specimen": {
        "radius_mm": (35.0, _number(5, 1000)), "height_mm": (25.0, _HEIGHTS), "poisson": (0.49, _POISSON),
        "stiffness_n_per_mm": ([1.1, 2.4, 5.3, 20.0], _list_of(f"numbers from {0.05:g} to {1000:g}", _STIFF[1])),
        "stiffness_by": ("punch", (f"one of {', '.join(LENGTHS)}", lambda x: isinstance(x, str) and x in LENGTHS)),
        "rigid": (True, ("true or false", lambda value: isinstance(value, bool))),
        "friction": (
            ["frictionless", "stick"],
            _list_of("frictionless, stick or numbers from 0.01 to 10", lambda x: _is_word(x) or _COULOMB[1](x)),
        ),
    },
    "solve": {"force_n": (5.0, _number(0.5, 50)), "mesh_mm": (0.5, _number(0.05, 2))},
}  # fmt: skip
"""Table to key to its default (None: it must be there) and what it can be."""


@dataclass(frozen=True)
class Case:
    """A table to be solved. name : of its file, less the suffix. stiffness_n_per_mm : inf for a rigid plate;
    stiffness_by : what it is measured with, of ``LENGTHS``."""

    name: str
    pressing: Pressing
    stiffness_n_per_mm: float
    stiffness_by: str

    @property
    def digest(self) -> str:
        """Digest of all that the solution depends on, and of the solver."""
        said = json.dumps([asdict(self.pressing), self.stiffness_n_per_mm, self.stiffness_by], sort_keys=True)
        return hashlib.sha256(said.encode() + _solver()).hexdigest()


@cache
def _solver() -> bytes:
    folder = Path(__file__).parent
    return b"".join((folder / f"{name}.py").read_bytes() for name in ("bodies", "contact", "press", "punch"))


def read_sensor(path: Path) -> list[Case]:
    """The tables that a sensor's file asks for. SettingError : it is no such file."""
    try:
        said = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        do = "Correct it; see docs/reference/dome-tables.md."
        raise SettingError(str(path), wanted="a file in TOML", found=str(error), do=do) from error
    _known(str(path), {name: said[name] for name in said if name not in ("camera", "sensor")}, KEYS)
    values = {name: dict(_table(path, name, said.get(name, {}))) for name in KEYS}
    dome, specimen = values["dome"], values["specimen"]
    if dome["skin_mm"] >= dome["radius_mm"] / 2:
        do = "Correct skin_mm or radius_mm."
        wanted = "a skin thinner than half the radius"
        raise SettingError(f"{path}, dome.skin_mm", wanted=wanted, found=f"{dome['skin_mm']:g} mm", do=do)
    if specimen["radius_mm"] < dome["radius_mm"]:
        wanted, found = f"at least the dome's radius, {dome['radius_mm']:g}", f"{specimen['radius_mm']:g}"
        raise SettingError(f"{path}, specimen.radius_mm", wanted=wanted, found=found, do="Take a wider specimen.")
    if not (specimen["stiffness_n_per_mm"] or specimen["rigid"]) or not specimen["friction"]:
        wanted = "one stiffness at least, or rigid = true, and one friction"
        raise SettingError(f"{path}, specimen", wanted=wanted, found="none", do="Add one.")
    return list(_cases(values))


def _known(where: str, found: dict[str, Any], known: dict[str, Any]) -> None:
    for key in found:
        if key not in known:
            near = get_close_matches(key, list(known), 1)
            do = f"Did you mean {near[0]}?" if near else "Remove it."
            raise SettingError(where, wanted=f"only {', '.join(known)}", found=key, do=do)


def _table(path: Path, name: str, found: Any) -> Iterator[tuple[str, Any]]:
    if not isinstance(found, dict):
        raise SettingError(f"{path}, {name}", wanted=f"a table [{name}]", found=repr(found), do=f"Write [{name}].")
    _known(f"{path}, {name}", found, KEYS[name])
    for key, (default, (wanted, good)) in KEYS[name].items():
        value = found.get(key, default)
        if not good(value):
            do = "Add it." if value is None else "Correct it."
            shown = "none" if value is None else repr(value)
            raise SettingError(f"{path}, {name}.{key}", wanted=wanted, found=shown, do=do)
        yield key, value


def _cases(values: dict[str, dict[str, Any]]) -> Iterator[Case]:
    d, s, solve = values["dome"], values["specimen"], values["solve"]
    dome = Dome(
        float(d["radius_mm"]), float(d["skin_mm"]), Rubber(float(d["skin_modulus_mpa"]), float(d["skin_poisson"])),
        Rubber(float(d["gel_modulus_mpa"]), float(d["gel_poisson"])),
    )  # fmt: skip
    several = isinstance(s["height_mm"], list)
    heights = sorted(map(float, s["height_mm"] if several else [s["height_mm"]]))
    soft = list(product(sorted(map(float, s["stiffness_n_per_mm"])), heights))
    for stiffness, height in [*soft, *([(np.inf, heights[-1])] if s["rigid"] else [])]:
        size, rubber, called = (float(s["radius_mm"]), height), None, "rigid"
        if stiffness < np.inf:
            poisson = float(s["poisson"])
            rubber = Rubber(stiffness / LENGTHS[s["stiffness_by"]](*size, poisson), poisson)
            called = _called(stiffness) + f"_h{height:g}" * several
        for friction in s["friction"]:
            mu = float(FRICTIONS.get(friction, friction))
            word = "mu" * (friction not in FRICTIONS) + _called(friction)
            pressing = Pressing(dome, Specimen(rubber, *size), mu, float(solve["force_n"]), float(solve["mesh_mm"]))
            yield Case(f"{d['name']}_k{called}_{word}", pressing, stiffness, s["stiffness_by"])
