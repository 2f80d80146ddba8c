"""The delay budget: what every filter and sensor delays, and what of it is left when EMG and force are paired."""

from __future__ import annotations

from dataclasses import dataclass


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
        return self.emg_s - self.force_s - self.removed_s

    def __str__(self) -> str:
        parts = ", ".join(f"{name} {1e3 * delay:.3g} ms" for name, delay in self.parts)
        return f"delays: {parts}; removed in pairing {1e3 * self.removed_s:.3g} ms, left {1e3 * self.mismatch_s:.3g} ms"
