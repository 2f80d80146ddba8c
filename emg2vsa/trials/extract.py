"""The making of trials: condition one continuous recording, find its presses, judge each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, bridge_gaps, median, samples_1d
from emg2vsa.errors import SignalError
from emg2vsa.recordings import Channel
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.cocontraction import cocontraction_index
from emg2vsa.signals.delays import delay_budget
from emg2vsa.signals.envelope import Smoother, decimation, envelopes_at, smoother
from emg2vsa.signals.filters import IirFilter, band_pass, force_low_pass
from emg2vsa.signals.force import ForceRecord, condition_force
from emg2vsa.signals.force_sign import doubt_by_emg
from emg2vsa.signals.pairing import Clock, Instants, force_at, instants_between, rest_instants
from emg2vsa.signals.quality import ratio_db, window_means
from emg2vsa.signals.verdicts import judge
from emg2vsa.trials import Trials
from emg2vsa.trials.emg_record import EmgRecord, emg_record, where_of
from emg2vsa.trials.evidence import gather_evidence, record_qualities

OVERVIEW_HZ = 10.0


@dataclass(frozen=True)
class Chain:
    """What is run on one record: EMG band-pass and envelope, every ``step``-th sample kept; force low-pass or none."""

    band: IirFilter
    envelope: Smoother
    step: int
    low: IirFilter | None

    def envelopes(self, record: EmgRecord, pressing: Instants, resting: Instants) -> tuple[Floats, Floats]:
        """Envelopes (m, N) in volts, computed at the instants of either only."""
        first, counts = np.append(pressing.first, resting.first), np.append(pressing.counts, resting.counts)
        both = envelopes_at(record.samples, first, counts, self.step, self.band, self.envelope)
        n_pressing = pressing.offsets[-1]
        return both[:, :n_pressing].copy(), both[:, n_pressing:]


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
    record = emg_record(emg)
    chain = _chain(filters, record, force.fs_hz)
    delay, shifts = delay_budget(filters.phase, chain.band, chain.envelope, chain.low, force_channel.delay_s)
    conditioned, force_missing = _conditioned(force, chain.low, force_channel, window)
    emg_clock = Clock(record.start_s - shifts.emg_s, record.fs_hz, record.samples[0].size)
    force_clock = Clock(force.start_s - shifts.force_s, force.fs_hz, force_missing.size)
    presses = conditioned.presses
    start_s, stop_s = presses.start_s + force_clock.start_s, presses.stop_s + force_clock.start_s
    instants = instants_between(start_s, stop_s, emg_clock, force_clock, chain.step)
    force_n = force_at(conditioned.force_n, instants, emg_clock, force_clock)

    resting = rest_instants(conditioned.rest, emg_clock, force_clock, chain.step)
    envelopes_v, resting_v = chain.envelopes(record, instants, resting)
    activity, unit, said = cocontraction_index(envelopes_v, record.muscles, cocontraction)
    rest_v = _rest_level(resting_v, resting)
    snr_db = ratio_db(window_means(envelopes_v, instants.offsets), rest_v[:, None])
    quality = record_qualities(record, instants, chain.envelope)
    doubt = conditioned.sign_doubt or doubt_by_emg(
        force_n, envelopes_v, instants.offsets, rest_v, window.force_n, force_channel.sign
    )
    evidence = gather_evidence(conditioned, instants, force_n, force_missing, quality, snr_db, record, doubt)
    verdicts = [judge(trial, window) for trial in evidence]
    said += (doubt,) if doubt else ()
    every = max(1, round(force.fs_hz / OVERVIEW_HZ))
    conversions = (f"{role}: {channel.conversion}" for role, channel in (*emg.items(), ("force", force)))
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
        fs_hz=record.fs_hz / chain.step,
        offsets=instants.offsets,
        force_n=force_n,
        activity=activity,
        envelopes_v=envelopes_v,
        activity_unit=unit,
        rest_force_n=conditioned.tare_n,
        rest_envelope_v=rest_v,
        mains_ratio=np.array([max((q.mains_ratio for q in row), default=0.0) for row in quality]),
        clip_share=np.array([max((q.clip_share for q in row), default=0.0) for row in quality]),
        overview_time_s=force_clock.time_s(np.arange(0, force_missing.size, every)),
        overview_force_n=conditioned.force_n[::every].copy(),
        delay=delay,
        notes=(*notes, *conversions, *_filter_notes(chain), str(delay), *conditioned.notes, *said),
        sign_doubt=doubt,
    )


def _chain(filters: FilterSettings, record: EmgRecord, force_fs_hz: float) -> Chain:
    """The filters, designed for these rates; SignalError where the EMG is too short for them."""
    step = decimation(record.fs_hz, filters.output_fs_hz)
    band, envelope = band_pass(filters, record.fs_hz), smoother(filters, record.fs_hz, step)
    n, needed = record.samples[0].size, max(band.pad_samples + 1, envelope.taps.size)
    if n < needed:
        found, do = f"{n}", "Record for longer, or shorten the envelope's kernel."
        raise SignalError("EMG", wanted=f"at least {needed} samples for its filters", found=found, do=do)
    return Chain(band, envelope, step, force_low_pass(filters, force_fs_hz))


def _conditioned(
    force: Channel, low: IirFilter | None, force_channel: ForceChannelSettings, window: WindowSettings
) -> tuple[ForceRecord, NDArray[np.bool_]]:
    """The force record, and which of its samples (n,) were missing."""
    at_least = 4 if low is None else max(4, low.pad_samples + 1)
    raw_n, missing = bridge_gaps(samples_1d(force.samples, where_of(force), at_least=at_least), where_of(force))
    return condition_force(raw_n, force.fs_hz, low, force_channel, window), missing


def _rest_level(envelopes_v: Floats, resting: Instants) -> Floats:
    """Median over the pieces of rest of the mean envelope (m,); NaN without any."""
    if resting.counts.size == 0:
        return np.full(len(envelopes_v), np.nan)
    return np.array([median(means) for means in window_means(envelopes_v, resting.offsets)])


def _filter_notes(chain: Chain) -> tuple[str, ...]:
    force = ("force: not filtered, as the study says",) if chain.low is None else chain.low.notes
    return (*chain.band.notes, *chain.envelope.notes, *force)
