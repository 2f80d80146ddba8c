"""Random numbers that belong to one press alone, so that any press can be made again without the others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casr.errors import SettingError

_STREAMS = ("sensor", "centre", "brightness", "timing", "force", "frame")


@dataclass(frozen=True)
class Draws:
    """Independent generators for each thing that is random in a press.

    Parameters
    ----------
    seed : of the sensor and all its presses, 0 or more.
    stiffness_n_per_mm, angle_deg, repetition : which press.
    """

    seed: int
    stiffness_n_per_mm: float
    angle_deg: float
    repetition: int

    def __post_init__(self) -> None:
        if self.seed < 0 or self.repetition < 0:
            raise SettingError(
                "seed, repetition",
                wanted="numbers of 0 or more",
                found=f"{self.seed}, {self.repetition}",
                do="Choose other numbers.",
            )

    def sensor(self) -> np.random.Generator:
        """For what all presses of one sensor share: dirt, texture, missing pins."""
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(0,)))

    def of(self, stream: str, *number: int) -> np.random.Generator:
        """For ``centre``, ``brightness``, ``timing``, ``force`` or ``frame`` (with its number) of this press."""
        entropy = (self.seed, round(self.stiffness_n_per_mm * 1000), round(self.angle_deg * 1000), self.repetition)
        return np.random.default_rng(np.random.SeedSequence(entropy, spawn_key=(_STREAMS.index(stream), *number)))
