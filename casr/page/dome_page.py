"""The page of a dome whose tables were solved: section and pins, how they move, areas, how unlike other domes it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr import html
from casr.contact_area.library_front import FREE_MISFIT
from casr.dome.library import Library, gather
from casr.dome.tables import ContactTable
from casr.dome.view import INNER_RADIUS_MM, OUTER_RADIUS_MM
from casr.page.pages import picture_figure, whole_page
from casr.palette import BLUE, FAINT, GREEN, PURPLE, RED, SKY, YELLOW
from casr.svg import Axes, Picture

Array = NDArray[np.float64]

PIN_MM, PITCH_MM = 3.0, 3.5
"""Length and pitch of the pins that are drawn, in millimetres of a dome of 20 mm: the sensor's file says nothing of
them.
"""
_AT_N = (0.5, 1.0, 2.0, 4.0)
_COLOURS = (BLUE, RED, GREEN, PURPLE, YELLOW, SKY)
_REACH_MM = 25.0
"Arc, up to which pins stand."


@dataclass(frozen=True, eq=False)
class SolvedTable:
    """name : of its file. said : its metadata, see docs/reference/dome-tables.md."""

    name: str
    table: ContactTable
    said: dict[str, Any]


def dome_page(solved: Sequence[SolvedTable], others: Library) -> str:
    """The page as HTML. solved : the tables of one dome, one at least. others : domes to compare it with."""
    first = solved[0].said
    dome, scale = first["pressing"]["dome"], first["dome_radius_mm"] / OUTER_RADIUS_MM
    worst = max(each.said["area_error"] for each in solved)
    tiles = [
        ("Radius", f"{dome['radius_mm']:g} mm", "outside"),
        ("Skin", f"{dome['skin_mm']:g} mm", f"{dome['skin']['modulus_mpa']:g} MPa"),
        ("Filling", f"{1e3 * dome['gel']['modulus_mpa']:g} kPa", "Young's modulus"),
        ("dome_radius_mm", f"{first['dome_radius_mm']:.4g}", "for camera.toml"),
        ("Tables", str(len(solved)), f"areas within {worst:.1%}"),
    ]
    unlike = [unlikeness(each.table, others) for each in solved]
    drawn = [_section(solved, scale), _field(solved, scale), _areas(solved, scale), _unlike(solved, unlike, scale)]
    pictures = html.section("pictures", "Pictures", html.pictures(map(picture_figure, drawn)))
    numbers = html.section("numbers", "Numbers", _table(solved, unlike))
    return whole_page(
        f"Dome {solved[0].table.dome}", "Contact by finite elements", html.tiles(tiles) + pictures + numbers
    )


@dataclass(frozen=True, eq=False)
class Unlike:
    """How far a table is from the nearest of other worlds. radius_mm, share : (R,) what of the motion of tips of pins
    that world leaves over at a contact radius. dome : its name. worst : largest share.
    """

    radius_mm: Array
    share: Array
    dome: str

    @property
    def worst(self) -> float:
        return float(self.share.max())


def unlikeness(table: ContactTable, others: Library) -> Unlike:
    """The world is that which leaves least over all radii, each at the radius and amplitude that fit best, as the front
    of a press is found."""
    own = gather([table], radius_step_mm=0.25, arc_step_mm=0.5)
    rows = np.flatnonzero((own.radius_mm >= 2) & (own.radius_mm <= own.computed_mm[0]))
    arcs = np.arange(0.0, _REACH_MM, 0.5)
    weight = np.sqrt(np.sin(arcs / INNER_RADIUS_MM))  # pins of a ring are as many as it is long
    (mine,), theirs = (weight * _outward(of.motion_at(arcs, np.float64).T, arcs) for of in (own, others))  # (W, R, S)
    length = np.linalg.norm(theirs, axis=-1)
    alike = np.abs(np.einsum("rs,wqs->wrq", mine[rows], theirs)) / length[:, None]
    left = np.sqrt(np.maximum(1 - (alike.max(axis=2) / np.linalg.norm(mine[rows], axis=-1)) ** 2, 0.0))
    best = int(np.argmin((left**2).sum(axis=1)))
    return Unlike(own.radius_mm[rows], left[best], str(others.dome[best]))


def _outward(motion: Array, arcs: Array) -> Array:
    """Motion of tips of pins away from the axis, mm; motion (..., S, 3)."""
    angle = arcs / INNER_RADIUS_MM
    return np.asarray(motion[..., 0] + PIN_MM * (np.sin(angle) - np.sin(angle - motion[..., 2])))


def _at(table: ContactTable, force_n: float) -> Array:
    """(P, 3) motion at a force."""
    row = np.interp(force_n, table.force_n, np.arange(table.force_n.size))
    low = min(int(row), table.force_n.size - 2)
    return np.asarray(table.motion[low] * (low + 1 - row) + table.motion[low + 1] * (row - low))


def _ends(solved: Sequence[SolvedTable]) -> list[SolvedTable]:
    """Results on the softest and on the hardest specimen."""
    ranked = sorted(solved, key=lambda each: each.table.stiffness_n_per_mm)
    return ranked[:1] if len(ranked) == 1 else [ranked[0], ranked[-1]]


def _looks(solved: Sequence[SolvedTable]) -> list[tuple[SolvedTable, dict[str, Any]]]:
    """Colour by specimen, which is told once, and dashes where nothing sticks."""
    specimens = list(dict.fromkeys(_specimen(each) for each in solved))
    looks, told = [], set()
    for each in solved:
        name = _specimen(each)
        dash = "10 8" if each.table.friction == "frictionless" else ""
        colour = _COLOURS[specimens.index(name) % len(_COLOURS)]
        looks.append((each, {"colour": colour, "dash": dash, "label": "" if name in told else name}))
        told.add(name)
    return looks


def _section(solved: Sequence[SolvedTable], scale: float) -> Picture:
    size = OUTER_RADIUS_MM * scale
    axes = Axes((0.0, 1.15 * size, 1.25 * size, 0.0), ("mm from the axis", "mm from the flange"), height=700)
    dome = solved[0].said["pressing"]["dome"]
    angle = np.linspace(0, np.pi / 2, 60)
    around = np.array([np.sin(angle), np.cos(angle)]).T
    axes.line(dome["radius_mm"] * around, FAINT, label="skin at rest")
    axes.line((dome["radius_mm"] - dome["skin_mm"]) * around, FAINT)
    roots = np.arange(0.0, _REACH_MM + 1e-9, PITCH_MM)
    for each, colour in zip(_ends(solved), (BLUE, RED), strict=False):
        table, moved = each.table, _at(each.table, _AT_N[2])
        angle = table.s_mm / INNER_RADIUS_MM
        at = INNER_RADIUS_MM * np.array([np.sin(angle), np.cos(angle)]).T + moved[:, :2]
        axes.line(scale * at, colour, label=f"inside at {_AT_N[2]:g} N on {_specimen(each)}")
        for root in roots:
            foot = np.array([np.interp(root, table.s_mm, column) for column in at.T])
            turn = root / INNER_RADIUS_MM - float(np.interp(root, table.s_mm, moved[:, 2]))
            axes.line(scale * np.array([foot, foot - PIN_MM * np.array([np.sin(turn), np.cos(turn)])]), colour)
    pins = f"pins of {scale * PIN_MM:.2g} mm every {scale * PITCH_MM:.2g} mm"
    caption = f"Half of it, flange below. The sensor's file says nothing of pins: {pins} are drawn."
    return Picture("section", "Dome and pins", caption, axes)


def _field(solved: Sequence[SolvedTable], scale: float) -> Picture:
    each = _ends(solved)[-1]
    table, arcs = each.table, np.linspace(0, _REACH_MM, 101)
    forces = [force for force in _AT_N if force <= table.force_n[-1]]
    curves = []
    for force in forces:
        motion = np.array([np.interp(arcs, table.s_mm, column) for column in _at(table, force).T]).T
        curves.append(scale * np.column_stack([arcs, _outward(motion, arcs)]))
    top = 1.1 * max(float(curve[:, 1].max()) for curve in curves)
    low = min(0.0, *(1.1 * float(curve[:, 1].min()) for curve in curves))
    axes = Axes((0.0, top, scale * _REACH_MM, low), ("arc from the pole, inside (mm)", "tip outward (mm)"))
    for force, curve, colour in zip(forces, curves, _COLOURS, strict=False):
        axes.line(curve, colour, label=f"{force:g} N")
    caption = (
        f"How far tips of pins move away from the axis on {_specimen(each)}; the fold is near the edge of contact."
    )
    return Picture("field", "Motion of pins", caption, axes)


def _areas(solved: Sequence[SolvedTable], scale: float) -> Picture:
    curves = [np.pi * (scale * each.table.contact_radius_mm) ** 2 for each in solved]
    right = max(float(each.table.force_n[-1]) for each in solved)
    top = 1.08 * max(float(curve.max()) for curve in curves)
    axes = Axes((0.0, top, right, 0.0), ("force (N)", "contact area (mm²)"))
    for (each, look), curve in zip(_looks(solved), curves, strict=True):
        error = each.said["area_error"]
        axes.band(each.table.force_n, curve * (1 - error), curve * (1 + error), look["colour"], opacity=0.1)
        axes.line(np.column_stack([each.table.force_n, curve]), title=each.name, **look)
    caption = "Seen along the axis. Dashed: without friction. Bands: the stated error of the solution."
    return Picture("areas", "Contact area", caption, axes)


def _unlike(solved: Sequence[SolvedTable], unlike: Sequence[Unlike], scale: float) -> Picture:
    right = scale * max(float(each.radius_mm[-1]) for each in unlike)
    top = max(6.0, 110 * max(each.worst for each in unlike))
    axes = Axes((0.0, top, right, 0.0), ("radius of contact (mm)", "left over (%)"))
    axes.level(100 * FREE_MISFIT)
    for (each, look), own in zip(_looks(solved), unlike, strict=True):
        at = np.column_stack([scale * own.radius_mm, 100 * own.share])
        axes.line(at, title=f"{each.name}, like {own.dome}", **look)
    caption = (
        "What of the motion of the pins the nearest dome that comes with casr leaves over. Above the line, "
        f"{FREE_MISFIT:.0%}, a press that is scored without these tables comes with a doubt."
    )
    return Picture("misfit", "Misfit to other domes", caption, axes)


def _table(solved: Sequence[SolvedTable], unlike: Sequence[Unlike]) -> str:
    heads = ("Table", *(f"A({force:g} N), mm²" for force in _AT_N), "error", "of mesh and steps", "of penalty",
             "balance", "nearest dome", "misfit")  # fmt: skip
    rows = []
    for each, own in zip(solved, unlike, strict=True):
        said, parts = each.said, each.said["area_error_of"]
        areas = [f"{area:.1f}" if np.isfinite(area) else "–" for area in said["area_mm2"].values()]
        errors = [f"{share:.1%}" for share in (said["area_error"], parts["mesh_and_steps"], parts["penalty"])]
        rows.append((each.name, *areas, *errors, f"{said['force_unbalance']:.0e}", own.dome, f"{own.worst:.1%}"))
    return html.table("Balance: force of contact against that on the flange.", heads, rows)


def _specimen(each: SolvedTable) -> str:
    if np.isinf(each.table.stiffness_n_per_mm):
        return "a rigid plate"
    return f"{each.table.stiffness_n_per_mm:g} N/mm, {each.said['pressing']['specimen']['height_mm']:.3g} mm high"
