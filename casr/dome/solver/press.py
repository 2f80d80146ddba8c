"""One dome pressed on one specimen: meshes, Newton's steps along the depth, and the rows of its table."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from casr.dome.solver.bodies import Bodies, Inverted, Mesh, Rubber, Stopped, block, graded
from casr.dome.solver.contact import Contact, Grip, Opposite

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

USUAL_RADIUS_MM, USUAL_MODULUS_MPA = 20.0, 0.07
"""All is solved in the units in which the dome has this radius, and its gel with the skin's share of it this modulus:
lengths below are of that dome, and domes that differ in size or modulus alone have one solution."""
PENALTY_N_PER_MM3, PENALTY_SHARE = 28.0, 80.0
"Largest penalty, and the usual one in moduli of the specimen over the size of an element."
LONGEST_MM, SHORTEST_MM, FIRST_SHARE, GROWTH = 0.12, 1e-3, 1 / 12, 1.1
"Steps of the depth; the first, as a share of the longest."
MOST_RISE = 0.1
"Largest rise in one step, as a share of the force that is to be reached."
_TURNS, _CLOSE = 30, 1e-8
_FREE, _SHORTENED, _FLAT = 4, 8, 0.5
_MOST = 0.6
"Largest pressure that a face bears, in moduli of the specimen."
_FINE_TO, _EDGE_MM = 0.9, 1.5
"""Arc, in radii, up to which the mesh is fine; distance from the edge of contact of what tells where it is."""
_PRESSURES = 3
"Times that a step is solved again with the pressures that it gave, which limit Coulomb's friction."
DEEPEST = 0.6
"Deepest way of the flange, as a share of the radius."
DONE_SHARE = 1.02
"Force of the last step, as a share of the largest force asked for."


@dataclass(frozen=True)
class Dome:
    """A hemisphere, the skin's inside bonded to the gel, the base of both clamped to the flange; mm, MPa."""

    radius_mm: float
    skin_mm: float
    skin: Rubber
    gel: Rubber


@dataclass(frozen=True)
class Specimen:
    """A cylinder bonded to a rigid plate, or with no rubber that plate itself; mm, MPa."""

    rubber: Rubber | None
    radius_mm: float = 35.0
    height_mm: float = 25.0


@dataclass(frozen=True)
class Pressing:
    """mesh_mm : size of elements in the contact. step_mm : longest, of the depth, in a dome of 20 mm. force_n : to
    reach. friction : Coulomb's; 0 slides, inf sticks. penalty : of the contact, in usual ones."""

    dome: Dome
    specimen: Specimen
    friction: float = 0.0
    force_n: float = 5.0
    mesh_mm: float = 0.5
    step_mm: float = LONGEST_MM
    penalty: float = 1.0


LENGTHS = ("depth_mm", "contact_radius_mm", "edge_arc_mm", "s_mm", "u_r_mm", "u_z_mm")
"Names of the lengths of ``Pressed``."


@dataclass(frozen=True, eq=False)
class Pressed:
    """Rows of T steps, the first untouched, as in the file of a table.

    unbalance : force of contact against that on the flange, share, worst of all steps. unstored : work of the flange
    less stored energy, share; friction takes some.
    """

    force_n: Array
    depth_mm: Array
    contact_radius_mm: Array
    edge_arc_mm: Array
    s_mm: Array
    u_r_mm: Array
    u_z_mm: Array
    tilt_rad: Array
    unbalance: float
    unstored: float


def _ball(pressing: Pressing) -> tuple[Mesh, list[Rubber]]:
    """Mesh of the dome, and the rubber of each of its elements."""
    dome, size = pressing.dome, pressing.mesh_mm
    inner = dome.radius_mm - dome.skin_mm
    arc = graded(np.pi / 2, _FINE_TO, size / dome.radius_mm)
    layers = max(2, round(dome.skin_mm / size))
    deep = inner - graded(inner, 0.0, max(size, 0.5) * 1.2, 1.15)[::-1]
    radii = np.concatenate([deep, np.linspace(inner, dome.radius_mm, layers + 1)[1:]])
    ball = block(radii, arc, lambda r, angle: (r * np.sin(angle), r * np.cos(angle)))
    middle = ball.at[ball.nodes, 0].mean(axis=1)
    return ball, [dome.skin if r > inner else dome.gel for r in middle]


