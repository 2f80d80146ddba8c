"""A probe that comes down at a tilt: the shear force of its contact, and what force along the axis and area become.

Both bodies are incompressible, so a contact resists a sideways way with 2/3 of what it resists an approach with
(Mindlin 1949, Journal of Applied Mechanics 16, 259): it sticks while the shear force stays below friction, then slides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Generic

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.dome_contact import SHEAR_OVER_NORMAL
from emg2vsa.errors import SettingError
from emg2vsa.worlds.contact.relaxation import ConvolvedForce, Number, Relaxation

SHRINK_AT_SLIDING = 0.1
"Share of the area that is lost when the contact begins to slide (assumption; up to 0.3: Sahli 2018, PNAS 115, 471)."

TINY_N_PER_MM = 1e-300


class Shear(Generic[Number]):
    """Shear force Q of one contact, stepped along with its normal force; or of many at once, as `ConvolvedForce`.

    Parameters
    ----------
    relaxation : of both bodies, as for the normal force.
    zero : 0.0, or zeros (P,) for P contacts.
    friction : coefficient at which a contact that sticks begins to slide; 0 is none.
    mount_n_per_mm : stiffness of the mount across the probe's axis, in series; infinite is rigid.
    friction_drop : by how much less the coefficient is while it slides. Then it slides in jerks: at each the force
        drops by twice that (the slider swings past its balance and sticks again).
    """

    def __init__(
        self,
        relaxation: Relaxation | Sequence[Relaxation],
        zero: Number,
        *,
        friction: float,
        mount_n_per_mm: float = math.inf,
        friction_drop: float = 0.0,
    ) -> None:
        check_skin(friction, friction_drop, mount_n_per_mm)
        self._friction, self._after_slip = friction, friction - 2 * friction_drop
        self._give = 1 / mount_n_per_mm
        self._convolved: ConvolvedForce[Number] = ConvolvedForce(relaxation, zero)
        self._zero: Number = zero
        self.way_mm: Number = zero
        "How far the contact is sheared: the way of the probe's tip along the surface, less what has slid."

    def reset(self) -> None:
        """No contact, and no past."""
        self._convolved.reset()
        self.way_mm = self._zero

    @property
    def force_n(self) -> Number:
        """Q, the way the surface holds the probe back."""
        return self._convolved.force_n

    def after(self, step_s: float, way_mm: Number, slope_n_per_mm: Number, normal_n: Number) -> Number:
        """Q after a step on which the probe goes ``way_mm`` along the surface, without going there.

        ``slope_n_per_mm`` : growth of the elastic force per depth on this step. ``normal_n`` : at its end.
        """
        convolved = self._convolved
        alpha, beta = convolved.alpha_beta(step_s)
        stiffness = SHEAR_OVER_NORMAL * slope_n_per_mm
        pulled_n = convolved.convolved_n - alpha + stiffness * (way_mm + self._give * convolved.force_n)
        return self._held(pulled_n / (beta + stiffness * self._give), normal_n)

    def advance(self, step_s: float, way_mm: Number, slope_n_per_mm: Number, normal_n: Number) -> Number:
        """Go there: Q at the end of the step."""
        shear_n, before_n = self.after(step_s, way_mm, slope_n_per_mm, normal_n), self._convolved.convolved_n
        grown_n = self._convolved.advance(step_s, shear_n) - before_n
        # where nothing presses yet there is nothing to shear
        self.way_mm = self.way_mm + grown_n / (SHEAR_OVER_NORMAL * slope_n_per_mm + TINY_N_PER_MM)
        return shear_n

    def _held(self, shear_n: Number, normal_n: Number) -> Number:
        """What friction can hold of it."""
        if isinstance(shear_n, float):
            if abs(shear_n) <= self._friction * normal_n:
                return shear_n
            return math.copysign(self._after_slip * max(normal_n, 0.0), shear_n)
        limit_n = np.maximum(normal_n, 0.0)
        slides = np.abs(shear_n) > self._friction * limit_n
        return np.where(slides, np.copysign(self._after_slip * limit_n, shear_n), shear_n)


def check_skin(friction: float, friction_drop: float, mount_n_per_mm: float) -> None:
    """SettingError unless a contact can be as `Shear` describes it."""
    if not (0 <= 2 * friction_drop <= friction < math.inf):
        raise SettingError(
            "friction", wanted="a coefficient of 0 or more, of which sliding takes at most half",
            found=f"{friction!r}, less {friction_drop!r} in sliding", do="Correct the friction.",
        )  # fmt: skip
    if not mount_n_per_mm > 0:
        raise SettingError(
            "mount_n_per_mm", wanted="a number above 0", found=repr(mount_n_per_mm), do="Correct the mount."
        )


def forces_n(normal_n: Number, shear_n: Number, tilt_rad: float) -> tuple[Number, Number]:
    """Force across the probe's axis, the way the surface falls off, and along it, down."""
    sine, cosine = math.sin(tilt_rad), math.cos(tilt_rad)
    return normal_n * sine - shear_n * cosine, normal_n * cosine + shear_n * sine


def area_share(shear_n: ArrayLike, normal_n: ArrayLike, friction: float) -> Floats:
    """What shear leaves of the contact area: 1 - 0.1 (Q / mu P)^2; 1 without friction or force. Any shape."""
    limit_n = friction * np.asarray(normal_n, dtype=np.float64)
    pressed = limit_n > 0
    used = np.where(pressed, np.asarray(shear_n, dtype=np.float64) / np.where(pressed, limit_n, 1.0), 0.0)
    return np.asarray(1 - SHRINK_AT_SLIDING * used**2)


def area_share_of_one(shear_n: float, normal_n: float, friction: float) -> float:
    """`area_share` of a single contact, to the last bit, in plain numbers: far quicker."""
    limit_n = friction * normal_n
    used = shear_n / limit_n if limit_n > 0 else 0.0
    return 1 - SHRINK_AT_SLIDING * (used * used)
