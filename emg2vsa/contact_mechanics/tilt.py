"""A probe that comes down at a tilt: the shear force of its contact, and what force along the axis and area become.

Both bodies are incompressible, so a contact resists a sideways way with 2/3 of what it resists an approach with
(Mindlin 1949, Journal of Applied Mechanics 16, 259): it sticks while the shear force stays below friction, then slides.
"""

from __future__ import annotations

import math

from emg2vsa.contact_mechanics.relaxation import ConvolvedForce, Relaxation
from emg2vsa.errors import SettingError

SHEAR_OVER_NORMAL = 2 / 3
"Ratio of the tangential to the normal stiffness of a contact between incompressible bodies."
SHRINK_AT_SLIDING = 0.1
"Share of the area that is lost when the contact begins to slide (assumption; up to 0.3: Sahli 2018, PNAS 115, 471)."


class Shear:
    """Shear force Q of one contact, stepped along with its normal force.

    Parameters
    ----------
    relaxation : of both bodies, as for the normal force.
    friction : coefficient at which a contact that sticks begins to slide; 0 is none.
    mount_n_per_mm : stiffness of the mount across the probe's axis, in series; infinite is rigid.
    friction_drop : by how much less the coefficient is while it slides. Then it slides in jerks: at each the force
        drops by twice that (the slider swings past its balance and sticks again).
    """

    def __init__(
        self, relaxation: Relaxation, *, friction: float, mount_n_per_mm: float = math.inf, friction_drop: float = 0.0
    ) -> None:
        if not 0 <= 2 * friction_drop <= friction or not math.isfinite(friction):
            raise SettingError(
                "friction", wanted="a coefficient of 0 or more, with at most half of it lost in sliding",
                found=f"{friction!r}, {friction_drop!r}", do="Correct the friction.",
            )  # fmt: skip
        if not mount_n_per_mm > 0:
            raise SettingError(
                "mount_n_per_mm", wanted="a number above 0", found=repr(mount_n_per_mm), do="Correct the mount."
            )
        self._friction, self._after_slip = friction, friction - 2 * friction_drop
        self._give = 1 / mount_n_per_mm
        self._convolved = ConvolvedForce(relaxation, 0.0)
        self.reset()

    def reset(self) -> None:
        """No contact, and no past."""
        self._convolved.reset()
        self.way_mm = 0.0
        "How far the contact is sheared: the way of the probe's tip against the specimen, less what has slid."

    @property
    def force_n(self) -> float:
        """Q, the way the surface holds the probe back."""
        return self._convolved.force_n

    def after(self, step_s: float, way_mm: float, slope_n_per_mm: float, normal_n: float) -> float:
        """Q after a step on which the probe went ``way_mm`` along the surface, without going there.

        ``slope_n_per_mm``: growth of the elastic normal force per depth, over this step. ``normal_n``: at its end.
        """
        alpha, beta = self._convolved.alpha_beta(step_s)
        stiffness = SHEAR_OVER_NORMAL * slope_n_per_mm
        pulled = self._convolved.convolved_n - alpha + stiffness * (way_mm + self._give * self._convolved.force_n)
        shear_n = pulled / (beta + stiffness * self._give)
        if abs(shear_n) > self._friction * normal_n:
            return math.copysign(self._after_slip * max(normal_n, 0.0), shear_n)
        return shear_n

    def advance(self, step_s: float, way_mm: float, slope_n_per_mm: float, normal_n: float) -> float:
        """Go there: Q at the end of the step."""
        shear_n, before_n = self.after(step_s, way_mm, slope_n_per_mm, normal_n), self._convolved.convolved_n
        grown_n = self._convolved.advance(step_s, shear_n) - before_n
        if slope_n_per_mm > 0:
            self.way_mm += grown_n / (SHEAR_OVER_NORMAL * slope_n_per_mm)
        return shear_n

    def rest(self) -> None:
        """The probe has left the specimen."""
        self.reset()


def forces_n(normal_n: float, shear_n: float, tilt_rad: float) -> tuple[float, float]:
    """Force across the probe's axis, the way the surface falls off, and along it, down."""
    sine, cosine = math.sin(tilt_rad), math.cos(tilt_rad)
    return normal_n * sine - shear_n * cosine, normal_n * cosine + shear_n * sine


def area_share(shear_n: float, normal_n: float, friction: float) -> float:
    """What shear leaves of the contact area: 1 - 0.1 (Q / mu P)^2; 1 without friction or force."""
    limit_n = friction * normal_n
    return 1 - SHRINK_AT_SLIDING * (shear_n / limit_n) ** 2 if limit_n > 0 else 1.0
