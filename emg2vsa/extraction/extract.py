"""The making of trials: condition one continuous recording, find its presses, judge each on what was measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, bridge_gaps, samples_1d
from emg2vsa.extraction import Trials
from emg2vsa.extraction.cleaning import Cleaned, cleaned
from emg2vsa.extraction.emg_record import Chain, EmgRecord, emg_record, filter_chain, where_of
from emg2vsa.extraction.evidence import (
    gather_evidence,
    record_qualities,
    said_of_bias,
    said_of_held,
    said_of_movement,
    said_of_overload,
)
from emg2vsa.extraction.press_bias import of_hum, of_lag, of_moments, of_zero
from emg2vsa.extraction.press_envelopes import PressEnvelopes, Timeline, press_envelopes, timeline
from emg2vsa.extraction.rests import rests_differ, rests_heard, tension
from emg2vsa.recordings import Channel
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.bias import BiasBudget, Cause, left_in, taken_out
from emg2vsa.signals.cocontraction import cocontraction_index
from emg2vsa.signals.filters import IirFilter
from emg2vsa.signals.floor import floor_change, floor_over_muscle
from emg2vsa.signals.force import ForceRecord, condition_force, doubt_by_emg
from emg2vsa.signals.force_doubts import exchanged, returns_to_zero, sampled_slowly
from emg2vsa.signals.lag import Lag
from emg2vsa.signals.level_drift import level_drift, level_trends
from emg2vsa.signals.overview import EmgOverview, emg_overview
from emg2vsa.signals.plausibility import LARGE_LAG_S, force_unit_doubt
from emg2vsa.signals.quality import RawQuality, ratio_db, window_means
from emg2vsa.signals.traits import Traits, traits_of
from emg2vsa.signals.verdicts import Evidence, judge

OVERVIEW_HZ = 10.0
LARGE_CORRECTION = 0.05
"A press whose b is corrected by a larger share says so: the correction rests on the hand being at rest."
TONE_CORRECTION = 0.02
"... and where the rests differ, which muscle tone does and noise does not, above this share."
NOISY = 0.5
"""Relative error of the correction for the rest level where the rest has the power of the muscles: 1 % of b at a third
of it (15 uV), and at twice of it (40 uV), where b came out 20 to 50 % too low, a third of b."""


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

    emg : volts by muscle, force : newtons, untared; each at any rate and start. Force is filtered over the whole
    record; EMG only inside loading phases, a few pieces of rest, and the support of its filters around them. Force is
    interpolated onto the instants of the envelopes. Missing samples are interpolated, and many reject the trials that
    hold them. SignalError, SettingError: channels too short or without time in common, or filters that cannot be built.
    """
    raw = emg_record(emg)
    chain = filter_chain(filters, raw, force.fs_hz)
    conditioned, force_missing, misread, slowly = _conditioned(force, raw, chain.low, force_channel, window)
    conditioned = replace(conditioned, rest=rests_heard(conditioned.rest, force.start_s, force.fs_hz, raw))
    force = replace(force, samples=np.empty(0))  # of a long record much, where the caller holds them no longer
    clean = cleaned(raw, force, force_missing, conditioned, chain, filters, force_channel, window)
    times = timeline(clean, conditioned, force, force_missing.size, chain, filters, force_channel)
    found = press_envelopes(raw, clean, chain, times, conditioned.rest, filters, cocontraction)
    bias = _bias(raw, clean, conditioned, times, found, filters.rest_level == "subtract")
    envelopes_v = np.where(found.all_gone, np.nan, found.envelopes_v)
    activity, unit, fused = cocontraction_index(envelopes_v, raw.muscles, cocontraction)
    fault, remarks = _channel_fault(misread, slowly, conditioned, times, found, force_channel, window)
    said = _said_of_presses(force, conditioned, clean, times, found, bias, raw.fs_hz / chain.step, window)
    quality, evidence = _evidence(raw, chain, conditioned, force_missing, times, found, fault, said)
    verdicts = [judge(trial, window) for trial in evidence]
    overview = emg_overview(raw.samples, raw.fs_hz, times.emg.start_s, found.signals.presses, found.signals.rests)
    every = max(1, round(force.fs_hz / OVERVIEW_HZ))
    conversions = (f"{role}: {channel.conversion}" for role, channel in (*emg.items(), ("force", force)))
    return Trials(
        participant=participant, specimen=specimen, muscles=raw.muscles,
        repetition=np.arange(1, times.start_s.size + 1), start_s=times.start_s, stop_s=times.stop_s,
        duration_s=times.stop_s - times.start_s, peak_force_n=conditioned.presses.peak_n,
        snr_db=np.array([[*trial.snr_db.values()] for trial in evidence]).reshape(-1, len(raw.muscles)).min(axis=1),
        falling_share=np.array([trial.falling_share for trial in evidence], dtype=np.float64),
        verdict=np.array([verdict for verdict, _ in verdicts], dtype="<U8"),
        reasons=tuple(reasons for _, reasons in verdicts),
        fs_hz=raw.fs_hz / chain.step, offsets=times.instants.offsets, force_n=times.force_n, activity=activity,
        envelopes_v=envelopes_v, activity_unit=unit, rest_force_n=conditioned.tare_n, rest_envelope_v=found.rest_v,
        mains_ratio=np.array([max((q.mains_ratio for q in row), default=0.0) for row in quality]),
        clip_share=np.array([max((q.clip_share for q in row), default=0.0) for row in quality]),
        overview_time_s=times.force.time_s(np.arange(0, force_missing.size, every)),
        overview_force_n=conditioned.force_n[::every].copy(),
        delay=times.delay, lag_s=clean.lag.lag_s, lag_se_s=clean.lag.se_s, bias=bias,
        notes=(*notes, *conversions, *chain.notes, str(times.delay), *conditioned.notes, *clean.said, *fused,
               *filter(None, (fault,))),
        traits=_traits(raw, conditioned, clean.lag, times, found, overview), tare=conditioned.tare,
        zero_shift_n=conditioned.zero_shift_n, fault=fault, remarks=() if fault else remarks,
        rates_hz=(*(channel.fs_hz for channel in emg.values()), force.fs_hz), overviews=(overview,),
    )  # fmt: skip