def _plate(pressing: Pressing) -> Mesh:
    """Mesh of the specimen, or of the face of a rigid plate."""
    dome, specimen, size = pressing.dome, pressing.specimen, pressing.mesh_mm
    return block(
        np.concatenate([graded(specimen.radius_mm, 0.9 * dome.radius_mm, size)]),
        graded(specimen.height_mm, min(4 * size, specimen.height_mm), size, 1.3)
        if specimen.rubber
        else np.array([0, 1.0]),
        lambda r, z: (r, dome.radius_mm + z),
    )


class _World:
    """Meshes of a pressing, its degrees of freedom, and what is known of its solution."""

    def __init__(self, pressing: Pressing) -> None:
        dome, specimen, size = pressing.dome, pressing.specimen, pressing.mesh_mm
        self.dome = dome
        (ball, rubbers), plate = _ball(pressing), _plate(pressing)
        inner = dome.radius_mm - dome.skin_mm
        parts = [(ball, rubbers), (plate, [specimen.rubber or Rubber(1.0)] * len(plate.nodes))]
        self.bodies = Bodies(parts)
        start = len(ball.place)
        skin, self.inside = ball.line(0, dome.radius_mm), ball.line(0, inner)
        face = plate.line(1, 0.0) + start
        self.skin_arc = ball.at[skin, 1] * dome.radius_mm
        self.inner_angle = ball.at[self.inside, 1]
        self.skin, self.face = skin, face
        modulus = specimen.rubber.modulus_mpa if specimen.rubber else np.inf
        penalty = pressing.penalty * min(PENALTY_N_PER_MM3, PENALTY_SHARE * modulus / size)
        self.contact = Contact(skin, face, self.bodies.place, penalty, _MOST * modulus)
        self.arc_of_points = self.contact.arcs(self.skin_arc)
        back = plate.line(1, plate.at[:, 1].max()) if specimen.rubber else np.arange(len(plate.place))
        back += start
        self.driven = 2 * back + 1
        self.specimen = 2 * np.arange(start, len(self.bodies.place)) + 1
        clamped = np.union1d(ball.line(1, np.pi / 2), ball.line(0, 0.0))
        self.flange = 2 * clamped + 1
        axis = np.flatnonzero(np.abs(self.bodies.place[:, 0]) < 1e-9)
        fixed = np.concatenate([2 * clamped, 2 * clamped + 1, 2 * axis, 2 * back, self.driven])
        self.free = np.setdiff1d(np.arange(self.bodies.size), fixed)
        self.number = np.full(self.bodies.size, -1)
        self.number[self.free] = np.arange(self.free.size)
        kept = (self.number[self.bodies.rows] >= 0) & (self.number[self.bodies.columns] >= 0)
        self.kept = np.flatnonzero(kept)
        self.rows, self.columns = (self.number[each[self.kept]] for each in (self.bodies.rows, self.bodies.columns))

    def forces(
        self, moved: Array, grip: Grip, kept: Opposite | None = None
    ) -> tuple[Array, float, Opposite, Callable[[], Array]]:
        """Forces on all nodes (2 N,), the contact force along the axis and its opposite, and the solver for free
        nodes.
        """
        force, values = self.bodies.resistance(moved)
        of = self.contact.opposite(moved, kept)
        _, dofs, pushing, bent = self.contact.resistance(of, grip)
        force += np.bincount(dofs.ravel(), pushing.ravel(), force.size)

        def step() -> Array:
            from scipy.sparse import csc_array  # noqa: PLC0415  (an extra)
            from scipy.sparse.linalg import splu  # noqa: PLC0415

            rows, columns = (self.number[each] for each in (np.repeat(dofs, 12, 1).ravel(), np.tile(dofs, 12).ravel()))
            there = (rows >= 0) & (columns >= 0)
            entries = np.concatenate([values[self.kept], bent.ravel()[there]])
            at = (np.concatenate([self.rows, rows[there]]), np.concatenate([self.columns, columns[there]]))
            matrix = csc_array((entries, at), shape=(self.free.size,) * 2)
            options = {"SymmetricMode": True}
            factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
            return np.asarray(factors.solve(-force[self.free]))

        return force, self.contact.pressure_n(of), of, step

    def solved(self, guess: Array, grip: Grip) -> tuple[Array, float, float, Opposite] | None:
        """Newton from a guess: displacements, forces of contact and of the flange, what is opposite; None if it fails.

        A step is shortened where the energy falls along it no longer: points that touch and leave in turn would keep
        it from an end.
        """
        moved = guess.copy()
        try:
            force, pressure, of, step = self.forces(moved, grip)
            for turn in range(_TURNS):
                kept = of if turn >= _FREE else None
                if float(np.abs(force[self.free]).max()) < _CLOSE * max(pressure, 0.01):
                    return moved, pressure, float(force[self.flange].sum()), of
                change = step()
                falls, share = float(force[self.free] @ change), 1.0
                for _ in range(_SHORTENED):
                    trial = moved.copy()
                    trial[self.free] += share * change
                    try:
                        force, pressure, of, step = self.forces(trial, grip, kept)
                    except Inverted:
                        share /= 4
                        continue
                    rises = float(force[self.free] @ change)
                    if abs(rises) <= _FLAT * abs(falls):
                        break
                    share *= min(max(falls / (falls - rises), 0.1), 0.7) if rises > 0 else 1.0
                    if rises < 0:
                        break
                moved = trial
        except (Inverted, RuntimeError):
            return None
        return None

    def energy(self, moved: Array, grip: Grip, of: Opposite) -> float:
        return self.bodies.energy(moved) + self.contact.resistance(of, grip)[0]

    def edge(self, moved: Array) -> tuple[float, float]:
        """Radius of the edge of contact seen along the axis, and its arc on the undeformed outside of the skin.

        Outside a smooth edge the gap grows with the distance to the power of 3/2: its power 2/3 is followed back to 0.
        """
        of = self.contact.opposite(moved)
        now = self.bodies.place + moved.reshape(-1, 2)
        arc = self.arc_of_points[of.own]
        r = np.interp(arc, self.skin_arc, now[self.skin, 0])
        open_ = of.gap > 0
        last = int(np.flatnonzero(~open_).max(initial=-1))
        if last < 0:
            return 0.0, 0.0
        away = r - r[last]
        used = (np.arange(r.size) > last) & (away < max(_EDGE_MM, 3 * (r[min(last + 4, r.size - 1)] - r[last])))
        law = of.gap[used] ** (2 / 3)
        curve = np.polynomial.Polynomial.fit(law, r[used], 2)
        radius = float(curve(0.0))
        return radius, float(np.interp(radius, r, arc))


