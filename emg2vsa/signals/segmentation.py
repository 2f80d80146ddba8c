"""Every loading phase in a continuous record of force, the failed ones too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, finite, runs_of

SAME_CONTACT_S = 0.25
"A press that fails this close to one that succeeds is part of it: force dipped, or bounced on release."
SHORTEST_S = 0.02
"No finger loads a specimen within a shorter time: such a peak is counted as a touch."
ATTEMPT_SHARE = 0.2
"A press that rises less than this share of the way from lower to upper force is a touch: counted, not a trial."


@dataclass(frozen=True)
class Presses:
    """Loading phases in time order; times in seconds from the first sample, interpolated between samples.

    start_s, stop_s : (p,) last rise through the lower force, and first reach of the upper one (failed: the peak).
    release_s : (p,) return below the lower force. peak_n : (p,) highest force before it. reached : (p,) upper force.
    at_edge : (p,) the record begins inside the window, or ends before the press was over.
    touches : contacts too light to be a press. skipped : 1 where the record begins above the upper force or falling.
    """

    start_s: Floats
    stop_s: Floats
    release_s: Floats
    peak_n: Floats
    reached: NDArray[np.bool_]
    at_edge: NDArray[np.bool_]
    touches: int
    skipped: int


@dataclass(frozen=True)
class _Press:
    start_s: float
    stop_s: float
    contact_s: float
    release_s: float
    peak_n: float
    reached: bool
    at_edge: bool


def find_presses(force_n: Floats, fs_hz: float, window_n: tuple[float, float]) -> Presses:
    """Presses in the tared, filtered force (n,), N, n >= 2: from the last rise through ``window_n[0]`` before the first
    reach of ``window_n[1]``, to that reach (paper IV.B). SignalError where force is not finite."""
    lower_n, upper_n = window_n
    starts, stops = runs_of(finite(force_n, "force to find presses in", at_least=2) >= lower_n)
    found: list[_Press] = []
    touches = skipped = 0
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        press = _press(force_n, fs_hz, start, stop, window_n)
        if press is None:
            skipped += 1
        elif press.stop_s - press.start_s < SHORTEST_S or press.peak_n < lower_n + ATTEMPT_SHARE * (upper_n - lower_n):
            touches += 1
        else:
            found.append(press)
    kept = _without_partial(found)
    return Presses(
        start_s=np.array([p.start_s for p in kept], dtype=np.float64),
        stop_s=np.array([p.stop_s for p in kept], dtype=np.float64),
        release_s=np.array([p.release_s for p in kept], dtype=np.float64),
        peak_n=np.array([p.peak_n for p in kept], dtype=np.float64),
        reached=np.array([p.reached for p in kept], dtype=np.bool_),
        at_edge=np.array([p.at_edge for p in kept], dtype=np.bool_),
        touches=touches,
        skipped=skipped,
    )


def _press(force_n: Floats, fs_hz: float, start: int, stop: int, window_n: tuple[float, float]) -> _Press | None:
    """The press that stays at or above the lower force in [start, stop); None where it has no loading phase."""
    lower_n, upper_n = window_n
    contact = force_n[start:stop]
    peak = int(np.argmax(contact))
    reached = bool(contact[peak] >= upper_n)
    reach = int(np.argmax(contact >= upper_n)) if reached else peak
    if start == 0 and reach == 0:
        return None
    start_s = _rise(force_n, start, lower_n) / fs_hz if start else 0.0
    stop_at = _rise(force_n, start + reach, upper_n) if reached else float(start + reach)
    open_end = stop == force_n.size and not reached and start + reach == stop - 1
    return _Press(
        start_s, stop_at / fs_hz, start / fs_hz, stop / fs_hz, float(contact[peak]), reached, start == 0 or open_end
    )


def _rise(force_n: Floats, after: int, level_n: float) -> float:
    """Fractional sample at which force rises through the level, between ``after - 1`` and ``after``."""
    low, high = force_n[after - 1], force_n[after]
    return float(after - (high - level_n) / (high - low))


def _without_partial(presses: list[_Press]) -> list[_Press]:
    """Without failed presses that belong to a neighbour: to a successful one, or to a failed one that rose higher."""
    kept: list[_Press] = []
    for press in presses:
        if kept and press.contact_s - kept[-1].release_s < SAME_CONTACT_S:
            before = kept[-1]
            if not before.reached and (press.reached or press.peak_n > before.peak_n):
                kept[-1] = press
                continue
            if not press.reached:
                continue
        kept.append(press)
    return kept
