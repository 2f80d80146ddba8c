"""Bias and spread of b through the conditioning, on a signal whose b is known.

Sum of two muscles v = 30 + 15 ln F uV, shared 60:40; Gaussian carrier with a Stegeman-type spectrum through 20-450 Hz,
1.2 uV of noise in each channel; F rises linearly from 0.2 to 7.2 N in 2.5 s. Fit on 0.5 to 7 N.

The bias is far smaller than the spread, so the noise of the carrier itself is taken out (a control variate): b of the
clean rectified carriers, by a linear fit with the true weights, has exactly the true mean, and what it misses by in
these trials is what chance added to every chain.

``python -m benchmarks.slope_of_b [--trials 1500]``.
"""

from __future__ import annotations

import argparse

import numpy as np
from scipy import signal

from emg2vsa.arrays import Floats
from emg2vsa.curves.force_bins import bin_edges
from emg2vsa.curves.logarithmic import LogFit
from emg2vsa.curves.press_fits import fit_presses
from emg2vsa.settings import FilterSettings, FitSettings, WindowSettings
from emg2vsa.signals.delays import delay_budget
from emg2vsa.signals.envelope import decimation, envelopes_at, smoother
from emg2vsa.signals.filters import band_pass, force_low_pass
from emg2vsa.signals.pairing import Clock, force_at, instants_between
from emg2vsa.signals.windowed import filter_record

FS_HZ, DURATION_S, A_UV, B_UV = 1000.0, 2.5, 30.0, 15.0
SHARES, NOISE_UV = (0.6, 0.4), 1.2
MARGIN_S = 1.0
"The ramp's law continues so long before and after, so that the filters see no jump."

CHAINS: dict[str, tuple[FilterSettings, FitSettings]] = {
    "default (zero-phase, bins, 1/v^2)": (FilterSettings(), FitSettings()),
    "default, RMS envelope": (FilterSettings(envelope="rms"), FitSettings()),
    "default, Nyquist rule (10-500 Hz)": (FilterSettings(band_hz=(10.0, 500.0)), FitSettings()),
    "compensated, bins, 1/v^2": (FilterSettings(phase="compensated"), FitSettings()),
    "zero-phase, bins, unweighted": (FilterSettings(), FitSettings(weights="none")),
    "causal, bins, 1/v^2": (FilterSettings(phase="causal"), FitSettings()),
    "paper (causal, samples, unweighted)": (
        FilterSettings(band_hz=(10.0, 500.0), phase="causal", output_fs_hz="native"),
        FitSettings(points="samples", weights="none"),
    ),
}


def carrier(rng: np.random.Generator, n: int) -> Floats:
    """Gaussian noise of unit mean rectified value: Stegeman spectrum (60, 120 Hz), Butterworth 4 through 20-450 Hz."""
    size = n + 2000
    f = np.fft.rfftfreq(size, 1 / FS_HZ)
    power = 120.0**4 * f**2 / ((f**2 + 60.0**2) * (f**2 + 120.0**2) ** 2)
    sos = signal.butter(4, (20.0, 450.0), "bandpass", fs=FS_HZ, output="sos")
    power *= np.abs(signal.freqz_sos(sos, worN=f, fs=FS_HZ)[1]) ** 2
    power /= np.sum(power)
    spectrum = np.sqrt(power / 2) * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    wave = np.fft.irfft(spectrum, size)[1000 : 1000 + n] * size / np.sqrt(2)
    return np.asarray(wave * np.sqrt(np.pi / 2), dtype=np.float64)


