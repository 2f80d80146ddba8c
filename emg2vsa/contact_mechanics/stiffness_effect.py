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
from emg2vsa.contact_mechanics.camera_frames import FrameErrors, frames_of
from emg2vsa.contact_mechanics.geometry import PowerLaw
from emg2vsa.contact_mechanics.press_path import Drive, PressPaths, StiffnessSteps, simulate_presses
from emg2vsa.contact_mechanics.relaxation import Relaxation, in_series, specimen_share
from emg2vsa.errors import DataError

STEP_S = 2e-3
_PHASES = 40
"Presses over which a sum over frames is averaged: each begins at another time between two frames."
_DRAWS = 400
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
    pressed = {material.name: _pressed(bench, material, bench.steps) for material in materials}
    elastic, creeping = pressed[materials[0].name], pressed[materials[1].name]
    mirror = dict(zip(names, reversed(names), strict=True))
    mirrored = {condition: {name: of[mirror[name]] for name in names} for condition, of in bench.steps.items()}
    swapped = _pressed(bench, materials[0], mirrored)
    rng = np.random.default_rng(_SEED)
    rates = [np.log(_seen_rates(creeping[name], bench, errors, rng)) for name in names[:2]]
    spread = np.array([each.std(axis=1, ddof=1) for each in rates])
    return StiffnessEffect(
        specimens=names,
        conditions=(rigid, *bench.steps),
        materials=tuple(pressed),
        pair=(names[0], names[1]),
        duration_s=_table(elastic, lambda each: each.duration_s(*bench.window_n)),
        slope=np.array([_table(of, lambda each: each.slope_mm2_per_n(*bench.window_n)) for of in pressed.values()]),
        frame_sum=_table(elastic, lambda each: _frame_sums(each, bench)),
        frame_sum_swapped=_table(swapped, lambda each: _frame_sums(each, bench)),
        slope_swapped=_table(swapped, lambda each: each.slope_mm2_per_n(*bench.window_n)),
        timing_cv=spread,
        specimen_share=np.array([specimen_share(each, bench.sensor_mpa) for each in bench.stiffness_mpa.values()]),
        area_power=np.array([_area_power(bench, name) for name in names]),
        timing_d=(rates[1].mean(axis=1) - rates[0].mean(axis=1)) / np.sqrt((spread**2).mean(axis=0)),
    )


def _area_power(bench: Bench, name: str) -> float:
    low, high = bench.area_mm2(name, np.array(bench.window_n))
    return float(np.log(high / low) / np.log(bench.window_n[1] / bench.window_n[0]))


def _pressed(
    bench: Bench, material: Material, steps: Mapping[str, Mapping[str, StiffnessSteps]]
) -> dict[str, list[PressPaths]]:
    found = {}
    for name, specimen_mpa in bench.stiffness_mpa.items():
        share = specimen_share(specimen_mpa, bench.sensor_mpa)
        body = in_series(
            [
                (share, Relaxation.of_share(material.specimens.get(name, 0.0))),
                (1 - share, Relaxation.of_share(material.sensor)),
            ]
        )
        contact = PowerLaw(1 / (1 / bench.sensor_mpa + 1 / specimen_mpa), bench.tip_radius_mm, bench.exponent)
        own = [of[name] for of in steps.values()]
        runs = [
            simulate_presses(
                [contact], body, replace(bench.drive, springs=None), f_max_n=bench.window_n[1], step_s=STEP_S
            )
        ]
        if own:
            runs.append(
                simulate_presses([contact] * len(own), body, bench.drive, own, f_max_n=bench.window_n[1], step_s=STEP_S)
            )
        found[name] = [
            replace(run, area_mm2=bench.area_mm2(name, run.convolved_n.ravel()).reshape(run.convolved_n.shape))
            for run in runs
        ]
    return found


def _table(pressed: Mapping[str, Sequence[PressPaths]], of: Callable[[PressPaths], Floats]) -> Floats:
    """(K, C)."""
    return np.array([np.concatenate([of(run) for run in runs]) for runs in pressed.values()])


def _frame_sums(paths: PressPaths, bench: Bench) -> Floats:
    """(P,) mean of equation (2) as printed over presses that begin at other times between two frames."""
    rng, firsts = np.random.default_rng(_SEED), (np.arange(_PHASES) + 0.5) / _PHASES / bench.rate_hz
    sums = [
        [_rate(paths, p, bench, first, FrameErrors(), rng, "paper") for first in firsts.tolist()]
        for p in range(paths.force_n.shape[1])
    ]
    return np.asarray(np.mean(sums, axis=1))


def _seen_rates(runs: Sequence[PressPaths], bench: Bench, errors: FrameErrors, rng: np.random.Generator) -> Floats:
    """(C, draws) spread rates by the power law, as a camera's frames give them."""
    return np.array(
        [
            [_rate(run, p, bench, rng.uniform(0, 1 / bench.rate_hz), errors, rng, "power") for _ in range(_DRAWS)]
            for run in runs
            for p in range(run.force_n.shape[1])
        ]
    )


def _rate(
    paths: PressPaths,
    press: int,
    bench: Bench,
    first_s: float,
    errors: FrameErrors,
    rng: np.random.Generator,
    rule: str,
) -> float:
    force_n, area_mm2 = frames_of(paths, press, first_s, errors, rng, rate_hz=bench.rate_hz, window_n=bench.window_n)
    return spread_rate(area_mm2, force_n, rule=rule, window_n=bench.window_n).value
