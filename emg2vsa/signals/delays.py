"""The delays of the filters that were run, and the shifts that pair EMG with force."""

from __future__ import annotations

from dataclasses import dataclass

from emg2vsa.signals.delay_budget import DelayBudget
from emg2vsa.signals.envelope import Smoother
from emg2vsa.signals.filters import IirFilter, Phase


@dataclass(frozen=True)
class Shifts:
    """What is subtracted from the times of either signal before they are paired, seconds."""

    emg_s: float
    force_s: float


def delay_budget(
    phase: Phase, band: IirFilter, envelope: Smoother, low: IirFilter | None, sensor_s: float
) -> tuple[DelayBudget, Shifts]:
    """Budget and shifts of one recording.

    The stated delay of the force sensor is always removed. Filter delays are zero (zero-phase), removed (compensated)
    or left in (causal: as on line and in the paper; the budget then states the mismatch).
    """
    low_s = 0.0 if low is None else low.delay_s
    parts = [(band.name, band.delay_s), (envelope.name, envelope.delay_s)]
    parts += [] if low is None else [(low.name, low_s)]
    parts += [("force sensor", sensor_s)] if sensor_s else []
    emg_s = band.delay_s + envelope.delay_s
    compensated = phase == "compensated"
    shifts = Shifts(emg_s if compensated else 0.0, (low_s if compensated else 0.0) + sensor_s)
    return DelayBudget(tuple(parts), emg_s, low_s + sensor_s, shifts.emg_s - shifts.force_s), shifts