def simulate(n_trials: int) -> tuple[Floats, Floats, Floats]:
    """EMG (muscles, n_trials, n) in uV, true force (n,) in newtons, b (n_trials,) of the clean carriers."""
    rng = np.random.default_rng(33)
    n = round((DURATION_S + 2 * MARGIN_S) * FS_HZ)
    time_s = np.arange(n) / FS_HZ - MARGIN_S
    force_n = 0.2 + 7.0 / DURATION_S * time_s
    level = A_UV + B_UV * np.log(np.maximum(force_n, 0.2))
    inside = (force_n >= 0.5) & (force_n <= 7.0)
    emg, clean_b = np.empty((len(SHARES), n_trials, n)), np.empty(n_trials)
    for trial in range(n_trials):
        clean = np.stack([share * level * carrier(rng, n) for share in SHARES])
        emg[:, trial] = clean + NOISE_UV * rng.standard_normal(clean.shape)
        activity = np.abs(clean).sum(axis=0)[inside]
        clean_b[trial] = np.polyfit(np.log(force_n[inside]), activity, 1, w=1 / level[inside])[0]
    return emg, force_n, clean_b


def curves(emg: Floats, force_n: Floats, filters: FilterSettings) -> tuple[Floats, Floats]:
    """Activity (n_trials, k) and force (k,) as the stage pairs them."""
    step = decimation(FS_HZ, filters.output_fs_hz)
    band, kernel, low = band_pass(filters, FS_HZ), smoother(filters, FS_HZ, step), force_low_pass(filters, FS_HZ)
    assert low is not None
    _, shifts = delay_budget(filters.phase, band, kernel, low, 0.0)
    emg_clock, force_clock = (Clock(-shift, FS_HZ, force_n.size) for shift in (shifts.emg_s, shifts.force_s))
    filtered_n = filter_record(force_n, low)
    inside = np.flatnonzero((filtered_n >= 0.5) & (filtered_n <= 7.0))[[0, -1]]
    start_s, stop_s = (force_clock.time_s(inside[i : i + 1]) for i in (0, 1))
    instants = instants_between(start_s, stop_s, emg_clock, force_clock, step)
    rows = [
        envelopes_at(tuple(trials), instants.first, instants.counts, step, band, kernel).sum(axis=0)
        for trials in emg.swapaxes(0, 1)
    ]
    return np.stack(rows), force_at(filtered_n, instants, emg_clock, force_clock)


def fitted(activity: Floats, force_n: Floats, fit: FitSettings) -> LogFit:
    """Equation (6) for every trial, as the stage fits it."""
    offsets = np.arange(len(activity) + 1) * force_n.size
    force = np.broadcast_to(force_n, activity.shape).ravel()
    edges = bin_edges(*WindowSettings().force_n, fit.bin_n)
    return fit_presses(force, activity.ravel(), offsets, edges, fit).reported


def unbiased_mean(b: Floats, clean_b: Floats) -> tuple[float, float]:
    """Mean of b with the luck of these carriers taken out, and its Monte-Carlo standard error."""
    share = np.cov(b, clean_b)[0, 1] / np.var(clean_b, ddof=1)
    corrected = b - share * (clean_b - B_UV)
    return float(corrected.mean()), float(corrected.std(ddof=1) / b.size**0.5)


def print_slope_table(n_trials: int) -> None:
    emg, force_n, clean_b = simulate(n_trials)
    print(f"b of {n_trials} simulated trials, percent of the truth ({B_UV:g} uV)")
    print(f"{'':38}{'bias':>7}{'MC error':>10}{'SD':>7}{'plain mean':>12}  95 % interval covers")
    for name, (filters, fit) in CHAINS.items():
        found = fitted(*curves(emg, force_n, filters), fit)
        # the root mean square of Gaussian noise is sqrt(pi/2) of its mean rectified value
        truth = B_UV * (np.sqrt(np.pi / 2) if filters.envelope == "rms" else 1.0)
        mean, error = unbiased_mean(found.b / truth * B_UV, clean_b)
        cover = 100 * np.mean((found.b_lo <= truth) & (found.b_hi >= truth))
        percent = [100 * (mean / B_UV - 1), 100 * error / B_UV, 100 * found.b.std(ddof=1) / truth]
        plain = 100 * (found.b.mean() / truth - 1)
        print(f"{name:38}{percent[0]:+7.2f}{percent[1]:10.2f}{percent[2]:7.2f}{plain:+12.2f}  {cover:.1f} %")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=1500)
    print_slope_table(parser.parse_args().trials)


if __name__ == "__main__":
    main()
