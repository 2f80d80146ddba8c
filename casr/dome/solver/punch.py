"""The kappa that a specimen of a table is called by: that under a rigid flat punch without friction, at small depth.

Kappa over the modulus is a length (casr.dome.kappa) that depends on the size of the cylinder and on Poisson's ratio
alone. One mm deep a block of 35 x 25 mm is 1 % stiffer.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from casr.dome.kappa import PUNCH_MM
from casr.dome.solver.bodies import Bodies, Rubber, block, graded

_ELEMENTS = (10, 20)
"Under the punch, of the two meshes. The stress at its rim is singular, so that the error falls as the size does."


@cache
def punch_on_block_mm(radius_mm: float, height_mm: float, poisson: float) -> float:
    """Length kappa/E, mm, of a punch on a cylinder bonded to a rigid plate. The punch is half as wide as a specimen of
    less than 20 mm radius.
    """
    coarse, fine = (_on_mesh(radius_mm, height_mm, poisson, count) for count in _ELEMENTS)
    return 2 * fine - coarse


def _on_mesh(radius_mm: float, height_mm: float, poisson: float, count: int) -> float:
    from scipy.sparse import csc_array  # noqa: PLC0415  (an extra)
    from scipy.sparse.linalg import splu  # noqa: PLC0415

    punch = min(PUNCH_MM, radius_mm / 2)
    size = punch / count
    across = np.concatenate([np.linspace(0, punch, count + 1), punch + graded(radius_mm - punch, 2 * size, size)[1:]])
    mesh = block(across, graded(height_mm, 4 * size, size), lambda r, z: (r, z))
    body = Bodies([(mesh, [Rubber(1.0, poisson)] * len(mesh.nodes))])
    face, back = mesh.line(1, 0.0), mesh.line(1, height_mm)
    pressed = 2 * face[mesh.place[face, 0] <= punch + 1e-9] + 1
    axis = 2 * np.flatnonzero(mesh.place[:, 0] < 1e-9)
    free = np.setdiff1d(np.arange(body.size), np.concatenate([pressed, axis, 2 * back, 2 * back + 1]))
    _, values = body.resistance(np.zeros(body.size))
    moved, number = np.zeros(body.size), np.full(body.size, -1)
    moved[pressed], number[free] = 1.0, np.arange(free.size)
    rows, columns = number[body.rows], number[body.columns]
    kept = (rows >= 0) & (columns >= 0)
    inner = csc_array((values[kept], (rows[kept], columns[kept])), shape=(free.size,) * 2)
    force = np.bincount(body.rows, values * moved[body.columns], body.size)
    moved[free] = -splu(inner).solve(force[free])
    return float(np.bincount(body.rows, values * moved[body.columns], body.size)[pressed].sum())
