"""Do intervals of kappa over a range of force and of contact hold the truth, and are presses that cannot say told?

``python -m benchmarks.plate_force_range [--trials 400] [--phantoms DIR] | python -m benchmarks.bench.record
plate_force_range``: some two minutes of one process. ``--phantoms``: compressions of real silicone.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.force_range import RangeFit, fit_range
from emg2vsa.curves.plate import fit_plate
from emg2vsa.readers.press_table import PressTable, read_press_table

RANGE_N = (0.5, 7.0)
Law = Callable[[Floats], Floats]
Press = tuple[Floats, Floats]


def line(kappa: float) -> Law:
    return lambda depth: kappa * np.maximum(depth, 0)


def rubber(modulus_kpa: float, height_mm: float = 30, diameter_mm: float = 50) -> Law:
    """Neo-Hookean cylinder between frictionless plates: F = E A / 3 (1 / s^2 - s), s = 1 - depth / height."""

    def force(depth: Floats) -> Floats:
        stretch = 1 - np.clip(depth, 0, 0.8 * height_mm) / height_mm
        return np.asarray(modulus_kpa * 1e-3 * np.pi / 4 * diameter_mm**2 / 3 * (stretch**-2 - stretch))

    return force


def closing(law: Law, mm: float = 0.12) -> Law:
    """The plate lies flat after about ``mm``, and the force rises at a fifth of the slope at first."""
    return lambda depth: law(np.maximum(depth, 0) - 0.8 * mm * (1 - np.exp(-np.maximum(depth, 0) / mm)))


def bowl(stiffness: float) -> Law:
    """A round probe: F = c depth^1.5."""
    return lambda depth: stiffness * np.maximum(depth, 0) ** 1.5


def press(
    law: Law, noise_n: float, seed: int, *, rest_mm: float = 1.0, step_mm: float = 0.0167, follows: float = 0.0
) -> tuple[Floats, Floats, float]:
    """Depth and force up to some 8 N, and where the plate touches. follows : correlation of neighbours' noise."""
    rng = np.random.default_rng(seed)
    touch = rest_mm * rng.uniform(0.8, 1.2)
    deep = np.linspace(0, 20, 20001)
    x = np.arange(0, touch + np.interp(8, law(deep), deep), step_mm)
    noise = rng.standard_normal(x.size)
    for i in range(1, x.size if follows else 0):
        noise[i] = follows * noise[i - 1] + np.sqrt(1 - follows**2) * noise[i]
    return x, law(x - touch) + noise_n * noise, float(touch)


def truth(law: Law, force_n: Floats) -> tuple[float, Floats]:
    """Secant between the ends of ``force_n`` and tangent at each, by finite differences of the law itself."""
    deep, h = np.linspace(0, 20, 2_000_001), 1e-3
    at = np.interp([force_n - h, force_n, force_n + h], law(deep), deep)
    return float((force_n[-1] - force_n[0]) / (at[1, -1] - at[1, 0])), 2 * h / (at[2] - at[0])


WORLDS: dict[str, Law] = {
    "line, 1.1 N/mm": line(1.1), "line, 7.6 N/mm": line(7.6), "rubber, 10 kPa": rubber(10),
    "rubber, 30 kPa": rubber(30), "rubber, 60 kPa": rubber(60), "rubber, 107 kPa": rubber(107),
    "closing, rubber, 30 kPa": closing(rubber(30)), "closing, rubber, 107 kPa": closing(rubber(107)),
    "bowl, 2 N/mm^1.5": bowl(2.0),
}  # fmt: skip
CONDITIONS = ((0.005, 1.0, 0.0), (0.02, 0.0, 0.0), (0.02, 1.0, 0.0), (0.02, 1.0, 0.8), (0.1, 1.0, 0.0))
"""Noise (N), rest before contact (mm), and correlation of neighbours' noise."""


def coverage(trials: int) -> Iterator[str]:
    head = "world | noise (N) | rest (mm) | correlation | line's kappa | secant | tangent at .5 N | at 7 N | contact"
    yield f"| {head} | contact's width (mm) | true change (%) | named nonlinear (%) | height stated (%) | good (%) |"
    yield "|---|" + "---:|" * 13
    for name, law in WORLDS.items():
        for noise_n, rest_mm, follows in CONDITIONS:
            made = [press(law, noise_n, seed, rest_mm=rest_mm, follows=follows) for seed in range(trials)]
            fits = [fit_range(x, force, RANGE_N, 30) for x, force, _ in made]
            nonlinear = [(replace(fit, of_rubber=np.nan).nonlinear, fit.nonlinear) for fit in fits]
            before = fit_plate([(x[force < 7], force[force < 7]) for x, force, _ in made])
            secant, tangent = truth(law, np.linspace(*RANGE_N, 9))
            held = [
                (
                    abs(before.kappa[i] - secant) <= 1.96 * before.kappa_se[i],
                    abs(fit.secant - secant) <= fit.half_width(fit.secant_se),
                    *(abs(fit.tangent[j] - tangent[j]) <= fit.half_width(fit.tangent_se[j]) for j in (0, -1)),
                    fit.contact_low <= made[i][2] <= fit.contact_high,
                )
                for i, fit in enumerate(fits)
            ]
            width = np.median([fit.contact_high - fit.contact_low for fit in fits])
            cells = [f"{noise_n:g}", f"{rest_mm:g}", f"{follows:g}", *(f"{each:.3f}" for each in np.mean(held, axis=0))]
            cells += [f"{width:.3f}", f"{100 * (tangent[-1] - tangent[0]) / secant:.0f}"]
            cells += [f"{100 * share:.0f}" for share in np.mean(nonlinear, axis=0)]
            cells += [f"{100 * np.mean([fit.rating == 'good' for fit in fits]):.0f}"]
            yield f"| {name} | {' | '.join(cells)} |"


