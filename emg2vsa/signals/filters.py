"""Butterworth filters as second-order sections, and what they truly do: -3 dB edges, delay, length of memory.

Always sections in float64: transfer-function coefficients lose 10 digits at order 4 and all of them at order 8.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np
from scipy import signal

from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError
from emg2vsa.settings import FilterSettings

TRUNCATION = 1e-14
"Share of a transient that may be left after ``support_samples``."

FEWEST_DIGITS = 7.0
"A filter that would keep fewer decimal digits is refused."
SAID_DIGITS = 9.0
"A filter that keeps fewer says so: an edge below about 1e-4 of the rate."

Phase = Literal["zero-phase", "compensated", "causal"]


@dataclass(frozen=True)
class IirFilter:
    """One filter as it is run.

    sos : (sections, 6). passes_offset : gain 1 at 0 Hz (a low-pass), else 0. zero_phase : run forward and backward.
    delay_s : group delay of one causal pass in the middle of its band; 0 when zero-phase.
    support_samples : after so many samples the memory of the start has fallen below ``TRUNCATION``.
    pad_samples : length of the odd extension at the ends of a record (scipy's rule); 0 for one causal pass.
    notes : what must be said aloud, the Nyquist rule first. engine : that of ``FilterSettings``.
    """

    name: str
    sos: Floats
    passes_offset: bool
    zero_phase: bool
    delay_s: float
    support_samples: int
    pad_samples: int
    notes: tuple[str, ...]
    engine: Literal["plain", "compiled"] = "plain"


def band_pass(filters: FilterSettings, fs_hz: float) -> IirFilter:
    """The EMG band-pass of ``filters`` at ``fs_hz``.

    An upper edge at or above fs/2 cannot be built (paper: 500 Hz at 1000 Hz). It is dropped: what remains is a
    high-pass at the lower edge of the same order, and a note says so. SettingError : edges that cannot be.
    """
    return replace(_band_pass(filters.band_hz, filters.band_order, filters.phase, fs_hz), engine=filters.engine)


def force_low_pass(filters: FilterSettings, fs_hz: float) -> IirFilter | None:
    """The force low-pass of ``filters`` at ``fs_hz``, Hz; None where the study takes force as it is. SettingError : a
    cut-off from half the rate on."""
    if not filters.force_filter:
        return None
    return _low_pass(filters.force_cutoff_hz, filters.force_order, filters.phase, fs_hz)


@lru_cache(maxsize=64)
def _band_pass(band_hz: tuple[float, float], order: int, phase: Phase, fs_hz: float) -> IirFilter:
    low, high = band_hz
    half = fs_hz / 2
    if not 0 < low < min(high, half):
        found, do = f"{low:g} to {high:g} Hz at {fs_hz:g} Hz", "Give lower edge, then upper edge."
        raise SettingError("filters.band_hz", wanted=f"0 < lower < upper, lower < {half:g} Hz", found=found, do=do)
    if high < half:
        edges = one_pass_band_hz((low, high), order, phase, fs_hz)
        sos = signal.butter(order, edges, "bandpass", fs=fs_hz, output="sos")
        return _described("EMG band-pass", sos, phase, fs_hz, math.sqrt(low * high), ())
    edge = _unwarped(_warped(low, fs_hz) * _narrowing(order, phase), fs_hz)
    sos = signal.butter(order, edge, "highpass", fs=fs_hz, output="sos")
    rule = (
        f"NYQUIST RULE: upper edge {high:g} Hz is at or above half the EMG rate ({half:g} Hz) and cannot be built; "
        f"dropped, EMG is high-passed at {low:g} Hz"
    )
    return _described("EMG high-pass", sos, phase, fs_hz, math.sqrt(low * half), (rule,))


@lru_cache(maxsize=64)
def _low_pass(cutoff_hz: float, order: int, phase: Phase, fs_hz: float) -> IirFilter:
    if cutoff_hz >= fs_hz / 2:
        raise SettingError(
            "filters.force_cutoff_hz",
            wanted=f"less than half the force rate, {fs_hz / 2:g} Hz",
            found=f"{cutoff_hz:g} Hz",
            do="Lower it, or set force_filter = false.",
        )
    edge = _unwarped(_warped(cutoff_hz, fs_hz) / _narrowing(order, phase), fs_hz)
    sos = signal.butter(order, edge, "lowpass", fs=fs_hz, output="sos")
    return _described("force low-pass", sos, phase, fs_hz, 0.0, ())


def one_pass_band_hz(band_hz: tuple[float, float], order: int, phase: Phase, fs_hz: float) -> tuple[float, float]:
    """Edges to design one pass with, so that the whole run is 3.01 dB down at ``band_hz``.

    Two passes of a plain design would be 6 dB down there, that is, 12.4 to 438 Hz for 10 to 450 Hz at 1000 Hz. The
    prototype's bandwidth is widened about the same centre (Winter 2009, section 2.2.4.4, for the band-pass case).
    """
    low, high = (_warped(edge, fs_hz) for edge in band_hz)
    width, centre = (high - low) / _narrowing(order, phase), low * high
    upper = (width + math.sqrt(width**2 + 4 * centre)) / 2
    return _unwarped(centre / upper, fs_hz), _unwarped(upper, fs_hz)


def _narrowing(order: int, phase: Phase) -> float:
    """How much all passes together narrow a Butterworth low-pass of one pass; 1 for a single pass."""
    passes = 2 if phase == "zero-phase" else 1
    return float((2 ** (1 / passes) - 1) ** (0.5 / order))


def _warped(frequency_hz: float, fs_hz: float) -> float:
    return math.tan(math.pi * frequency_hz / fs_hz)


def _unwarped(warped: float, fs_hz: float) -> float:
    return math.atan(warped) * fs_hz / math.pi


def _described(
    name: str, sos: Floats, phase: Phase, fs_hz: float, delay_at_hz: float, notes: tuple[str, ...]
) -> IirFilter:
    zero_phase = phase == "zero-phase"
    delay_s = 0.0 if zero_phase else group_delay_samples(sos, delay_at_hz, fs_hz) / fs_hz
    edges = true_edges_hz(sos, fs_hz, passes=2 if zero_phase else 1, inside_hz=delay_at_hz)
    runs = "forward and backward" if zero_phase else "forward only"
    order = f"Butterworth, {sos.shape[0]} section{'s' if sos.shape[0] > 1 else ''}, run {runs}"
    delay = "no delay" if zero_phase else f"delay {1e3 * delay_s:.3g} ms at {delay_at_hz:.3g} Hz"
    shown = " and ".join(f"{edge:.4g} Hz" for edge in edges if not math.isnan(edge))
    said = f"{name}: {order}; true -3 dB at {shown}; {delay}"
    few = _about_digits(name, sos, fs_hz)
    support = support_samples(sos)
    pad = default_pad_samples(sos) if zero_phase else 0
    return IirFilter(name, sos, delay_at_hz == 0, zero_phase, delay_s, support, pad, (*notes, *few, said))


def digits_kept(sos: Floats) -> float:
    """Decimal digits of a signal near 0 Hz that survive the filter's own rounding in float64. sos : (sections, 6).

    A section recurs with 1 + a1 + a2, about the square of its edge in radians per sample: what is left of that sum
    after rounding is what is left of the signal.
    """
    return float(np.log10(np.min(np.abs(sos[:, 3:].sum(axis=1))) / (4 * np.finfo(np.float64).eps)))


def _about_digits(name: str, sos: Floats, fs_hz: float) -> tuple[str, ...]:
    """A note where the filter keeps few digits; SettingError where it keeps too few."""
    digits = digits_kept(sos)
    if digits < FEWEST_DIGITS:
        key = "filters.force_cutoff_hz" if "force" in name else "filters.band_hz"
        raise SettingError(
            key,
            wanted=f"an edge that keeps {FEWEST_DIGITS:g} digits of the signal at {fs_hz:g} Hz",
            found=f"one that keeps {max(digits, 0):.1f}",
            do="Raise the lowest edge, or resample the recording to a lower rate.",
        )
    if digits >= SAID_DIGITS:
        return ()
    return (
        f"{name}: the lowest edge is so far below the rate of {fs_hz:g} Hz that rounding leaves about {digits:.0f} "
        "digits of a slow signal; resample the recording to a lower rate",
    )


def gain(sos: Floats, frequency_hz: float, fs_hz: float) -> float:
    """Magnitude of the response of one pass of ``sos`` (sections, 6) at one frequency, Hz."""
    z = np.exp(-2j * np.pi * frequency_hz / fs_hz) ** np.arange(3)
    return float(np.prod(np.abs(sos[:, :3] @ z) / np.abs(sos[:, 3:] @ z)))


def group_delay_samples(sos: Floats, frequency_hz: float, fs_hz: float) -> float:
    """Group delay in samples of one pass at one frequency, from the derivative of every section's polynomials. sos :
    (sections, 6)."""
    powers = np.arange(3)
    z = np.exp(-2j * np.pi * frequency_hz / fs_hz) ** powers
    numerator = (sos[:, :3] @ (powers * z)) / (sos[:, :3] @ z)
    denominator = (sos[:, 3:] @ (powers * z)) / (sos[:, 3:] @ z)
    return float(np.sum((numerator - denominator).real))


def true_edges_hz(sos: Floats, fs_hz: float, *, passes: int, inside_hz: float) -> tuple[float, float]:
    """Frequencies, Hz, below and above ``inside_hz`` where the gain of all passes is 3.01 dB down; NaN where it never
    is.

    sos : (sections, 6).
    """
    target = 0.5 ** (0.5 / passes)

    def edge(outside_hz: float) -> float:
        if gain(sos, outside_hz, fs_hz) >= target:
            return math.nan
        inside, outside = inside_hz, outside_hz
        for _ in range(60):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if gain(sos, middle, fs_hz) >= target else (inside, middle)
        return inside

    return edge(0.0), edge(fs_hz / 2)


def support_samples(sos: Floats, share: float = TRUNCATION) -> int:
    """Samples after which no more than a share of a start-up transient is left, from the slowest pole radius.

    sos : (sections, 6).
    """
    radius = max(float(np.max(np.abs(np.roots(section[3:])))) for section in sos)
    return math.ceil(math.log(share) / math.log(radius))


def default_pad_samples(sos: Floats) -> int:
    """Odd extension in samples that ``scipy.signal.sosfiltfilt`` puts at both ends by default. sos : (sections, 6)."""
    taps = 2 * sos.shape[0] + 1
    return 3 * int(taps - min(np.sum(sos[:, 2] == 0), np.sum(sos[:, 5] == 0)))
