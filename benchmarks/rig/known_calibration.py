"""A calibration whose specimens are known exactly: areas by finite elements, presses that differ by 0.3 %."""

from __future__ import annotations

import numpy as np

from emg2vsa.calibration.cut_presses import cut_forces, cut_rates
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.settings import CalibrationSettings
from emg2vsa.worlds.tactile import TabulatedWorld

MOUNTING_SD_PERCENT = 2.5
"""The areas here are true ones, and those of a press that is judged come from its pins, which tell them to 2.5 %."""
KAPPA = {"A": 7.63, "B": 5.3, "C": 3.35, "D": 2.0, "E": 1.11}


def known_calibration(
    condition: str = "high-stiffness",
    angle_deg: float = 0.0,
    *,
    area_unit: str = "mm2",
    quantity: str = "front",
    simulated: bool = True,
) -> OnlineCalibration:
    """What presses of the elastic emulated rig are judged by."""
    world, forces, rng = TabulatedWorld(), cut_forces(0.5, 7.0), np.random.default_rng(0)
    force_n, kappa = np.linspace(0.5, 7.2, 30), np.array(list(KAPPA.values()))
    areas = [np.pi * world.radius_mm(force_n, each) ** 2 for each in kappa]
    rates = np.array(
        [
            [cut_rates(force_n, area * (1 + 0.003 * rng.standard_normal()), 0.5, forces) for _ in range(6)]
            for area in areas
        ]
    )
    return OnlineCalibration(
        specimens=tuple(KAPPA), kappa=kappa, kappa_se=np.zeros(kappa.size), quantity=quantity, area_unit=area_unit,
        angle_deg=angle_deg, condition=condition, start_n=0.5, forces_n=forces, rates=rates,
        travel=np.full(rates.shape, np.nan), mounting=np.ones(rates.shape[:2], dtype=np.int64),
        settings=CalibrationSettings(mounting_sd_percent=MOUNTING_SD_PERCENT), growth=0.65, simulated=simulated,
    )  # fmt: skip
