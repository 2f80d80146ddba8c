"""The forces of presses against those of the tables: ln kappa0 of the dome, by each press."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.kappa.field import OF_VIEW
from casr.kappa.labels import Labels

Array = NDArray[np.float64]

_FRAME_SD, _FRAME_SD_N, _BEND_SD = 0.01, 0.01, 0.03
"SDs of ln force and of force from frame to frame, and of ln force from one e-fold to the next."


@dataclass(frozen=True, eq=False)
class PressForce:
    """ln kappa0 by one press: its value, variance, and (G,) derivative by all parameters of ``Labels``."""

    level: float
    variance: float
    by: Array


def forces_of(labels: Labels) -> dict[int, PressForce]:
    """Forces of the presses that have any, by the number of the press."""
    found = {}
    for k, field in enumerate(labels.fields):
        if field.press.force_n is None:
            continue
        force_n = field.press.force_n[field.frames]
        there = force_n > 0.1
        if there.sum() < 3:
            continue
        log_force = np.log(np.where(there, force_n, 1.0))
        covariance = np.diag((_FRAME_SD**2 + (_FRAME_SD_N / force_n) ** 2)[there])
        for shape, sd in (
            (1 / force_n[there], field.press.force_zero_sd_n),
            (log_force[there] - log_force[there].mean(), _BEND_SD),
        ):
            covariance += sd**2 * np.outer(shape, shape)
        weight = np.linalg.solve(covariance, np.ones(int(there.sum())))
        total = float(weight.sum())
        weight = weight / total
        reduced, change = _reduced_force(labels, k)
        level = float(weight @ (log_force - reduced)[there])
        found[k] = PressForce(level, 1 / total, -weight @ change[there])
    return found


def _reduced_force(labels: Labels, k: int) -> tuple[Array, Array]:
    """(T,) ln of force over kappa0 at the radii of a press, and (T, G) its derivative by all parameters."""
    family, state, own = labels.family, labels.states[k], int(labels.own_at[k])
    bends = len(family.bends)
    first = len(OF_VIEW)
    names = [0, *range(first, first + bends), own, own + 1]
    values = np.array([state.shared[0], *state.shared[first : first + bends], *state.own[:2]])

    def at(values: Array, radius_mm: Array) -> Array:
        world = family.world(values[0], values[-2], values[-1], 0.0, values[1 : 1 + bends])
        return np.interp(np.log(radius_mm), np.log(family.radius_mm), family.log_force(world))

    here, step = at(values, state.radius_mm), 1e-3
    change = (at(values, state.radius_mm + step) - here)[:, None] / step * labels.radius_by[k]
    for row, name in enumerate(names):
        moved = values.copy()
        moved[row] += step
        change[:, name] += (at(moved, state.radius_mm) - here) / step
    return here, change
