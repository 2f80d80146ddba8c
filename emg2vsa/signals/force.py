"""The force channel of a record: filtered, tared, and cut into presses; and whether its sign is right.

A reversed channel shows every release as a press.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints, median, slices
from emg2vsa.errors import SignalError
from emg2vsa.settings import ForceChannelSettings, WindowSettings
from emg2vsa.signals.filters import IirFilter
from emg2vsa.signals.quality import SILENT_DB, ratio_db, window_means
from emg2vsa.signals.rest import Rest, find_rest
from emg2vsa.signals.segmentation import Presses, find_presses
from emg2vsa.signals.windowed import filter_record

GAP_S = 2.0
"The level before contact is looked for this long before it."
REST_END_S = 0.3
"The zero of force at either end of a rest is a median over so long."
NOISE_REVERSAL = 4.0
"A reversal of force within so many standard deviations of its noise at rest is noise ..."
JUMP_WINDOWS, JUMP_TIMES, JUMP_SAMPLES = 50.0, 10.0, 5
"""A finger's force does not jump and return within so many samples by so many upper forces of the window, and so many
times what three quarters of the record lie within (a unit that is wrong makes all of it large)."""
SMALLEST_REVERSAL = 0.005
"... and so is one within this share of the force window."


@dataclass(frozen=True)
class ForceRecord:
    """force_n : (n,) tared and filtered. tare_n : median of what was subtracted. gap_n : (p,) level before each press,
    NaN if unknown. reversal_n : fall of force that is no more than noise. sign_doubt : of a record without presses.
    tare : as ``Trials.tare``. zero_shift_n : (p,) as ``Trials.zero_shift_n``."""

    force_n: Floats
    fs_hz: float
    rest: Rest
    presses: Presses
    tare_n: float
    gap_n: Floats
    reversal_n: float
    sign_doubt: str
    notes: tuple[str, ...]
    tare: str
    zero_shift_n: Floats


def condition_force(
    samples: Floats, fs_hz: float, low: IirFilter | None, channel: ForceChannelSettings, window: WindowSettings
) -> ForceRecord:
    """Filter the whole record (n,) of raw force, tare it on its rests, and find the presses. SignalError where force
    jumps as no transducer's does.

    Filter and window are those of paper IV.B.
    """
    refuse_jumps(samples, channel.name, window.force_n[1])
    filtered = samples if low is None else filter_record(samples, low)
    rest = find_rest(filtered, fs_hz, window)
    force_n, tare_n, notes = _tared(filtered, samples, fs_hz, rest, channel)
    presses = find_presses(force_n, fs_hz, window.force_n)
    noise_n = 0.0 if np.isnan(rest.noise_n) else NOISE_REVERSAL * rest.noise_n
    reversal_n = max(noise_n, SMALLEST_REVERSAL * (window.force_n[1] - window.force_n[0]))
    gap_n = _gaps(force_n, fs_hz, presses) if rest.level_n.size else np.full(presses.start_s.size, np.nan)
    doubt = "" if presses.start_s.size else _doubt_by_force(force_n, window.force_n, channel.sign)
    notes = (*notes, *_said_of_presses(presses, force_n, window))
    tare = channel.tare if channel.tare == "none" or rest.level_n.size else "impossible"
    shift_n = _zero_shifts(rest, force_n, fs_hz, presses) if tare == "rest" else np.full(presses.start_s.size, np.nan)
    return ForceRecord(force_n, fs_hz, rest, presses, tare_n, gap_n, reversal_n, doubt, notes, tare, shift_n)


def refuse_jumps(samples: Floats, name: str, upper_n: float) -> None:
    """SignalError where samples of raw force (n,) stand out by more than a transducer holds: glued readings."""
    largest = float(np.ptp(samples)) if samples.size else 0.0
    if largest <= JUMP_WINDOWS * upper_n:
        return
    limit = max(JUMP_WINDOWS * upper_n, JUMP_TIMES * float(np.quantile(np.abs(samples - np.median(samples)), 0.75)))
    steps = np.diff(samples)
    large = np.flatnonzero(np.abs(steps) > limit)
    back = (np.diff(large) <= JUMP_SAMPLES) & (np.diff(np.sign(steps[large])) != 0)
    n = int(np.count_nonzero(back))
    if not n:
        return
    largest = float(np.abs(steps[large]).max())
    raise SignalError(
        f"channel {name!r}", wanted=f"a force that changes by less than {JUMP_WINDOWS * upper_n:g} N within a sample",
        found=f"{n} jump{'s' * (n != 1)} of up to {largest:.2g} N and back, as where two readings are glued together",
        do="Export the recording again, or correct the lines in which a number is missing or too long.",
    )  # fmt: skip


def _tared(
    filtered: Floats, samples: Floats, fs_hz: float, rest: Rest, channel: ForceChannelSettings
) -> tuple[Floats, float, tuple[str, ...]]:
    """Force (n,) less its rests, their median, and what is said; in the place of ``filtered``, unless that is the raw
    ``samples`` themselves."""
    if channel.tare == "none":
        return filtered, 0.0, ("force: not tared, as the study says",)
    if rest.level_n.size == 0:
        return filtered, 0.0, ("force: tare impossible, the record never rests; force is taken as it is",)
    tare_n, drift_n = median(rest.level_n), float(np.ptp(rest.level_n))
    rests = "1 rest" if rest.level_n.size == 1 else f"{rest.level_n.size} rests"
    said = f"force: tared on {rests}, median {tare_n:.4g} N, drift {drift_n:.2g} N"
    tared = np.empty_like(filtered) if filtered is samples else filtered
    for part in slices(filtered.size):
        np.subtract(filtered[part], rest.baseline.at(np.arange(part.start, part.stop) / fs_hz), out=tared[part])
    return tared, tare_n, (said,)


def _zero_shifts(rest: Rest, force_n: Floats, fs_hz: float, presses: Presses) -> Floats:
    """How far (p,) the rest after each press is from where the rest before it led, newtons; NaN without both.

    A drift or a slow wave leads to the next rest by the slopes that the rests themselves show. A step within a rest
    does not: the end of the rest before, or the beginning of that after, is then off the tare.
    """
    shifts = np.full(presses.start_s.size, np.nan)
    if rest.level_n.size < 2:
        return shifts
    centre_s = (rest.start + rest.stop) / 2 / fs_hz
    change_n, lasts_s = np.diff(rest.level_n), np.diff(centre_s)
    size, pair = rest.stop - rest.start, np.stack((rest.slope[:-1], rest.slope[1:]))
    # the slope of a rest that is far shorter than its neighbour is rough, and leads nowhere
    pair = np.where([size[:-1] * 2 < size[1:], size[1:] * 2 < size[:-1]], pair[::-1], pair)
    led = np.abs(change_n - pair.mean(axis=0) * lasts_s)
    after = np.searchsorted(centre_s, presses.start_s)
    known = (after > 0) & (after < centre_s.size)
    end = max(1, round(REST_END_S * fs_hz))
    before_n = np.array([median(force_n[max(a, b - end) : b]) for a, b in zip(rest.start, rest.stop, strict=True)])
    after_n = np.array([median(force_n[a : min(b, a + end)]) for a, b in zip(rest.start, rest.stop, strict=True)])
    off_n = np.maximum(np.abs(before_n[:-1]), np.abs(after_n[1:]))
    shifts[known] = np.maximum(led, off_n)[after[known] - 1]
    return shifts


def _gaps(force_n: Floats, fs_hz: float, presses: Presses) -> Floats:
    """Lower quartile of the force between the release before and each contact, over at most ``GAP_S``."""
    released = np.concatenate(([0.0], presses.release_s))[: presses.start_s.size]
    gaps = np.full(released.size, np.nan)
    for i, (after_s, before_s) in enumerate(zip(released, presses.start_s, strict=True)):
        piece = force_n[int(max(after_s, before_s - GAP_S) * fs_hz) : int(before_s * fs_hz)]
        if piece.size >= 0.3 * fs_hz:
            ordered = np.sort(piece[:: max(1, round(fs_hz / 50))])
            gaps[i] = ordered[ordered.size // 4]
    return gaps


def _said_of_presses(presses: Presses, force_n: Floats, window: WindowSettings) -> tuple[str, ...]:
    lower_n, upper_n = window.force_n
    n = presses.start_s.size
    notes = []
    if window.expected_trials is not None and n != window.expected_trials:
        notes.append(f"presses: {n} found, {window.expected_trials} expected")
    if presses.touches:
        notes.append(f"presses: light touches of the specimen, not counted: {presses.touches}")
    if presses.skipped:
        notes.append("presses: the record begins above the window or while force falls; that press is not counted")
    if n == 0:
        reach = f"{force_n.min():.3g} to {force_n.max():.3g} N"
        notes.append(f"presses: none; tared force goes from {reach}, the window is {lower_n:g} to {upper_n:g} N")
    return tuple(notes)


def doubt_by_emg(
    force_n: Floats,
    envelopes_v: Floats,
    offsets: Ints,
    rest_v: Floats,
    window_n: tuple[float, float],
    sign: int,
) -> str:
    """Why the ``sign`` of the force seems wrong by what the muscles do, or "".

    Force (N,) and envelopes (m, N) of the presses that ``offsets`` cut; rest_v : (m,) envelopes at rest. Pressing takes
    EMG. Where in the upper half of the force window at least one muscle is below its rest and none above it, both by
    more than ``SILENT_DB`` and in the median of the presses, the rest was the press.
    """
    high = (force_n > sum(window_n) / 2).astype(np.float64)
    with np.errstate(invalid="ignore"):
        high_v = window_means(envelopes_v * high, offsets) / window_means(high[None], offsets)
    known = [row[np.isfinite(row)] for row in ratio_db(high_v, rest_v[:, None])]
    typical_db = [median(row) for row in known if row.size]
    if not typical_db or min(typical_db) > -SILENT_DB or max(typical_db) > SILENT_DB:
        return ""
    return f"force rises while EMG is below its rest; {_question(sign)}"


def _doubt_by_force(force_n: Floats, window_n: tuple[float, float], sign: int) -> str:
    """Why the ``sign`` of the tared force (n,) of a record without presses seems wrong, or ""."""
    if -force_n.min() < window_n[1] or force_n.max() >= window_n[1]:
        return ""
    return f"force goes down to {force_n.min():.3g} N and up to {force_n.max():.3g} N only; {_question(sign)}"


def _question(sign: int) -> str:
    """What to ask of whoever wrote the study."""
    return f"is its sign {-sign}?"
