"""The stage from signals to trials: conditioned EMG and force of every press in a recording, each with its verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, bridge_gaps, samples_1d
from emg2vsa.errors import SignalError
from emg2vsa.recordings import Channel
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.cocontraction import cocontraction_index
from emg2vsa.signals.delays import DelayBudget, delay_budget
from emg2vsa.signals.envelope import Smoother, decimation, envelopes_at, smoother
from emg2vsa.signals.filters import IirFilter, band_pass, force_low_pass
from emg2vsa.signals.force import ForceRecord, condition_force
from emg2vsa.signals.pairing import Clock, Instants, force_at, instants_between, rest_instants
from emg2vsa.signals.quality import RawQuality, falling_share, ratio_db, raw_quality, window_means
from emg2vsa.signals.verdicts import Evidence, judge

OVERVIEW_HZ = 10.0


@dataclass(frozen=True)
class Trials:
    """The presses of one recording in time order; (n,) unless said, times on the recording's clock.

    Rejected trials stay. ``offsets`` cuts the ragged arrays: trial i is ``[offsets[i]:offsets[i + 1]]``.
    """

    participant: str
    specimen: str
    muscles: tuple[str, ...]
    repetition: Ints
    "From 1, in time order."
    start_s: Floats
    "Last rise through the lower force before the upper force is first reached."
    stop_s: Floats
    "First reach of the upper force; of a press that never reaches it, its peak."
    duration_s: Floats
    peak_force_n: Floats
    falling_share: Floats
    "Share of the force path between start and stop that falls, noise left out."
    snr_db: Floats
    "Mean envelope over that of the rest, of the muscle with the lowest; NaN without a rest."
    verdict: NDArray[np.str_]
    "ok, warned or rejected."
    reasons: tuple[str, ...]
    fs_hz: float
    "Rate of the ragged arrays."
    offsets: Ints
    "(n + 1,)"
    force_n: Floats
    "(N,) tared and filtered, at the instants of the envelopes."
    activity: Floats
    "(N,) co-contraction, in ``activity_unit``."
    envelopes_v: Floats
    "(muscles, N) volts."
    activity_unit: str
    "V, or 1 for normalised and ratio indices."
    rest_force_n: float
    "Median of the tare that was subtracted."
    rest_envelope_v: Floats
    "(muscles,) envelope at rest; NaN without a rest."
    mains_ratio: Floats
    "(muscles,) largest share of power at the mains in any trial."
    clip_share: Floats
    "(muscles,) largest share of clipped samples in any trial."
    overview_time_s: Floats
    "(k,) about 10 Hz over the whole record."
    overview_force_n: Floats
    "(k,) tared, filtered force."
    delay: DelayBudget
    notes: tuple[str, ...]
    "What was run and must be said: Nyquist rule, true -3 dB frequencies, delays, conversions, tare, presses."


@dataclass(frozen=True)
class _Emg:
    """The EMG channels of one record, (n,) each in volts, and where they were interpolated."""

    muscles: tuple[str, ...]
    samples: tuple[Floats, ...]
    missing: tuple[NDArray[np.bool_], ...]
    fs_hz: float
    start_s: float


def extract_trials(
    emg: Mapping[str, Channel],
    force: Channel,
    *,
    participant: str,
    specimen: str,
    filters: FilterSettings,
    cocontraction: CocontractionSettings,
    window: WindowSettings,
    force_channel: ForceChannelSettings,
    notes: tuple[str, ...] = (),
) -> Trials:
    """Condition one continuous recording and find its trials (paper IV.B).

    emg : volts by muscle, all at one rate. force : newtons, untared, at any rate and start. Force is filtered over the
    whole record; EMG only inside loading phases, a few pieces of rest, and the support of its filters around them.
    Force is interpolated onto the instants of the envelopes. Missing samples are interpolated, and reject the trials
    that hold them. SignalError, SettingError: channels too short, of unequal rates, or filters that cannot be built.
    """
    low = force_low_pass(filters, force.fs_hz)
    record = _emg_channels(emg)
    step = decimation(record.fs_hz, filters.output_fs_hz)
    band, envelope = band_pass(filters, record.fs_hz), smoother(filters, record.fs_hz, step)
    _check_length(record, band, envelope)
    delay, shifts = delay_budget(filters.phase, band, envelope, low, force_channel.delay_s)

    at_least = 4 if low is None else max(4, low.pad_samples + 1)
    raw_n, force_missing = bridge_gaps(samples_1d(force.samples, _where(force), at_least=at_least), _where(force))
    conditioned = condition_force(raw_n, force.fs_hz, low, force_channel.tare, window)
    emg_clock = Clock(record.start_s - shifts.emg_s, record.fs_hz, record.samples[0].size)
    force_clock = Clock(force.start_s - shifts.force_s, force.fs_hz, raw_n.size)

    presses = conditioned.presses
    start_s, stop_s = presses.start_s + force_clock.start_s, presses.stop_s + force_clock.start_s
    instants = instants_between(start_s, stop_s, emg_clock, force_clock, step)
    force_n = force_at(conditioned.force_n, instants, emg_clock, force_clock)
    envelopes_v = envelopes_at(record.samples, instants.first, instants.counts, step, band, envelope)
    activity, unit, said = cocontraction_index(envelopes_v, record.muscles, cocontraction)

    resting = rest_instants(conditioned.rest, emg_clock, force_clock, step)
    rest_v = _rest_level(envelopes_at(record.samples, resting.first, resting.counts, step, band, envelope), resting)
    snr_db = ratio_db(window_means(envelopes_v, instants.offsets), rest_v[:, None])
    quality = _raw_quality(record, instants, envelope)
    evidence = _evidence(conditioned, instants, force_n, force_missing, quality, snr_db, record)
    verdicts = [judge(trial, window) for trial in evidence]

    every = max(1, round(force.fs_hz / OVERVIEW_HZ))
    return Trials(
        participant=participant,
        specimen=specimen,
        muscles=record.muscles,
        repetition=np.arange(1, start_s.size + 1),
        start_s=start_s,
        stop_s=stop_s,
        duration_s=stop_s - start_s,
        peak_force_n=presses.peak_n,
        falling_share=np.array([trial.falling_share for trial in evidence], dtype=np.float64),
        snr_db=snr_db.min(axis=0),
        verdict=np.array([verdict for verdict, _ in verdicts], dtype="<U8"),
        reasons=tuple(reasons for _, reasons in verdicts),
        fs_hz=record.fs_hz / step,
        offsets=instants.offsets,
        force_n=force_n,
        activity=activity,
        envelopes_v=envelopes_v,
        activity_unit=unit,
        rest_force_n=conditioned.tare_n,
        rest_envelope_v=rest_v,
        mains_ratio=np.array([max((q.mains_ratio for q in row), default=0.0) for row in quality]),
        clip_share=np.array([max((q.clip_share for q in row), default=0.0) for row in quality]),
        overview_time_s=force_clock.time_s(np.arange(0, raw_n.size, every)),
        overview_force_n=conditioned.force_n[::every].copy(),
        delay=delay,
        notes=(
            *notes,
            *(f"{role}: {channel.conversion}" for role, channel in (*emg.items(), ("force", force))),
            *band.notes,
            *envelope.notes,
            *(("force: not filtered, as the study says",) if low is None else low.notes),
            str(delay),
            *conditioned.notes,
            *said,
        ),
    )


def _where(channel: Channel) -> str:
    return f"channel {channel.name!r}"


def _emg_channels(emg: Mapping[str, Channel]) -> _Emg:
    """All channels at the rate and start of the first, cut to the shortest."""
    if not emg:
        raise SignalError("EMG", wanted="at least one channel", found="none", do="Name the channel of a muscle.")
    first = next(iter(emg.values()))
    for channel in emg.values():
        if abs(channel.fs_hz - first.fs_hz) > 1e-6 * first.fs_hz or abs(channel.start_s - first.start_s) > 1e-6:
            raise SignalError(
                _where(channel),
                wanted=f"{first.fs_hz:g} Hz from {first.start_s:g} s, as {_where(first)}",
                found=f"{channel.fs_hz:g} Hz from {channel.start_s:g} s",
                do="Choose EMG channels of one sensor system.",
            )
    n = min(channel.samples.size for channel in emg.values())
    bridged = [bridge_gaps(samples_1d(c.samples, _where(c), at_least=2)[:n], _where(c)) for c in emg.values()]
    samples, missing = zip(*bridged, strict=True)
    return _Emg(tuple(emg), samples, missing, first.fs_hz, first.start_s)


def _check_length(record: _Emg, band: IirFilter, envelope: Smoother) -> None:
    n, needed = record.samples[0].size, max(band.pad_samples + 1, envelope.taps.size)
    if n < needed:
        found, do = f"{n}", "Record for longer, or shorten the envelope's kernel."
        raise SignalError("EMG", wanted=f"at least {needed} samples for its filters", found=found, do=do)


def _rest_level(envelopes_v: Floats, resting: Instants) -> Floats:
    """Median over the pieces of rest of the mean envelope (m,); NaN without any."""
    if resting.counts.size == 0:
        return np.full(len(envelopes_v), np.nan)
    return np.asarray(np.median(window_means(envelopes_v, resting.offsets), axis=1))


def _raw_quality(record: _Emg, instants: Instants, envelope: Smoother) -> list[list[RawQuality]]:
    """Quality by muscle and trial, of all raw samples under the envelope's kernel."""
    starts = np.maximum(instants.first - envelope.before, 0)
    stops = instants.last + envelope.after + 1
    return [
        [raw_quality(samples[i:j], gone[i:j], record.fs_hz) for i, j in zip(starts, stops, strict=True)]
        for samples, gone in zip(record.samples, record.missing, strict=True)
    ]


