"""How often the 95 % intervals of mean slopes, profiles and schedules hold the truth, world by world.

``python -m benchmarks.interval_coverage [STUDIES]``, kept by ``benchmarks.bench.record``: some minutes. The truth is
that of the demo study: five specimens, of which three are exported and one is interpolated. Presses scatter by 12 % in
a and 15 % in b of their specimen; people by 25 % in their level and by 10 % from specimen to specimen.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.force_bins import bin_edges
from emg2vsa.fits import Fits
from emg2vsa.profiles import Profile, build_profiles, mean_errors
from emg2vsa.schedules.build import build_schedules, mean_over_steps, stiffness_percent
from emg2vsa.settings import ProfileSettings, ScheduleSettings, WindowSettings

STIFFNESS = {"S1": 7.63, "S2": 5.32, "S3": 3.35, "S4": 3.12, "S5": 1.11}
A_B = np.array([[42.0, 20.0], [36.0, 17.0], [28.0, 13.0], [27.0, 12.5], [16.0, 7.0]])
ALIKE = np.stack([5 + 0.45 * A_B[:, 1], A_B[:, 1]], axis=1)
"""All specimens have the same activity in the lowest step of force, so that each may be the end of the mapping."""
SCHEDULES, WINDOW = ScheduleSettings(conditions=("modular", "constant-max")), WindowSettings()
PROFILE = ProfileSettings(
    grid_points=20, specimens=("S1", "S3", "S5"), new_specimen="S_new", new_stiffness_n_per_mm=5.32
)
PRESS_SD, LEVEL_SD, CELL_SD = np.array([0.12, 0.15]), 0.25, 0.10
_LOG_SD = 0.5
Law = Literal["normal", "t3", "lognormal"]


@dataclass(frozen=True)
class World:
    """How presses or people scatter. factor : on the scatter of S1 to S5. a_with_b : their correlation. rho, level_rho
    : of successive presses, in a and b, or in a alone."""

    name: str
    law: Law = "normal"
    factor: tuple[float, ...] = (1, 1, 1, 1, 1)
    a_with_b: float = 0.0
    rho: float = 0.0
    level_rho: float = 0.0
    truth: tuple[tuple[float, float], ...] = tuple(map(tuple, A_B.tolist()))


UNEQUAL = (3.0, 1.0, 1.0, 1.0, 0.3)
ALL = (
    World("as assumed"),
    World("heavy tails (t, 3 df)", "t3"),
    World("skewed (lognormal, skewness 1.75)", "lognormal"),
    World("S1 scatters 3 times, S5 0.3 times", factor=UNEQUAL),
    World("a and b correlate by .8", a_with_b=0.8),
    World("a and b correlate by -.8", a_with_b=-0.8),
    World("all specimens alike at the lowest force", truth=tuple(map(tuple, ALIKE.tolist()))),
)
SERIAL = (
    World("successive presses correlate by .5", rho=0.5),
    World("the same, in a alone", level_rho=0.5),
    World("the same, in both, and S1 and S5 as above", rho=0.5, factor=UNEQUAL),
)


def standard(rng: np.random.Generator, law: Law, shape: tuple[int, ...]) -> Floats:
    """Draws of mean 0 and variance 1."""
    if law == "t3":
        return rng.standard_t(3, shape) / np.sqrt(3)
    if law == "lognormal":
        mean, growth = np.exp(_LOG_SD**2 / 2), np.exp(_LOG_SD**2)
        return (np.exp(_LOG_SD * rng.standard_normal(shape)) - mean) / (mean * np.sqrt(growth - 1))
    return rng.standard_normal(shape)


def presses(world: World, people: int, n: int, rng: np.random.Generator) -> Floats:
    """a and b (P, 5, n, 2) of presses; of one person the truth is the person's own."""
    z = standard(rng, world.law, (people, 5, n, 2))
    for place, rho in enumerate((world.rho or world.level_rho, world.rho)):
        for later in range(1, n) if rho else ():
            z[..., later, place] = rho * z[..., later - 1, place] + np.sqrt(1 - rho**2) * z[..., later, place]
    z[..., 1] = world.a_with_b * z[..., 0] + np.sqrt(1 - world.a_with_b**2) * z[..., 1]
    truth, factor = np.array(world.truth), np.array(world.factor)[:, None]
    scatter = (PRESS_SD * factor)[:, None] * z
    level = np.zeros((1, 1, 1))
    if people > 1:
        level = LEVEL_SD * standard(rng, world.law, (people, 1, 1)) + CELL_SD * factor * standard(
            rng, world.law, (people, 5, 2)
        )
    return np.asarray(truth[:, None] * (1 + level[..., None, :] + scatter))


