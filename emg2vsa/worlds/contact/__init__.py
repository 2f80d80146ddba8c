"""A viscoelastic dome on a viscoelastic specimen: contact area and depth follow the convolved force."""

from emg2vsa.worlds.contact.history import ContactHistory, adhesive_force_n, area_share
from emg2vsa.worlds.contact.press_path import Drive, PressPaths, StiffnessSteps, simulate_presses
from emg2vsa.worlds.contact.relaxation import ELASTIC, ConvolvedForce, Relaxation, in_series, specimen_share

__all__ = [
    "ELASTIC",
    "ContactHistory",
    "ConvolvedForce",
    "Drive",
    "PressPaths",
    "Relaxation",
    "StiffnessSteps",
    "adhesive_force_n",
    "area_share",
    "in_series",
    "simulate_presses",
    "specimen_share",
]
