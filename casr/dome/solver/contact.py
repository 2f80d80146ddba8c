"""Contact of the dome's outside with the face of a specimen, by a penalty at points of the dome's edges.

The gap of a point is its distance from the face along the axis. Its first variation is along the normal of the face, so
that what pushes it apart does too and no friction comes in. The face is seen as r -> z of the deformed specimen, along
quadratic edges. Where the skin sticks, the point of the face that it touched first stays the one that is opposite; with
Coulomb's friction it is let go as far as the shear is more than its share of the pressure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

POINTS = 4
"Points of an edge, at Gauss's places."
SOFT_MM = 2e-4
"""Overlap within which a point's pressure begins to grow: without it points touch and leave in turn for ever."""


def shapes(at: Array) -> Array:
    """Quadratic functions of an edge, their first and second slopes: (3, 3, n) at places (n,) from -1 to 1."""
    one = np.ones_like(at)
    return np.array(
        [
            [at * (at - 1) / 2, 1 - at**2, at * (at + 1) / 2],
            [at - 0.5 * one, -2 * at, at + 0.5 * one],
            [one, -2 * one, one],
        ]
    )


@dataclass(frozen=True, eq=False)
class Opposite:
    """What lies opposite to points of the dome: P that have a face there.

    own : which points. edge : (P,) of the face. at : (P,) place on it. gap : (P,) mm. steep : (P,) dz/dr of the face.
    length : (P,) dr over ``at``. slope (P, 12) of the gap and of ``at`` over the displacements of three nodes of the
    dome and three of the face, r and z; bent (P, 12, 12).
    """

    own: Rows
    edge: Rows
    at: Array
    gap: Array
    steep: Array
    length: Array
    gap_slope: Array
    at_slope: Array
    gap_bent: Array
    at_bent: Array


@dataclass(frozen=True, eq=False)
class Grip:
    """What holds the skin. held : (points,) place on the undeformed face that each sticks to; NaN where it slides.
    inward, outward : (points,) slip from there, mm, beyond which it holds no stronger."""

    held: Array
    inward: Array
    outward: Array


