"""The EMG of a recording without hum, spikes and gaps, and what was found on the way."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.extraction.emg_record import Chain, EmgRecord
from emg2vsa.recordings import Channel
from emg2vsa.settings import FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.force import ForceRecord
from emg2vsa.signals.gaps import Bridged, bridge
from emg2vsa.signals.hum import remove_hum, remove_touch_hum, touch_hum
from emg2vsa.signals.lag import Lag, estimate_lag
from emg2vsa.signals.movement import movement
from emg2vsa.signals.pairing import Clock, rest_samples
from emg2vsa.signals.verdicts import HELD_SHARE

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
    conditioned: ForceRecord,
    chain: Chain,
    filters: FilterSettings,
    force_channel: ForceChannelSettings,
    window: WindowSettings,
) -> Cleaned:
    """The EMG of a recording without its hum, and what was found on the way."""
    late_s = 0.0 if chain.low is None else chain.low.delay_s
    force_clock = Clock(force.start_s - force_channel.delay_s - late_s, force.fs_hz, conditioned.force_n.size)
    emg_clock = Clock(record.start_s, record.fs_hz, record.samples[0].size)
    said: list[str] = []
    presses = conditioned.presses
    edges = [np.clip(emg_clock.index(edge_s + force_clock.start_s), 0, emg_clock.n_samples).astype(np.int64)
             for edge_s in (presses.start_s, presses.stop_s)]  # fmt: skip
    gaps = bridge(record.samples, record.missing, record.fs_hz, np.stack(edges, axis=-1))
    samples, hum = gaps.samples, None
    force_at = partial(_force_at, force_n=conditioned.force_n, emg=emg_clock, force=force_clock)
    start, stop = rest_samples(conditioned.rest, emg_clock, force_clock)
    if filters.mains == "remove" or filters.rest_level == "subtract":
        removing = filters.mains == "remove"
        samples, hum = remove_hum(
            samples, record.fs_hz, start, stop, (edges[0], edges[1]),
            lambda at: force_at(at) > TOUCHED * window.force_n[0], only_absent=not removing,
        )  # fmt: skip
        if hum is not None and removing:
            shown = ", ".join(f"{muscle} {1e6 * v:.3g} uV" for muscle, v in zip(record.muscles, hum.rms, strict=True))
            orders = ", ".join(map(str, hum.harmonics.tolist()))
            said.append(f"mains: {hum.hz:.2f} Hz, harmonics {orders}, fitted at rest and subtracted: {shown} rms")
        if hum is not None and hum.absent.size:
            orders = ", ".join(map(str, hum.absent.tolist()))
            said.append(f"mains: harmonics {orders} change when the specimen is touched, subtracted at rest only")
    hum_hz = hum.hz if hum else None
    taken_v = np.zeros(len(samples))
    if filters.mains == "remove":
        samples, taken_v = remove_touch_hum(samples, record.fs_hz, edges[0], edges[1], hum_hz, force_at)
        if taken_v.any():
            shown = ", ".join(f"{muscle} {1e6 * v:.3g} uV" for muscle, v in zip(record.muscles, taken_v, strict=True))
            said.append(f"mains: hum while the specimen is touched, fitted in each press and subtracted: {shown} rms")
    # where nothing was taken, the same test of the same samples has just found none
    asked = filters.mains != "remove" or taken_v.any()
    touching_v = touch_hum(samples, record.fs_hz, edges[0], edges[1], hum_hz) if asked else taken_v
    if touching_v.any():
        # hum of the rests that stays is part of the rest level
        touching_v = np.sqrt(
            np.maximum(touching_v**2 - touch_hum(samples, record.fs_hz, start, stop, hum_hz) ** 2, 0.0)
        )
    stop_s = conditioned.presses.stop_s + force_clock.start_s
    moved = movement(gaps.samples, record.fs_hz, np.stack(edges, axis=-1), np.stack((start, stop), axis=-1))
    moved = [
        spans[[np.mean(absent[first:last]) < HELD_SHARE for first, last in spans.tolist()]] if absent.any() else spans
        for spans, absent in zip(moved, record.missing, strict=True)
    ]  # a line over a gap that is known is no movement
    lag = estimate_lag(samples, emg_clock, conditioned.force_n, force_clock, window.force_n[0], stop_s, moved)
    found = f"lag: force follows EMG by {1e3 * lag.lag_s:.0f} ms, "
    if lag.pieces > 1:
        said.append(f"{found}standard error {1e3 * lag.error_s:.0f} ms, {1e3 * lag.se_s:.0f} ms of it between presses")
    else:
        said.append(f"{found}by one press" if lag.pieces else "lag: not known")
    if filters.align == "lag" and not lag.certain:
        said.append("lag: not certain, force is not moved")
    return Cleaned(replace(record, samples=samples), lag, touching_v, taken_v, moved, gaps, tuple(said))


def _force_at(samples: Ints, force_n: Floats, emg: Clock, force: Clock) -> Floats:
    """Force (k,) at successive samples (k,) of the EMG, of that (n,) on its own clock."""
    at = force.index(emg.time_s(samples))
    low = min(max(int(at[0]), 0), force.n_samples - 1)
    high = min(max(int(at[-1]) + 2, low + 1), force.n_samples)
    return np.interp(at, np.arange(low, high), force_n[low:high])
