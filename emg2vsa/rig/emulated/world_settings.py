"""What the emulated rig is made of. Nothing here has been tuned to a result; what nobody has published is a guess."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from casr.specimens import SPECIMENS
from casr.synthetic import ContactWorld
from emg2vsa.actuator import SPRINGS, Springs
from emg2vsa.errors import SettingError


@dataclass(frozen=True, kw_only=True)
class WorldSettings:
    """One specimen under one actuator. SettingError for what cannot be.

    Parameters
    ----------
    stiffness_n_per_mm : of the specimen by plate indentation (paper, section IV.B; here its S3).
    angle_deg : between the probe's axis and the normal of the specimen's surface (paper: 0, 30, 45 degrees).
    contact : of soft sensor and specimen, as the emulated camera draws it, with its own sources and guesses.
    springs : of the actuator (source: in ``emg2vsa.actuator``); None is a rigid motor, the paper's high stiffness.
    friction_nm : Coulomb friction of the shaft (source: nickparnenzini/qbmove_plugin, qbmove_project.pdf); 0 is none.
    settling_s : time constant with which the shaft comes to rest, 0 is at once (guess).
    mm_per_degree : of the probe per turn of the shaft: a cogwheel of 11.5 mm pitch radius (guess; the paper is silent).
    turns_to_push : which way the shaft turns to move the probe down, 1 or -1.
    gap_mm : from the probe with the shaft at 0 to first contact, along the probe's axis (guess).
    """

    stiffness_n_per_mm: float = SPECIMENS["S3"]
    angle_deg: float = 0.0
    contact: ContactWorld = field(default_factory=ContactWorld)
    springs: Springs | None = SPRINGS["qbmove-maker-pro"]
    friction_nm: float = 0.01
    settling_s: float = 0.01
    mm_per_degree: float = 0.2
    turns_to_push: Literal[1, -1] = 1
    gap_mm: float = 5.0

    def __post_init__(self) -> None:
        rules = (
            ("stiffness_n_per_mm", "above 0", self.stiffness_n_per_mm > 0),
            ("angle_deg", "from 0 to below 90", 0 <= self.angle_deg < 90),
            ("friction_nm", "of 0 or more", self.friction_nm >= 0),
            ("settling_s", "of 0 or more", self.settling_s >= 0),
            ("mm_per_degree", "above 0", self.mm_per_degree > 0),
            ("gap_mm", "of 0 or more", self.gap_mm >= 0),
        )
        for name, wanted, holds in rules:
            value = getattr(self, name)
            if not (holds and math.isfinite(value)):
                do = "Correct the emulated rig."
                raise SettingError(name, wanted=f"a number {wanted}", found=repr(value), do=do)
        if self.contact.exponent >= 1:
            raise SettingError(
                "contact.exponent",
                wanted="below 1, or no force holds against a finite indentation",
                found=repr(self.contact.exponent),
                do="Correct the contact.",
            )
