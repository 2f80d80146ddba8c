"""How many specimens and presses does a wanted precision of kappa need? Whole experiments, simulated and judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.forms import HERTZ
from emg2vsa.calibration.repeats import repeat_interval
from emg2vsa.errors import SettingError
from emg2vsa.settings import CalibrationSettings

_EXPERIMENTS_AT_ONCE = 500


@dataclass(frozen=True, kw_only=True)
class Situation:
    """What is measured, and how well.

    kappa : N/mm, of the specimen to be estimated. kappa_range : of the calibration specimens, N/mm, which are spread
    evenly in ln kappa. noise : standard deviation of a press's CASR, as a share of it. kappa_error : standard error of
    each known kappa, as a share of it. mounting_sd : standard deviation of CASR from one mounting to the next, as a
    share of it; every specimen is mounted once. sensor_n_per_mm : stiffness of the sensor under the punch that measured
    kappa, the -1/a of a compliance calibration.
    """

    kappa: float
    kappa_range: tuple[float, float]
    noise: float
    kappa_error: float = 0.0
    mounting_sd: float = 0.0
    sensor_n_per_mm: float

    def __post_init__(self) -> None:
        low, high = self.kappa_range
        amounts = (self.kappa, low, high, self.noise, self.sensor_n_per_mm)
        if not (
            all(0 < amount < np.inf for amount in amounts)
            and low < high
            and 0 <= self.kappa_error < 1
            and 0 <= self.mounting_sd < 0.5
        ):
            raise SettingError(
                "design",
                wanted="stiffnesses and noise above 0, a rising range, an error of kappa from 0 to below 1, "
                "and a spread of mountings from 0 to below 0.5",
                found=repr(self),
                do="Correct these values.",
            )


@dataclass(frozen=True)
class Design:
    """specimens : of the calibration. repetitions : presses of each, and of the new one.

    half_width, error : medians over experiments of the interval's half width and of the error, as shares of kappa.
    coverage : share of intervals that hold the truth.
    """

    specimens: int
    repetitions: int
    half_width: float
    error: float
    coverage: float

    @property
    def presses(self) -> int:
        """Presses in all, those of the new specimen included."""
        return (self.specimens + 1) * self.repetitions


def try_designs(
    situation: Situation,
    specimens: Sequence[int] = (3, 4, 6, 8),
    repetitions: Sequence[int] = (3, 5, 10, 20, 40),
    settings: CalibrationSettings | None = None,
    *,
    experiments: int = 1000,
) -> tuple[Design, ...]:
    """Every design, specimens first; ``experiments`` of each. SettingError for fewer than two of anything.

    Two specimens would do for the numbers, but nothing would show whether the law holds.
    """
    if min(*specimens, *repetitions, experiments) < 2:
        raise SettingError(
            "design",
            wanted="2 or more specimens, repetitions and experiments",
            found="fewer",
            do="Raise these numbers.",
        )
    settings = settings or CalibrationSettings()
    return tuple(_tried(situation, s, r, settings, experiments) for s in specimens for r in repetitions)


def smallest(designs: Sequence[Design], half_width: float) -> Design | None:
    """The design of fewest presses whose half width is at most ``half_width``; None where none is narrow enough."""
    enough = [design for design in designs if design.half_width <= half_width]
    return min(enough, key=lambda design: (design.presses, design.specimens), default=None)


def _tried(situation: Situation, s: int, r: int, settings: CalibrationSettings, experiments: int) -> Design:
    rng = np.random.default_rng([settings.seed, s, r])
    sizes = [min(_EXPERIMENTS_AT_ONCE, experiments - done) for done in range(0, experiments, _EXPERIMENTS_AT_ONCE)]
    found = [_experiments(situation, s, r, settings, size, rng) for size in sizes]
    kappa, low, high = (np.concatenate(each) for each in zip(*found, strict=True))
    truth = situation.kappa
    return Design(
        specimens=s,
        repetitions=r,
        half_width=float(np.median(high - low)) / (2 * truth),
        error=float(np.median(np.abs(kappa / truth - 1))),
        coverage=float(np.mean((low <= truth) & (truth <= high))),
    )


def _experiments(
    situation: Situation, s: int, r: int, settings: CalibrationSettings, d: int, rng: np.random.Generator
) -> tuple[Floats, Floats, Floats]:
    """kappa, low and high (d,) of so many simulated experiments."""
    known = np.append(np.geomspace(*situation.kappa_range, s), situation.kappa)
    casr = (1 / known + 1 / situation.sensor_n_per_mm) ** (1 / HERTZ)
    scores = casr[:, None] * (1 + situation.noise * rng.standard_normal((d, s + 1, r)))
    if situation.mounting_sd:
        scores *= 1 + situation.mounting_sd * rng.standard_normal((d, s + 1, 1))
    measured = known[:s] * (1 + situation.kappa_error * rng.standard_normal((d, s)))
    calibration = calibrate(
        measured, scores[:, :s], settings, casr_unit="any unit", kappa_se=situation.kappa_error * known[:s],
        mounting_sd=situation.mounting_sd,
    )  # fmt: skip
    found = repeat_interval(calibration, scores[:, s])
    return found.kappa, found.low, found.high
