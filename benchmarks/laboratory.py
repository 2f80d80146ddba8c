"""Sessions as laboratories have them: carriers, ways of pressing and disturbances that the demo study does not have.

The demo study shows the analysis at work; these sessions try it. Nothing here is shared with what makes the demo but
the law v = a + b ln F and the spectrum's shape, so that a fault of one is not hidden by the other.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import signal, special

from emg2vsa.errors import SettingError
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.filters import one_pass_band_hz

FloatArray = NDArray[np.float64]

Ramp = Literal["linear", "exponential", "saturating", "plateaus", "stairs", "sawtooth", "tremor"]
Carrier = Literal["60/120", "40/80", "90/180", "20/45", "laplacian", "units-60", "units-15", "units-6"]

PEAK_N, LOG_ENDS_N, CONTACT_N = 7.5, 0.3, 0.5
HOLD_S, RELEASE_S, REST_S, FIRST_REST_S = 0.3, 0.7, (1.5, 2.5), 3.0
SPIKE_V, BURST_S = 5e-3, 0.1
UNIT_HZ, UNIT_SPREAD = (8.0, 20.0), 0.15
"Firing rates of motor units, and the relative spread of their intervals."


@dataclass(frozen=True, kw_only=True)
class Laboratory:
    """One session: the truth, how the hand presses, and what disturbs. Volts, newtons, hertz and seconds."""

    a_v: float = 30e-6
    b_v: float = 15e-6
    law: Callable[[FloatArray], FloatArray] | None = None
    "In place of a + b ln F: forces in newtons, from 0.3 N on, to volts."
    shares: tuple[float, ...] = (0.6, 0.4)
    "Of each muscle in the co-contraction."
    tone_share: float = 0.1
    "Muscle tone at rest, as a share of the co-contraction at 0.3 N, where the logarithm ends."
    presses: int = 10
    fs_hz: float = 1000.0
    force_fs_hz: float = 1000.0
    carrier: Carrier = "60/120"
    "Corners of a Gaussian spectrum (Shwedyk); the same of Laplace's distribution; or so many motor units."
    ramp: Ramp = "linear"
    ramp_s: float = 2.5
    "From 0 to the peak of 7.5 N."
    noise_v: float = 1e-6
    "White noise of each channel, rms."
    hum_v: float = 0.0
    "Mains hum of each channel, rms of all harmonics."
    hum_hz: float = 50.0
    hum_wander_hz: float = 0.02
    "Its frequency goes up and down by so much within half a minute."
    hum_harmonics: tuple[float, ...] = (1.0,)
    "Relative amplitude of each harmonic."
    touch_hum_v: float = 0.0
    "Mains hum of each channel while the specimen is touched, rms; frequency and harmonics as of the other."
    touch_hum_grows: bool = False
    "It grows with force, from nothing to 1.5 times at the peak."
    artefact_v: float = 0.0
    "Typical size of a jump of each electrode about the lower force of every press: a Hann window times a cosine."
    artefact_s: float = 0.06
    "Its length."
    fade: float = 1.0
    "Share of its level that the first muscle keeps at the end: an electrode that dries."
    spike_hz: float = 0.0
    "So many single samples a second of each channel are 5 mV off, either way."
    burst_v: float = 0.0
    "White noise of 0.1 s in every third press, in all channels."
    held_s: float = 0.0
    "In every press each channel holds one value for so long, at a time of its own."
    missing_s: float = 0.0
    "... or misses its samples."
    clip_at: float = 0.0
    "Each channel saturates at this share of its largest value."
    clip_noise_v: float = 0.0
    "White noise that is added behind the amplifier that saturates."
    lost_share: float = 0.0
    "Share of the packets of 13.5 ms that the EMG's radio lost: what follows comes so much earlier."
    crosstalk: float = 0.0
    "Share of the second muscle's amplitude that the first electrode sees too."
    level_sd: float = 0.0
    "Relative SD of a slow wander of the muscles' level (first-order autoregressive, lognormal)."
    level_s: float = 1.0
    "Its time constant."
    delay_s: float = 0.0
    "Force follows EMG so late (electromechanical delay, or a clock that is late)."
    force_noise_n: float = 0.01
    drift_n_per_min: float = 0.0
    wander_n: float = 0.0
    "Amplitude of a slow wave of the sensor's zero."
    wander_s: float = 20.0
    "Its period."
    step_n: float = 0.0
    "The sensor's zero jumps by so much at the middle press."


@dataclass(frozen=True)
class LaboratorySession:
    """What was recorded: emg_v (m, n) at fs_hz, force_n (k,) at force_fs_hz; and where the presses truly begin (p,)."""

    emg_v: FloatArray
    force_n: FloatArray
    onset_s: FloatArray
    zero_n: FloatArray
    "(k,) what the sensor reads without force."


def simulate_session(laboratory: Laboratory, seed: int) -> LaboratorySession:
    """One session; the same seed gives the same. The expected rectified value of the band-passed EMG (10-450 Hz) of all
    muscles together is v = a + b ln F, from 0.3 N on, plus what noise and hum add."""
    if laboratory.presses < 1:
        found = str(laboratory.presses)
        raise SettingError("presses", wanted="one press or more", found=found, do="Give a number from 1 on.")
    rng = np.random.default_rng(seed)
    fs_hz = laboratory.fs_hz
    true_n, starts = _force(rng, laboratory)
    lead = round(laboratory.delay_s * fs_hz)
    ahead_n = np.concatenate((true_n[lead:], np.full(lead, true_n[-1]))) if lead >= 0 else _late(true_n, -lead)
    level_v = activity_v(ahead_n, laboratory)
    emg_v = np.stack([_channel(rng, share * level_v, laboratory) for share in laboratory.shares])
    emg_v = _disturbed(emg_v, true_n, starts, laboratory, seed)
    time_s = np.arange(0, (true_n.size - 1) / fs_hz, 1 / laboratory.force_fs_hz)
    zero_n = _zero(time_s, laboratory, float(rng.uniform(-0.3, 0.3)), float(rng.uniform(0, 2 * math.pi)))
    read_n = np.interp(time_s * fs_hz, np.arange(true_n.size), true_n) + zero_n
    read_n += laboratory.force_noise_n * rng.standard_normal(read_n.size)
    return LaboratorySession(emg_v, read_n, starts / fs_hz, zero_n)


def _disturbed(
    emg_v: FloatArray, force_n: FloatArray, starts: NDArray[np.int64], laboratory: Laboratory, seed: int
) -> FloatArray:
    """The EMG (m, n) with what spoils it; by chance of its own, so that the carriers are those of the clean session."""
    rng = np.random.default_rng([seed, 34])
    fs_hz, n = laboratory.fs_hz, emg_v.shape[1]
    if laboratory.level_sd:
        memory = math.exp(-1 / (laboratory.level_s * fs_hz))
        white = rng.standard_normal(n + round(5 * laboratory.level_s * fs_hz))
        slow = signal.lfilter([math.sqrt(1 - memory**2)], [1, -memory], white)[-n:]
        emg_v = emg_v * np.exp(laboratory.level_sd * slow - laboratory.level_sd**2 / 2)
    emg_v[0] *= np.linspace(1, laboratory.fade, n)
    emg_v[0] += laboratory.crosstalk * emg_v[1]
    if laboratory.touch_hum_v:
        time_s = np.arange(n) / fs_hz
        angle = 2 * math.pi * np.cumsum(laboratory.hum_hz + laboratory.hum_wander_hz * np.sin(time_s / 5)) / fs_hz
        heights = np.array(laboratory.hum_harmonics) / np.linalg.norm(laboratory.hum_harmonics)
        contact = 1.5 * force_n / PEAK_N if laboratory.touch_hum_grows else force_n > 0
        for row in emg_v:
            for order, height in enumerate(heights, start=1):
                wave = np.sin(order * angle + rng.uniform(0, 2 * math.pi))
                row += math.sqrt(2) * laboratory.touch_hum_v * height * wave * contact
    if laboratory.artefact_v:
        size = round(laboratory.artefact_s * fs_hz)
        for start in starts.tolist():
            lower = start + int(np.argmax(force_n[start:] >= CONTACT_N))
            begin = lower + round(rng.uniform(-0.05, 0.05) * fs_hz) - size // 2
            wave = np.hanning(size) * np.cos(2 * math.pi * rng.uniform(0, 20) * np.arange(size) / fs_hz)
            emg_v[:, begin : begin + size] += laboratory.artefact_v * rng.lognormal(0, 0.4) * wave
    for press, start in enumerate(starts.tolist()):
        if laboratory.burst_v and press % 3 == 0:
            begin, size = start + round(rng.uniform(0.2, 0.8) * laboratory.ramp_s * fs_hz), round(BURST_S * fs_hz)
            emg_v[:, begin : begin + size] += laboratory.burst_v * rng.standard_normal((len(emg_v), size))
        for row in emg_v if laboratory.held_s or laboratory.missing_s else ():
            begin = start + round(rng.uniform(0.1, 0.9) * laboratory.ramp_s * fs_hz)
            row[begin : begin + round(laboratory.held_s * fs_hz)] = row[begin]
            row[begin : begin + round(laboratory.missing_s * fs_hz)] = np.nan
    if laboratory.spike_hz:
        at = rng.random(emg_v.shape) < laboratory.spike_hz / fs_hz
        emg_v[at] += SPIKE_V * rng.choice([-1.0, 1.0], np.count_nonzero(at))
    if laboratory.clip_at:
        rails = laboratory.clip_at * np.abs(emg_v).max(axis=1, keepdims=True)
        emg_v = np.clip(emg_v, -rails, rails) + laboratory.clip_noise_v * rng.standard_normal(emg_v.shape)
    if laboratory.lost_share:
        packet = round(0.0135 * fs_hz)
        kept = np.repeat(rng.random(n // packet + 1) >= laboratory.lost_share, packet)[:n]
        emg_v = emg_v[:, kept]
    return emg_v


def activity_v(force_n: FloatArray, laboratory: Laboratory) -> FloatArray:
    """True co-contraction (n,) at forces (n,): the law from 0.3 N on, below it a straight line down to the tone."""
    law = laboratory.law or (lambda force_n: laboratory.a_v + laboratory.b_v * np.log(force_n))
    end_v = law(np.array(LOG_ENDS_N))
    tone_v = laboratory.tone_share * end_v
    below = tone_v + (end_v - tone_v) * np.maximum(force_n, 0) / LOG_ENDS_N
    return np.where(force_n >= LOG_ENDS_N, law(np.maximum(force_n, LOG_ENDS_N)), below)


def _late(values: FloatArray, by: int) -> FloatArray:
    return np.concatenate((np.full(by, values[0]), values[: values.size - by]))


def _force(rng: np.random.Generator, laboratory: Laboratory) -> tuple[FloatArray, NDArray[np.int64]]:
    fs_hz = laboratory.fs_hz
    pieces, starts, n = [np.zeros(round(FIRST_REST_S * fs_hz))], [], round(FIRST_REST_S * fs_hz)
    for _ in range(laboratory.presses):
        loading = _loading(rng, laboratory)
        hold = np.full(round(HOLD_S * fs_hz), loading[-1])
        release = loading[-1] * 0.5 * (1 + np.cos(np.pi * np.arange(round(RELEASE_S * fs_hz)) / (RELEASE_S * fs_hz)))
        rest = np.zeros(round(rng.uniform(*REST_S) * fs_hz))
        starts.append(n)
        pieces += [loading, hold, release, rest]
        n += loading.size + hold.size + release.size + rest.size
    return np.concatenate(pieces), np.array(starts)


def _loading(rng: np.random.Generator, laboratory: Laboratory) -> FloatArray:
    x = np.arange(round(laboratory.ramp_s * laboratory.fs_hz)) / (laboratory.ramp_s * laboratory.fs_hz)
    kind, phase = laboratory.ramp, rng.uniform(0, 2 * math.pi)
    if kind == "exponential":
        rise = np.expm1(3 * x) / math.expm1(3)
    elif kind == "saturating":
        rise = -np.expm1(-2.5 * x) / -math.expm1(-2.5)
    elif kind == "plateaus":
        rise = np.interp(x, [0, 0.2, 0.35, 0.55, 0.7, 1], [0, 0.25, 0.25, 0.6, 0.6, 1])
    elif kind == "stairs":
        rise = np.floor(10 * x) / 10 + 0.1 * np.clip((10 * x % 1) * 3, 0, 1)
    elif kind == "sawtooth":
        rise = x + 0.02 * signal.sawtooth(2 * math.pi * 2 * x * laboratory.ramp_s + phase, 0.5)
    elif kind == "tremor":
        rise = x * (1 + 0.04 * np.sin(2 * math.pi * 8 * x * laboratory.ramp_s + phase))
    else:
        rise = x
    return np.asarray(PEAK_N * np.maximum(rise, 0))


def _zero(time_s: FloatArray, laboratory: Laboratory, offset_n: float, phase: float) -> FloatArray:
    drift = laboratory.drift_n_per_min * time_s / 60
    wave = laboratory.wander_n * np.sin(2 * math.pi * time_s / laboratory.wander_s + phase)
    return np.asarray(offset_n + drift + wave + laboratory.step_n * (time_s > time_s[-1] / 2))


def _channel(rng: np.random.Generator, level_v: FloatArray, laboratory: Laboratory) -> FloatArray:
    n, fs_hz = level_v.size, laboratory.fs_hz
    carrier = _carrier(rng, n, fs_hz, laboratory.carrier)
    # the units of a muscle are its own, and so is its level
    own = laboratory.carrier.startswith("units")
    emg_v = level_v * carrier / (_mean_rectified(carrier, fs_hz) if own else _rectified(fs_hz, laboratory.carrier))
    emg_v += laboratory.noise_v * rng.standard_normal(n)
    if laboratory.hum_v > 0:
        time_s = np.arange(n) / fs_hz
        slow = np.sin(2 * math.pi * time_s / 30 + rng.uniform(0, 2 * math.pi))
        angle = 2 * math.pi * np.cumsum(laboratory.hum_hz + laboratory.hum_wander_hz * slow) / fs_hz
        heights = np.array(laboratory.hum_harmonics) / np.linalg.norm(laboratory.hum_harmonics)
        phases = rng.uniform(0, 2 * math.pi, heights.size)
        for order, (height, phase) in enumerate(zip(heights, phases, strict=True), start=1):
            emg_v += math.sqrt(2) * laboratory.hum_v * height * np.sin(order * angle + phase)
    return np.asarray(emg_v)


def _carrier(rng: np.random.Generator, n: int, fs_hz: float, kind: Carrier) -> FloatArray:
    if kind.startswith("units"):
        return _motor_units(rng, n, fs_hz, int(kind.partition("-")[2]))
    low_hz, high_hz = (60.0, 120.0) if kind == "laplacian" else map(float, kind.split("/"))
    spectrum = np.fft.rfft(rng.standard_normal(n + 64))
    f = np.fft.rfftfreq(n + 64, 1 / fs_hz)
    spectrum *= high_hz**2 * f / (np.sqrt(f**2 + low_hz**2) * (f**2 + high_hz**2))
    wave = np.fft.irfft(spectrum, n + 64)[:n]
    wave /= np.sqrt(np.mean(wave**2))
    if kind == "laplacian":
        # the value with the same rank in Laplace's distribution
        tail = special.ndtr(-np.abs(wave))
        return np.asarray(-np.sign(wave) * np.log(2 * tail) / math.sqrt(2))
    return np.asarray(wave)


def _motor_units(rng: np.random.Generator, n: int, fs_hz: float, units: int) -> FloatArray:
    """Trains of biphasic potentials of 4 to 8 ms, each unit with its own size, width and firing rate."""
    wave = np.zeros(n)
    for _ in range(units):
        rate_hz, size, width_s = rng.uniform(*UNIT_HZ), rng.lognormal(0, 0.5), rng.uniform(0.0008, 0.0016)
        gaps_s = np.maximum(1 + UNIT_SPREAD * rng.standard_normal(int(n / fs_hz * rate_hz * 1.5) + 20), 0.3) / rate_hz
        at = (np.cumsum(gaps_s) - rng.uniform(0, 1 / rate_hz)) * fs_hz
        at = at[(at >= 0) & (at < n - 1)]
        train = np.bincount(at.astype(np.int64), minlength=n).astype(np.float64)
        x = np.arange(-0.008, 0.008, 1 / fs_hz) / width_s
        wave += size * np.convolve(train, -x * np.exp(-(x**2) / 2), mode="same")
    return wave


@lru_cache(maxsize=64)
def _rectified(fs_hz: float, kind: Carrier) -> float:
    """Mean rectified value of the carrier over 600 s."""
    rng = np.random.default_rng(20)
    return float(np.mean([_mean_rectified(_carrier(rng, round(100 * fs_hz), fs_hz, kind), fs_hz) for _ in range(6)]))


def _mean_rectified(carrier: FloatArray, fs_hz: float) -> float:
    """Mean rectified value behind the analysis' default band-pass."""
    filters = FilterSettings()
    low_hz, high_hz = filters.band_hz
    band_hz = one_pass_band_hz((low_hz, min(high_hz, 0.45 * fs_hz)), filters.band_order, "zero-phase", fs_hz)
    sos = signal.butter(filters.band_order, band_hz, "bandpass", fs=fs_hz, output="sos")
    return float(np.mean(np.abs(signal.sosfiltfilt(sos, carrier))))
