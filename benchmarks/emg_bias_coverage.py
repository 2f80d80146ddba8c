"""Bias of b, its spread and the coverage of its 95 % interval, condition by condition, on simulated sessions.

``python -m benchmarks.emg_bias_coverage [SESSIONS]``, kept by ``benchmarks.bench.record``: two processes, some
minutes. Before: the rest level and the hum stay in the envelope. After: the defaults; ``lag``: with align = "lag";
``told``: with the share of crosstalk in the study file.
The disturbed conditions use the seeds of the clean one, so that the noise of the carrier is the same in all: what a
disturbance adds is known far better than the bias itself, and stands in a column of its own.
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import signal

from benchmarks.laboratory import Laboratory, simulate_session
from emg2vsa.arrays import Floats
from emg2vsa.curves.force_bins import bin_edges
from emg2vsa.curves.press_fits import fit_presses
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import Fits, fit_trials, usable
from emg2vsa.recordings import Channel
from emg2vsa.settings import (
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    HypothesisSettings,
    WindowSettings,
)

CLEAN = Laboratory()
BEFORE = FilterSettings(mains="keep", rest_level="keep")
AFTER = FilterSettings()
ALIGNED = replace(AFTER, align="lag")
WINDOW = WindowSettings()

CONDITIONS: dict[str, tuple[Laboratory, tuple[str, ...]]] = {
    "clean (Shwedyk 60/120)": (CLEAN, ("before", "after", "lag")),
    "carrier 40/80 Hz": (replace(CLEAN, carrier="40/80"), ("after",)),
    "carrier 90/180 Hz": (replace(CLEAN, carrier="90/180"), ("after",)),
    "carrier 20/45 Hz": (replace(CLEAN, carrier="20/45"), ("after",)),
    "Laplacian carrier": (replace(CLEAN, carrier="laplacian"), ("after",)),
    "60 motor units": (replace(CLEAN, carrier="units-60"), ("after",)),
    "15 motor units": (replace(CLEAN, carrier="units-15"), ("after",)),
    "6 motor units": (replace(CLEAN, carrier="units-6"), ("after",)),
    "ramp 0.7 s": (replace(CLEAN, ramp_s=0.7), ("after",)),
    "ramp 8 s": (replace(CLEAN, ramp_s=8.0), ("after",)),
    "exponential ramp": (replace(CLEAN, ramp="exponential"), ("after",)),
    "saturating ramp": (replace(CLEAN, ramp="saturating"), ("after",)),
    "plateaus": (replace(CLEAN, ramp="plateaus"), ("after",)),
    "stairs": (replace(CLEAN, ramp="stairs"), ("after",)),
    "sawtooth 2 Hz": (replace(CLEAN, ramp="sawtooth"), ("after",)),
    "tremor 4 % at 8 Hz": (replace(CLEAN, ramp="tremor"), ("after",)),
    "rest tone 0.2 of v(0.3 N)": (replace(CLEAN, tone_share=0.2), ("before", "after")),
    "noise 3 uV": (replace(CLEAN, noise_v=3e-6), ("before", "after")),
    "noise 5 uV": (replace(CLEAN, noise_v=5e-6), ("before", "after")),
    "noise 10 uV": (replace(CLEAN, noise_v=10e-6), ("before", "after")),
    "hum 5 uV, 50 Hz": (replace(CLEAN, hum_v=5e-6), ("before", "after")),
    "hum 5 uV, 60 Hz, 3 harmonics": (
        replace(CLEAN, hum_v=5e-6, hum_hz=60.0, hum_harmonics=(1.0, 0.5, 0.5)),
        ("before", "after"),
    ),
    "hum 10 uV, wander 0.05 Hz": (replace(CLEAN, hum_v=10e-6, hum_wander_hz=0.05), ("before", "after")),
    "hum 10 uV, 3 harmonics": (replace(CLEAN, hum_v=10e-6, hum_harmonics=(1.0, 0.5, 0.5)), ("before", "after")),
    "delay 60 ms": (replace(CLEAN, delay_s=0.06), ("before", "after", "lag")),
    "clocks 0.5 s apart": (replace(CLEAN, delay_s=0.5), ("after", "lag")),
    "clocks -0.2 s apart": (replace(CLEAN, delay_s=-0.2), ("after", "lag")),
    "force noise 0.1 N": (replace(CLEAN, force_noise_n=0.1), ("after",)),
    "drift 3 N/min": (replace(CLEAN, drift_n_per_min=3.0), ("after",)),
    "drift -3 N/min": (replace(CLEAN, drift_n_per_min=-3.0), ("after",)),
    "wander 0.3 N / 20 s": (replace(CLEAN, wander_n=0.3), ("after",)),
    "step +0.4 N": (replace(CLEAN, step_n=0.4), ("after",)),
    "artefact 50 uV": (replace(CLEAN, artefact_v=50e-6), ("after",)),
    "artefact 150 uV": (replace(CLEAN, artefact_v=150e-6), ("after",)),
    "artefact 150 uV, 200 ms": (replace(CLEAN, artefact_v=150e-6, artefact_s=0.2), ("after",)),
    "artefact 50 uV, carrier 20/45 Hz": (replace(CLEAN, artefact_v=50e-6, carrier="20/45"), ("after",)),
    "touch hum 5 uV": (replace(CLEAN, touch_hum_v=5e-6), ("after",)),
    "touch hum 10 uV": (replace(CLEAN, touch_hum_v=10e-6), ("after",)),
    "touch hum 20 uV": (replace(CLEAN, touch_hum_v=20e-6), ("after",)),
    "touch hum 20 uV, 60 Hz, 3 harmonics": (
        replace(CLEAN, touch_hum_v=20e-6, hum_hz=60.0, hum_harmonics=(1.0, 0.5, 0.5)),
        ("after",),
    ),
    "touch hum 40 uV": (replace(CLEAN, touch_hum_v=40e-6), ("after",)),
    "electrode fades to 0.5": (replace(CLEAN, fade=0.5), ("after",)),
    "packets lost 1 %": (replace(CLEAN, lost_share=0.01), ("after",)),
    "packets lost 2 %": (replace(CLEAN, lost_share=0.02), ("after",)),
    "crosstalk 0.3": (replace(CLEAN, crosstalk=0.3), ("after", "told")),
    "level wanders 20 %, 0.2 s": (replace(CLEAN, level_sd=0.2, level_s=0.2), ("after",)),
    "level wanders 20 %, 2 s": (replace(CLEAN, level_sd=0.2, level_s=2.0), ("after",)),
    "EMG 1925.93 Hz, force 148.15 Hz": (replace(CLEAN, fs_hz=1925.93, force_fs_hz=148.15), ("after",)),
}
CHAINS = {"before": BEFORE, "after": AFTER, "lag": ALIGNED, "told": AFTER}
TOLD = CocontractionSettings(crosstalk={"M0": {"M1": 0.3}})


class Outcome(NamedTuple):
    """Of all presses of some sessions: b over the truth (k,), its interval's cover, use, ok, and what was predicted."""

    ratio: Floats
    covers: Floats
    used: Floats
    ok: Floats
    predicted: Floats
    lag_ms: Floats


