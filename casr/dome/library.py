"""Many solutions of a dome's contact on one grid, so that a press can be held against all of them at once."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib import resources
from itertools import pairwise
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from casr.dome.spline import Spline
from casr.dome.tables import SMOOTH_FROM_N, USUAL_HEIGHT_MM, ContactTable, read_table
from casr.dome.view import Real
from casr.errors import PassingError, SettingError

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

MODULI_MPA = {
    "C": (0.8, 0.01), "J": (0.8, 0.02), "H": (0.8, 0.05), "D": (0.8, 0.1), "E": (0.3, 0.1), "I": (0.3, 0.2),
    "G": (0.15, 0.3),
}  # fmt: skip
"""Moduli of skin and gel of the domes of the shipped library, softest gel first for each skin. Nothing else differs."""
FAMILY = tuple(MODULI_MPA)
SHIPPED = "library.npz"
DEFAULT_WORLD = "skin_over_gel.npz"
"""Dome A, which the simulator presses; the library does not hold it."""
DIGESTS = {
    SHIPPED: "82c9ac20bff6ee033b8a172c32cddfeedabea0b8f6cd13f64340f33a9c26c188",
    DEFAULT_WORLD: "086de282cdf307adab8f6dda05990879f8105b318bedcf5fae0805b0573293c5",
}
"SHA-256 of the files, as scripts/dome_tables prints them: what hangs on the tables is known to hang on this module."
LAST_RADIUS_MM = 18.0
_QUANTUM = 2e-4
"Step in which files store the motion, mm or rad: a fiftieth of a pixel at 10 px/mm would be 2e-3."
_SMOOTH_DEGREE = 6
_TREND_FROM = 0.6
"A table is continued along the lines through its steps from this share of its largest radius on."


_MATTERS = 0.25
"Weight of a table from which on a world counts as computed as far as that table only."
USUAL_STIFFNESS = 3.0
"Stiffness of a usual dome, N/mm: motion runs most evenly over 1 / (1 + stiffness of the specimen / that of the dome)."
_OF_WORLDS = ("dome", "stiffness_n_per_mm", "friction", "height_mm", "computed_mm", "force_n", "edge_arc_mm", "motion")


@dataclass(frozen=True, eq=False)
class Library:
    """W worlds (a dome on a specimen), R contact radii, S arcs.

    dome, stiffness_n_per_mm, friction, height_mm : (W,) of each world; stiffness is inf for a rigid plate, whose height
        says nothing.
    radius_mm : (R,) evenly spaced. arc_mm : (S,) evenly spaced from 0, along the inside of the undeformed skin.
    computed_mm : (W,) largest radius that was computed; beyond it is continued.
    force_n, edge_arc_mm : (W, R) normal force at each radius, and the edge on the undeformed outside of the skin.
    motion : (W, R, S, 3) displacement outward and towards the tip, mm, and rotation, rad.
    """

    dome: NDArray[np.str_]
    stiffness_n_per_mm: Array
    friction: NDArray[np.str_]
    height_mm: Array
    radius_mm: Array
    arc_mm: Array
    computed_mm: Array
    force_n: Array
    edge_arc_mm: Array
    motion: NDArray[np.float32]

    @property
    def n_worlds(self) -> int:
        """W."""
        return len(self.dome)

    def only(self, worlds: Rows) -> Library:
        """Some of the worlds."""
        return replace(self, **{name: getattr(self, name)[worlds] for name in _OF_WORLDS})

    def beside(self, *others: Library) -> Library:
        """These worlds, then those of other libraries on the same grid."""
        every = (self, *others)
        return replace(self, **{name: np.concatenate([getattr(each, name) for each in every]) for name in _OF_WORLDS})

    def motion_at(self, arc_mm: Array, kind: type[Real]) -> NDArray[Real]:
        """(3, N, R, W) motion at arcs (N,); beyond the last arc that of the last.

        kind : single precision where speed counts for more than digits: an arc that differs in its last one moves the
        seventh of the motion, and areas by 1e-6.
        """
        return self.between(*self.nodes_at(arc_mm), kind)

    def nodes_at(self, arc_mm: Array) -> tuple[Rows, Array]:
        """(N,) node below each arc (N,), mm, and the share of the one above it; of ``between``."""
        place = np.clip(arc_mm / self.arc_mm[1], 0, self.arc_mm.size - 1.000001)
        low = place.astype(np.intp)
        return low, place - low

    def between(self, low: Rows, share: Array, kind: type[Real]) -> NDArray[Real]:
        """``motion_at`` arcs of ``nodes_at``, and its ``kind``."""
        part = share.astype(kind)[:, None, None]
        between: NDArray[Real] = self._by_arc.take(low, axis=1).astype(kind, copy=False)
        between *= 1 - part
        above = self._by_arc.take(low + 1, axis=1).astype(kind, copy=False)
        above *= part
        between += above
        return between

    @cached_property
    def coarse(self) -> Library:
        """The same worlds at every fourth radius."""
        return self.at_radii(slice(None, None, 4))

    def at_radii(self, some: slice) -> Library:
        """The same worlds at some of the radii."""
        by_radius = {name: getattr(self, name)[:, some] for name in ("force_n", "edge_arc_mm", "motion")}
        return replace(self, radius_mm=self.radius_mm[some], **by_radius)

    @cached_property
    def _by_arc(self) -> NDArray[np.float32]:
        """(3, S, R, W) the motion, so that what belongs to an arc lies together."""
        return np.ascontiguousarray(self.motion.transpose(3, 2, 1, 0))

    def save(self, file: Path | IO[bytes]) -> None:
        """Write it with the motion in steps of 0.2 micrometres."""
        motion = np.round(self.motion / _QUANTUM)
        np.savez_compressed(
            file, dome=self.dome, stiffness_n_per_mm=self.stiffness_n_per_mm, friction=self.friction,
            height_mm=self.height_mm, radius_mm=self.radius_mm, arc_mm=self.arc_mm, computed_mm=self.computed_mm,
            force_n=self.force_n.astype(np.float32), edge_arc_mm=self.edge_arc_mm.astype(np.float32),
            motion=motion.clip(-32767, 32767).astype(np.int16),
        )  # fmt: skip


def gather(tables: Sequence[ContactTable], *, radius_step_mm: float, arc_step_mm: float) -> Library:
    """The tables on one grid of radii and arcs, steps in mm; arcs end where the shortest table does."""
    radius = np.arange(1.0, LAST_RADIUS_MM + radius_step_mm / 2, radius_step_mm)
    arc = np.arange(0.0, min(table.s_mm[-1] for table in tables), arc_step_mm)
    gridded = [_by_radius(table, radius, arc) for table in tables]
    return Library(
        dome=np.array([table.dome for table in tables]),
        stiffness_n_per_mm=np.array([table.stiffness_n_per_mm for table in tables]),
        friction=np.array([table.friction for table in tables]),
        height_mm=np.array([table.height_mm for table in tables]), radius_mm=radius, arc_mm=arc,
        computed_mm=np.array([table.contact_radius_mm[-1] for table in tables]),
        force_n=np.array([each[0] for each in gridded]), edge_arc_mm=np.array([each[1] for each in gridded]),
        motion=np.array([each[2] for each in gridded], dtype=np.float32),
    )  # fmt: skip


def _by_radius(table: ContactTable, radius: Array, arc: Array) -> tuple[Array, Array, Array]:
    """(R,) force, (R,) edge and (R, S, 3) motion at each radius."""
    low = np.clip(np.searchsorted(table.s_mm, arc) - 1, 0, table.s_mm.size - 2)
    share = ((arc - table.s_mm[low]) / (table.s_mm[low + 1] - table.s_mm[low]))[:, None]
    on_arc = table.motion[:, low] * (1 - share) + table.motion[:, low + 1] * share
    radius_mm = _smooth_radius(table)
    rising = np.append(False, np.diff(np.maximum.accumulate(radius_mm)) > 0)
    reached = radius_mm[rising]
    near_end = reached >= _TREND_FROM * reached[-1]
    log_force = _continued(np.log(reached), np.log(table.force_n[rising]), np.log(radius), near_end)
    edge = _continued(reached, table.edge_arc_mm[rising], radius, near_end)
    return np.exp(log_force), edge, _continued(reached, on_arc[rising], radius, near_end)


def _smooth_radius(table: ContactTable) -> Array:
    """(T,) radius without the steps that the edge makes from node to node of the mesh (0.5 % of it)."""
    smoothed = table.force_n >= SMOOTH_FROM_N
    log_force = np.log(table.force_n[smoothed])
    weights = np.sqrt(np.gradient(log_force))  # so that all forces count alike
    law = np.polynomial.Polynomial.fit(log_force, np.log(table.contact_radius_mm[smoothed]), _SMOOTH_DEGREE, w=weights)
    radius = table.contact_radius_mm.copy()
    radius[smoothed] = np.exp(law(log_force))
    return radius


def _continued(x: Array, y: Array, at: Array, near_end: NDArray[np.bool_]) -> Array:
    """y(x) at ``at``: along lines between rows and below the first, beyond the last along the parabola of the last."""
    row = np.clip(np.searchsorted(x, at) - 1, 0, x.size - 2)
    wide = (slice(None),) + (None,) * (y.ndim - 1)
    part = ((at - x[row]) / (x[row + 1] - x[row]))[wide]
    inside = y[row] * (1 - part) + y[row + 1] * part
    powers = np.vander(x[near_end] - x[-1], 3)[:, :2]  # through the last row
    slopes = np.linalg.lstsq(powers, (y[near_end] - y[-1]).reshape(len(powers), -1), rcond=None)[0]
    ahead = np.vander(np.maximum(at - x[-1], 0.0), 3)[:, :2]
    beyond = y[-1] + (ahead @ slopes).reshape(at.shape + y.shape[1:])
    return np.where((at > x[-1])[wide], beyond, inside)


def with_between(library: Library) -> Library:
    """Also the worlds halfway in compliance between neighbours in stiffness, along splines through all stiffnesses of a
    dome, and those halfway between neighbouring domes of ``FAMILY``."""
    halfway = []
    for dome, friction in sorted(set(zip(library.dome.tolist(), library.friction.tolist(), strict=True))):
        rows = np.flatnonzero((library.dome == dome) & (library.friction == friction))
        rows = rows[np.argsort(-library.stiffness_n_per_mm[rows])]
        if rows.size > 1 and (np.diff(library.stiffness_n_per_mm[rows]) < 0).all():
            halfway.append(_halfway(library, rows))
    library = library.beside(*halfway)
    pairs = _next_in_family(library)
    both = np.array([pair[:2] for pair in pairs], dtype=np.intp).reshape(-1, 2)
    dome = np.array([pair[2] for pair in pairs], dtype=np.str_)
    return library.beside(_mixed(library, both, np.full(both.shape, 0.5), dome=dome))


def _mixed(library: Library, rows: NDArray[np.intp], weights: Array, **of_worlds: Any) -> Library:
    """Worlds that are mixed of those of the rows (W, K) with weights (W, K), and what else is different in them than in
    the first of each."""
    one = library.only(rows[:, 0])
    reached_mm = np.where(np.abs(weights) >= _MATTERS, library.computed_mm[rows], np.inf)

    def mixed(values: NDArray[Any]) -> NDArray[Any]:
        wide = weights.astype(values.dtype).reshape(*weights.shape, *(1,) * (values.ndim - 1))
        return np.asarray(sum(wide[:, k] * values[rows[:, k]] for k in range(rows.shape[1])))

    return replace(
        one, computed_mm=reached_mm.min(axis=1), force_n=np.exp(mixed(np.log(library.force_n))),
        edge_arc_mm=mixed(library.edge_arc_mm), motion=mixed(library.motion), **of_worlds,
    )  # fmt: skip


SAME_HEIGHT = 0.02
"Heights that differ by no more than this share of them are one: the area changes by 0.5 % at most."


def of_height(library: Library, height_mm: float) -> Library:
    """The worlds on specimens of this height, mm of a dome of 20 mm, and on rigid plates.

    Between two heights of one dome, stiffness and friction the motion and the logarithm of the force lie on lines over
    height^(-1/2): at 1.1 and 5.3 N/mm within 1 % of the area at 15 mm between 10 and 25 mm, 3 % at 10 between 7 and 25.
    SettingError : no tables enclose the height.
    """
    pairs = [pair for rows in _next_in_height(library) if (pair := _around(library.height_mm[rows], rows, height_mm))]
    if not pairs:
        known = np.unique(library.height_mm[np.isfinite(library.stiffness_n_per_mm)].round(2))
        raise SettingError(
            "specimen_height_mm",
            wanted=f"tables of one dome, stiffness and friction on both sides of {height_mm:.4g} mm",
            found=f"heights of {', '.join(f'{each:g}' for each in known)} mm in all tables, in mm of a dome of 20 mm",
            do="Solve them: height_mm = [lower, higher] under [specimen] of the file for casr dome.",
        )  # fmt: skip
    rows, share = np.array([pair[:2] for pair in pairs], dtype=np.intp), np.array([pair[2] for pair in pairs])
    weights = np.column_stack([1 - share, share])
    soft = _mixed(library, rows, weights, height_mm=np.full(len(pairs), height_mm))
    return library.only(np.flatnonzero(np.isinf(library.stiffness_n_per_mm))).beside(soft)


def _next_in_height(library: Library) -> list[Rows]:
    """Rows of soft specimens that differ in height alone, the lowest first."""
    rows: dict[tuple[str, float, str], list[int]] = {}
    stiffness = library.stiffness_n_per_mm.round(6).tolist()
    for row, key in enumerate(zip(library.dome.tolist(), stiffness, library.friction.tolist(), strict=True)):
        if np.isfinite(key[1]):
            rows.setdefault(key, []).append(row)
    return [np.array(sorted(each, key=lambda row: float(library.height_mm[row]))) for each in rows.values()]


def _around(heights_mm: Array, rows: Rows, height_mm: float) -> tuple[int, int, float] | None:
    """The row of the height, or those below and above it, and the share of the latter; None where there are none."""
    near = int(np.argmin(np.abs(heights_mm - height_mm)))
    if abs(heights_mm[near] / height_mm - 1) <= SAME_HEIGHT:
        return int(rows[near]), int(rows[near]), 0.0
    high = int(np.searchsorted(heights_mm, height_mm))
    if high in (0, len(rows)):
        return None
    low, here, above = np.array([heights_mm[high - 1], height_mm, heights_mm[high]]) ** -0.5
    return int(rows[high - 1]), int(rows[high]), float((low - here) / (low - above))


def _halfway(library: Library, rows: Rows) -> Library:
    """The worlds halfway in compliance between those of the rows, which differ in it alone, from stiff to soft."""
    compliance = 1 / library.stiffness_n_per_mm[rows]
    halfway = (compliance[1:] + compliance[:-1]) / 2
    spline = Spline(_softness(compliance))
    weights = np.array([spline.weights(at) for at in _softness(halfway).tolist()])
    every = np.broadcast_to(rows, weights.shape)
    return _mixed(library, every, weights, stiffness_n_per_mm=1 / halfway)


def _softness(compliance: Array) -> Array:
    return compliance / (compliance + 1 / USUAL_STIFFNESS)


def _next_in_family(library: Library) -> list[tuple[int, int, str]]:
    """Rows of two worlds on alike specimens, and the dome between them."""
    names = zip(
        library.dome.tolist(), library.friction.tolist(), library.stiffness_n_per_mm.round(6).tolist(), strict=True
    )
    row_of = {name: row for row, name in enumerate(names)}
    there = [dome for dome in FAMILY if dome in library.dome]
    softer = dict(pairwise(reversed(there)))
    return [
        (other, row, f"{softer[dome]}+{dome}")
        for (dome, friction, stiffness), row in row_of.items()
        if (other := row_of.get((softer.get(dome, ""), friction, stiffness))) is not None
    ]


@cache
def tables_of(folder: str) -> tuple[ContactTable, ...]:
    """The tables of a folder (layout: ``casr.dome.tables``). SettingError where there are none."""
    paths = sorted(Path(folder).glob("*.npz"))
    if not paths:
        raise SettingError(
            folder, wanted="tables of domes, <dome>_k<stiffness>_<friction>.npz", found="none",
            do="Give the folder that holds them.",
        )  # fmt: skip
    return tuple(map(read_table, paths))


def read_library(folder: Path) -> Library:
    """The tables of a folder on the grid of those that are shipped; errors as ``tables_of``."""
    return gather(tables_of(str(folder)), radius_step_mm=0.25, arc_step_mm=0.5)


@cache
def shipped(name: str = SHIPPED) -> Library:
    """A library that comes with casr. PassingError : the file is not the one that casr was made with."""
    data = resources.files("casr.dome").joinpath(name).read_bytes()
    if hashlib.sha256(data).hexdigest() != DIGESTS[name]:
        raise PassingError(
            name, wanted="the tables that casr was made with", found="other or damaged tables", do="Install casr again."
        )
    with np.load(io.BytesIO(data), allow_pickle=False) as kept:
        arrays = {key: kept[key] for key in kept.files}
    motion = arrays.pop("motion").astype(np.float32) * np.float32(_QUANTUM)
    wide = {key: arrays.pop(key).astype(np.float64) for key in ("force_n", "edge_arc_mm")}
    arrays.setdefault("height_mm", np.full(arrays["dome"].shape, USUAL_HEIGHT_MM))
    return Library(**arrays, **wide, motion=motion)


@cache
def worlds(folder: str | None = None, height_mm: float | None = None) -> Library:
    """What a press is held against: the shipped domes and those between them, and the domes of a lab's ``folder``.

    height_mm : of the specimen, mm of a dome of 20 mm; None: tables of all heights. SettingError : see ``of_height``.
    """
    return with_between(tables(folder, height_mm))


@cache
def tables(folder: str | None = None, height_mm: float | None = None) -> Library:
    """``worlds`` without what lies between the tables.

    folder : of a lab's own tables. height_mm : of the specimen, mm.
    SettingError : the arcs of the folder's tables end before those that come with casr; also as ``of_height``.
    """
    ours = shipped()
    if height_mm is not None:
        return of_height(tables(folder), height_mm)
    if folder is None:
        return ours
    own = read_library(Path(folder))
    if own.radius_mm.shape != ours.radius_mm.shape or own.arc_mm.size < ours.arc_mm.size:
        raise SettingError(
            folder, wanted=f"tables whose arc reaches {ours.arc_mm[-1]:g} mm", found=f"{own.arc_mm[-1]:g} mm",
            do="Compute the skin as far as its clamped edge.",
        )  # fmt: skip
    same_grid: dict[str, Any] = {
        "radius_mm": ours.radius_mm,
        "arc_mm": ours.arc_mm,
        "motion": own.motion[:, :, : ours.arc_mm.size],
    }
    return ours.beside(replace(own, **same_grid))
