"""The stage from CASR scores of known specimens to the stiffness of an unknown one (paper VI)."""

from __future__ import annotations

from emg2vsa.calibration.calibrate import Calibration, CalibrationSettings, calibrate
from emg2vsa.calibration.comparison import LawComparison, compare_laws
from emg2vsa.calibration.unknown import Estimate, estimate

__all__ = [
    "Calibration",
    "CalibrationSettings",
    "Estimate",
    "LawComparison",
    "calibrate",
    "compare_laws",
    "estimate",
]