def _conditioned(
    force: Channel, emg: EmgRecord, low: IirFilter | None, force_channel: ForceChannelSettings, window: WindowSettings
) -> tuple[ForceRecord, NDArray[np.bool_], str, tuple[str, ...]]:
    """The force record, which of its samples (n,) were missing, and what is wrong and odd with it as a channel."""
    at_least = 4 if low is None else max(4, low.pad_samples + 1)
    raw_n, missing = bridge_gaps(samples_1d(force.samples, where_of(force), at_least=at_least), where_of(force))
    misread = exchanged(raw_n, force.fs_hz, emg.muscles, emg.samples, emg.fs_hz)
    settles = returns_to_zero(raw_n, force.fs_hz)
    slowly = tuple(sampled_slowly(raw_n, force.fs_hz))
    found = condition_force(raw_n, force.fs_hz, low, force_channel, window)
    if settles and found.sign_doubt and not returns_to_zero(-raw_n, force.fs_hz):
        settles = ""  # of the wrong sign, rests look like presses
    return found, missing, misread or settles, slowly


def _bias(
    raw: EmgRecord, clean: Cleaned, conditioned: ForceRecord, times: Timeline, found: PressEnvelopes, subtract: bool
) -> BiasBudget:
    """What each cause had done, or still does, to b of each press. subtract : the rest level is taken out."""
    force_n, levels_v, instants = times.force_n, found.levels_v, times.instants
    floor_a, floor_b = floor_change(levels_v, found.floor_v, force_n, instants.offsets)
    over_muscle = floor_over_muscle(levels_v, found.floor_v, instants.offsets)
    errors: dict[Cause, Floats] = {"spikes and bursts": clean.gaps.spiked, "lost samples": clean.gaps.missed}
    return BiasBudget.of(
        [
            taken_out("rest level", floor_b, np.abs(floor_b) * np.hypot(found.floor_error, NOISY * over_muscle))
            if subtract else left_in("rest level", floor_a, floor_b),
            *of_hum(replace(raw, samples=clean.gaps.samples), clean, levels_v, force_n, instants),
            *found.shifts,
            level_drift(found.envelopes_v, instants.offsets, *level_trends(found.envelopes_v, instants.offsets)),
            *of_moments(
                found.gone, errors, found.undisturbed_v, found.disturbed_v, force_n, levels_v, instants.offsets
            ),
            *of_zero(conditioned.zero_shift_n, force_n, levels_v, instants),
            *of_lag(
                clean.lag, times.moved_s, times.stop_s, conditioned, instants, times.emg, times.force, force_n, levels_v
            ),
        ],
        times.start_s.size,
    )  # fmt: skip


