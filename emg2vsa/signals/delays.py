"""The delay budget: what every filter and sensor delays, and what of it is left when EMG and force are paired.

What only reads a budget loads no filter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from emg2vsa.signals.envelope import Smoother
    from emg2vsa.signals.filters import IirFilter, Phase

ESTIMATED = "force after EMG, estimated"
"Name of the part of a budget by which force was moved."


@dataclass(frozen=True)
class DelayBudget:
    """Delays in seconds, positive where the output is late.

    parts : each by name, as it was run. emg_s, force_s : their sums per signal. removed_s : how much of
    ``emg_s - force_s`` was taken out in pairing; what remains is ``mismatch_s``, positive where EMG lags force.
    """

    parts: tuple[tuple[str, float], ...]
    emg_s: float
    force_s: float
    removed_s: float

    @property
    def mismatch_s(self) -> float:
        """What is left after pairing, s: positive where EMG lags force."""
        return self.emg_s - self.force_s - self.removed_s

    def __str__(self) -> str:
        parts = ", ".join(f"{name} {1e3 * delay:.3g} ms" for name, delay in self.parts)
        return f"delays: {parts}; removed in pairing {1e3 * self.removed_s:.3g} ms, left {1e3 * self.mismatch_s:.3g} ms"


@dataclass(frozen=True)
class Shifts:
    """What is subtracted from the times of either signal before they are paired, seconds."""

    emg_s: float
    force_s: float


def delay_budget(
    phase: Phase, band: IirFilter, envelope: Smoother, low: IirFilter | None, sensor_s: float, lag_s: float = 0.0
) -> tuple[DelayBudget, Shifts]:
    """Budget and shifts of one recording.

    sensor_s : stated delay of the force sensor, s. lag_s : by which force was found to follow EMG, s. Both are always
        removed.
    Filter delays are zero (zero-phase), removed (compensated) or left in (causal: as on line and in the paper; the
    budget then states the mismatch).
    """
    low_s = 0.0 if low is None else low.delay_s
    parts = [(band.name, band.delay_s), (envelope.name, envelope.delay_s)]
    parts += [] if low is None else [(low.name, low_s)]
    parts += [("force sensor", sensor_s)] if sensor_s else []
    parts += [(ESTIMATED, lag_s)] if lag_s else []
    emg_s = band.delay_s + envelope.delay_s
    compensated = phase == "compensated"
    shifts = Shifts(emg_s if compensated else 0.0, (low_s if compensated else 0.0) + sensor_s + lag_s)
    return DelayBudget(tuple(parts), emg_s, low_s + sensor_s + lag_s, shifts.emg_s - shifts.force_s), shifts