def fitted(laboratory: Laboratory, chain: str, seed: int) -> tuple[Trials, Fits]:
    """One session through the chain."""
    session = simulate_session(laboratory, seed)
    emg = {f"M{i}": _channel(row, "V", laboratory.fs_hz) for i, row in enumerate(session.emg_v)}
    trials = extract_trials(
        emg, _channel(session.force_n, "N", laboratory.force_fs_hz), participant="P", specimen="S",
        filters=CHAINS[chain], cocontraction=TOLD if chain == "told" else CocontractionSettings(), window=WINDOW,
        force_channel=ForceChannelSettings(name="Fz"),
    )  # fmt: skip
    return trials, fit_trials(trials, FitSettings(), WINDOW)


def analyse(laboratory: Laboratory, chain: str, seed: int) -> Outcome:
    """What is said of one session."""
    trials, fits = fitted(laboratory, chain, seed)
    return Outcome(
        fits.b_v / laboratory.b_v, ((fits.b_lo_v <= laboratory.b_v) & (fits.b_hi_v >= laboratory.b_v)).astype(float),
        usable(fits, HypothesisSettings().use).astype(float), (fits.verdict == "ok").astype(float), fits.b_bias,
        np.array([1e3 * trials.lag_s]),
    )  # fmt: skip


