"""Filters at extreme edges, offsets and scales; envelopes; the edges of presses."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from mpmath import mp

from benchmarks.stress.case import Case, Found, exactly
from benchmarks.stress.exact_signals import butterworth, filtered, hamming_low_pass, smoothed
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.envelope import envelopes_at, smoother
from emg2vsa.signals.filters import band_pass, force_low_pass
from emg2vsa.signals.segmentation import find_presses
from emg2vsa.signals.windowed import filter_record

N = 360
LONGEST = 12_000
"Samples of a record: four periods of the edge where that is less."


def cases() -> Iterator[Case]:
    yield from _low_passes()
    yield from _band_passes()
    yield from _envelopes()
    yield from _presses()


def noise(n: int = N, slow: float = 1 / 120) -> np.ndarray:
    """White noise on a sine of ``slow`` periods a sample and one of 3 % of that: amplitudes near 1."""
    phase = 2 * np.pi * slow * np.arange(n)
    return np.random.default_rng(1).standard_normal(n) / 5 + np.sin(phase) + np.cos(phase / 30)


def _low_passes() -> Iterator[Case]:
    worlds = (
        # edge/fs, offset, scale, order, phase, bound, smoke
        (5e-3, 0.0, 1.0, 2, "zero-phase", 12.0, True),
        (5e-3, 1e6, 1.0, 2, "zero-phase", 9.0, True),
        (5e-3, 1e9, 1.0, 2, "zero-phase", 6.0, True),
        (5e-3, 0.0, 1e-300, 2, "zero-phase", 12.0, False),
        (5e-3, 0.0, 1e300, 2, "zero-phase", 12.0, False),
        (0.25, 0.0, 1.0, 4, "causal", 14.0, False),
        (0.49, 0.0, 1.0, 2, "zero-phase", 13.0, True),
        (0.49, 0.0, 1.0, 8, "zero-phase", 12.0, False),
        (0.1, 0.0, 1.0, 8, "zero-phase", 13.0, False),
        (1e-2, 0.0, 1.0, 8, "zero-phase", 10.0, False),
        (1e-3, 0.0, 1.0, 2, "zero-phase", 11.0, False),
        (5e-4, 1e4, 1.0, 2, "zero-phase", 10.0, False),
        (1e-4, 0.0, 1.0, 2, "zero-phase", 8.0, False),
        (1e-4, 1e6, 1.0, 2, "causal", 8.0, False),
        (2e-5, 0.0, 1.0, 2, "zero-phase", 6.0, False),
        (1e-5, 0.0, 1.0, 2, "zero-phase", 6.0, False),
        (1e-6, 0.0, 1.0, 1, "zero-phase", 6.0, False),
        (1e-6, 0.0, 1.0, 2, "zero-phase", 6.0, True),
    )
    for share, offset, scale, order, phase, bound, smoke in worlds:
        yield low_pass_case(share, offset, scale, order, phase, bound, smoke)
    single = (noise() * 1.5).astype(np.float32)
    yield low_pass_case(5e-3, 0.0, 1.0, 2, "zero-phase", 12.0, True, single)


def low_pass_case(
    share: float,
    offset: float,
    scale: float,
    order: int,
    phase: str,
    bound: float,
    smoke: bool,
    samples: np.ndarray | None = None,
) -> Case:
    """Low-pass at ``share`` of the rate; the error is a share of the signal without its offset."""
    fs_hz = 1000.0
    settings = FilterSettings(force_cutoff_hz=share * fs_hz, force_order=order, phase=phase)  # type: ignore[arg-type]
    n = min(max(N, round(4 / share)), LONGEST)
    given = scale * (noise(n, share / 2) + offset) if samples is None else samples
    passes, cutoff = (2 if phase == "zero-phase" else 1), share * fs_hz

    def ours(x: np.ndarray) -> Found:
        iir = force_low_pass(settings, fs_hz)
        assert iir is not None
        return Found({"samples": filter_record(x, iir)}, _warned(iir.notes))

    def exact(x: np.ndarray) -> dict[str, Any]:
        sections = butterworth("low-pass", order, [cutoff], fs_hz, passes)
        pad = 3 * (2 * len(sections) + 1 - (order % 2)) if passes == 2 else 0
        return {"samples": filtered([exactly(v) for v in x], sections, pad, passes, 1)}

    kind = " float32" if samples is not None else ""
    world = f"{share:g} fs, order {order}, {phase}, offset {offset:g}, scale {scale:g}{kind}"
    return Case(
        "signals.filters, low-pass",
        world,
        (given,),
        ours,
        exact,
        bound,
        size=float(scale),
        condition=float(np.log10(1 + abs(offset))),
        must_say=order > 1 and share <= 1e-4,
        smoke=smoke,
    )


def _band_passes() -> Iterator[Case]:
    worlds = (
        # band, fs, order, offset, bound, smoke
        ((10.0, 450.0), 1000.0, 2, 0.0, 12.0, True),
        ((10.0, 450.0), 1000.0, 2, 1e6, 9.0, True),
        ((20.0, 450.0), 50e3, 2, 1e6, 9.0, False),
        ((10.0, 499.9), 1000.0, 2, 0.0, 11.0, False),
        ((10.0, 500.0), 1000.0, 2, 1e6, 9.0, False),
        ((49.0, 51.0), 1000.0, 8, 0.0, 8.0, False),
        ((49.999, 50.001), 1000.0, 2, 0.0, 8.0, False),
        ((0.1, 450.0), 1000.0, 2, 1e6, 7.0, False),
        ((0.01, 50.0), 20e3, 2, 1e3, 7.0, True),
        ((10.0, 450.0), 1000.0, 8, 0.0, 9.0, False),
    )
    for band, fs_hz, order, offset, bound, smoke in worlds:
        yield band_pass_case(band, fs_hz, order, offset, bound, smoke)


def band_pass_case(
    band: tuple[float, float], fs_hz: float, order: int, offset: float, bound: float, smoke: bool
) -> Case:
    """Band-pass forward and backward."""
    settings = FilterSettings(band_hz=band, band_order=order)

    def ours(x: np.ndarray) -> Found:
        iir = band_pass(settings, fs_hz)
        return Found({"samples": filter_record(x, iir)}, _warned(iir.notes))

    def exact(x: np.ndarray) -> dict[str, Any]:
        kind, edges = ("band-pass", list(band)) if band[1] < fs_hz / 2 else ("high-pass", [band[0]])
        sections = butterworth(kind, order, edges, fs_hz, 2)
        return {"samples": filtered([exactly(v) for v in x], sections, 3 * (2 * len(sections) + 1), 2, 0)}

    return Case(
        "signals.filters, band-pass",
        f"{band[0]:g} to {band[1]:g} Hz at {fs_hz:g} Hz, order {order}, offset {offset:g}",
        (noise() + offset,),
        ours,
        exact,
        bound,
        size="largest",
        condition=float(np.log10(1 + abs(offset))),
        smoke=smoke,
    )


def _warned(notes: tuple[str, ...]) -> str:
    """Of a filter's notes, those beyond its description."""
    return "; ".join(note for note in notes if "true -3 dB" not in note)


