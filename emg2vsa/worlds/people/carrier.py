"""Random signals of a given spectrum, and the carrier of surface EMG."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import fft

FloatArray = NDArray[np.float64]
Spectrum = Callable[[FloatArray], FloatArray]

MUSCLE_LOW_HZ, MUSCLE_HIGH_HZ = 60.0, 120.0
"Corners of the muscle spectrum (Shwedyk, Balasubramanian and Scott 1977; Stegeman and Hermens 1998)."
AMPLIFIER_BAND_HZ = (20.0, 450.0)
"Second-order band of the amplifier (12 dB per octave at each edge), as a Bagnoli has it."


def muscle_spectrum(frequency_hz: FloatArray) -> FloatArray:
    """Power of surface EMG behind its amplifier, arbitrary unit: f_h^4 f^2 / ((f^2 + f_l^2) (f^2 + f_h^2)^2)."""
    f2 = np.square(frequency_hz)
    muscle = MUSCLE_HIGH_HZ**4 * f2 / ((f2 + MUSCLE_LOW_HZ**2) * np.square(f2 + MUSCLE_HIGH_HZ**2))
    low, high = AMPLIFIER_BAND_HZ
    power: FloatArray = muscle * np.square(f2) / (np.square(f2) + low**4) / (1 + np.square(f2 / high**2))
    return power


def gaussian_noise(rng: np.random.Generator, n: int, fs_hz: float, spectrum: Spectrum) -> FloatArray:
    """``n`` samples of zero-mean Gaussian noise whose power follows ``spectrum`` and whose expected variance is 1.

    The noise is drawn in the frequency domain over a length somewhat above ``n``, so that its ends do not meet.
    """
    length = fft.next_fast_len(n + 64, real=True)
    frequency_hz = fft.rfftfreq(length, 1 / fs_hz)
    power = spectrum(frequency_hz)
    power[0] = 0.0
    if length % 2 == 0:
        power[-1] = 0.0
    # each inner bin stands for two conjugate ones; E|z|^2 = 2 for a complex draw of unit real and imaginary parts
    amplitude = np.sqrt(power / power.sum()) * (length / 2)
    draw = rng.standard_normal((frequency_hz.size, 2)).view(np.complex128)[:, 0]
    return fft.irfft(amplitude * draw, length)[:n]


def emg_carrier(rng: np.random.Generator, n: int, fs_hz: float) -> FloatArray:
    """Gaussian EMG carrier with a mean rectified value of 1: sigma sqrt(2/pi) = 1."""
    return math.sqrt(math.pi / 2) * gaussian_noise(rng, n, fs_hz, muscle_spectrum)


def below(corner_hz: float) -> Spectrum:
    """Spectrum of a slow drift: flat up to ``corner_hz``, then falling by 24 dB per octave."""
    return lambda frequency_hz: 1 / (1 + (frequency_hz / corner_hz) ** 8)


def around(centre_hz: float, width_hz: float) -> Spectrum:
    """Spectrum of a tremor: a Gaussian peak of standard deviation ``width_hz``."""
    return lambda frequency_hz: np.exp(-0.5 * np.square((frequency_hz - centre_hz) / width_hz))
