"""700 logarithmic fits, clusters and analyses of variance: time and error beside the peers; coverage of the intervals.

    python -m benchmarks.fits

Times are processor time, best of interleaved repeats, one thread. Errors are digits against 50-digit arithmetic, the
worst number of a sample of fits.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Callable
from decimal import Decimal, localcontext
from typing import Any

import numpy as np
from scipy import signal, stats

from emg2vsa.curves.force_bins import bin_edges
from emg2vsa.curves.logarithmic import LogFit, fit_log
from emg2vsa.curves.press_fits import fit_presses
from emg2vsa.settings import FitSettings
from emg2vsa.stats.anova import one_way
from emg2vsa.stats.lsd import lsd
from emg2vsa.stats.normality import ks_normal

try:
    from statsmodels.api import OLS
except ImportError:
    OLS = None

A_V, B_V = 30e-6, 15e-6
N_FITS, N_POINTS = 700, 131
REPEATS = 7
CHECKED = range(0, N_FITS, 35)
REPORTED = {
    "bins, weighted (default)": FitSettings(),
    "bins, robust": FitSettings(robust=True),
    "bins, unweighted": FitSettings(weights="none"),
    "samples at 100 Hz": FitSettings(points="samples", weights="none"),
}
Run = Callable[[], Any]


def main() -> None:
    """Print the three tables."""
    log_fits()
    tests_of_b()
    coverage()


def best_times(runs: dict[str, Run]) -> dict[str, float]:
    """Smallest processor time of each run, repeats interleaved."""
    best = dict.fromkeys(runs, float("inf"))
    for _ in range(REPEATS):
        for name, run in runs.items():
            for _ in range(20 if best[name] < 0.02 else 1):
                start = time.process_time()
                run()
                best[name] = min(best[name], time.process_time() - start)
    return best


def log_fits() -> None:
    """Time and digits of 700 fits on 131 points."""
    rng = np.random.default_rng(1)
    grid = np.linspace(0.5, 7, N_POINTS)
    for title, force in (
        ("each fit on its own forces", np.sort(rng.uniform(0.5, 7, (N_FITS, N_POINTS)), axis=1)),
        ("all fits on one grid of forces", np.tile(grid, (N_FITS, 1))),
    ):
        v = A_V + B_V * np.log(force) + 5e-6 * rng.standard_normal(force.shape)
        common = force[0] if title.startswith("all") else None
        runs = log_fit_runs(force if common is None else grid, force, v, common)
        times = best_times(runs)
        print(f"\n{N_FITS} logarithmic fits of {N_POINTS} points, {title}")
        print(f"{'':42}{'ms':>9}{'ours is':>10}  digits of b, SE(b), R2")
        for name, run in runs.items():
            ratio = times[name] / times["emg2vsa fit_log"]
            print(f"{name:42}{1e3 * times[name]:9.2f}{ratio:9.1f}x  {digits(run(), force, v)}")


def log_fit_runs(own_force: np.ndarray, force: np.ndarray, v: np.ndarray, grid: np.ndarray | None) -> dict[str, Run]:
    def ours(**options: Any) -> dict[str, np.ndarray]:
        fit = fit_log(own_force, v, **options)
        return {"b": fit.b, "b_se": fit.b_se, "r2": fit.r2}

    def linregress() -> dict[str, np.ndarray]:
        fits = [stats.linregress(np.log(f), y) for f, y in zip(force, v, strict=True)]
        return columns([(fit.slope, fit.stderr, fit.rvalue**2) for fit in fits])

    def polyfit() -> dict[str, np.ndarray]:
        return {"b": np.array([np.polyfit(np.log(f), y, 1)[0] for f, y in zip(force, v, strict=True)])}

    runs: dict[str, Run] = {"emg2vsa fit_log": ours, "scipy linregress, loop": linregress, "np.polyfit, loop": polyfit}
    if grid is not None:
        runs["np.linalg.lstsq, one call (b and R2 only)"] = lambda: multi_lstsq(grid, v)
    if OLS is not None:
        runs["statsmodels OLS, loop"] = lambda: columns(
            [
                ols_row(OLS(y, np.column_stack([np.ones(N_POINTS), np.log(f)])).fit())
                for f, y in zip(force, v, strict=True)
            ]
        )
    return runs


def ols_row(fit: Any) -> tuple[float, float, float]:
    return fit.params[1], fit.bse[1], fit.rsquared


def columns(rows: list[tuple[float, float, float]]) -> dict[str, np.ndarray]:
    return dict(zip(("b", "b_se", "r2"), np.array(rows).T, strict=True))


def multi_lstsq(grid: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
    coefficients, residual, _, _ = np.linalg.lstsq(np.column_stack([np.ones(grid.size), np.log(grid)]), v.T, rcond=None)
    return {"b": coefficients[1], "r2": 1 - residual / np.sum((v - v.mean(axis=1, keepdims=True)) ** 2, axis=1)}


def digits(result: dict[str, np.ndarray], force: np.ndarray, v: np.ndarray) -> str:
    """Fewest correct digits of b, SE(b) and R2 over the checked fits, '-' where a peer does not give the number."""
    truths = [exact(force[i], v[i]) for i in CHECKED]
    shown = []
    for name in ("b", "b_se", "r2"):
        if name not in result:
            shown.append("   -")
            continue
        errors = [abs(Decimal(float(result[name][i])) / t[name] - 1) for i, t in zip(CHECKED, truths, strict=True)]
        shown.append(f"{-float(max(*errors, Decimal('1e-16')).log10()):4.1f}")
    return "  ".join(shown)


def exact(force: np.ndarray, v: np.ndarray) -> dict[str, Decimal]:
    """The same fit in 50-digit arithmetic."""
    with localcontext() as context:
        context.prec = 50
        x, y = [Decimal(float(f)).ln() for f in force], [Decimal(float(value)) for value in v]
        n, zero = len(x), Decimal(0)
        dx = [xi - sum(x, zero) / n for xi in x]
        dy = [yi - sum(y, zero) / n for yi in y]
        sxx, syy = sum((d * d for d in dx), zero), sum((d * d for d in dy), zero)
        b = sum((p * q for p, q in zip(dx, dy, strict=True)), zero) / sxx
        sse = sum(((q - b * p) ** 2 for p, q in zip(dx, dy, strict=True)), zero)
        return {"b": b, "b_se": (sse / (n - 2) / sxx).sqrt(), "r2": 1 - sse / syy}


def tests_of_b() -> None:
    """Time and difference of the tests of section IV.B."""
    b = np.random.default_rng(2).standard_normal((14, 5, 10)) + np.arange(5)[:, None] * 0.5
    rows = b.reshape(70, 10)
    z = (rows - rows.mean(axis=1, keepdims=True)) / rows.std(axis=1, ddof=1, keepdims=True)
    ks, anova = ks_normal(rows, standardise=True), one_way(b)
    runs: dict[str, Run] = {
        "emg2vsa, 70 KS of 10": lambda: ks_normal(rows, standardise=True),
        "scipy ks_1samp(axis)": lambda: stats.ks_1samp(z, stats.norm.cdf, axis=1),
        "scipy kstest, loop": lambda: [stats.kstest(x, "norm") for x in z],
        "emg2vsa, 14 ANOVA 5 x 10": lambda: one_way(b),
        "emg2vsa, 14 ANOVA 5 x 10 and 140 LSD pairs": lambda: lsd(one_way(b)),
        "scipy f_oneway(axis), no pairs": lambda: stats.f_oneway(*np.moveaxis(b, 1, 0), axis=1),
        "scipy f_oneway, loop, no pairs": lambda: [stats.f_oneway(*design) for design in b],
    }
    times = best_times(runs)
    print("\ntests of b")
    for name, seconds in times.items():
        print(f"{name:46}{1e3 * seconds:9.3f} ms")
    ks_gap = np.max(np.abs(ks.p - [stats.kstest(x, "norm").pvalue for x in z]))
    f_gap = np.max(np.abs(anova.p / [stats.f_oneway(*design).pvalue for design in b] - 1))
    print(f"largest difference to scipy: p of KS {ks_gap:.1e}, relative p of ANOVA {f_gap:.1e}")


def coverage(n_trials: int = 2000) -> None:
    """Nominal 95 % intervals of b on simulated envelopes, whose samples are correlated."""
    print(f"\ncoverage of nominal 95 % intervals of b, {n_trials} simulated presses")
    print("Monte-Carlo errors: coverage 0.5 %, bias 0.15 %, common to all rows of a ramp")
    print(f"{'envelope, ramp, points':58}{'covers':>8}{'bias':>8}{'SD':>7}{'mean SE':>9}   of b")
    for envelope, taps in (("20 Hz FIR", 1), ("20 Hz FIR forth and back", 2), ("RMS 100 ms", 0)):
        for ramp in ("even", "eased"):
            force, v = simulate(n_trials, taps, ramp)
            slow = force[:, ::10].ravel(), v[:, ::10].ravel(), np.arange(n_trials + 1) * force[:, ::10].shape[1]
            runs = {name: fit_presses(*slow, bin_edges(0.5, 7, 0.3), settings) for name, settings in REPORTED.items()}
            fits = {name: run.reported for name, run in runs.items()}
            fits["samples at 1000 Hz (paper)"] = fit_log(force, v)
            for points, fit in fits.items():
                print(f"{envelope + ', ' + ramp + ', ' + points:58}{coverage_row(fit)}")


def coverage_row(fit: LogFit) -> str:
    covers = np.mean((fit.b_lo < B_V) & (fit.b_hi > B_V))
    bias, sd, se = np.mean(fit.b) / B_V - 1, np.std(fit.b) / B_V, np.mean(fit.b_se) / B_V
    return f"{100 * covers:7.1f}%{100 * bias:+7.2f}%{100 * sd:6.1f}%{100 * se:8.1f}%"


def simulate(n: int, fir_passes: int, ramp: str, fs_hz: int = 1000) -> tuple[np.ndarray, np.ndarray]:
    """Force and co-contraction (n, 2500) of presses of 2.5 s: Gaussian carriers of two muscles, 60 to 40, no noise."""
    rng = np.random.default_rng(3)
    n_samples, edge = int(2.5 * fs_hz), fs_hz // 2
    u = np.arange(-edge, n_samples + edge) / (n_samples - 1)
    force = 0.5 + 6.5 * (u if ramp == "even" else 0.5 - 0.5 * np.cos(np.pi * np.clip(u, 0, 1)))
    level = A_V + B_V * np.log(np.maximum(force, 0.2))
    fir = signal.firwin(51, 20, fs=fs_hz)
    spectrum = signal.butter(2, (20, 150), "bandpass", fs=fs_hz, output="sos")
    v = np.zeros((n, level.size))
    for share in (0.4, 0.6):
        carrier = signal.sosfilt(spectrum, rng.standard_normal((n, level.size + fs_hz)), axis=1)[:, fs_hz:]
        emg = share * level * carrier / carrier.std()
        if fir_passes:
            taps = fir if fir_passes == 1 else np.convolve(fir, fir)
            v += np.sqrt(np.pi / 2) * signal.oaconvolve(np.abs(emg), taps[None], mode="same", axes=1)
        else:
            v += np.sqrt(signal.oaconvolve(emg**2, np.full((1, 101), 1 / 101), mode="same", axes=1))
    return np.tile(force[edge:-edge], (n, 1)), v[:, edge:-edge]


if __name__ == "__main__":
    main()