def press(pressing: Pressing) -> Pressed:
    """Solve it up to its force. Raises Stopped : a step failed however small, or the dome is pressed too deep."""
    dome = pressing.dome
    length_mm = dome.radius_mm / USUAL_RADIUS_MM
    skin_mpa = dome.skin.modulus_mpa * dome.skin_mm / dome.radius_mm
    modulus_mpa = (dome.gel.modulus_mpa + skin_mpa) / USUAL_MODULUS_MPA
    usual = _in_units(pressing, length_mm, modulus_mpa)
    world, one_n = _World(usual), modulus_mpa * length_mm**2
    rows: list[_Row] = []
    try:
        rows.extend(_steps(world, usual))
    except Stopped as error:
        reached_mm, reached_n = (rows[-1][0] * length_mm, rows[-1][2] * one_n) if rows else (0.0, 0.0)
        raise Stopped(f"{reached_n:.3g} N at {reached_mm:.3g} mm of depth: {error}", reached_n) from error
    found = _table(world, rows)
    lengths = {name: getattr(found, name) * length_mm for name in LENGTHS}
    return replace(found, force_n=found.force_n * one_n, **lengths)


def _in_units(pressing: Pressing, length_mm: float, modulus_mpa: float) -> Pressing:
    """The same contact with lengths and moduli counted in others."""
    dome, specimen = pressing.dome, pressing.specimen

    def of(rubber: Rubber) -> Rubber:
        return replace(rubber, modulus_mpa=rubber.modulus_mpa / modulus_mpa)

    return replace(
        pressing, force_n=pressing.force_n / (modulus_mpa * length_mm**2), mesh_mm=pressing.mesh_mm / length_mm,
        dome=Dome(dome.radius_mm / length_mm, dome.skin_mm / length_mm, of(dome.skin), of(dome.gel)),
        specimen=Specimen(
            specimen.rubber and of(specimen.rubber), specimen.radius_mm / length_mm, specimen.height_mm / length_mm
        ),
    )  # fmt: skip