def with_rest(x: Floats, force: Floats, drift: float = 0.0) -> Press:
    """2 mm of rest before the press, with the noise of its beginning; drift : a share of kappa."""
    noise = np.std(np.diff(force[:20], 2)) / np.sqrt(6)
    before = np.arange(0, 2, 0.0167)
    depth = np.r_[before, x - x[0] + 2]
    slope = drift * RANGE_N[1] / x[int(np.argmax(force > RANGE_N[1]))]
    rest = noise * np.random.default_rng(1).standard_normal(before.size)
    return depth, np.r_[rest, force] + slope * depth


KINDS: dict[str, Callable[[Floats, Floats], Press]] = {
    "as measured": lambda x, f: (x, f),
    "with 2 mm of rest": with_rest,
    "with rest, 3 N of offset": lambda x, f: (with_rest(x, f)[0], with_rest(x, f)[1] + 3),
    "loading and unloading": lambda x, f: (np.r_[x, x[::-1]], np.r_[f, 0.9 * f[::-1]]),
    "both signs turned": lambda x, f: (-x, -f),
    "a gap from 2 to 4 N": lambda x, f: (np.where((f > 2) & (f < 4), np.nan, x), f),
    "drift of 5 % of kappa": lambda x, f: with_rest(x, f, 0.05),
    "drift of 20 % of kappa": lambda x, f: with_rest(x, f, 0.2),
    "force turned": lambda x, f: (x, -f),
    "depth turned": lambda x, f: (-x, f),
    "begins at 0.3 N": lambda x, f: (x[f > 0.3], f[f > 0.3]),
    "begins at 2 N": lambda x, f: (x[f > 2], f[f > 2]),
    "begins at 2 N, set to zero there": lambda x, f: (x[f > 2], f[f > 2] - f[f > 2][0]),
    "ends at 0.6 N": lambda x, f: (x[: int(np.argmax(f > 0.6))], f[: int(np.argmax(f > 0.6))]),
    "unloading alone": lambda x, f: (x[::-1], f[::-1]),
    "slips by 1.5 N at 3 N": lambda x, f: (x, f - 1.5 * (f > 3)),
    "noise alone": lambda x, f: (x, 0.02 * np.random.default_rng(1).standard_normal(x.size)),
    "constant": lambda x, f: (x, np.full(x.size, 2.0)),
}


def judged(tables: dict[str, PressTable]) -> Iterator[str]:
    yield "| curves | named nonlinear | good | doubtful | unusable | secant off by, median (%) | most (%) |"
    yield "|---|" + "---:|" * 6
    alone = {name: fit_range(each.depth_mm, each.force_n, RANGE_N) for name, each in tables.items()}
    for kind, change in KINDS.items():
        fits = {
            name: fit_range(*change(each.depth_mm, each.force_n), RANGE_N, each.height_mm)
            for name, each in tables.items()
        }
        ratings = Counter(fit.rating for fit in fits.values())
        off = [100 * (fit.secant / alone[name].secant - 1) for name, fit in fits.items() if fit.rating != "unusable"]
        cells = [str(sum(fit.nonlinear for fit in fits.values()))]
        cells += [str(ratings[each]) for each in ("good", "doubtful", "unusable")]
        cells += [f"{np.median(off):.1f}", f"{np.max(np.abs(off)):.1f}"] if off else ["", ""]
        yield f"| {kind} | {' | '.join(cells)} |"


def of_mixtures(fits: dict[str, RangeFit]) -> Iterator[str]:
    head = "mixture | secant (N/mm) | SD of repeats (%) | error within a press (%) | tangent at .5 N | at 3.75 N"
    yield f"| {head} | at 7 N | course of the press (%) | of rubber (%) | named nonlinear |"
    yield "|---|" + "---:|" * 9
    for mixture in dict.fromkeys(name[:-1] for name in fits):
        own = [fit for name, fit in fits.items() if name[:-1] == mixture]
        secant = np.array([fit.secant for fit in own])
        within = np.sqrt(np.mean([fit.secant_se**2 for fit in own]))
        tangent = np.mean([fit.tangent[[0, 4, 8]] for fit in own], axis=0)
        cells = [f"{secant.mean():.3f}", f"{100 * secant.std(ddof=1) / secant.mean():.2f}"]
        cells += [f"{100 * within / secant.mean():.2f}", *(f"{each:.3f}" for each in tangent)]
        cells += [f"{100 * np.mean([getattr(fit, key) for fit in own]):.0f}" for key in ("change", "of_rubber")]
        yield f"| {mixture} | {' | '.join(cells)} | {sum(fit.nonlinear for fit in own)} of {len(own)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=400)
    parser.add_argument("--phantoms", type=Path)
    given = parser.parse_args()
    print("# Kappa over a range of force\n")
    print(
        f"Coverage of 95 % intervals from 0.5 to 7 N, {given.trials} presses each; the line's kappa is Hooke's law as"
    )
    print("in the paper with its standard error, held against the same secant. Nonlinear: by the press alone, and")
    print("with its height of 30 mm stated.\n")
    print("\n".join(coverage(given.trials)))
    if given.phantoms:
        tables = {path.stem: read_press_table(path) for path in sorted(given.phantoms.glob("*/*.csv"))}
        print(f"\nReal silicone, {len(tables)} compressions (Dawood et al. 2026, CC BY 4.0), 0.5 to 7 N:\n")
        fits = {name: fit_range(each.depth_mm, each.force_n, RANGE_N, each.height_mm) for name, each in tables.items()}
        print("\n".join(of_mixtures(fits)))
        print("\nThe same curves spoilt:\n")
        print("\n".join(judged(tables)))


if __name__ == "__main__":
    main()
