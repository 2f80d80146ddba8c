"""Presses under all conditions, and a camera's few frames of them, for what stiffness can do by mechanics alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from casr.spread import fit_power_laws, spread_rate
from emg2vsa.arrays import Floats
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.errors import DataError
from emg2vsa.stiffness_effect import LOSSY_SENSOR, LOSSY_SPECIMENS, StiffnessEffect
from emg2vsa.worlds.contact.press_path import Drive, PressPaths, StiffnessSteps, simulate_presses
from emg2vsa.worlds.contact.relaxation import Relaxation, in_series, specimen_share

STEP_S = 2.5e-3
_PHASES = 40
"Presses over which a sum over frames is averaged: each begins at another time between two frames."
_DRAWS = 2000
_SEED = 18


@dataclass(frozen=True, kw_only=True)
class FrameErrors:
    """Standard deviations of normal errors; 0 is none.

    area_share : of the area of a frame, as a share. force_n : of the force of a frame.
    latency_sd_s : of the delay of frames from press to press, about one that is corrected. jitter_s : from frame to
    frame.
    """

    area_share: float = 0.0
    force_n: float = 0.0
    latency_sd_s: float = 0.0
    jitter_s: float = 0.0


@dataclass(frozen=True)
class Material:
    """Shares of the force that sensor and specimens relax by between 0.1 and 10 s; 0 is elastic."""

    name: str
    sensor: float
    specimens: Mapping[str, float]


AREA_NOISE = 0.01
"Standard deviation of the area of one frame, as a share (assumption)."


def materials_of(sensor: float, specimens: Mapping[str, float]) -> tuple[Material, Material, Material]:
    """Elastic ones, those given, and a very lossy sensor."""
    return (
        Material("elastic", 0.0, dict.fromkeys(specimens, 0.0)),
        Material("assumed", sensor, specimens),
        Material("lossy sensor", LOSSY_SENSOR, dict.fromkeys(specimens, LOSSY_SPECIMENS)),
    )


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
    rates = [each.rates() for each in (elastic, creeping, *(_Pressed(bench, each) for each in materials[2:]))]
    seen = np.log(creeping.seen_rates(2, errors))
    cv = seen.std(axis=2, ddof=1)
    return StiffnessEffect(
        specimens=names,
        conditions=(rigid, *bench.steps),
        materials=tuple(material.name for material in materials),
        pair=(names[0], names[1]),
        duration_s=elastic.durations(),
        rate=np.array(rates),
        frame_sum=elastic.frame_sums(),
        frame_sum_swapped=swapped.frame_sums(),
        rate_swapped=swapped.rates(),
        timing_cv=cv,
        timing_d=(seen[1] - seen[0]).mean(axis=1) / np.sqrt((cv**2).mean(axis=0)),
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
        of, names, kinds = schedule_of or {}, list(bench.stiffness_mpa), len(bench.steps)
        steps = [own[of.get(name, name)] for own in bench.steps.values() for name in names]
        self._runs = []
        for times, drive, schedules in ((1, replace(bench.drive, springs=None), ()), (kinds, bench.drive, steps)):
            paths = simulate_presses(
                contacts * times, bodies * times, drive, schedules, f_max_n=bench.window_n[1], step_s=STEP_S
            )
            areas = [bench.area_mm2(name, n) for name, n in zip(names * times, paths.convolved_n.T, strict=True)]
            self._runs.append(replace(paths, area_mm2=np.stack(areas, axis=1)))

    def durations(self) -> Floats:
        """(K, C) seconds from the lower to the higher force of the window."""
        return self._table([run.duration_s(*self._bench.window_n) for run in self._runs])

    def rates(self) -> Floats:
        """(K, C) spread rates."""
        return self._table([run.rate_mm2_per_n(*self._bench.window_n) for run in self._runs])

    def frame_sums(self) -> Floats:
        """(K, C) mean of equation (2) as printed over presses that begin at other times between two frames."""
        firsts = (np.arange(_PHASES) + 0.5) / _PHASES / self._bench.rate_hz
        rng, no_errors = np.random.default_rng(_SEED), FrameErrors()
        sums = [
            [self._frame_sum(*self._frames(run, p, firsts, no_errors, rng)) for p in range(_presses(run))]
            for run in self._runs
        ]
        return self._table([np.array(each) for each in sums])

    def seen_rates(self, specimens: int, errors: FrameErrors) -> Floats:
        """(specimens, C, draws) spread rates of the first ones by the power law, as frames with errors give them."""
        rng, found = np.random.default_rng(_SEED), []
        for run in self._runs:
            for p in range(_presses(run)):
                if p % self._count < specimens:
                    firsts = rng.uniform(0, 1 / self._bench.rate_hz, _DRAWS)
                    force_n, area_mm2 = self._frames(run, p, firsts, errors, rng)
                    found.append(fit_power_laws(area_mm2, force_n).mean_rates(*self._bench.window_n))
        return np.array(found).reshape(-1, specimens, _DRAWS).swapaxes(0, 1)

    def _frames(
        self, run: PressPaths, press: int, firsts: Floats, errors: FrameErrors, rng: np.random.Generator
    ) -> tuple[Floats, Floats]:
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


def frames_of(
    paths: PressPaths,
    press: int,
    first_s: Floats,
    errors: FrameErrors,
    rng: np.random.Generator,
    *,
    rate_hz: float = 20.0,
    window_n: tuple[float, float] = (0.5, 7.0),
) -> tuple[Floats, Floats]:
    """(D, T) forces and areas of the frames of a press seen D times; NaN where the force is outside the window.

    The first frame of each comes ``first_s`` (D,) after contact. A frame shows the contact as it was before its time
    stamp by the delay.
    """
    known = np.isfinite(paths.force_n[:, press])
    time_s, force, area = paths.time_s[known], paths.force_n[known, press], paths.area_mm2[known, press]
    stamps_s = first_s[:, None] + np.arange(math.ceil(time_s[-1] * rate_hz)) / rate_hz
    late_s = rng.normal(0, errors.latency_sd_s, (first_s.size, 1))
    late_s = late_s + rng.normal(0, errors.jitter_s, stamps_s.shape)
    forces = np.interp(stamps_s, time_s, force) + rng.normal(0, errors.force_n, stamps_s.shape)
    areas = np.interp(stamps_s - late_s, time_s, area) * (1 + rng.normal(0, errors.area_share, stamps_s.shape))
    seen = (stamps_s <= time_s[-1]) & (forces >= window_n[0]) & (forces <= window_n[1]) & (areas > 0)
    return np.where(seen, forces, np.nan), np.where(seen, areas, np.nan)
