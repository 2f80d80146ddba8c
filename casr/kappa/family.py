"""Domes of a library as one continuous family: motion and force at any dome, specimen and friction between the tables.

Motion at a contact radius depends on the ratio of gel to skin, on the specimen's stiffness over that of the dome, and
on friction; no modulus of its own enters. A dome's stiffness kappa0 is measured on its own table: that of a Hertz
contact, 3/2 F R / a^2, which has the same force on a rigid plate at the radius ``REFERENCE_MM``. So a world lies at

    place (of the dome in its family),  z = 1 / (1 + kappa / kappa0),  stick (share of friction),

z = 0 on a rigid plate, z = 1 on a specimen so soft that the dome keeps its shape. Between tables motion and the
logarithm of force / (kappa0 (1 - z)) run along cubic splines, in z and from dome to dome. Only the tables' numbers
enter: domes stand as far apart as their motions on a rigid plate are.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from casr.dome.library import FAMILY, Library, Rows
from casr.dome.spline import Spline
from casr.dome.tables import USUAL_HEIGHT_MM
from casr.dome.view import OUTER_RADIUS_MM
from casr.errors import SettingError

Array = NDArray[np.float64]

REFERENCE_MM = 6.0
"Contact radius at which domes are compared: the stiffest reaches it at 8 N."
_MATTERS = 0.1
"Weight of a table."
_COMPARED_MM = (3.0, 9.0)
_PLACE_STEP, _Z_STEP = 1e-4, 1e-4
"Steps of the differences that give slopes."


@dataclass(frozen=True, eq=False)
class World:
    """Weights of the K tables of a family at one place, and what the force is scaled with.

    motion, force : (K,) weights. log_scale : ln of what the mixed force is to be multiplied with.
    """

    motion: Array
    force: Array
    log_scale: float


class Family:
    """Domes that differ in one way, each on specimens of the same S stiffnesses and in two frictions.

    bends : (B, D) weights of domes, see ``_bends``.
    names : (D,) of the domes. place : (D,) from 0 to 1. log_kappa0 : (D,) ln of their stiffness, N/mm.
    radius_mm, arc_mm : grids of the library.
    """

    def __init__(self, library: Library, names: tuple[str, ...]) -> None:
        self.names, self.radius_mm, self.arc_mm = names, library.radius_mm, library.arc_mm
        rows = [[_rows(library, dome, friction) for friction in ("frictionless", "stick")] for dome in names]
        self._rows = np.array([pair[0] + pair[1] for pair in rows], dtype=np.intp).reshape(len(names), 2, -1)
        compliance = 1 / library.stiffness_n_per_mm[self._rows[:, 0]]
        rigid = self._rows[:, :, 0]
        reference = np.array([[_force_at(library, row, REFERENCE_MM) for row in pair] for pair in rigid])
        self.log_kappa0 = np.log(1.5 * reference * OUTER_RADIUS_MM / REFERENCE_MM**2).mean(axis=1)
        kappa0 = np.exp(self.log_kappa0)[:, None]
        self._z = kappa0 * compliance / (1 + kappa0 * compliance)  # (D, S), rising from 0
        self._spline = [Spline(np.append(z, 1.0)) for z in self._z]
        self._force_spline = [Spline(z) for z in self._z]
        motion = library.motion[self._rows].astype(np.float64)
        self.place = _places(motion[:, :, 0], library.radius_mm)
        self._between = Spline(self.place)
        self._at_z: dict[float, tuple[Array, Array]] = {}
        "Weights (D, 1, S) of motion and of force at the z that was last asked for."
        self.bends = _bends(self.place)
        flat = self._rows.ravel()
        self._computed_mm = library.computed_mm[flat]
        self._motion = library.motion[flat].reshape(flat.size, -1).astype(np.float64)
        soft = np.log1p(-self._z)[:, None, :, None] + self.log_kappa0[:, None, None, None]
        self._log_force = (np.log(library.force_n[self._rows]) - soft).reshape(flat.size, -1)
        self.softest_z = float(self._z[:, -1].min())

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the numbers of the tables."""
        told = hashlib.sha256()
        motion = self._motion.astype(np.float32)  # as tables have it
        for each in (self.radius_mm, self.arc_mm, self._z, self._computed_mm, motion, self._log_force):
            told.update(np.ascontiguousarray(each).tobytes())
        return told.hexdigest()

    def at(self, place: float, of_domes: Array) -> float:
        """What a dome at a place has, of which those of the family have (D,)."""
        return float(self._between.weights(place) @ of_domes)

    def log_kappa0_at(self, place: float) -> float:
        """ln kappa0 that the library's own moduli give a dome at a place."""
        return self.at(place, self.log_kappa0)

    def world(self, place: float, z: float, stick: float, log_kappa0: float, bend: Array | None = None) -> World:
        """The world at a place of the family, and off it by shares (B,) of its ``bends``."""
        between = self._between.weights(place) + (0.0 if bend is None else bend @ self.bends)
        if z not in self._at_z:  # most changes of a world leave its z
            every = [[s.weights(z) for s in splines] for splines in (self._spline, self._force_spline)]
            self._at_z = {z: (np.array(every[0])[:, None, :-1], np.array(every[1])[:, None])}
        of_tables = between[:, None, None] * np.array([1 - stick, stick])[:, None]
        motion, force = (np.ravel(of_tables * weights) for weights in self._at_z[z])
        return World(motion, force, float(np.log1p(-z)) + log_kappa0)

    def motion_slopes(self, place: float, z: float, stick: float, bend: Array) -> Array:
        """(4 + B, K) ``World.motion`` of a world, and its slopes by place, z, stick and each of ``bends``."""
        between = self._between.weights(place) + bend @ self.bends
        by_place = (self._between.weights(place + _PLACE_STEP) - self._between.weights(place)) / _PLACE_STEP
        at_z, next_z = (np.array([s.weights(at)[:-1] for s in self._spline])[:, None] for at in (z, z + _Z_STEP))
        friction, by_stick = np.array([[1 - stick, stick], [-1.0, 1.0]])[..., None]
        of_domes = np.vstack([between, by_place, between, between, self.bends])[:, :, None, None]
        of_z = np.stack([at_z, at_z, (next_z - at_z) / _Z_STEP, at_z, *[at_z] * len(self.bends)])
        of_friction = np.stack([friction, friction, friction, by_stick, *[friction] * len(self.bends)])[:, None]
        return np.asarray((of_domes * of_friction * of_z).reshape(len(of_domes), -1))

    def motion(self, weights: Array, first: int = 0, last: int | None = None) -> Array:
        """(..., R, S, 3) motion of worlds by weights (..., K), at the radii from a first to before a last."""
        size = 3 * self.arc_mm.size
        mixed = weights @ self._motion[:, first * size : None if last is None else last * size]
        return np.asarray(mixed.reshape(*weights.shape[:-1], -1, self.arc_mm.size, 3))

    def computed_mm(self, world: World) -> float:
        """Contact radius, mm, up to which the tables that matter to a world were computed; beyond it they are
        continued."""
        return float(self._computed_mm[np.abs(world.motion) >= _MATTERS].min())

    def log_force(self, world: World) -> Array:
        """(R,) ln of the force, N, at each radius."""
        return np.asarray(world.force @ self._log_force + world.log_scale)


