"""One continuous synthetic recording, in volts and newtons, with the truth behind it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import SettingError
from emg2vsa.settings import SimulationSettings
from emg2vsa.worlds.people.carrier import below, emg_carrier, gaussian_noise
from emg2vsa.worlds.people.presses import Presses, make_presses

FloatArray = NDArray[np.float64]

JOIN_SHARE = 0.6
"The logarithm ends at this share of the lower force of the window (0.3 N of 0.5 N)."
REST_SHARE = 0.2
"Rest tone, as a share of the co-contraction where the logarithm ends."
EMG_DRIFT_V, EMG_DRIFT_HZ = 3e-6, 1.0
"Baseline drift of each EMG channel, rms, and the frequency it ends at."
FORCE_DRIFT_N, FORCE_DRIFT_HZ = 0.01, 0.02
"Drift of the force sensor, rms, and the frequency it ends at."


@dataclass(frozen=True)
class Truth:
    """What was put in. a_v, b_v : (r,) coefficients of each repetition; cocontraction_v : (n,) at every sample.

    force_offset_n : bias of the force sensor over the whole recording.
    """

    a_v: FloatArray
    b_v: FloatArray
    presses: Presses
    cocontraction_v: FloatArray
    force_offset_n: float


@dataclass(frozen=True)
class SyntheticRecording:
    """Sensor signals: emg_v maps muscle to (n,) volts at the electrode; force_n : (n,) compression positive, biased."""

    fs_hz: float
    emg_v: dict[str, FloatArray]
    force_n: FloatArray
    truth: Truth

    @property
    def duration_s(self) -> float:
        return self.force_n.size / self.fs_hz


def make_recording(
    seed: np.random.SeedSequence,
    settings: SimulationSettings,
    *,
    a_v: float,
    b_v: float,
    window_n: tuple[float, float],
    force_delay_s: float = 0.0,
) -> SyntheticRecording:
    """Simulate one recording; the same seed gives the same recording, whatever else is simulated.

    a_v, b_v : coefficients of this participant on this specimen; every repetition scales both by one random factor of
    relative spread ``settings.repetition_sd``. window_n : force window, newtons. force_delay_s : of the force sensor.
    """
    presses_rng, scale_rng, force_rng, *muscle_rngs = _streams(seed, 3 + len(settings.muscle_share))
    presses = make_presses(presses_rng, settings, window_n, settings.repetitions)
    scale = spread(scale_rng, settings.repetition_sd, settings.repetitions)
    unit_v = true_cocontraction_v(presses.force_n, a_v, b_v, window_n[0])
    cocontraction_v = unit_v * _scale_over_time(presses, scale, settings.fs_hz)
    emg_v = {
        muscle: _emg_channel(rng, share * cocontraction_v, settings)
        for rng, (muscle, share) in zip(muscle_rngs, settings.muscle_share.items(), strict=True)
    }
    offset_n = float(force_rng.uniform(-settings.force_offset_n, settings.force_offset_n))
    force_n = _force_channel(force_rng, presses.force_n, offset_n, force_delay_s, settings)
    truth = Truth(a_v * scale, b_v * scale, presses, cocontraction_v, offset_n)
    return SyntheticRecording(settings.fs_hz, emg_v, force_n, truth)


def _streams(seed: np.random.SeedSequence, n: int) -> list[np.random.Generator]:
    """One stream per part, so that a further muscle leaves force and the other muscles as they are."""
    # SeedSequence.spawn would count its calls, and a second recording from one seed would differ
    keys = [(*seed.spawn_key, part) for part in range(n)]
    return [np.random.default_rng(np.random.SeedSequence(seed.entropy, spawn_key=key)) for key in keys]


def spread(rng: np.random.Generator, relative_sd: float, n: int) -> FloatArray:
    """``n`` factors around 1; a wide spread is cut at 0.1, for a co-contraction stays positive."""
    factors: FloatArray = np.maximum(1 + relative_sd * rng.standard_normal(n), 0.1)
    return factors


def _scale_over_time(presses: Presses, scale: FloatArray, fs_hz: float) -> FloatArray:
    """Each repetition's factor, changing smoothly from the one before it around the cue that precedes the press."""
    cue_s = presses.cue_start_s
    knots_s = np.column_stack([cue_s - 0.1, cue_s + 0.1]).ravel()
    levels = np.repeat(np.concatenate([scale[:1], scale]), 2)[1:-1]
    factor: FloatArray = np.interp(np.arange(presses.force_n.size) / fs_hz, knots_s, levels)
    return factor


def _emg_channel(rng: np.random.Generator, envelope_v: FloatArray, settings: SimulationSettings) -> FloatArray:
    """Carrier times envelope, mains, baseline drift and white sensor noise."""
    n, fs_hz = envelope_v.size, settings.fs_hz
    phase = rng.uniform(0, 2 * np.pi)
    mains = math.sqrt(2) * settings.mains_v * np.sin(2 * np.pi * settings.mains_hz * np.arange(n) / fs_hz + phase)
    drift = EMG_DRIFT_V * gaussian_noise(rng, n, fs_hz, below(EMG_DRIFT_HZ))
    noise = settings.emg_noise_v * rng.standard_normal(n)
    emg_v: FloatArray = envelope_v * emg_carrier(rng, n, fs_hz) + mains + drift + noise
    return emg_v


def _force_channel(
    rng: np.random.Generator, force_n: FloatArray, offset_n: float, delay_s: float, settings: SimulationSettings
) -> FloatArray:
    """True force as a sensor with delay, offset, slow drift and white noise reports it."""
    n, fs_hz = force_n.size, settings.fs_hz
    drift = FORCE_DRIFT_N * gaussian_noise(rng, n, fs_hz, below(FORCE_DRIFT_HZ))
    noise = settings.force_noise_n * rng.standard_normal(n)
    if delay_s > 0:
        force_n = np.interp(np.arange(n) - delay_s * fs_hz, np.arange(n), force_n)
    return force_n + offset_n + drift + noise


def true_cocontraction_v(force_n: FloatArray, a_v: float, b_v: float, lower_n: float) -> FloatArray:
    """Equation (6), v = a + b ln F, for F >= 0.6 ``lower_n``; below, a power of F, equal in value and slope there.

    force_n : (n,) true force, not negative. Returns (n,) volts; at zero force a rest tone, a fifth of the joint value.
    """
    join_n, join_v = logarithm_end(a_v, b_v, lower_n)
    rest_v = REST_SHARE * join_v
    exponent = b_v / (join_v - rest_v)
    below = rest_v + (join_v - rest_v) * (np.minimum(force_n, join_n) / join_n) ** exponent
    return np.where(force_n >= join_n, a_v + b_v * np.log(np.maximum(force_n, join_n)), below)


def logarithm_end(a_v: float, b_v: float, lower_n: float) -> tuple[float, float]:
    """Force and co-contraction at which the logarithm ends."""
    join_n = JOIN_SHARE * lower_n
    return join_n, a_v + b_v * math.log(join_n)


def check_coefficients(where: str, a_v: float, b_v: float, lower_n: float) -> None:
    """Refuse a logarithm that is not rising, or not positive where it ends."""
    join_n, join_v = logarithm_end(a_v, b_v, lower_n)
    if not (b_v > 0 and join_v > 0):
        raise SettingError(
            where,
            wanted=f"b_v > 0 and a_v + b_v ln({join_n:g} N) > 0, so that EMG rises with force and stays positive",
            found=f"a_v = {a_v:g}, b_v = {b_v:g}, which give {join_v:.3g} V at {join_n:g} N",
            do="Raise a_v or lower b_v.",
        )
