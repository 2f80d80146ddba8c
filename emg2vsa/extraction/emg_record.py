"""The EMG channels of one recording on one clock, and the filters that are run on them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, bridge_gaps, samples_1d
from emg2vsa.errors import SignalError
from emg2vsa.recordings import Channel
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.envelope import Smoother, decimation, envelopes_at, smoother
from emg2vsa.signals.filters import IirFilter, band_pass, force_low_pass
from emg2vsa.signals.pairing import Clock, Instants, band_limited_at


@dataclass(frozen=True)
class EmgRecord:
    """The EMG channels of one record, (n,) each in volts, and where they were interpolated.

    native : the channels at their own rates, by which they are judged; () where these are equal.
    """

    muscles: tuple[str, ...]
    samples: tuple[Floats, ...]
    missing: tuple[NDArray[np.bool_], ...]
    fs_hz: float
    start_s: float
    native: tuple[Native, ...] = ()


def where_of(channel: Channel) -> str:
    """The channel, as an error names it."""
    return f"channel {channel.name!r}"


def emg_record(emg: Mapping[str, Channel]) -> EmgRecord:
    """All channels on the clock of the fastest, where all were recorded.

    A channel of that rate and start stays as it is; the samples of any other are interpolated by band-limited
    interpolation, which changes nothing below 0.9 of half its own rate.
    SignalError : no channel, or channels without time in common.
    """
    if not emg:
        raise SignalError("EMG", wanted="at least one channel", found="none", do="Name the channel of a muscle.")
    native = {role: native_of(channel) for role, channel in emg.items()}
    fastest = max(emg.values(), key=lambda channel: channel.fs_hz)
    alike = [
        abs(c.fs_hz - fastest.fs_hz) <= 1e-6 * fastest.fs_hz and abs(c.start_s - fastest.start_s) <= 1e-6
        for c in emg.values()
    ]
    if all(alike):
        n = min(own.samples.size for own in native.values())
        samples = tuple(own.samples[:n] for own in native.values())
        missing = tuple(own.missing[:n] for own in native.values())
        return EmgRecord(tuple(emg), samples, missing, fastest.fs_hz, fastest.start_s)
    start_s = max(own.start_s for own in native.values())
    stop_s = min(own.start_s + (own.samples.size - 1) / own.fs_hz for own in native.values())
    first = int(np.ceil((start_s - fastest.start_s) * fastest.fs_hz - 1e-9))
    last = int(np.floor((stop_s - fastest.start_s) * fastest.fs_hz + 1e-9))
    if last - first < 1:
        raise SignalError(
            "EMG", wanted="channels with time in common", found=f"none from {start_s:g} s to {stop_s:g} s",
            do="Choose channels of one recording.",
        )  # fmt: skip
    clock = Clock(fastest.start_s + first / fastest.fs_hz, fastest.fs_hz, last - first + 1)
    on_clock = [own.on(clock, same) for own, same in zip(native.values(), alike, strict=True)]
    return EmgRecord(
        tuple(emg), tuple(samples for samples, _ in on_clock), tuple(missing for _, missing in on_clock), clock.fs_hz,
        clock.start_s, tuple(native.values()),
    )  # fmt: skip


@dataclass(frozen=True)
class Native:
    """A channel as it was recorded, (n,) volts, and where it was interpolated for want of samples."""

    samples: Floats
    missing: NDArray[np.bool_]
    fs_hz: float
    start_s: float

    def index(self, time_s: Floats) -> Floats:
        """Index (n,), not whole, of times (n,), s, in the channel as it was recorded."""
        return np.asarray((time_s - self.start_s) * self.fs_hz, dtype=np.float64)

    def on(self, clock: Clock, same: bool) -> tuple[Floats, NDArray[np.bool_]]:
        """Samples (n,) and what is missing (n,) on a clock of n samples; ``same``: it is the channel's own, from a
        later sample on."""
        position = self.index(clock.time_s(np.arange(clock.n_samples)))
        nearest = np.clip(np.rint(position).astype(np.int64), 0, self.samples.size - 1)
        samples = self.samples[nearest] if same else band_limited_at(self.samples, position)
        return samples, self.missing[nearest]


def native_of(channel: Channel) -> Native:
    where = where_of(channel)
    samples, missing = bridge_gaps(samples_1d(channel.samples, where, at_least=2), where)
    return Native(samples, missing, channel.fs_hz, channel.start_s)


@dataclass(frozen=True)
class Chain:
    """What is run on one record: EMG band-pass and envelope, every ``step``-th sample kept; force low-pass or none."""

    band: IirFilter
    envelope: Smoother
    step: int
    low: IirFilter | None

    @property
    def notes(self) -> tuple[str, ...]:
        """What must be said of the filters."""
        force = ("force: not filtered, as the study says",) if self.low is None else self.low.notes
        return (*self.band.notes, *self.envelope.notes, *force)

    def envelopes(self, record: EmgRecord, pressing: Instants, resting: Instants) -> tuple[Floats, Floats]:
        """Envelopes (m, N) in volts (paper IV.B), computed at the instants of either only."""
        first, counts = np.append(pressing.first, resting.first), np.append(pressing.counts, resting.counts)
        both = envelopes_at(record.samples, first, counts, self.step, self.band, self.envelope)
        n_pressing = pressing.offsets[-1]
        return both[:, :n_pressing].copy(), both[:, n_pressing:]

    def whole(self, record: EmgRecord) -> Floats:
        """Envelopes (m, N) in volts (paper IV.B) of the whole record."""
        counts = np.array([(record.samples[0].size - 1) // self.step + 1])
        return envelopes_at(record.samples, np.zeros(1, np.int64), counts, self.step, self.band, self.envelope)


def filter_chain(filters: FilterSettings, record: EmgRecord, force_fs_hz: float) -> Chain:
    """The filters, designed for the rates of EMG and force, Hz; SignalError where the EMG is too short for them."""
    step = decimation(record.fs_hz, filters.output_fs_hz)
    band, envelope = band_pass(filters, record.fs_hz), smoother(filters, record.fs_hz, step)
    n, needed = record.samples[0].size, max(band.pad_samples + 1, envelope.taps.size)
    if n < needed:
        found, do = f"{n}", "Record for longer, or shorten the envelope's kernel."
        raise SignalError("EMG", wanted=f"at least {needed} samples for its filters", found=found, do=do)
    return Chain(band, envelope, step, force_low_pass(filters, force_fs_hz))