_Row = tuple[float, Array, float, float, float]
"""Depth, displacements, forces of contact and of the flange, and stored energy."""


def _steps(world: _World, pressing: Pressing) -> Iterator[_Row]:
    contact, friction = world.contact, pressing.friction
    moved, held = np.zeros(world.bodies.size), np.full(contact.size, np.nan)
    of = contact.opposite(moved)
    before = moved
    depth, length, last, force = 0.0, FIRST_SHARE * pressing.step_mm, 0.0, 0.0
    while force < DONE_SHARE * pressing.force_n:
        guess = moved + (moved - before) * (length / last if last else 0.0)
        guess[world.driven] = -(depth + length)
        grip = contact.grip(of, held, friction)
        found = world.solved(guess, grip) if last else None
        if found is None:
            guess = moved.copy()
            guess[world.specimen] -= length
            found = world.solved(guess, grip)
        for _ in range(_PRESSURES if 0 < friction < np.inf else 0):
            if found is not None:
                grip = contact.grip(found[3], held, friction)
                found = world.solved(found[0], grip)
        if found is None or (found[1] - force > MOST_RISE * pressing.force_n and length >= 2 * SHORTEST_MM):
            length /= 2
            if length < SHORTEST_MM:
                raise Stopped("no further step is solved, however small")
            continue
        before, (moved, force, flange, now) = moved, found
        depth, last = depth + length, length
        yield depth, moved, force, flange, world.energy(moved, grip, now)
        if friction > 0:
            held = _held(contact, grip, of, now)
        of = now
        length = min(length * GROWTH, pressing.step_mm)
        if depth > DEEPEST * pressing.dome.radius_mm:
            raise Stopped(f"the flange has moved {DEEPEST:.0%} of the dome's radius")


def _held(contact: Contact, grip: Grip, before: Opposite, now: Opposite) -> Array:
    """What each point sticks to after a step: where it was when its gap closed, along the line of the step; drawn along
    as far as it slips."""
    places = [contact.touched(each) for each in (before, now)]
    gaps = np.full((2, contact.size), np.nan)
    for gap, each in zip(gaps, (before, now), strict=True):
        gap[each.own] = each.gap
    share = np.clip(gaps[0] / np.where(gaps[0] > gaps[1], gaps[0] - gaps[1], 1.0), 0.0, 1.0)
    first = np.where(np.isfinite(places[0]), places[0] + share * (places[1] - places[0]), places[1])
    drawn = places[1] - np.clip(places[1] - grip.held, -grip.inward, grip.outward)
    return np.where(gaps[1] < 0, np.where(np.isfinite(grip.held), drawn, first), np.nan)


def _table(world: _World, rows: list[_Row]) -> Pressed:
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  (an extra)

    depth, moved, force, base, stored = (np.array(each) for each in zip(*rows, strict=True))
    edges = np.array([world.edge(each) for each in moved])
    inside = moved.reshape(len(rows), -1, 2)[:, world.inside]
    angle = world.inner_angle
    inner = world.dome.radius_mm - world.dome.skin_mm
    rest = inner * np.array([np.sin(angle), np.cos(angle)]).T
    turned = np.gradient(rest + inside, angle * inner, axis=1, edge_order=2)
    tilt = np.arctan2(turned[..., 1], turned[..., 0]) + angle
    work = float(CubicSpline(depth, force).integrate(depth[0], depth[-1]))

    def with_rest(values: Array) -> Array:
        return np.concatenate([np.zeros((1, *values.shape[1:])), values])

    return Pressed(
        with_rest(force), with_rest(depth), with_rest(edges[:, 0]), with_rest(edges[:, 1]), angle * inner,
        with_rest(inside[..., 0]), with_rest(inside[..., 1]), with_rest(tilt),
        float(np.abs(base / force - 1).max()), float(abs((stored[-1] - stored[0]) / work - 1)),
    )  # fmt: skip