class Contact:
    """skin, face : (n,) nodes of the dome's outside and of the specimen's face, from the axis on; every second one
    begins an edge. place : (N, 2) of all nodes, undeformed. penalty : N/mm3, of a gap and of a slip. most_mpa : a
    pressure that is not to be expected; a larger one on the way to a solution does not turn with the face, so that its
    slope stays that of a minimum."""

    def __init__(self, skin: Rows, face: Rows, place: Array, penalty: float, most_mpa: float) -> None:
        self._skin = np.stack([skin[:-2:2], skin[1:-1:2], skin[2::2]], axis=1)
        self._face = np.stack([face[:-2:2], face[1:-1:2], face[2::2]], axis=1)
        self._place, self.penalty, self._most_mm = place, penalty, most_mpa / penalty
        at, weight = np.polynomial.legendre.leggauss(POINTS)
        value, slope, _ = shapes(at)
        r, z = (place[self._skin, k] for k in (0, 1))
        length = np.hypot(r @ slope, z @ slope)
        self._weight = (2 * np.pi * (r @ value) * length * weight).ravel()
        self._value = np.tile(value, len(self._skin))  # (3, points)
        self._nodes = np.repeat(self._skin, POINTS, axis=0)
        self.size = len(self._nodes)

    def arcs(self, arc: Array) -> Array:
        """Arc of the points, mm, from that of the nodes of the skin (n,)."""
        return np.asarray(np.stack([arc[:-2:2], arc[1:-1:2], arc[2::2]], axis=1) @ self._value[:, :POINTS]).ravel()

    def opposite(self, moved: Array, kept: Opposite | None = None) -> Opposite:
        """What lies opposite to the dome's points after the displacements ``moved`` (2 N,) of all nodes, mm.

        kept : whose points and edges of the face to go on with, though points may leave them: Newton's method does not
            end where points cross from edge to edge of a bent face in turn.
        """
        now = self._place + moved.reshape(-1, 2)
        r, z = ((self._value.T * now[self._nodes, k]).sum(axis=1) for k in (0, 1))
        knots = now[self._face[:, 0], 0]
        own = kept.own if kept else np.flatnonzero((r >= 0) & (r < now[self._face[-1, 2], 0]))
        edge = kept.edge if kept else np.clip(np.searchsorted(knots, r[own], side="right") - 1, 0, len(knots) - 1)
        rr, zz = (now[self._face[edge], k].T for k in (0, 1))
        at = np.zeros(own.size)
        for _ in range(6):
            value, first, _ = shapes(at)
            at -= ((value * rr).sum(axis=0) - r[own]) / (first * rr).sum(axis=0)
        value, first, second = shapes(at)
        r1, r2 = (first * rr).sum(axis=0), (second * rr).sum(axis=0)
        z1, z2 = (first * zz).sum(axis=0), (second * zz).sum(axis=0)
        steep = z1 / r1
        table = np.zeros((4, own.size, 6, 2))
        gap_slope, at_slope, turn, pull = table
        skin = self._value[:, own].T
        at_slope[:, :3, 0], at_slope[:, 3:, 0] = skin / r1[:, None], -(value / r1).T
        gap_slope[:, :3, 0], gap_slope[:, :3, 1] = steep[:, None] * skin, -skin
        gap_slope[:, 3:, 0], gap_slope[:, 3:, 1] = -(steep * value).T, value.T
        turn[:, 3:, 0], turn[:, 3:, 1] = -(steep * first).T, first.T
        pull[:, 3:, 0] = first.T
        gap_slope, at_slope, turn, pull = table.reshape(4, own.size, 12)
        both = at_slope[:, :, None] * at_slope[:, None, :]
        gap_bent = _with(at_slope, turn) + (z2 - steep * r2)[:, None, None] * both
        at_bent = -(_with(at_slope, pull) + r2[:, None, None] * both) / r1[:, None, None]
        gap = (value * zz).sum(axis=0) - z[own]
        return Opposite(own, edge, at, gap, steep, r1, gap_slope, at_slope, gap_bent, at_bent)

    def touched(self, of: Opposite) -> Array:
        """(points,) where on the undeformed face each point is, mm from the axis; NaN for those without a face."""
        place = np.full(self.size, np.nan)
        place[of.own] = (shapes(of.at)[0].T * self._place[self._face[of.edge], 0]).sum(axis=1)
        return place

    def grip(self, of: Opposite, held: Array, friction: float) -> Grip:
        """Where points are held, and how strongly at the pressures of now.

        held : (points,) place on the undeformed face, mm. friction : Coulomb's; inf sticks.
        Along the normal (s, -1) of a face of slope s, per unit of penalty, act the overlap times sqrt(1 + s^2) and a
        part of the hold along r; both are in Coulomb's pressure.
        """
        inward, outward = np.zeros((2, self.size))
        if np.isinf(friction):
            return Grip(held, inward + np.inf, outward + np.inf)
        stretch = (shapes(of.at)[1].T * self._place[self._face[of.edge], 0]).sum(axis=1) / of.length
        most = -friction * _soft(np.minimum(of.gap, 0), 1) * (1 + of.steep**2) / stretch
        for limit, sign in ((inward, -1), (outward, 1)):
            share = 1 + sign * friction * of.steep
            limit[of.own] = np.where(share > 0, most / np.where(share > 0, share, 1.0), np.inf)
        return Grip(held, inward, outward)

    def resistance(self, of: Opposite, grip: Grip) -> tuple[float, Array, Array, Array]:
        """Energy, degrees of freedom (P, 12) of the points in touch, forces there (P, 12) and slopes (P, 12, 12)."""
        near = np.flatnonzero(of.gap < 0)
        own, edge = of.own[near], of.edge[near]
        weight = self.penalty * self._weight[own]
        gap, slope = of.gap[near], of.gap_slope[near]
        energy = float(weight @ _soft(gap, 0))
        force = (weight * _soft(gap, 1))[:, None] * slope
        bent = (weight * _soft(gap, 2))[:, None, None] * (slope[:, :, None] * slope[:, None, :])
        bent += (weight * np.maximum(_soft(gap, 1), -self._most_mm))[:, None, None] * of.gap_bent[near]
        sticks = np.isfinite(grip.held[own])
        if sticks.any():
            near, own_s, weight = near[sticks], own[sticks], weight[sticks]
            rest = self._place[self._face[edge[sticks]], 0].T
            value, first, second = (np.asarray((each * rest).sum(axis=0)) for each in shapes(of.at[near]))
            slip = value - grip.held[own_s]
            hold = np.clip(slip, -grip.inward[own_s], grip.outward[own_s])
            energy += float(weight @ (hold * slip - hold**2 / 2))
            along = of.at_slope[near]
            force[sticks] += (weight * hold * first)[:, None] * along
            stiff = weight * ((hold == slip) * first**2 + hold * second)
            bent[sticks] += stiff[:, None, None] * along[:, :, None] * along[:, None, :]
            bent[sticks] += (weight * hold * first)[:, None, None] * of.at_bent[near]
        nodes = np.concatenate([self._nodes[own], self._face[edge]], axis=1)
        dofs = np.stack([2 * nodes, 2 * nodes + 1], axis=-1).reshape(-1, 12)
        return energy, dofs, force, bent

    def pressure_n(self, of: Opposite) -> float:
        """Force along the axis of all points, N."""
        return float(-self.penalty * self._weight[of.own] @ _soft(np.minimum(of.gap, 0), 1))


def _soft(gap: Array, order: int) -> Array:
    """Energy of an overlap -gap >= 0, its slope or second slope over the gap, for a penalty of 1."""
    deep, soft = -gap, SOFT_MM
    inside = (deep**3 / (6 * soft), -(deep**2) / (2 * soft), deep / soft)[order]
    beyond = (deep**2 / 2 - soft * deep / 2 + soft**2 / 6, soft / 2 - deep, np.ones_like(deep))[order]
    return np.where(deep < soft, inside, beyond)


def _with(one: Array, other: Array) -> Array:
    product: Array = one[:, :, None] * other[:, None, :]
    return product + product.transpose(0, 2, 1)