def _channel_fault(
    misread: str, slowly: tuple[str, ...], conditioned: ForceRecord, times: Timeline, found: PressEnvelopes,
    force_channel: ForceChannelSettings, window: WindowSettings,
) -> tuple[str, tuple[str, ...]]:  # fmt: skip
    """What is wrong with a whole channel, "" for nothing, and what is odd about it."""
    doubt = conditioned.sign_doubt or doubt_by_emg(
        times.force_n, found.measured_v, times.instants.offsets, found.rest_v, window.force_n, force_channel.sign
    )
    implausible = misread or force_unit_doubt(conditioned.force_n, window.force_n) or found.seen.fault
    rejects = window.implausible == "reject"
    # a channel that is not the force it should be is the cause of whatever sign or unit it seems to have
    fault = (implausible if rejects and (misread or not doubt) else "") or doubt
    told = () if rejects or not implausible else (implausible,)
    return fault, (*told, *slowly, *found.seen.remarks)


def _said_of_presses(
    force: Channel, conditioned: ForceRecord, clean: Cleaned, times: Timeline, found: PressEnvelopes, bias: BiasBudget,
    envelope_fs_hz: float, window: WindowSettings,
) -> list[tuple[tuple[bool, str], ...]]:  # fmt: skip
    """For each press what is said about it, and whether that rejects it."""
    lag, differ = clean.lag, rests_differ(found.resting_v, times.resting, envelope_fs_hz)
    # where clocks differ by more, the rests of EMG are not those of force
    tense = tension(found.resting_v, times.resting) if differ and abs(lag.lag_s) < LARGE_LAG_S else 1.0
    told_above, left_s = TONE_CORRECTION if differ else LARGE_CORRECTION, lag.left_s(times.moved_s, times.stop_s)
    biased = said_of_bias(conditioned, bias, told_above, lag, left_s, tense, window)
    muscles, artefact = clean.record.muscles, found.gone["contact artefact"]
    loaded = said_of_overload(force, conditioned.presses)
    held = said_of_held(muscles, clean.gaps.held)
    shaken = said_of_movement(muscles, clean.moved, artefact, times.instants, clean.record.fs_hz, bias)
    return [
        (*over, *gaps, *shook, *own, *((False, sign) for sign in signs))
        for over, gaps, shook, own, signs in zip(loaded, held, shaken, biased, found.seen.of_press, strict=True)
    ]


def _evidence(
    raw: EmgRecord, chain: Chain, conditioned: ForceRecord, force_missing: NDArray[np.bool_], times: Timeline,
    found: PressEnvelopes, fault: str, said: list[tuple[tuple[bool, str], ...]],
) -> tuple[list[list[RawQuality]], list[Evidence]]:  # fmt: skip
    """Of each press the quality of its raw samples by muscle, and all that it is judged by."""
    quality = record_qualities(raw, times.instants, chain.envelope)
    snr_db = ratio_db(window_means(found.measured_v, times.instants.offsets), found.rest_v[:, None])
    evidence = gather_evidence(
        conditioned, times.instants, times.force_n, force_missing, quality, snr_db, raw, fault, said
    )
    return quality, evidence


def _traits(
    raw: EmgRecord, conditioned: ForceRecord, lag: Lag, times: Timeline, found: PressEnvelopes, overview: EmgOverview
) -> Traits:
    """What tells this recording's presses from copies and from those of another person."""
    offsets = times.instants.offsets
    return traits_of(
        raw.muscles, raw.samples, raw.fs_hz, found.signals.rests, overview, found.rest_v,
        window_means(found.measured_v, offsets), times.stop_s - times.start_s, conditioned.presses.peak_n, lag.lag_s,
        times.force_n, found.measured_v, offsets,
    )  # fmt: skip
