"""One contact of plain numbers, stepped: `ConvolvedForce` and `Shear` of the same bodies in one pass over branches.

The numbers are theirs to the last bit (tests/rig/emulated/test_contact_history.py). A solver asks for the forces at the
end of a step many times, so all that does not depend on the end is computed once a step.
"""

from __future__ import annotations

import math
from functools import lru_cache, reduce
from itertools import repeat
from operator import add, mul

from emg2vsa.contact_mechanics import Relaxation
from emg2vsa.contact_mechanics.tilt import SHEAR_OVER_NORMAL, TINY_N_PER_MM, check_skin

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
        (left, from_old, self._from_new), self.beta = self._weights(step_s)
        old_n, shear_n = self._normal_n, self._shear_n
        # here and in `advance` all branches at once, and summed one after the other, as floats are
        self._parts = list(map(add, map(mul, left, self._normal), map(mul, from_old, repeat(old_n))))
        self._shear_parts = list(map(add, map(mul, left, self._shear), map(mul, from_old, repeat(shear_n))))
        self._alpha_n = reduce(add, self._parts, 0.0)
        self._pulled_n = self._convolved_n - reduce(add, self._shear_parts, 0.0)
        self._given_mm = self._give * shear_n

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
        from_new = self._from_new
        self._normal = list(map(add, self._parts, map(mul, from_new, repeat(normal_n))))
        self._shear = list(map(add, self._shear_parts, map(mul, from_new, repeat(shear_n))))
        grown_n = reduce(add, self._shear, self._instant * shear_n)
        # where nothing presses yet there is nothing to shear
        self.way_mm += (grown_n - self._convolved_n) / (SHEAR_OVER_NORMAL * slope_n_per_mm + TINY_N_PER_MM)
        self._normal_n, self._shear_n, self._convolved_n = normal_n, shear_n, grown_n
        return normal_n, shear_n


def _weights(
    branches: list[tuple[float, float]], instant: float, step_s: float
) -> tuple[tuple[list[float], list[float], list[float]], float]:
    """Of all branches over a step: of their state, of the force at the start and of that at the end; and beta."""
    left, from_old, from_new, beta = list[float](), list[float](), list[float](), instant
    for tau_s, branch in branches:
        share = step_s / tau_s
        gone = -math.expm1(-share)
        mean = gone / share if share > 0 else 1.0
        left.append(1 - gone)
        from_old.append(branch * (mean - (1 - gone)))
        from_new.append(branch * (1 - mean))
        beta = beta + from_new[-1]
    return (left, from_old, from_new), beta