def _envelopes() -> Iterator[Case]:
    for envelope, scale, offset, bound, smoke in (
        ("fir", 1e-5, 0.0, 12.0, True),
        ("fir", 1.0, 1e6, 9.0, False),
        ("fir", 1e-300, 0.0, 12.0, False),
        ("fir", 1e300, 0.0, 12.0, False),
        ("rms", 1e-5, 0.0, 12.0, True),
        ("rms", 1.0, 1e6, 9.0, False),
        ("rms", 1e-200, 0.0, 12.0, True),
        ("rms", 1e200, 0.0, 12.0, True),
        ("rms", 1e-300, 0.0, 12.0, False),
    ):
        yield envelope_case(envelope, scale, offset, bound, smoke)


def envelope_case(envelope: str, scale: float, offset: float, bound: float, smoke: bool) -> Case:
    """Envelope of one window of band-passed noise, 5 instants."""
    fs_hz, step = 1000.0, 10
    settings = FilterSettings(envelope=envelope)  # type: ignore[arg-type]
    centres = list(range(150, 200, step))
    white = np.random.default_rng(2).standard_normal(N)

    def ours(x: np.ndarray) -> Found:
        iir, kernel = band_pass(settings, fs_hz), smoother(settings, fs_hz, step)
        found = envelopes_at((x,), np.array([centres[0]]), np.array([len(centres)]), step, iir, kernel)
        return Found({"envelope": found[0]})

    def exact(x: np.ndarray) -> dict[str, Any]:
        sections = butterworth("band-pass", 2, [10.0, 450.0], fs_hz, 2)
        rows = filtered([exactly(v) for v in x], sections, 3 * (2 * len(sections) + 1), 2, 0)
        rms = envelope == "rms"
        taps = [mp.mpf(1) / 101] * 101 if rms else hamming_low_pass(50, 20.0, fs_hz)
        return {"envelope": smoothed(rows, taps, centres, rms)}

    return Case(
        f"signals.envelope, {envelope}",
        f"scale {scale:g}, offset {offset:g} x signal",
        (scale * (white + offset),),
        ours,
        exact,
        bound,
        condition=float(np.log10(1 + offset)),
        smoke=smoke,
    )


def _presses() -> Iterator[Case]:
    for offset, scale, bound, smoke in (
        (0.0, 1.0, 13.0, True),
        (1e6, 1.0, 8.0, True),
        (0.0, 1e-300, 13.0, False),
        (0.0, 1e300, 13.0, False),
        (1e9, 1.0, 5.0, False),
    ):
        yield press_case(offset, scale, bound, smoke)


def press_case(offset: float, scale: float, bound: float, smoke: bool) -> Case:
    """Edges of one press in a force that lies on an offset, and a window that lies there too."""
    fs_hz, at = 1000.0, np.arange(400.0)
    force = scale * (8 * np.sin(np.pi * at / 400) ** 2 + offset)
    window = (scale * (0.5 + offset), scale * (7.0 + offset))

    def ours(x: np.ndarray) -> Found:
        found = find_presses(x, fs_hz, window)
        return Found({"start_s": found.start_s, "stop_s": found.stop_s})

    def exact(x: np.ndarray) -> dict[str, Any]:
        values, edges = [exactly(v) for v in x], []
        for level in window:
            after = next(i for i, value in enumerate(values) if value >= level)
            low, high = values[after - 1], values[after]
            edges.append((after - (high - level) / (high - low)) / int(fs_hz))
        return {"start_s": [edges[0]], "stop_s": [edges[1]]}

    return Case(
        "signals.segmentation.find_presses",
        f"offset {offset:g} N, scale {scale:g}",
        (force,),
        ours,
        exact,
        bound,
        smoke=smoke,
    )
