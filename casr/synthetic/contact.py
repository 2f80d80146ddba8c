"""How large the contact is at a force: a soft dome pressed on a specimen of known stiffness."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import SettingError
from casr.synthetic.stick import StickSkin

if TYPE_CHECKING:
    from casr.synthetic.settings import PressSettings


@dataclass(frozen=True, kw_only=True)
class ContactWorld:
    """Mechanics of sensor and specimen.

    Parameters
    ----------
    tip_radius_mm : radius of the dome; the TacTip's tip is 40 mm wide (source: the sensor).
    exponent : of the contact radius over force. 1/4 lies inside the range of a nonlinear soft finger, n/(2n+1) <= 1/3
        (source: Xydas and Kao 1999); 1/3 is Hertz.
    sensor_modulus_mpa : reduced modulus of the dome (guess).
    punch_radius_mm : radius of the flat plate that measured the specimen's stiffness (guess), for E* = kappa/(2 a)
        (source: Sneddon 1965).
    lever_ratio : length of a pin over the radius of the dome (guess).
    stick_force_n : up to this force the contact grows over the resting skin and pins only tilt; from it on the contact
        is a piece of skin that stretches (guess). It lies below the first contact of 0.5 N by the force gained in half
        a frame: the log rows of a frame are written after its exposure, so the frame whose rows first average 0.5 N
        may have been exposed at 0.44 N, and the area law is to hold from there.
    """

    tip_radius_mm: float = 20.0
    exponent: float = 0.25
    sensor_modulus_mpa: float = 0.4
    punch_radius_mm: float = 5.0
    lever_ratio: float = 0.1
    stick_force_n: float = 0.43

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value > 0):
                raise SettingError(field.name, wanted="a number above 0", found=repr(value), do="Correct the contact.")
        if self.lever_ratio >= 1 or self.exponent > 1:
            raise SettingError(
                "lever_ratio, exponent",
                wanted="a ratio below 1 and an exponent of at most 1",
                found=f"{self.lever_ratio!r}, {self.exponent!r}",
                do="Correct the contact.",
            )

    @property
    def name(self) -> str:
        """In results."""
        return f"stick from {self.stick_force_n:g} N"

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What is not known to be so."""
        return ("from stick_force_n on the contact is a piece of skin that stretches as the contact grows",)

    def press(self, settings: PressSettings, centre_mm: tuple[float, float], area_factor: float = 1.0) -> StickSkin:
        """The skin of one press."""
        return StickSkin(self, settings, centre_mm, area_factor)

    def modulus_mpa(self, stiffness_n_per_mm: float) -> float:
        """Reduced modulus of dome and specimen in series, MPa."""
        specimen_mpa = stiffness_n_per_mm / (2 * self.punch_radius_mm)
        return 1 / (1 / self.sensor_modulus_mpa + 1 / specimen_mpa)

    def radius_mm(self, force_n: ArrayLike, stiffness_n_per_mm: float) -> NDArray[np.float64]:
        """Contact radius a = R (3F / (4 E* R^2))^exponent, mm; 0 where the force does not press."""
        force = np.maximum(np.asarray(force_n, dtype=np.float64), 0.0)
        pressure_mpa = 4 * self.modulus_mpa(stiffness_n_per_mm) * self.tip_radius_mm**2 / 3
        return np.asarray(self.tip_radius_mm * (force / pressure_mpa) ** self.exponent, dtype=np.float64)

    def area_mm2(self, force_n: ArrayLike, stiffness_n_per_mm: float, angle_deg: float = 0.0) -> NDArray[np.float64]:
        """Contact area in the image plane, pi a^2 cos(angle), mm^2."""
        return np.pi * self.radius_mm(force_n, stiffness_n_per_mm) ** 2 * math.cos(math.radians(angle_deg))
