"""Mains hum, fitted while the hand rests and subtracted from the whole record.

The frequency of the mains wanders by some 0.01 Hz within a minute, so one sine for the whole record would lose its
phase. Amplitude and phase of every harmonic are fitted in half seconds of rest; one frequency is the one at which
neighbouring half seconds agree, and between them amplitude and phase are interpolated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints
from emg2vsa.signals.quality import MAINS_HZ

Phasors = NDArray[np.complex128]

HARMONICS = 6
PIECE_S = 0.5
"A window of Hann's of this length tells 50 Hz from 60 Hz."
OFFSET_HZ = 0.4
"The mains is looked for so far around its nominal frequency."
STEADY = 0.5
"A harmonic is subtracted where neighbouring pieces agree in so much of its power; noise alone agrees in none."
CLEAR = 4.0
"... and where it has so many times the power that is found between the harmonics."
ASIDE_HZ = 6.0
"Between the harmonics: so far below and above each."
FEWEST = 8
"Fewer half seconds of rest do not tell the frequency of the mains."
BLOCK_S = 0.25
"Amplitude and phase are constant within blocks of this length."


@dataclass(frozen=True)
class Hum:
    """What was found. hz : of the mains. harmonics : (h,) those subtracted from any channel. rms : (m,) of each."""

    hz: float
    harmonics: Ints
    rms: Floats


def remove_hum(
    channels: tuple[Floats, ...], fs_hz: float, start: Ints, stop: Ints
) -> tuple[tuple[Floats, ...], Hum | None]:
    """The channels (n,) without the hum that is found in their rests [start, stop) (r,), and what it was, or None.

    ``FEWEST`` pieces of half a second of rest are the least; hum that does not keep its phase between them stays.
    """
    size = round(PIECE_S * fs_hz)
    begins = np.concatenate([np.arange(a, b - size + 1, size) for a, b in zip(start, stop, strict=True)] or [start])
    if begins.size < FEWEST or fs_hz <= 4 * MAINS_HZ[0]:
        return channels, None
    time_s = (begins + (size - 1) / 2) / fs_hz
    pieces = np.stack([samples[begins[:, None] + np.arange(size)] for samples in channels])
    phasors, orders = _phasors(pieces, begins, fs_hz)
    found = np.mean(np.abs(phasors) ** 2, axis=-1)
    clear = found[:, :, 1] > CLEAR * (found[:, :, 0] + found[:, :, 2]) / 2
    best: tuple[float, float, Phasors] | None = None
    for mains, nominal_hz in enumerate(MAINS_HZ):
        if not clear[:, mains].any():
            continue
        own = phasors[:, mains, 1]
        offset_hz = _offset_hz(np.where(clear[:, mains, :, None], own, 0.0), time_s, orders)
        turned = own * np.exp(-2j * np.pi * offset_hz * orders[:, None] * time_s)
        agreed = np.mean((turned[..., 1:] * turned[..., :-1].conj()).real, axis=-1)
        steady = clear[:, mains] & (agreed > STEADY * found[:, mains, 1])
        power = float(np.sum(agreed[steady]))
        if steady.any() and (best is None or power > best[0]):
            best = (power, nominal_hz + offset_hz, np.where(steady[..., None], turned, 0.0))
    if best is None:
        return channels, None
    _, hz, turned = best
    used = np.any(turned != 0, axis=(0, 2))
    turned, orders = turned[:, used], orders[used]
    cleaned = tuple(
        _without(samples, own, hz * orders.astype(np.float64), time_s, fs_hz)
        for samples, own in zip(channels, turned, strict=True)
    )
    rms = np.sqrt(np.sum(np.mean(np.abs(turned) ** 2, axis=-1), axis=-1) / 2)
    return cleaned, Hum(hz, orders, rms)


def _phasors(pieces: Floats, begins: Ints, fs_hz: float) -> tuple[Phasors, Ints]:
    """Amplitude and phase at time 0 of sines in pieces (m, p, size) from ``begins`` (p,) on, and the orders (h,).

    (m, 2, 3, h, p): of both mains, below, at and above each of their harmonics. Each is the nearest bin of the piece's
    spectrum: at the middle of a symmetric window its phase is that of the sine, wherever within the bin that stands.
    """
    size = pieces.shape[-1]
    orders = np.arange(1, HARMONICS + 1)
    orders = orders[orders * max(MAINS_HZ) < 0.45 * fs_hz]
    hz = np.multiply.outer(MAINS_HZ, orders)[:, None, :] + np.array([-ASIDE_HZ, 0.0, ASIDE_HZ])[:, None]
    bins = np.rint(hz * size / fs_hz).astype(np.int64)
    window = np.sin(np.pi * (np.arange(size) + 0.5) / size) ** 2
    spectrum = np.fft.rfft(pieces * (2 / window.sum() * window), axis=-1)
    middle = (size - 1) / 2
    to_middle = np.exp(2j * np.pi * bins * middle / size)
    at_zero = np.exp(-2j * np.pi / fs_hz * np.multiply.outer(hz, begins + middle))
    return np.moveaxis(spectrum[..., bins] * to_middle, 1, -1) * at_zero, orders


def _offset_hz(phasors: Phasors, time_s: Floats, orders: Ints) -> float:
    """By how much the mains is off its nominal frequency: where neighbouring pieces agree best."""
    strongest = int(np.argmax(np.sum(np.abs(phasors) ** 2, axis=(0, 2))))
    order, phasor = int(orders[strongest]), phasors[:, strongest]
    product = np.sum(phasor[:, 1:] * phasor[:, :-1].conj(), axis=0)
    grid_hz = np.linspace(-OFFSET_HZ, OFFSET_HZ, 161)
    agreed = np.sum((np.exp(-2j * np.pi * order * np.outer(grid_hz, np.diff(time_s))) * product).real, axis=1)
    at = int(np.argmax(agreed))
    if 0 < at < grid_hz.size - 1:
        low, top, high = agreed[at - 1 : at + 2]
        return float(grid_hz[at] + (grid_hz[1] - grid_hz[0]) * (high - low) / (2 * (2 * top - low - high)))
    return float(grid_hz[at])


def _without(samples: Floats, turned: Phasors, hz: Floats, time_s: Floats, fs_hz: float) -> Floats:
    """Samples (n,) minus the sines whose phasors (h, p) at ``time_s`` (p,) turn slowly about the frequencies (h,)."""
    size = max(1, round(BLOCK_S * fs_hz))
    starts = np.arange(0, samples.size, size)
    middle_s = (starts + (size - 1) / 2) / fs_hz
    slow = np.stack(
        [np.interp(middle_s, time_s, row.real) + 1j * np.interp(middle_s, time_s, row.imag) for row in turned]
    )
    slow *= np.exp(2j * np.pi / fs_hz * np.outer(hz, starts))
    wave = np.exp(2j * np.pi / fs_hz * np.outer(hz, np.arange(size)))
    left = np.zeros(starts.size * size)
    left[: samples.size] = samples
    for own, turning in zip(slow, wave, strict=True):
        blocks = left.reshape(-1, size)
        blocks -= own.real[:, None] * turning.real - own.imag[:, None] * turning.imag
    return left[: samples.size]
