"""Random numbers that belong to one press alone, so that any press can be made again without the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from casr.errors import SettingError

_STREAMS = ("sensor", "centre", "brightness", "timing", "force", "frame", "scatter", "jitter")
_FIRST_OF_MOUNTING = 100
"Key of the first thing that a mounting draws, away from those of the streams."


@dataclass(frozen=True)
class Draws:
    """Independent generators for each thing that is random in a press.

    Parameters
    ----------
    seed : of the sensor and all its presses, 0 or more.
    stiffness_n_per_mm, angle_deg, repetition : which press. mounting : of sensor and specimens, which presses share.
    """

    seed: int
    stiffness_n_per_mm: float
    angle_deg: float
    repetition: int
    mounting: int = 0

    mounted: ClassVar[tuple[str, ...]] = ("depth", "stiffness", "angle")
    "What a mounting fixes."

    def __post_init__(self) -> None:
        if min(self.seed, self.repetition, self.mounting) < 0:
            raise SettingError(
                "seed, repetition, mounting",
                wanted="numbers of 0 or more",
                found=f"{self.seed}, {self.repetition}, {self.mounting}",
                do="Choose other numbers.",
            )

    def sensor(self) -> np.random.Generator:
        """For what all presses of one sensor share: dirt, texture, missing pins."""
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(0,)))

    def of_mounting(self, what: str) -> np.random.Generator:
        """For what all presses of this mounting share; a depth with all specimens, an angle with this specimen's."""
        which = self.mounted.index(what)
        specimen = (round(self.stiffness_n_per_mm * 1000), round(self.angle_deg * 1000))
        key = (_FIRST_OF_MOUNTING + which,)
        return np.random.default_rng(
            np.random.SeedSequence((self.seed, self.mounting, *specimen[:which]), spawn_key=key)
        )

    def of(self, stream: str, *number: int) -> np.random.Generator:
        """For one of ``_STREAMS`` of this press; ``frame`` takes its number."""
        entropy = (self.seed, round(self.stiffness_n_per_mm * 1000), round(self.angle_deg * 1000), self.repetition)
        return np.random.default_rng(np.random.SeedSequence(entropy, spawn_key=(_STREAMS.index(stream), *number)))