def fits_of(values: Floats) -> Fits:
    """Fits with what profiles use of them."""
    p, s, n, _ = values.shape
    who, what, which = (each.ravel() for each in np.indices((p, s, n)))
    blank, size = np.full(who.size, np.nan), who.size
    return Fits(
        participant=np.char.add("P", who.astype(str)),
        specimen=np.char.add("S", (what + 1).astype(str)), repetition=which + 1, verdict=np.full(size, "ok"),
        visit=np.full(size, ""),
        reason=np.full(size, ""), start_s=blank, a_v=values[..., 0].ravel(), b_v=values[..., 1].ravel(), a_se_v=blank,
        b_se_v=blank, b_lo_v=blank, b_hi_v=blank, n_points=np.full(size, 22), adj_r2=blank, r2_bins=blank,
        adj_r2_bins=blank, r2_samples=blank, adj_r2_samples=blank, n_effective=blank, lag1=blank, b_bias=blank,
        b_bias_se=blank, b_corrected=blank, cause=np.full(size, ""), v_min_v=blank,
        v_max_v=blank, bin_edges_n=np.array([0.5, 7.0]), bin_force_n=np.empty((size, 0)), bin_v=np.empty((size, 0)),
        activity_unit="V", points="bins", weights="none", confidence=0.95,
    )  # fmt: skip


def true_percent(truth: Floats, new: Profile) -> Floats:
    """Stiffness (8, K) of S1, S3, S5 and S_new: modular, then constant at the maximum."""
    edges = bin_edges(*WINDOW.force_n, SCHEDULES.step_n)
    v = np.array([mean_over_steps(a, b, edges) for a, b in (*truth[[0, 2, 4]], (new.a_v, new.b_v))])
    v = np.concatenate([v, np.broadcast_to(v.max(axis=1, keepdims=True), v.shape)])
    return stiffness_percent(v, (float(v.min()), float(v.max())), SCHEDULES.stiffness_percent)


def covered(world: World, people: int, n: int, studies: int) -> list[str]:
    """Cells of the table: coverage of mean b, the band of S_new, and schedules, with the half-width of these."""
    truth, unit = np.array(world.truth), cast("Literal['press', 'person']", "person" if people > 1 else "press")
    exact = build_profiles(fits_of(truth[None, :, None]), STIFFNESS, PROFILE, WINDOW, "ok").new
    assert exact is not None
    percent, of_b = true_percent(truth, exact), np.zeros((5, 5, 2))
    of_b[range(5), range(5), 1] = 1
    slopes, bands, steps, widths = [], [], [], []
    for seed in range(studies):
        fits = fits_of(presses(world, people, n, np.random.default_rng((people, n, seed))))
        profiles = build_profiles(fits, STIFFNESS, PROFILE, WINDOW, "ok")
        assert profiles.new is not None
        errors = mean_errors(fits, np.ones(fits.b_v.size, dtype=np.bool_), [*STIFFNESS], unit)
        mean_b = fits.b_v.reshape(people, 5, n).mean(axis=(0, 2))
        slopes.append(np.abs(mean_b - truth[:, 1]) <= errors.half_width(of_b))
        bands.append(np.abs(profiles.new.v - exact.v) <= profiles.half_width_v(profiles.new))
        made = sorted(build_schedules(profiles, SCHEDULES, {}), key=lambda s: s.condition, reverse=True)
        low, high = np.moveaxis(np.array([s.interval_percent for s in made]), 1, 0)
        steps.append((low - 1e-9 <= percent) & (percent <= high + 1e-9))
        widths.append(np.mean(high - low) / 2)
    ends = np.isin(percent, SCHEDULES.stiffness_percent)
    every = [np.mean(each, axis=0) for each in (slopes, bands, np.array(steps)[:, ~ends])]
    return [*(f"{100 * each.mean():.1f} ({100 * each.min():.0f})" for each in every), f"{np.median(widths):.1f}"]


def main(studies: int) -> Iterable[str]:
    """The page."""
    yield "# Coverage of the intervals of mean slopes, profiles and schedules\n"
    known = 196 * np.sqrt(0.95 * 0.05 / studies)
    yield (
        f"{studies} studies a row, so that 95 % is known within {known:.1f} points. Of each interval: mean coverage of "
        "95 % intervals in percent, and that of the worst specimen, force or step. Steps that are the ends of the "
        "mapping by definition do not count. Half-width: of the schedules, in points of stiffness, mean over steps, "
        "median over studies.\n"
    )
    yield "| World | People | Presses | Mean b | Profile of S_new | Schedules | Half-width |"
    yield "|---|---:|---:|---:|---:|---:|---:|"
    for people, n, worlds in ((1, 5, ALL + SERIAL), (1, 10, ALL + SERIAL), (5, 10, ALL), (14, 10, ALL)):
        for world in worlds:
            yield f"| {world.name} | {people} | {n} | {' | '.join(covered(world, people, n, studies))} |"


if __name__ == "__main__":
    for line in main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000):
        print(line, flush=True)
