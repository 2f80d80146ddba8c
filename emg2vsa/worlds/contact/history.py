"""One contact of plain numbers, stepped: normal force, and the shear force of a probe that comes down at a tilt.

The normal force is that of `ConvolvedForce` to the last bit, stepped in one pass with the shear. A solver asks for the
forces at the end of a step many times, so all that does not depend on the end is computed once a step.

Both bodies are incompressible, so a contact resists a sideways way with 2/3 of what it resists an approach with
(Mindlin 1949, Journal of Applied Mechanics 16, 259): it sticks while the shear force stays below friction, then slides.
Shear shrinks the contact's area, adhesion enlarges it.
"""

from __future__ import annotations

import math
from functools import lru_cache

from emg2vsa.dome_contact import SHEAR_OVER_NORMAL
from emg2vsa.errors import SettingError
from emg2vsa.worlds.contact.relaxation import Relaxation, shares_of_step

SHRINK_AT_SLIDING = 0.1
"Share of the area that is lost when the contact begins to slide (assumption; up to 0.3: Sahli 2018, PNAS 115, 471)."
_TINY_N_PER_MM = 1e-300
_STEP_LENGTHS = 64
"Steps of the 1 kHz loop have few lengths, which differ by their rounding."


class ContactHistory:
    """Normal force P and shear force Q of one contact.

    A step is: ``begin``, ``forces`` for as many ends of it as wanted, and ``advance`` to the true end.

    Parameters
    ----------
    relaxation : of both bodies in series.
    friction : coefficient at which a contact that sticks begins to slide; 0 is none.
    mount_n_per_mm : stiffness of the mount across the probe's axis, in series; infinite is rigid.
    friction_drop : by how much less the coefficient is while it slides. Then it slides in jerks: at each the force
        drops by twice that (the slider swings past its balance and sticks again).

    Raises
    ------
    SettingError : no contact can be so.
    """

    def __init__(self, relaxation: Relaxation, *, friction: float, mount_n_per_mm: float, friction_drop: float) -> None:
        if not (0 <= 2 * friction_drop <= friction < math.inf):
            raise SettingError(
                "friction", wanted="a coefficient of 0 or more, of which sliding takes at most half",
                found=f"{friction!r}, less {friction_drop!r} in sliding", do="Correct the friction.",
            )  # fmt: skip
        if not mount_n_per_mm > 0:
            raise SettingError(
                "mount_n_per_mm", wanted="a number above 0", found=repr(mount_n_per_mm), do="Correct the mount."
            )
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
        "What is convolved so far, of each branch. ``way_mm`` : of the tip along the surface, less what has slid."

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
        """Normal and shear force, N, at the end of the step; both 0 where nothing pushes back there (shear: Mindlin
        1949).

        elastic_n : of an elastic contact there. slope_n_per_mm : its growth per depth on this step. way_mm : along the
            surface, on this step, mm.
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
        """Go there; normal and shear force then, N, as `forces`."""
        normal_n, shear_n = self.forces(elastic_n, slope_n_per_mm, way_mm)
        grown_n = self._instant * shear_n
        normal, shear = [], []
        for (_, _, from_new), part, shear_part in zip(self._of_step, self._parts, self._shear_parts, strict=True):
            normal.append(part + from_new * normal_n)
            z = shear_part + from_new * shear_n
            shear.append(z)
            grown_n = grown_n + z
        # where nothing presses yet there is nothing to shear
        self.way_mm += (grown_n - self._convolved_n) / (SHEAR_OVER_NORMAL * slope_n_per_mm + _TINY_N_PER_MM)
        self._normal, self._shear, self._normal_n, self._shear_n = normal, shear, normal_n, shear_n
        self._convolved_n = grown_n
        return normal_n, shear_n


def _weights(
    branches: list[tuple[float, float]], instant: float, step_s: float
) -> tuple[list[tuple[float, float, float]], float]:
    """Weights of each branch over a step: of its state, of the force at the start and of that at the end; and beta."""
    weights, beta = [], instant
    for tau_s, branch in branches:
        left, from_old, from_new = shares_of_step(step_s / tau_s)
        weights.append((left, branch * from_old, branch * from_new))
        beta = beta + weights[-1][2]
    return weights, beta


def area_share(shear_n: float, normal_n: float, friction: float) -> float:
    """What shear leaves of the contact area: 1 - 0.1 (Q / mu P)^2; 1 without friction or force. Q, P in N."""
    limit_n = friction * normal_n
    used = shear_n / limit_n if limit_n > 0 else 0.0
    return 1 - SHRINK_AT_SLIDING * (used * used)


def adhesive_force_n(force_n: float, adhesion_mj_per_m2: float, tip_radius_mm: float = 20.0) -> float:
    """The force at which a contact without adhesion is as large: F + W + sqrt(2 W F + W^2), W = 3 pi w R.

    Johnson, Kendall and Roberts 1971, Proceedings of the Royal Society A 324, 301. The factor in area is the same for
    all specimens, since the modulus cancels. Without adhesion it is F to the last bit.
    """
    if adhesion_mj_per_m2 == 0:
        return force_n
    pull_n = 3 * math.pi * adhesion_mj_per_m2 * tip_radius_mm * 1e-6
    return force_n + pull_n + math.sqrt(2 * pull_n * force_n + pull_n**2)