def _channel(samples: Floats, unit: str, fs_hz: float) -> Channel:
    return Channel(unit, samples, unit, fs_hz, 0.0, "simulated")


def condition(name: str, sessions: int) -> dict[str, Outcome]:
    """All chains of one condition; each array of all its sessions."""
    laboratory, chains = CONDITIONS[name]
    joined = {}
    for chain in chains:
        parts = [analyse(laboratory, chain, seed) for seed in range(sessions)]
        joined[chain] = Outcome(*map(np.concatenate, zip(*parts, strict=True)))
    return joined


def slow_noise(rho: float, presses: int = 1200, n: int = 1000) -> tuple[float, float]:
    """Coverage of the interval in percent, and mean standard error over spread of b, for multiplicative AR(1) noise."""
    rng = np.random.default_rng(5)
    force_n = np.linspace(0.5, 7, n)
    white = rng.standard_normal((presses, n + 4000))
    noise = signal.lfilter([np.sqrt(1 - rho**2)], [1, -rho], white, axis=1)[:, 4000:]
    v = (30 + 15 * np.log(force_n)) * (1 + 0.3 * noise)
    edges = bin_edges(0.5, 7, 0.3)
    fit = fit_presses(np.tile(force_n, presses), v.ravel(), n * np.arange(presses + 1), edges, FitSettings()).reported
    covers = (fit.b_lo <= 15) & (fit.b_hi >= 15)
    return 100 * float(covers.mean()), float(fit.b_se.mean() / fit.b.std())


def main() -> None:
    sessions = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    with ProcessPoolExecutor(2) as pool:
        outcomes = dict(zip(CONDITIONS, pool.map(condition, CONDITIONS, [sessions] * len(CONDITIONS)), strict=True))
    clean = outcomes["clean (Shwedyk 60/120)"]["before"].ratio.mean()
    print("# Bias of b and coverage of its interval\n")
    print("`python -m benchmarks.emg_bias_coverage`: v = 30 + 15 ln F uV, shares 60/40, 10 presses of 2.5 s a session,")
    print(f"{sessions} sessions a row, the same seeds in all. Presses that enter the tests by default.")
    print("`to clean`: bias less that of the first row, whose own is the carriers' chance (same seeds, same carriers).")
    print("`predicted`: what the press itself says of the bias that was left in.\n")
    print(
        "| condition | chain | b bias % (se) | to clean % | SD % | coverage 95 % | predicted % | lag ms | used | ok |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name, chains in outcomes.items():
        for chain, found in chains.items():
            used = found.used > 0
            ratio = found.ratio[used]
            bias, se = 100 * (ratio.mean() - 1), 100 * ratio.std() / np.sqrt(ratio.size)
            cells = (
                name, chain, f"{bias:+.1f} ({se:.1f})", f"{100 * (ratio.mean() - clean):+.1f}",
                f"{100 * ratio.std():.1f}",
                f"{100 * found.covers[used].mean():.1f}", f"{100 * np.nanmean(found.predicted[used]):+.1f}",
                f"{np.nanmean(found.lag_ms):.0f} ± {np.nanstd(found.lag_ms):.0f}",
                f"{int(used.sum())} of {used.size}", f"{int(found.ok.sum())}",
            )  # fmt: skip
            print(f"| {' | '.join(cells)} |")
    print("\n## Noise slow against the press\n")
    print("Multiplicative AR(1) noise of SD 0.3 on 1000 samples, 1200 presses, fit on bins.\n")
    print("| rho | coverage 95 % | standard error / SD |\n|---|---|---|")
    for rho in (0.0, 0.9, 0.98, 0.99, 0.995):
        cover, share = slow_noise(rho)
        print(f"| {rho:g} | {cover:.1f} | {share:.2f} |")


if __name__ == "__main__":
    main()
