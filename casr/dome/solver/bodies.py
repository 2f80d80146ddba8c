"""Rubber bodies of revolution: nine-node quadrilaterals of scikit-fem, Neo-Hooke, large displacements.

The energy of a unit volume, mu = E / (2 (1 + nu)), lam = 2 mu nu / (1 - 2 nu), J = det F:

    mu / 2 (tr F'F - 3) - mu ln J + lam / 2 (J - 1)^2

The last part is integrated at 2 x 2 points of an element and the others at 3 x 3, so that nearly incompressible rubber
does not lock (Malkus and Hughes 1978, Computer Methods in Applied Mechanics and Engineering 15, 63). Lengths in mm,
moduli in MPa, forces in N.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

_FACE, _WITHIN = 5, 3
"Degrees of polynomials that 3 x 3 and 2 x 2 points integrate exactly."


class Inverted(ArithmeticError):
    """An element is turned inside out: the step was too large."""


class Stopped(ArithmeticError):
    """A solution went no further. reached_n : the force there."""

    def __init__(self, why: str, reached_n: float = 0.0) -> None:
        super().__init__(why)
        self.reached_n = reached_n


@dataclass(frozen=True)
class Rubber:
    """Young's modulus at small strain, MPa, and Poisson's ratio."""

    modulus_mpa: float
    poisson: float = 0.49

    @property
    def shear_mpa(self) -> float:
        return self.modulus_mpa / (2 * (1 + self.poisson))

    @property
    def lame_mpa(self) -> float:
        return 2 * self.shear_mpa * self.poisson / (1 - 2 * self.poisson)


@dataclass(frozen=True, eq=False)
class _Points:
    """slopes (E, Q, 5, 18): F less unity over the displacements of an element's nodes, in the order rr, rz, zr, zz and
    around the axis. weight (E, Q): 2 pi r times area. first, second (E,): what multiplies the two energies there."""

    slopes: Array
    weight: Array
    first: Array
    second: Array


@dataclass(frozen=True, eq=False)
class Mesh:
    """place (N, 2): r and z of each node, mm. at (N, 2): its two parameters in the block it was made of. nodes (E, 9):
    of each element. basis : of scikit-fem, by degree of integration."""

    place: Array
    at: Array
    nodes: Rows
    points: tuple[tuple[Array, Array, Array], ...]

    def line(self, axis: int, value: float) -> Rows:
        """The nodes on which one parameter has this value, in the order of the other."""
        on = np.flatnonzero(np.abs(self.at[:, axis] - value) < 1e-9)
        return on[np.argsort(self.at[on, 1 - axis])]


def block(first: Array, second: Array, place: Callable[[Array, Array], tuple[Array, Array]]) -> Mesh:
    """Elements between the ascending parameters ``first`` and ``second``, put at (r, z) = place(first, second)."""
    from skfem import Basis, ElementQuad2, MeshQuad, MeshQuad2  # noqa: PLC0415  (an extra, and 0.4 s)

    square = MeshQuad2.from_mesh(MeshQuad.init_tensor(first, second))
    mesh = replace(square, doflocs=np.array(place(*square.doflocs)))
    bases = [Basis(mesh, ElementQuad2(), intorder=order) for order in (_FACE, _WITHIN)]
    at = Basis(square, ElementQuad2(), intorder=_WITHIN).doflocs.T
    points = []
    for basis in bases:
        radius = np.asarray(basis.global_coordinates())[0]
        shapes = np.array([np.broadcast_to(np.asarray(each[0]), radius.shape) for each in basis.basis])
        slopes = np.array([each[0].grad for each in basis.basis])
        points.append((shapes, slopes, np.array([radius, basis.dx])))
    return Mesh(np.array(place(*at.T)).T, at, bases[0].element_dofs.T.astype(np.intp), tuple(points))


def graded(end: float, fine: float, size: float, growth: float = 1.2) -> Array:
    """Places (n,) from 0 to ``end``, mm: steps of ``size`` up to ``fine``, growing ones beyond."""
    steps = [size] * max(1, int(np.ceil(min(fine, end) / size)))
    while sum(steps) < end:
        steps.append(steps[-1] * growth)
    return np.concatenate([[0.0], np.cumsum(steps)]) * (end / sum(steps))


class Bodies:
    """Several meshes of rubber side by side in one vector of displacements, r and z of each node in turn.

    place : (N, 2) of all nodes. size : 2 N.
    """

    def __init__(self, parts: Sequence[tuple[Mesh, Sequence[Rubber]]]) -> None:
        """parts : each mesh with the rubber of each of its elements."""
        self.place = np.concatenate([mesh.place for mesh, _ in parts])
        self.size = self.place.size
        self._groups: list[tuple[Rows, tuple[_Points, _Points]]] = []
        start = 0
        for mesh, rubbers in parts:
            nodes = mesh.nodes + start
            start += len(mesh.place)
            dofs = np.stack([2 * nodes, 2 * nodes + 1], axis=-1).reshape(len(nodes), 18)
            shear, lame = np.array([(each.shear_mpa, each.lame_mpa) for each in rubbers]).T
            kinds = zip(mesh.points, ((shear, shear), (lame * 0, lame)), strict=True)
            self._groups.append((dofs, tuple(_points(*of, *moduli) for of, moduli in kinds)))  # type: ignore[arg-type]
        shapes = [(np.repeat(dofs, 18, axis=1).ravel(), np.tile(dofs, 18).ravel()) for dofs, _ in self._groups]
        self.rows, self.columns = (np.concatenate(each) for each in zip(*shapes, strict=True))

    def energy(self, moved: Array) -> float:
        """N mm, at displacements (2 N,)."""
        return sum(float(part[0]) for part in self._parts(moved, only_energy=True))

    def resistance(self, moved: Array) -> tuple[Array, Array]:
        """Forces on the nodes (2 N,) that hold the displacements, and the values of their slopes at ``rows`` and
        ``columns``. Inverted : an element is inside out.

        Nearly incompressible elements do not lock, after Malkus and Hughes (1978).
        """
        forces, values = np.zeros(self.size), []
        for (dofs, _), (_, force, slope) in zip(self._groups, self._parts(moved), strict=True):
            forces += np.bincount(dofs.ravel(), force.ravel(), self.size)
            values.append(slope.ravel())
        return forces, np.concatenate(values)

    def _parts(self, moved: Array, *, only_energy: bool = False) -> list[tuple[float, Array, Array]]:
        found = []
        for dofs, (full, within) in self._groups:
            own = moved[dofs]
            both = [_of_shear(full, own, only_energy), _of_volume(within, own, only_energy)]
            found.append((both[0][0] + both[1][0], both[0][1] + both[1][1], both[0][2] + both[1][2]))
        return found


def _points(shapes: Array, slopes: Array, at: Array, first: Array, second: Array) -> _Points:
    radius, area = at
    _, elements, points = shapes.shape
    table = np.zeros((elements, points, 5, 9, 2))
    table[:, :, 0, :, 0] = table[:, :, 2, :, 1] = slopes[:, 0].transpose(1, 2, 0)
    table[:, :, 1, :, 0] = table[:, :, 3, :, 1] = slopes[:, 1].transpose(1, 2, 0)
    table[:, :, 4, :, 0] = (shapes / radius).transpose(1, 2, 0)
    return _Points(table.reshape(elements, points, 5, 18), 2 * np.pi * radius * area, first, second)


def _deformed(points: _Points, own: Array) -> tuple[Array, Array, Array]:
    """F (E, Q, 5), its determinant J (E, Q) and the slope of J over F."""
    elements, count = points.weight.shape
    f = (points.slopes.reshape(elements, -1, 18) @ own[..., None]).reshape(elements, count, 5)
    f += np.array([1.0, 0, 0, 1.0, 1.0])
    rr, rz, zr, zz, around = np.moveaxis(f, -1, 0)
    plane = rr * zz - rz * zr
    j = plane * around
    if not ((plane > 0) & (around > 0)).all():
        raise Inverted
    return f, j, np.stack([zz * around, -zr * around, -rz * around, rr * around, plane], axis=-1)


def _bent(f: Array) -> Array:
    """Second slope of J over F, (E, Q, 5, 5)."""
    rr, rz, zr, zz, around = np.moveaxis(f, -1, 0)
    bent = np.zeros((*f.shape, 5))
    for i, j, value in ((0, 3, around), (1, 2, -around), (0, 4, zz), (1, 4, -zr), (2, 4, -rz), (3, 4, rr)):
        bent[..., i, j] = bent[..., j, i] = value
    return bent


_NONE = np.empty(0)


def _of_shear(points: _Points, own: Array, only_energy: bool) -> tuple[float, Array, Array]:
    f, j, k = _deformed(points, own)
    energy = points.weight * points.first[:, None] * ((f**2).sum(axis=-1) / 2 - 1.5 - np.log(j))
    if only_energy:
        return float(energy.sum()), _NONE, _NONE
    inverse = k / j[..., None]
    bent = np.eye(5) + inverse[..., :, None] * inverse[..., None, :] - _bent(f) / j[..., None, None]
    return float(energy.sum()), *_at_nodes(points, points.first, f - inverse, bent)


def _of_volume(points: _Points, own: Array, only_energy: bool) -> tuple[float, Array, Array]:
    f, j, k = _deformed(points, own)
    energy = points.weight * points.second[:, None] * (j - 1) ** 2 / 2
    if only_energy:
        return float(energy.sum()), _NONE, _NONE
    over = (j - 1)[..., None]
    bent = k[..., :, None] * k[..., None, :] + over[..., None] * _bent(f)
    return float(energy.sum()), *_at_nodes(points, points.second, over * k, bent)


def _at_nodes(points: _Points, modulus: Array, stress: Array, bent: Array) -> tuple[Array, Array]:
    """Forces (E, 18) and their slopes (E, 18, 18) from stress and its slope over F."""
    weight = (points.weight * modulus[:, None])[..., None]
    elements = len(stress)
    table = points.slopes.reshape(elements, -1, 18)
    force = ((weight * stress).reshape(elements, 1, -1) @ table)[:, 0]
    rows = ((weight[..., None] * bent) @ points.slopes).reshape(elements, -1, 18)
    return force, table.transpose(0, 2, 1) @ rows
