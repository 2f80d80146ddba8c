"""Scores that the contact of ``emg2vsa.worlds.tactile`` gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from casr.specimens import SPECIMENS
from emg2vsa.calibration.calibrate import Calibration
from emg2vsa.calibration.left_out import left_out
from emg2vsa.calibration.repeats import RepeatInterval, repeat_interval
from emg2vsa.worlds.tactile import ContactWorld, casr_truth

FORCES_N = np.linspace(0.5, 7, 131)


@dataclass(frozen=True)
class Bench:
    """Specimens S1, S3 and S5 known, S2 new, in one contact world."""

    world: ContactWorld
    kappa = np.array([SPECIMENS[name] for name in ("S1", "S3", "S5")])
    kappa_new = SPECIMENS["S2"]

    def casr(self, kappa: Any, angle_deg: float = 0.0) -> np.ndarray:
        """Exact CASR, mm2/N, of specimens of these stiffnesses."""
        areas = [self.world.area_mm2(FORCES_N, k, angle_deg) for k in np.atleast_1d(kappa)]
        return np.array([casr_truth(area, FORCES_N) for area in areas])

    def mm_per_n(self, kappa: Any) -> np.ndarray:
        """Exact mean indentation per newton of specimens of these stiffnesses, to a factor."""
        moduli = np.array([self.world.modulus_mpa(k) for k in np.atleast_1d(kappa)])
        return moduli ** (self.world.exponent - 1)

    def presses(self, seed: int, d: int = 1, noise: Any = 0.02, r: int = 10) -> tuple[np.ndarray, np.ndarray]:
        """Scores of the known specimens (d, 3, r) and the new one (d, r); noise as a share, one or one for each."""
        share = np.broadcast_to(noise, (4,))[:, None] * np.random.default_rng(seed).standard_normal((d, 4, r))
        scores = self.casr([*self.kappa, self.kappa_new])[:, None] * (1 + share)
        return scores[:, :3], scores[:, 3]

    @staticmethod
    def interval(calibration: Calibration, scores: np.ndarray) -> RepeatInterval:
        """As ``estimate`` has it, without its bootstrap: widened where the known specimens reject the law."""
        widened = left_out(calibration).widening(calibration.settings.confidence)
        return repeat_interval(calibration, scores, widened=widened)


@pytest.fixture(scope="session")
def hertz() -> Bench:
    """A Hertz contact, in which the compliance law is exact."""
    return Bench(ContactWorld(exponent=1 / 3))


@pytest.fixture(scope="session")
def ours() -> Bench:
    """The simulated world of this project, in which it is not."""
    return Bench(ContactWorld())


@pytest.fixture(scope="session")
def bench_of() -> type[Bench]:
    """A bench in any world."""
    return Bench