def _evidence(
    force: ForceRecord,
    instants: Instants,
    force_n: Floats,
    force_missing: NDArray[np.bool_],
    quality: list[list[RawQuality]],
    snr_db: Floats,
    record: _Emg,
) -> list[Evidence]:
    presses, offsets = force.presses, instants.offsets
    missing_until = np.concatenate(([0], np.cumsum(force_missing)))
    fs_hz = force.fs_hz
    evidence = []
    for i, (start_s, stop_s) in enumerate(zip(presses.start_s, presses.stop_s, strict=True)):
        curve_n = force_n[offsets[i] : offsets[i + 1]]
        begin, end = int(start_s * fs_hz), min(int(np.ceil(stop_s * fs_hz)) + 1, force_missing.size)
        evidence.append(
            Evidence(
                duration_s=float(stop_s - start_s),
                peak_force_n=float(presses.peak_n[i]),
                reached=bool(presses.reached[i]),
                at_edge=bool(presses.at_edge[i]),
                covered=bool(instants.covered[i]),
                force_missing=int(missing_until[end] - missing_until[begin]),
                falling_share=falling_share(curve_n, force.reversal_n),
                rest_gap_n=float(force.gap_n[i]),
                start_force_n=float(force.force_n[begin]),
                emg_fs_hz=record.fs_hz,
                emg={muscle: row[i] for muscle, row in zip(record.muscles, quality, strict=True)},
                snr_db=dict(zip(record.muscles, snr_db[:, i].tolist(), strict=True)),
            )
        )
    return evidence
