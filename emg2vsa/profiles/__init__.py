"""Mean trend of the co-contraction per specimen, and the profile of a specimen nobody palpated (paper IV.B, VI.B).

The paper's weight of the softer neighbour is kappa / 10 N/mm; the default is the bracket (decision 3).
"""

from __future__ import annotations

from emg2vsa.profiles.build import build_profiles
from emg2vsa.profiles.by_person import ByPerson, by_person
from emg2vsa.profiles.errors import MeanErrors, Unit, errors_of, mean_errors
from emg2vsa.profiles.profile import ByRule, LeftOut, Profile, Profiles

__all__ = [
    "ByPerson", "ByRule", "LeftOut", "MeanErrors", "Profile", "Profiles", "Unit", "build_profiles", "by_person",
    "errors_of", "mean_errors",
]  # fmt: skip
