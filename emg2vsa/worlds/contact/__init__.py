"""A viscoelastic dome on a viscoelastic specimen: contact area and depth follow the convolved force."""

from __future__ import annotations

from emg2vsa.worlds.contact.adhesion import adhesive_force_n, adhesive_force_of_one_n
from emg2vsa.worlds.contact.press_path import Drive, PressPaths, StiffnessSteps, Tilt, simulate_presses
from emg2vsa.worlds.contact.relaxation import ELASTIC, ConvolvedForce, Relaxation, in_series
from emg2vsa.worlds.contact.tilt import Shear, area_share, area_share_of_one, forces_n

__all__ = [
    "ELASTIC",
    "ConvolvedForce",
    "Drive",
    "PressPaths",
    "Relaxation",
    "Shear",
    "StiffnessSteps",
    "Tilt",
    "adhesive_force_n",
    "adhesive_force_of_one_n",
    "area_share",
    "area_share_of_one",
    "forces_n",
    "in_series",
    "simulate_presses",
]
