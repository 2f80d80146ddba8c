"""Worlds that presses are simulated in, each with the library of domes that may explain them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path

import numpy as np

from casr.dome.library import FAMILY, SHIPPED, Library, shipped, with_between
from casr.dome.library import worlds as all_domes
from casr.errors import SettingError
from emg2vsa.worlds.tactile import ContactWorld, TabulatedWorld, World

FULL_TABLES = Path(os.environ.get("EMG2VSA_TEST_DATA", Path(__file__).parents[3] / "shared" / "data")) / "contact_fem"
STICK_FORCES_N = (0.1, 0.43, 1.0, 2.0)
FRONT_FORCE_N = 7.0
"Of the last press: no skin is caught before it."
FRICTIONS = ("stick", "frictionless")


@dataclass(frozen=True)
class BenchWorld:
    """A world. library : that its presses are scored with. absent : why it cannot be simulated here, or empty."""

    world: World | None
    library: Library
    absent: str = ""


GROUPS = {
    "tabulated": ("tabulated", "tabulated-frictionless"),
    "full": ("full", "full-frictionless"),
    "domes": tuple(f"dome-{dome}-{friction}" for dome in FAMILY for friction in FRICTIONS),
    "stick": (*(f"stick-{force:g}" for force in STICK_FORCES_N), "front"),
}
GROUPS["all"] = tuple(name for group in GROUPS.values() for name in group)


def named(asked: Sequence[str]) -> tuple[str, ...]:
    """Names of worlds, from names of worlds and of groups. SettingError for another name."""
    found: dict[str, None] = {}
    for name in asked:
        names = GROUPS.get(name, (name,) if name in GROUPS["all"] else ())
        if not names:
            raise SettingError(
                "--world", wanted=f"{', '.join(GROUPS)} or one of {', '.join(GROUPS['all'])}", found=repr(name),
                do="Check the spelling.",
            )  # fmt: skip
        found |= dict.fromkeys(names)
    return tuple(found)


@cache
def world_named(name: str) -> BenchWorld:
    """One world of ``GROUPS``."""
    kind, _, rest = name.partition("-")
    if kind == "dome":
        dome, _, friction = rest.partition("-")
        return BenchWorld(TabulatedWorld(friction=friction, dome=dome, tables=SHIPPED), without(dome))
    if kind == "stick":
        return BenchWorld(ContactWorld(stick_force_n=float(rest)), all_domes())
    if kind == "front":
        return BenchWorld(ContactWorld(stick_force_n=FRONT_FORCE_N), all_domes())
    friction = rest or "stick"
    if kind == "tabulated":
        return BenchWorld(TabulatedWorld(friction=friction), all_domes())
    if not FULL_TABLES.is_dir():
        return BenchWorld(None, all_domes(), f"no {FULL_TABLES.name} (EMG2VSA_TEST_DATA names the folder above it)")
    return BenchWorld(TabulatedWorld(friction=friction, tables=str(FULL_TABLES)), all_domes())


def without(dome: str) -> Library:
    """The shipped library as it would be without one dome."""
    library = shipped()
    kept = library.dome != dome
    arrays = {field.name: getattr(library, field.name) for field in fields(Library)}
    grids = {name: arrays.pop(name) for name in ("radius_mm", "arc_mm")}
    return with_between(Library(**grids, **{name: np.asarray(array)[kept] for name, array in arrays.items()}))
