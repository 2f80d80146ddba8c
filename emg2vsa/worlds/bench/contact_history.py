"""One contact of plain numbers, stepped: `ConvolvedForce` and `Shear` of the same bodies in one pass over branches.

The numbers are theirs to the last bit (tests/worlds/bench/test_contact_history.py). A solver asks for the forces at the
end of a step many times, so all that does not depend on the end is computed once a step.
"""

from __future__ import annotations

import math
from functools import lru_cache

from emg2vsa.dome_contact import SHEAR_OVER_NORMAL
from emg2vsa.worlds.contact import Relaxation
from emg2vsa.worlds.contact.tilt import TINY_N_PER_MM, check_skin

_STEP_LENGTHS = 64
"Steps of the 1 kHz loop have few lengths, which differ by their rounding."


class ContactHistory:
    """Normal and shear force of one contact. Parameters as those of `Shear`.

    A step is: ``begin``, ``forces`` for as many ends of it as wanted, and ``advance`` to the true end.
    """

    def __init__(self, relaxation: Relaxation, *, friction: float, mount_n_per_mm: float, friction_drop: float) -> None:
        check_skin(friction, friction_drop, mount_n_per_mm)
        self._friction, self._after_slip = friction, friction - 2 * friction_drop
        self._give, self._instant = 1 / mount_n_per_mm, relaxation.instant
        branches = sorted(zip(relaxation.taus_s, relaxation.branches, strict=True))
        self._n_branches = len(branches)
        self._weights = lru_cache(_STEP_LENGTHS)(lambda step_s: _weights(branches, relaxation.instant, step_s))
        self.reset()

    def reset(self) -> None:
        """No contact, and no past."""
        self._normal_n = self._shear_n = self._convolved_n = self.way_mm = 0.0
        self._normal = self._shear = [0.0] * self._n_branches
        "What is convolved so far, of each branch."

    def begin(self, step_s: float) -> None:
        """A step of that length."""
        weights, self.beta = self._weights(step_s)
        old_n, shear_n = self._normal_n, self._shear_n
        alpha = shear_alpha = 0.0
        parts, shear_parts = [], []
        for (left, from_old, _), z, q in zip(weights, self._normal, self._shear, strict=True):
            part, shear_part = left * z + from_old * old_n, left * q + from_old * shear_n
            alpha, shear_alpha = alpha + part, shear_alpha + shear_part
            parts.append(part)
            shear_parts.append(shear_part)
        self._alpha_n, self._parts, self._shear_parts, self._of_step = alpha, parts, shear_parts, weights
        self._pulled_n, self._given_mm = self._convolved_n - shear_alpha, self._give * shear_n

    def forces(self, elastic_n: float, slope_n_per_mm: float, way_mm: float) -> tuple[float, float]:
        """Normal and shear force at the end of the step; both 0 where nothing pushes back there.

        elastic_n : of an elastic contact there. slope_n_per_mm : its growth per depth on this step. way_mm : along the
        surface, on this step.
        """
        normal_n = (elastic_n - self._alpha_n) / self.beta
        if normal_n <= 0:
            return 0.0, 0.0
        stiffness = SHEAR_OVER_NORMAL * slope_n_per_mm
        shear_n = (self._pulled_n + stiffness * (way_mm + self._given_mm)) / (self.beta + stiffness * self._give)
        if not -self._friction * normal_n <= shear_n <= self._friction * normal_n:
            shear_n = math.copysign(self._after_slip * normal_n, shear_n)
        return normal_n, shear_n

    def advance(self, elastic_n: float, slope_n_per_mm: float, way_mm: float) -> tuple[float, float]:
        """Go there; normal and shear force then, as `forces`."""
        normal_n, shear_n = self.forces(elastic_n, slope_n_per_mm, way_mm)
        grown_n = self._instant * shear_n
        normal, shear = [], []
        for (_, _, from_new), part, shear_part in zip(self._of_step, self._parts, self._shear_parts, strict=True):
            normal.append(part + from_new * normal_n)
            z = shear_part + from_new * shear_n
            shear.append(z)
            grown_n = grown_n + z
        # where nothing presses yet there is nothing to shear
        self.way_mm += (grown_n - self._convolved_n) / (SHEAR_OVER_NORMAL * slope_n_per_mm + TINY_N_PER_MM)
        self._normal, self._shear, self._normal_n, self._shear_n = normal, shear, normal_n, shear_n
        self._convolved_n = grown_n
        return normal_n, shear_n


def _weights(
    branches: list[tuple[float, float]], instant: float, step_s: float
) -> tuple[list[tuple[float, float, float]], float]:
    """Of each branch over a step: of its state, of the force at the start and of that at the end; and beta."""
    weights, beta = [], instant
    for tau_s, branch in branches:
        share = step_s / tau_s
        gone = -math.expm1(-share)
        mean = gone / share if share > 0 else 1.0
        weights.append((1 - gone, branch * (mean - (1 - gone)), branch * (1 - mean)))
        beta = beta + weights[-1][2]
    return weights, beta
