"""What sensors make of people: EMG with its carrier, noise, hum and drift, and a force with offset, drift and noise.

Samples come in blocks of any size, and are the same however many are taken at a time: random numbers are drawn a page
at a time. A recording is a stream of one page, a session one of pages without an end.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft

FloatArray = NDArray[np.float64]
Draw = Callable[[int], FloatArray]
Spectrum = Callable[[FloatArray], FloatArray]

MUSCLE_LOW_HZ, MUSCLE_HIGH_HZ = 60.0, 120.0
"Corners of the muscle spectrum (Shwedyk, Balasubramanian and Scott 1977; Stegeman and Hermens 1998)."
AMPLIFIER_BAND_HZ = (20.0, 450.0)
"Second-order band of the amplifier (12 dB per octave at each edge), as a Bagnoli has it."
EMG_DRIFT_V, EMG_DRIFT_HZ = 3e-6, 1.0
"Baseline drift of each EMG channel, rms, and the frequency it ends at."
FORCE_DRIFT_N, FORCE_DRIFT_HZ = 0.01, 0.02
"Drift of the force sensor, rms, and the frequency it ends at."
EMG_PAGE, FORCE_PAGE = 1 << 14, 1 << 16
"Samples of a page of a stream without an end: some seconds of EMG, a minute of force, whose drift is slower."


def muscle_spectrum(frequency_hz: FloatArray) -> FloatArray:
    """Power (n,) of surface EMG behind its amplifier, arbitrary unit, at frequencies (n,), Hz: f_h^4 f^2 / ((f^2 +
    f_l^2) (f^2 + f_h^2)^2) (Shwedyk, Balasubramanian and Scott 1977; Stegeman and Hermens 1998)."""
    f2 = np.square(frequency_hz)
    muscle = MUSCLE_HIGH_HZ**4 * f2 / ((f2 + MUSCLE_LOW_HZ**2) * np.square(f2 + MUSCLE_HIGH_HZ**2))
    low, high = AMPLIFIER_BAND_HZ
    power: FloatArray = muscle * np.square(f2) / (np.square(f2) + low**4) / (1 + np.square(f2 / high**2))
    return power


def gaussian_noise(rng: np.random.Generator, n: int, fs_hz: float, spectrum: Spectrum) -> FloatArray:
    """(n,) samples at ``fs_hz``, Hz, of zero-mean Gaussian noise whose power follows ``spectrum`` and whose expected
    variance is 1.

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
    """(n,) Gaussian EMG carrier at ``fs_hz``, Hz, with a mean rectified value of 1: sigma sqrt(2/pi) = 1."""
    return math.sqrt(math.pi / 2) * gaussian_noise(rng, n, fs_hz, muscle_spectrum)


def below(corner_hz: float) -> Spectrum:
    """Spectrum of a slow drift: flat up to ``corner_hz``, then falling by 24 dB per octave."""
    return lambda frequency_hz: 1 / (1 + (frequency_hz / corner_hz) ** 8)


def around(centre_hz: float, width_hz: float) -> Spectrum:
    """Spectrum of a tremor: a Gaussian peak at ``centre_hz``, Hz, of standard deviation ``width_hz``."""
    return lambda frequency_hz: np.exp(-0.5 * np.square((frequency_hz - centre_hz) / width_hz))


class _Pages:
    """Rows (n, k) of random numbers; ``draw`` makes those of a page."""

    def __init__(self, draw: Draw, page: int) -> None:
        self._draw, self._page, self._left = draw, page, draw(page)

    def take(self, n: int) -> FloatArray:
        pages = -(-(n - len(self._left)) // self._page)
        if pages > 0:
            self._left = np.concatenate([self._left, *(self._draw(self._page) for _ in range(pages))])
        taken, self._left = self._left[:n], self._left[n:]
        return taken


class Faults(NamedTuple):
    """Faults of an electrode, rms: white noise, and mains hum of a frequency."""

    noise_v: float
    mains_v: float
    mains_hz: float


class Electrode:
    """EMG of one muscle: carrier times envelope, mains hum, baseline drift and white noise.

    page : samples whose random numbers are drawn together, at least 1.
    """

    def __init__(self, rng: np.random.Generator, fs_hz: float, faults: Faults, page: int = EMG_PAGE) -> None:
        self._fs_hz, self._faults = fs_hz, faults
        self._phase, self._taken = rng.uniform(0, 2 * np.pi), 0

        def draw(n: int) -> FloatArray:
            drift = EMG_DRIFT_V * gaussian_noise(rng, n, fs_hz, below(EMG_DRIFT_HZ))
            white = rng.standard_normal(n)
            return np.column_stack([drift, white, emg_carrier(rng, n, fs_hz)])

        self._pages = _Pages(draw, page)

    def take(self, envelope_v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(n,) the next samples, V, of a muscle that is so active (n,); its hum and its white noise, amplitude and
        standard deviation 1."""
        drift, white, carrier = self._pages.take(envelope_v.size).T
        number = np.arange(self._taken, self._taken + envelope_v.size)
        self._taken += envelope_v.size
        noise_v, mains_v, mains_hz = self._faults
        hum = np.sin(2 * np.pi * mains_hz * number / self._fs_hz + self._phase)
        emg_v = envelope_v * carrier + math.sqrt(2) * mains_v * hum + drift + noise_v * white
        return emg_v, hum, white


class ForceSensor:
    """True force as a sensor with offset, slow drift and white noise reports it."""

    def __init__(
        self, rng: np.random.Generator, fs_hz: float, *, noise_n: float, offset_n: float = 0.0, page: int = FORCE_PAGE
    ) -> None:
        self._offset_n = offset_n

        def draw(n: int) -> FloatArray:
            drift = FORCE_DRIFT_N * gaussian_noise(rng, n, fs_hz, below(FORCE_DRIFT_HZ))
            return np.column_stack([drift, noise_n * rng.standard_normal(n)])

        self._pages = _Pages(draw, page)

    def take(self, force_n: FloatArray) -> FloatArray:
        """(n,) the next samples, N, at a true force (n,)."""
        drift, noise = self._pages.take(force_n.size).T
        read_n: FloatArray = force_n + self._offset_n + drift + noise
        return read_n
