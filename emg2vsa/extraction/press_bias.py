"""What each cause does to b of the presses of a recording: hum, moments left out, clipping, crosstalk, lag, zero."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints
from emg2vsa.extraction.cleaning import Cleaned
from emg2vsa.extraction.emg_record import EmgRecord
from emg2vsa.signals.bias import Cause, Shift, left_in, line_change, taken_out
from emg2vsa.signals.clipping import Rail, unclipped
from emg2vsa.signals.crosstalk import KNOWN_TO, without_crosstalk
from emg2vsa.signals.floor import floor_change, press_levels
from emg2vsa.signals.force import ForceRecord
from emg2vsa.signals.lag import DIFFERS_S, Lag, curve_of
from emg2vsa.signals.movement import change_by_disturbance
from emg2vsa.signals.pairing import Clock, Instants, force_at
from emg2vsa.signals.press_signals import by_press
from emg2vsa.signals.quality import MAINS_HZ

HUM_LEFT = 0.05
"Standard error of the correction for hum, as a share of it; what is seen to stay has its own share in the budget."
LAW_KNOWN_TO = 0.3
"Standard error of a correction for clipping, as a share of what lies between the two laws of amplitude."
TOO_LATE_S = 0.15
"Where clocks part by more, b is not known: force and activity hardly share the press."
ZERO_OFF = 0.6
"Standard error of the force in a press, as a share of how far its zero moves around it: it may be off by nearly all."


def of_hum(record: EmgRecord, clean: Cleaned, levels_v: Floats, force_n: Floats, instants: Instants) -> Iterator[Shift]:
    """What hum of the presses does to them, that which stays and that which was taken from ``record``.

    levels_v : (m, N) V and force_n : (N,) N at the instants.
    """
    # a mean rectified value is sqrt(2 / pi) of the rms
    if clean.touching_v.any():
        stays_v = np.sqrt(2 / np.pi) * clean.touching_v
        yield left_in("hum at the touch", *floor_change(levels_v, stays_v, force_n, instants.offsets))
    size = max(1, round(record.fs_hz / min(MAINS_HZ)))
    taken_v = np.zeros_like(levels_v)
    begin = np.maximum(instants.samples - size // 2, 0)
    for row, own, one in zip(taken_v, record.samples, clean.record.samples, strict=True):
        for at, of in zip(by_press(begin, instants.offsets), by_press(row, instants.offsets), strict=True):
            if own is not one and at.size:
                span = slice(at[0], at[-1] + size)
                power = np.concatenate(([0.0], np.cumsum((own[span] - one[span]) ** 2)))
                low, high = at - at[0], np.minimum(at - at[0] + size, power.size - 1)
                of[:] = np.sqrt(2 / np.pi / size * (power[high] - power[low]))
    if taken_v.any():
        _, hummed = floor_change(np.hypot(levels_v, taken_v), taken_v, force_n, instants.offsets)
        cause: Cause = "hum at the touch" if clean.taken_v.any() else "mains"
        yield taken_out(cause, hummed, HUM_LEFT * np.abs(hummed))


def of_moments(
    gone: Mapping[Cause, NDArray[np.bool_]], errors: Mapping[Cause, Floats], undisturbed_v: Floats, disturbed_v: Floats,
    force_n: Floats, levels_v: Floats, offsets: Ints,
) -> Iterator[Shift]:  # fmt: skip
    """What disturbances that last a moment had done to the presses: those whose envelopes are ``gone`` (N,), and gaps
    that a line bridges. Envelopes (m, N) with these and without; ``errors`` (p,) of b by bridging."""
    all_gone = np.any([*gone.values()], axis=0)
    without = undisturbed_v.sum(axis=0), ~all_gone
    for cause, own in gone.items():
        error = errors.get(cause, np.zeros(offsets.size - 1))
        if not (own.any() or error.any()):
            continue
        with_it_v = undisturbed_v.sum(axis=0)
        if cause != "contact artefact":
            bridged_too = own if cause == "lost samples" else ~gone["lost samples"]
            with_it_v = np.where(bridged_too, disturbed_v.sum(axis=0), with_it_v)
        disturbed = with_it_v, own | ~all_gone
        yield change_by_disturbance(cause, force_n, levels_v.sum(axis=0), offsets, disturbed, without, error)


def without_clipping(
    envelopes_v: Floats, rails: Sequence[Rail | None], force_n: Floats, offsets: Ints
) -> tuple[Floats, Shift]:
    """Envelopes (m, N) as without saturation, and what it had done to b."""
    levels_v = press_levels(envelopes_v, force_n, offsets)
    each = [rail and unclipped(row, rail) for row, rail in zip(levels_v, rails, strict=True)]
    unknown = any(rail and not one for rail, one in zip(rails, each, strict=True))
    laws = [one or (row, row, row) for one, row in zip(each, levels_v, strict=True)]
    own, gauss, laplace = np.moveaxis(np.array(laws), 1, 0)
    x, true = np.log(np.maximum(force_n, 1e-9)), own.sum(axis=0)
    read, by_gauss, by_laplace = (
        line_change(x, v.sum(axis=0), x, true, true, offsets)[1] for v in (levels_v, gauss, laplace)
    )
    error = LAW_KNOWN_TO * np.abs(by_gauss - by_laplace) + float(unknown)
    return envelopes_v * own / levels_v, taken_out("clipping", read, error)


def of_lag(
    lag: Lag,
    moved_s: float,
    stop_s: Floats,
    conditioned: ForceRecord,
    instants: Instants,
    emg_clock: Clock,
    force_clock: Clock,
    force_n: Floats,
    levels_v: Floats,
) -> Iterator[Shift]:
    """What the lag does to the presses where ``moved_s`` (s) of it was taken out: one lag of all, one that grows, and
    one that each press has of its own.

    stop_s : (p,) ends of the loading phases, s. force_n : (N,) N and levels_v : (m, N) V at the instants.
    """
    level = levels_v.sum(axis=0)
    left = lag if lag.certain and not moved_s else Lag(0.0, 0.0)

    def change(lag_s: float) -> tuple[Floats, Floats]:
        """Change of a and b where activity is paired with a force that is so late."""
        ahead = replace(force_clock, start_s=force_clock.start_s - lag_s)
        late_n = force_at(conditioned.force_n, instants, emg_clock, ahead)
        x, y = np.log(np.maximum(force_n, 1e-9)), np.log(np.maximum(late_n, 1e-9))
        read, true = curve_of(y, level, instants.offsets, (y, x))
        return line_change(x, read, x, true, level, instants.offsets)

    if lag.drift:
        own_s = lag.left_s(moved_s, stop_s)
        largest_s = float(np.abs(own_s).max())
        a, b = change(largest_s)
        error_s = np.hypot(lag.about_drift_s, lag.feigned_s)
        error = np.where(np.abs(own_s) > TOO_LATE_S, 1.0, np.abs(b) * error_s / largest_s)
        yield left_in("clock", a * own_s / largest_s, b * own_s / largest_s, error)
        return
    if left.lag_s:
        a, b = change(left.lag_s)
        yield left_in("lag", a, b, np.abs(b) * left.error_s / abs(left.lag_s))
    if moved_s:
        _, b = change(lag.error_s)
        yield left_in("lag", np.zeros(b.size), np.zeros(b.size), np.abs(b))
    # a lag that is not certain may be there all the same
    uncertain_s = 0.0 if lag.certain or lag.pieces < 2 else max(abs(lag.lag_s) - lag.feigned_s, 0.0)
    if (off_s := max(uncertain_s, lag.between_s if lag.between_s > DIFFERS_S else 0.0)) > 0:
        _, b = change(off_s)
        yield left_in("lag", np.zeros(b.size), np.zeros(b.size), np.abs(b))


def alone(
    envelopes_v: Floats,
    muscles: tuple[str, ...],
    heard: Mapping[str, Mapping[str, float]],
    force_n: Floats,
    offsets: Ints,
) -> tuple[Floats, Shift]:
    """Envelopes (m, N) without what each muscle hears of others, by the shares that the operator names, and what it had
    done to b."""
    own_v = press_levels(envelopes_v, force_n, offsets)
    envelopes_v, alone_v = without_crosstalk(envelopes_v, own_v, muscles, heard)
    x, true = np.log(np.maximum(force_n, 1e-9)), alone_v.sum(axis=0)
    _, change = line_change(x, own_v.sum(axis=0), x, true, true, offsets)
    return envelopes_v, taken_out("crosstalk", change, 2 * KNOWN_TO * np.abs(change))


def of_zero(zero_shift_n: Floats, force_n: Floats, levels_v: Floats, instants: Instants) -> Iterator[Shift]:
    """What a zero of force that moves by ``zero_shift_n`` (p,), N, around a press may do to it.

    force_n : (N,) N and levels_v : (m, N) V at the instants.
    """
    off_n = ZERO_OFF * np.repeat(np.nan_to_num(zero_shift_n), instants.counts)
    if off_n.any():
        force_n, level_v = np.maximum(force_n, 1e-9), levels_v.sum(axis=0)
        _, b = line_change(np.log(force_n), level_v, np.log(force_n + off_n), level_v, level_v, instants.offsets)
        yield left_in("zero of force", np.zeros(b.size), np.zeros(b.size), np.abs(b))
