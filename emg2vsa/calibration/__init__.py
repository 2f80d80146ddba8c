"""The stage from CASR scores of known specimens to the stiffness of an unknown one (paper VI)."""

from __future__ import annotations

from emg2vsa.calibration.calibrate import Calibration, calibrate
from emg2vsa.calibration.comparison import LawComparison, compare_laws
from emg2vsa.calibration.left_out import LeftOut, left_out
from emg2vsa.calibration.unknown import Estimate, estimate
from emg2vsa.settings import CalibrationSettings

__all__ = [
    "Calibration",
    "CalibrationSettings",
    "Estimate",
    "LawComparison",
    "LeftOut",
    "calibrate",
    "compare_laws",
    "estimate",
    "left_out",
]
