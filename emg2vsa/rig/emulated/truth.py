"""What is true of the presses of an emulated run, to hold their scores against."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.rig.emulated.press_draws import PressDraws
from emg2vsa.rig.emulated.settings import EmulatedSettings
from emg2vsa.rig.experiment import run_name
from emg2vsa.rig.plan import RIGID
from emg2vsa.rig.rig_settings import RigSettings


def true_areas_mm2(
    specimen: str, angle_deg: float, condition: str, rig: RigSettings, emulated: EmulatedSettings, force_n: ArrayLike
) -> NDArray[np.float64]:
    """(R,) true contact area, mm2, of press r at ``force_n``[r], N along the probe's axis; NaN for NaN."""
    name = run_name(specimen, angle_deg, condition)
    draws = PressDraws(emulated, specimen, angle_deg, condition == RIGID, rig, name)
    areas = []
    for press, force in enumerate(np.asarray(force_n, dtype=np.float64).tolist()):
        world = draws.world(press)
        normal_n = force / math.cos(math.radians(world.angle_deg))
        areas.append(draws.scene(press).area_mm2(normal_n) if math.isfinite(normal_n) else math.nan)
    return np.array(areas)
