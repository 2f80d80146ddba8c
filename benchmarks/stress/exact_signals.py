"""Filters and envelopes by their definitions in 50 digits: poles, bilinear transform, recursion, moving means."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from mpmath import mp, mpf

Section = tuple[Any, Any, Any, Any, Any]
"b0, b1, b2, a1, a2 with a0 = 1."


def butterworth(kind: str, order: int, edges_hz: Sequence[float], fs_hz: float, passes: int) -> list[Section]:
    """Sections of one pass, of which all ``passes`` together are 3.01 dB down at ``edges_hz``."""
    narrowing = (mpf(2) ** (mpf(1) / passes) - 1) ** (mpf(1) / (2 * order))
    warped = [mp.tan(mp.pi * mpf(edge) / mpf(fs_hz)) for edge in edges_hz]
    angles = [mp.pi * (2 * k + order + 1) / (2 * order) for k in range((order + 1) // 2)]
    poles = [mp.expj(angle) for angle in angles]
    real = order % 2
    sections = []
    for i, pole in enumerate(poles):
        alone = real and i == len(poles) - 1
        if kind == "band-pass":
            width, centre = (warped[1] - warped[0]) / narrowing, warped[0] * warped[1]
            if alone:
                sections.append(_digital((0, width, 0), (1, width, centre)))
                continue
            half = pole * width / 2
            root = mp.sqrt(half * half - centre)
            for s in (half + root, half - root):
                sections.append(_digital((0, width, 0), (1, -2 * s.real, abs(s) ** 2)))
            continue
        if kind == "low-pass":
            edge = warped[0] / narrowing
            top, top_alone = (0, 0, edge**2), (0, 0, edge)
        else:
            edge = warped[0] * narrowing
            top, top_alone = (1, 0, 0), (0, 1, 0)
        if alone:
            sections.append(_digital(top_alone, (0, 1, edge)))
        else:
            sections.append(_digital(top, (1, -2 * pole.real * edge, edge**2)))
    return sections


def _digital(numerator: Sequence[Any], denominator: Sequence[Any]) -> Section:
    """Analog polynomials in s, highest power first, by s = (1 - x) / (1 + x), x one sample back."""
    first_order = numerator[0] == 0 and denominator[0] == 0

    def of(c: Sequence[Any]) -> list[Any]:
        s2, s1, s0 = (mpf(each) for each in c)
        return [s1 + s0, s0 - s1, mpf(0)] if first_order else [s2 + s1 + s0, 2 * (s0 - s2), s2 - s1 + s0]

    b, a = of(numerator), of(denominator)
    return b[0] / a[0], b[1] / a[0], b[2] / a[0], a[1] / a[0], a[2] / a[0]


def filtered(samples: Sequence[Any], sections: Sequence[Section], pad: int, passes: int, gain_at_0: int) -> list[Any]:
    """All passes with the odd extension of ``pad`` samples, each from the steady state of its first sample."""
    x = [mp.mpf(value) for value in samples]
    n = len(x)
    rows = [2 * x[0] - x[i] for i in range(pad, 0, -1)] + x + [2 * x[-1] - x[-1 - i] for i in range(1, pad + 1)]
    for _ in range(passes):
        rows = _one_pass(rows, sections, gain_at_0)[::-1]
    if passes == 1:
        rows = rows[::-1]
    return rows[pad : pad + n]


def _one_pass(rows: list[Any], sections: Sequence[Section], gain_at_0: int) -> list[Any]:
    origin = rows[0]
    out = [value - origin for value in rows]
    for b0, b1, b2, a1, a2 in sections:
        x1 = x2 = y1 = y2 = mpf(0)
        done = []
        for value in out:
            y = b0 * value + b1 * x1 + b2 * x2 - a1 * y1 - a2 * y2
            x2, x1, y2, y1 = x1, value, y1, y
            done.append(y)
        out = done
    return [value + gain_at_0 * origin for value in out]


def hamming_low_pass(order: int, cutoff_hz: float, fs_hz: float) -> list[Any]:
    """Taps of unit sum: sinc under a Hamming window."""
    share, taps = 2 * mpf(cutoff_hz) / mpf(fs_hz), []
    for i in range(order + 1):
        at = mpf(i) - mpf(order) / 2
        window = mpf("0.54") - mpf("0.46") * mp.cos(2 * mp.pi * i / order)
        taps.append(share * mp.sincpi(share * at) * window)
    total = mp.fsum(taps)
    return [tap / total for tap in taps]


def smoothed(rows: Sequence[Any], taps: Sequence[Any], centres: Sequence[int], squared: bool) -> np.ndarray:
    """Mean of the magnitudes, or root of the mean of squares, under taps centred at samples well inside the record."""
    half = len(taps) // 2
    found = []
    for at in centres:
        inside = rows[at - half : at + half + 1]
        level = mp.fdot(taps, [value * value if squared else abs(value) for value in inside])
        found.append(mp.sqrt(level) if squared else level)
    return np.array(found, dtype=object)
