"""What the emulated rig is made of. Nothing here has been tuned to a result; what nobody has published is a guess."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from casr.specimens import SPECIMENS
from emg2vsa.devices.qbmove.springs import SPRINGS, Springs
from emg2vsa.errors import SettingError
from emg2vsa.worlds.contact import ELASTIC, Relaxation
from emg2vsa.worlds.tactile import ContactWorld


@dataclass(frozen=True, kw_only=True)
class WorldSettings:
    """One specimen under one actuator. SettingError for an angle that cannot be.

    Parameters
    ----------
    stiffness_n_per_mm : of the specimen by plate indentation (paper, section IV.B; here its S3).
    angle_deg : between the probe's axis and the normal of the specimen's surface (paper: 0, 30, 45 degrees).
    contact : of soft sensor and specimen, as the emulated camera draws it, with its own sources and guesses.
    springs : of the actuator (source: in `SPRINGS`); None is a rigid motor, the paper's high stiffness.
    friction_nm : Coulomb friction of the shaft (source: nickparnenzini/qbmove_plugin, qbmove_project.pdf); 0 is none.
    settling_s : time constant with which the shaft comes to rest, 0 is at once (guess).
    mm_per_degree : of the probe per turn of the shaft: a cogwheel of 11.5 mm pitch radius (guess; the paper is silent).
    turns_to_push : which way the shaft turns to move the probe down, 1 or -1.
    relaxation : of sensor and specimen in series; the elastic one remembers nothing.
    skin_friction, friction_drop, mount_n_per_mm : between skin and specimen, and the sensor's mount across the probe's
        axis, as ``emg2vsa.worlds.contact.ContactHistory`` has them; friction 0 is a skin that slides freely.
    plate : a flat plate presses, in place of the dome of the tactile sensor.
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
    plate: bool = False
    relaxation: Relaxation = ELASTIC
    skin_friction: float = 0.0
    friction_drop: float = 0.0
    mount_n_per_mm: float = math.inf

    def __post_init__(self) -> None:
        if not 0 <= self.angle_deg < 90:
            do = "Correct the emulated rig."
            raise SettingError("angle_deg", wanted="0 to below 90 degrees", found=repr(self.angle_deg), do=do)
