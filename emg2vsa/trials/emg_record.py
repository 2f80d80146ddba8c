"""The EMG channels of one record, brought together and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, bridge_gaps, samples_1d
from emg2vsa.errors import SignalError
from emg2vsa.recordings import Channel


@dataclass(frozen=True)
class EmgRecord:
    """The EMG channels of one record, (n,) each in volts, and where they were interpolated."""

    muscles: tuple[str, ...]
    samples: tuple[Floats, ...]
    missing: tuple[NDArray[np.bool_], ...]
    fs_hz: float
    start_s: float


def where_of(channel: Channel) -> str:
    """The channel, as an error names it."""
    return f"channel {channel.name!r}"


def emg_record(emg: Mapping[str, Channel]) -> EmgRecord:
    """All channels at the rate and start of the first, cut to the shortest."""
    if not emg:
        raise SignalError("EMG", wanted="at least one channel", found="none", do="Name the channel of a muscle.")
    first = next(iter(emg.values()))
    for channel in emg.values():
        if abs(channel.fs_hz - first.fs_hz) > 1e-6 * first.fs_hz or abs(channel.start_s - first.start_s) > 1e-6:
            raise SignalError(
                where_of(channel),
                wanted=f"{first.fs_hz:g} Hz from {first.start_s:g} s, as {where_of(first)}",
                found=f"{channel.fs_hz:g} Hz from {channel.start_s:g} s",
                do="Choose EMG channels of one sensor system.",
            )
    n = min(channel.samples.size for channel in emg.values())
    bridged = [bridge_gaps(samples_1d(c.samples, where_of(c), at_least=2)[:n], where_of(c)) for c in emg.values()]
    samples, missing = zip(*bridged, strict=True)
    return EmgRecord(tuple(emg), samples, missing, first.fs_hz, first.start_s)
