"""The stage from scored runs to hypotheses: areas and rates by specimen, angle, algorithm and actuator (paper VI)."""

from emg2vsa.discrimination.discriminate import Discrimination, discriminate

__all__ = ["Discrimination", "discriminate"]
