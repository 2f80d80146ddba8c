"""The EMG of a recording without hum, spikes and gaps, and what was found on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, runs_of
from emg2vsa.extraction.emg_record import Chain, EmgRecord
from emg2vsa.recordings import Channel
from emg2vsa.settings import FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.force import ForceRecord
from emg2vsa.signals.gaps import Bridged, bridge
from emg2vsa.signals.hum import remove_hum, remove_touch_hum, touch_hum
from emg2vsa.signals.lag import Lag, estimate_lag
from emg2vsa.signals.movement import movement
from emg2vsa.signals.pairing import Clock, rest_samples
from emg2vsa.signals.segmentation import Presses
from emg2vsa.signals.verdicts import HELD_SHARE

SMEARED_S = 0.1
"Steps of activity remember so much of a gap."
TOUCHED = 0.1
"The finger is on the specimen above this share of the window's lower force."


class Cleaned(NamedTuple):
    """The EMG without its hum; the lag of force behind it; rms (m,) of the hum that presses still hold beside that of
    the rests, and of what was taken from them; spans in which each electrode moves; gaps; and what is said."""

    record: EmgRecord
    lag: Lag
    touching_v: Floats
    taken_v: Floats
    moved: list[Ints]
    gaps: Bridged
    said: tuple[str, ...]


def cleaned(
    record: EmgRecord,
    force: Channel,
    force_missing: NDArray[np.bool_],
    conditioned: ForceRecord,
    chain: Chain,
    filters: FilterSettings,
    force_channel: ForceChannelSettings,
    window: WindowSettings,
) -> Cleaned:
    """The EMG of a recording without its hum, and what was found on the way.

    force_missing : (n,) samples of force that were interpolated. conditioned : force of the whole record, its presses
        and rests.
    """
    late_s = 0.0 if chain.low is None else chain.low.delay_s
    force_clock = Clock(force.start_s - force_channel.delay_s - late_s, force.fs_hz, conditioned.force_n.size)
    emg_clock = Clock(record.start_s, record.fs_hz, record.samples[0].size)
    presses = conditioned.presses
    edges_s = np.stack((presses.start_s, presses.stop_s), axis=-1) + force_clock.start_s
    edges = np.clip(emg_clock.index(edges_s), 0, emg_clock.n_samples).astype(np.int64)
    gaps = bridge(record.samples, record.missing, record.fs_hz, edges)
    rests = np.stack(rest_samples(conditioned.rest, emg_clock, force_clock), axis=-1)
    force_at = partial(_force_at, force_n=conditioned.force_n, emg=emg_clock, force=force_clock)
    hum = _without_hum(replace(record, samples=gaps.samples), edges, rests, force_at, filters, window)
    moved = movement(gaps.samples, record.fs_hz, edges, rests)
    moved = [
        spans[[np.mean(absent[first:last]) < HELD_SHARE for first, last in spans.tolist()]] if len(spans) else spans
        for spans, absent in zip(moved, record.missing, strict=True)
    ]  # a line over a gap that is known is no movement
    unheard_s = _unheard_s(record, force_missing, presses, emg_clock, force_clock, window)
    lag = estimate_lag(
        hum.samples, emg_clock, conditioned.force_n, force_clock, window.force_n[0], edges_s[:, 1], moved, unheard_s
    )
    said = (*hum.said, *_said_of_lag(lag, filters))
    return Cleaned(replace(record, samples=hum.samples), lag, hum.touching_v, hum.taken_v, moved, gaps, said)


class _Hum(NamedTuple):
    """Samples (n,) by muscle without it; as in ``Cleaned``."""

    samples: tuple[Floats, ...]
    touching_v: Floats
    taken_v: Floats
    said: list[str]


def _without_hum(
    record: EmgRecord, presses: Ints, rests: Ints, force_at: Callable[[Ints], Floats], filters: FilterSettings,
    window: WindowSettings,
) -> _Hum:  # fmt: skip
    """Presses (p, 2) and rests (r, 2) of a record without hum. force_at : N, at successive samples (k,)."""
    samples, hum, said, removing = record.samples, None, list[str](), filters.mains == "remove"
    (begin, end), (start, stop) = presses.T, rests.T
    if removing or filters.rest_level == "subtract":
        samples, hum = remove_hum(
            samples, record.fs_hz, start, stop, (begin, end), lambda at: force_at(at) > TOUCHED * window.force_n[0],
            only_absent=not removing,
        )  # fmt: skip
    if hum is not None and removing:
        orders = ", ".join(map(str, hum.harmonics.tolist()))
        shown = _rms(record.muscles, hum.rms)
        said.append(f"mains: {hum.hz:.2f} Hz, harmonics {orders}, fitted at rest and subtracted: {shown} rms")
    if hum is not None and hum.absent.size:
        orders = ", ".join(map(str, hum.absent.tolist()))
        said.append(f"mains: harmonics {orders} change when the specimen is touched, subtracted at rest only")
    hum_hz = hum.hz if hum else None
    taken_v = np.zeros(len(samples))
    if removing:
        samples, taken_v = remove_touch_hum(samples, record.fs_hz, begin, end, hum_hz, force_at)
        if taken_v.any():
            shown = _rms(record.muscles, taken_v)
            said.append(f"mains: hum while the specimen is touched, fitted in each press and subtracted: {shown} rms")
    # where nothing was taken, the same test of the same samples has just found none
    asked = not removing or taken_v.any()
    touching_v = touch_hum(samples, record.fs_hz, begin, end, hum_hz) if asked else taken_v
    if touching_v.any():
        # hum of the rests that stays is part of the rest level
        resting_v = touch_hum(samples, record.fs_hz, start, stop, hum_hz)
        touching_v = np.sqrt(np.maximum(touching_v**2 - resting_v**2, 0.0))
    return _Hum(samples, touching_v, taken_v, said)


def _rms(muscles: tuple[str, ...], rms_v: Floats) -> str:
    return ", ".join(f"{muscle} {1e6 * v:.3g} uV" for muscle, v in zip(muscles, rms_v, strict=True))


def _said_of_lag(lag: Lag, filters: FilterSettings) -> Iterator[str]:
    found = f"lag: force follows EMG by {1e3 * lag.lag_s:.0f} ms, "
    if lag.pieces > 1:
        yield f"{found}standard error {1e3 * lag.error_s:.0f} ms, {1e3 * lag.se_s:.0f} ms of it between presses"
    else:
        yield f"{found}by one press" if lag.pieces else "lag: not known"
    if filters.align == "lag" and not lag.certain:
        yield "lag: not certain, force is not moved"


def _unheard_s(
    record: EmgRecord, force_missing: NDArray[np.bool_], presses: Presses, emg: Clock, force: Clock,
    window: WindowSettings,
) -> Floats:  # fmt: skip
    """(k, 2) when gaps and presses that are rejected are: of the lag of force they say nothing."""
    spans = [np.empty((0, 2))]
    for absent, clock in ((np.any(record.missing, axis=0), emg), (force_missing, force)):
        begin_s, end_s = (clock.time_s(at) for at in runs_of(absent))
        spans.append(np.stack((begin_s - SMEARED_S, end_s + SMEARED_S), axis=-1))
    start_s, stop_s = presses.start_s + force.start_s, presses.stop_s + force.start_s
    lasted_s, gaps_s = stop_s - start_s, np.concatenate(spans)
    shared_s = np.minimum(gaps_s[:, 1], stop_s[:, None]) - np.maximum(gaps_s[:, 0], start_s[:, None])
    good = presses.reached & (lasted_s > window.min_duration_s) & (lasted_s < window.max_duration_s)
    good &= np.maximum(shared_s, 0).sum(axis=1) <= HELD_SHARE * lasted_s
    if np.count_nonzero(good) > 2:
        cuts_s = np.concatenate(([-np.inf], (stop_s[:-1] + start_s[1:]) / 2, [np.inf]))
        spans.append(np.stack((cuts_s[:-1], cuts_s[1:]), axis=-1)[~good])
    return np.concatenate(spans)


def _force_at(samples: Ints, force_n: Floats, emg: Clock, force: Clock) -> Floats:
    """Force (k,) at successive samples (k,) of the EMG, of that (n,) on its own clock."""
    at = force.index(emg.time_s(samples))
    low = min(max(int(at[0]), 0), force.n_samples - 1)
    high = min(max(int(at[-1]) + 2, low + 1), force.n_samples)
    return np.interp(at, np.arange(low, high), force_n[low:high])