def families(library: Library) -> list[Family]:
    """The domes that come with casr as one family, and each dome of a lab's own as another.

    SettingError : no dome of the library has tables of both frictions on the same specimens, rigid among them.
    """
    found = [Family(library, group) for group in _groups(library) if _complete(library, group)]
    if not found:
        raise SettingError(
            "tables of domes", wanted="a dome on a rigid plate and two specimens, in both frictions", found="none",
            do="Solve the tables that are missing with casr dome.",
        )  # fmt: skip
    return found


def left_aside(library: Library) -> list[str]:
    """Domes whose tables are in no family, as some are missing."""
    return [dome for group in _groups(library) if not _complete(library, group) for dome in group]


def _groups(library: Library) -> list[tuple[str, ...]]:
    known = set(library.dome.tolist())
    ours = tuple(dome for dome in FAMILY if dome in known)
    return [*([ours] if ours else []), *((dome,) for dome in sorted(known - set(FAMILY)) if "+" not in dome)]


def _complete(library: Library, group: tuple[str, ...]) -> bool:
    kinds = {
        tuple(library.stiffness_n_per_mm[_rows(library, dome, friction)].round(6).tolist())
        for dome in group for friction in ("frictionless", "stick")
    }  # fmt: skip
    return len(kinds) == 1 and len(first := kinds.pop()) >= 3 and np.isinf(first[0])


def _rows(library: Library, dome: str, friction: str) -> list[int]:
    """Rows of a dome, the stiffest specimen first; of specimens of several heights the one nearest to the usual."""
    rows: Rows = np.flatnonzero((library.dome == dome) & (library.friction == friction))
    unusual = np.abs(np.log(library.height_mm[rows] / USUAL_HEIGHT_MM))
    rows = rows[np.lexsort((unusual, -library.stiffness_n_per_mm[rows]))]
    first = np.unique(library.stiffness_n_per_mm[rows].round(6), return_index=True)[1]
    return [int(row) for row in rows[first[::-1]]]


def _force_at(library: Library, row: int, radius_mm: float) -> float:
    return float(np.exp(np.interp(np.log(radius_mm), np.log(library.radius_mm), np.log(library.force_n[row]))))


def _bends(place: Array) -> Array:
    """(B, D) ways in which a dome may lie beside the family: as each inner dome lies beside what the others tell."""
    bends = np.zeros((max(place.size - 2, 0), place.size))
    for row, dome in enumerate(range(1, place.size - 1)):
        others = np.delete(np.arange(place.size), dome)
        bends[row, dome] = 1
        bends[row, others] = -Spline(place[others]).weights(place[dome])
    return bends


def _places(rigid: Array, radius_mm: Array) -> Array:
    """(D,) places from 0 to 1 of motions (D, F, R, S, 3) on a rigid plate, by how far neighbours are apart."""
    compared = rigid[:, :, (radius_mm >= _COMPARED_MM[0]) & (radius_mm <= _COMPARED_MM[1])]
    steps = np.sqrt(((compared[1:] - compared[:-1]) ** 2).sum(axis=(1, 2, 3, 4)))
    place = np.append(0.0, np.cumsum(steps))
    return np.asarray(place / max(place[-1], 1e-12))
