"""What the stiffness of the drive does to the spread rates of specimens, where nothing but mechanics can do it.

Three ways are kept apart: creep of sensor and specimen, through how long a press lasts; equation (2) as printed, a sum
over frames, through how many there are; and errors of timing, through how fast the force grows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from casr.spread import spread_rate
from emg2vsa.arrays import Floats
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.errors import DataError
from emg2vsa.worlds.contact.camera_frames import FrameErrors, frames_of, power_rates
from emg2vsa.worlds.contact.press_path import Drive, PressPaths, StiffnessSteps, simulate_presses
from emg2vsa.worlds.contact.relaxation import Relaxation, in_series, specimen_share

STEP_S = 2.5e-3
_PHASES = 40
"Presses over which a sum over frames is averaged: each begins at another time between two frames."
_DRAWS = 2000
_SEED = 18


@dataclass(frozen=True)
class Material:
    """Shares of the force that sensor and specimens relax by between 0.1 and 10 s; 0 is elastic."""

    name: str
    sensor: float
    specimens: Mapping[str, float]


LOSSY_SENSOR, LOSSY_SPECIMENS = 0.30, 0.10
"Shares of a sensor that creeps as much as soft printed skin may, on specimens that creep alike."
AREA_NOISE = 0.01
"Standard deviation of the area of one frame, as a share (assumption)."
PRESS_CV = 0.03
"Of the spread rate from press to press (assumption; the emulated bench has 3 to 5 %)."
_FOUND, _MISSED = 1.959964, 0.841621
"Normal quantiles of 5 % on both sides and of a power of 80 %."


def materials_of(sensor: float, specimens: Mapping[str, float]) -> tuple[Material, Material, Material]:
    """Elastic ones, those given, and a very lossy sensor."""
    return (
        Material("elastic", 0.0, dict.fromkeys(specimens, 0.0)),
        Material("assumed", sensor, specimens),
        Material("lossy sensor", LOSSY_SENSOR, dict.fromkeys(specimens, LOSSY_SPECIMENS)),
    )


def replicates_needed(difference: Floats, sd: float) -> Floats:
    """In each of four cells, for a difference of two contrasts at 5 % and a power of 80 %; each score has that ``sd``.

    Logarithms: a contrast is that of a ratio of two scores. Infinite for no difference.
    """
    with np.errstate(divide="ignore"):
        return np.asarray(4 * ((_FOUND + _MISSED) * sd / np.asarray(difference, dtype=np.float64)) ** 2)


@dataclass(frozen=True)
class Bench:
    """Who is pressed by what.

    stiffness_mpa : specimen to its reduced modulus, the stiffest first. sensor_mpa : that of the sensor.
    area_mm2 : contact area of a specimen, by name, at elastic forces (T,).
    drive : with springs. steps : condition to the steps of each specimen. window_n : forces that are scored.
    """

    stiffness_mpa: Mapping[str, float]
    sensor_mpa: float
    tip_radius_mm: float
    exponent: float
    area_mm2: Callable[[str, Floats], Floats]
    drive: Drive
    steps: Mapping[str, Mapping[str, StiffnessSteps]]
    window_n: tuple[float, float]
    rate_hz: float


@dataclass(frozen=True, eq=False)
class StiffnessEffect:
    """Of K specimens, the stiffest first, and C conditions, the rigid motor first.

    duration_s : (K, C) between the forces of the window, elastic bodies. slope : (M, K, C) true spread rate, mm2/N, in
    M materials. frame_sum : (K, C) equation (2) as printed, elastic bodies; frame_sum_swapped, slope_swapped : (K, C)
    the same and the slope with the schedules of the specimens in reverse order.
    timing_cv : (2, C) CV of the spread rate of the pair with errors of timing; timing_d : (C,) d' of the pair.
    specimen_share : (K,) of the compliance of specimen and sensor. area_power : (K,) ln of area per ln of force.
    """

    specimens: tuple[str, ...]
    conditions: tuple[str, ...]
    materials: tuple[str, ...]
    pair: tuple[str, str]
    duration_s: Floats
    slope: Floats
    frame_sum: Floats
    frame_sum_swapped: Floats
    slope_swapped: Floats
    timing_cv: Floats
    timing_d: Floats
    specimen_share: Floats
    area_power: Floats

    def creep_exponent(self, share: float, condition: int) -> float:
        """n of a creep t^n of the softest specimen alone that would raise its contrast to the stiffest by ``share``
        under a condition against the rigid motor: ln A grows by its power of force, times its share of the compliance,
        times n, with ln of the duration. Infinite where a press does not last longer."""
        longer = float(np.log(self.duration_s[-1, condition] / self.duration_s[-1, 0]))
        per_n = self.area_power[-1] * self.specimen_share[-1] * longer
        return float(np.log1p(share) / per_n) if per_n > 0 else np.inf

    def contrast(self, slopes: Floats, specimen: int = -1) -> Floats:
        """(..., C) logarithm of the ratio of a specimen, the softest unless said, to the stiffest; of (..., K, C)."""
        return np.asarray(np.log(slopes[..., specimen, :] / slopes[..., 0, :]))


def stiffness_effect(bench: Bench, materials: Sequence[Material], errors: FrameErrors, rigid: str) -> StiffnessEffect:
    """All of it. The first of the ``materials`` is elastic, and errors of timing act in the second.

    DataError with fewer than two specimens, or where a specimen lacks the steps of a condition.
    """
    names = tuple(bench.stiffness_mpa)
    lacking = [f"{name}, {condition}" for condition, of in bench.steps.items() for name in names if name not in of]
    if len(names) < 2 or lacking:
        raise DataError(
            "effect of stiffness", wanted="two specimens or more, each with a schedule for every condition",
            found=f"{len(names)} specimens" + (f", none for {lacking[0]}" if lacking else ""),
            do="Add specimens to the experiment, or leave conditions out.",
        )  # fmt: skip
    elastic, creeping = (_Pressed(bench, material) for material in materials[:2])
    swapped = _Pressed(bench, materials[0], dict(zip(names, reversed(names), strict=True)))
    slopes = [each.slopes() for each in (elastic, creeping, *(_Pressed(bench, each) for each in materials[2:]))]
    rates = np.log(creeping.seen_rates(2, errors))
    cv = rates.std(axis=2, ddof=1)
    return StiffnessEffect(
        specimens=names,
        conditions=(rigid, *bench.steps),
        materials=tuple(material.name for material in materials),
        pair=(names[0], names[1]),
        duration_s=elastic.durations(),
        slope=np.array(slopes),
        frame_sum=elastic.frame_sums(),
        frame_sum_swapped=swapped.frame_sums(),
        slope_swapped=swapped.slopes(),
        timing_cv=cv,
        timing_d=(rates[1] - rates[0]).mean(axis=1) / np.sqrt((cv**2).mean(axis=0)),
        specimen_share=np.array([specimen_share(each, bench.sensor_mpa) for each in bench.stiffness_mpa.values()]),
        area_power=np.array([_area_power(bench, name) for name in names]),
    )


def _area_power(bench: Bench, name: str) -> float:
    low, high = bench.area_mm2(name, np.array(bench.window_n))
    return float(np.log(high / low) / np.log(bench.window_n[1] / bench.window_n[0]))


class _Pressed:
    """Presses on all K specimens under all C conditions, the rigid motor first, specimens with own schedules or those
    of the specimen that ``schedule_of`` says."""

    def __init__(self, bench: Bench, material: Material, schedule_of: Mapping[str, str] | None = None) -> None:
        self._bench, self._count = bench, len(bench.stiffness_mpa)
        bodies, contacts = [], []
        for name, specimen_mpa in bench.stiffness_mpa.items():
            share = specimen_share(specimen_mpa, bench.sensor_mpa)
            of_specimen = Relaxation.of_share(material.specimens.get(name, 0.0))
            bodies.append(in_series([(share, of_specimen), (1 - share, Relaxation.of_share(material.sensor))]))
            modulus_mpa = 1 / (1 / bench.sensor_mpa + 1 / specimen_mpa)
            contacts.append(PowerLaw(modulus_mpa, bench.tip_radius_mm, bench.exponent))
        of = schedule_of or {}
        steps = [own[of.get(name, name)] for own in bench.steps.values() for name in bench.stiffness_mpa]
        kinds = len(bench.steps)
        self._runs = [
            self._with_areas(paths)
            for paths in (
                self._press(contacts, bodies, replace(bench.drive, springs=None), ()),
                self._press(contacts * kinds, bodies * kinds, bench.drive, steps),
            )
        ]

    def durations(self) -> Floats:
        """(K, C) seconds from the lower to the higher force of the window."""
        return self._table([run.duration_s(*self._bench.window_n) for run in self._runs])

    def slopes(self) -> Floats:
        """(K, C) straight lines of area on force."""
        return self._table([run.slope_mm2_per_n(*self._bench.window_n) for run in self._runs])

    def frame_sums(self) -> Floats:
        """(K, C) mean of equation (2) as printed over presses that begin at other times between two frames."""
        firsts = (np.arange(_PHASES) + 0.5) / _PHASES / self._bench.rate_hz
        return self._table(
            [
                np.array([self._frame_sum(*self._frames(run, p, firsts, FrameErrors())) for p in range(_presses(run))])
                for run in self._runs
            ]
        )

    def seen_rates(self, specimens: int, errors: FrameErrors) -> Floats:
        """(specimens, C, draws) spread rates of the first ones by the power law, as frames with errors give them."""
        rng, found = np.random.default_rng(_SEED), []
        for run in self._runs:
            for p in range(_presses(run)):
                if p % self._count < specimens:
                    firsts = rng.uniform(0, 1 / self._bench.rate_hz, _DRAWS)
                    frames = self._frames(run, p, firsts, errors, rng)
                    found.append(power_rates(*frames, self._bench.window_n))
        return np.array(found).reshape(-1, specimens, _DRAWS).swapaxes(0, 1)

    def _press(
        self, contacts: list[PowerLaw], bodies: list[Relaxation], drive: Drive, steps: Sequence[StiffnessSteps]
    ) -> PressPaths:
        return simulate_presses(contacts, bodies, drive, steps, f_max_n=self._bench.window_n[1], step_s=STEP_S)

    def _with_areas(self, paths: PressPaths) -> PressPaths:
        names = list(self._bench.stiffness_mpa)
        columns = [self._bench.area_mm2(names[p % self._count], column) for p, column in enumerate(paths.convolved_n.T)]
        return replace(paths, area_mm2=np.stack(columns, axis=1))

    def _frames(
        self,
        run: PressPaths,
        press: int,
        firsts: Floats,
        errors: FrameErrors,
        rng: np.random.Generator | None = None,
    ) -> tuple[Floats, Floats]:
        rng = rng or np.random.default_rng(_SEED)
        bench = self._bench
        return frames_of(run, press, firsts, errors, rng, rate_hz=bench.rate_hz, window_n=bench.window_n)

    def _frame_sum(self, force_n: Floats, area_mm2: Floats) -> float:
        """Mean over the rows."""
        sums = [
            spread_rate(area[np.isfinite(area)], force[np.isfinite(area)], rule="paper").value
            for force, area in zip(force_n, area_mm2, strict=True)
        ]
        return float(np.mean(sums))

    def _table(self, of_runs: Sequence[Floats]) -> Floats:
        """(K, C) from the rigid motor's (K,) and the springs' (C - 1) K."""
        return np.concatenate([values.reshape(-1, self._count) for values in of_runs]).T


def _presses(run: PressPaths) -> int:
    return int(run.force_n.shape[1])
