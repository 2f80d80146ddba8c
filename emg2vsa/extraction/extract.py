"""The making of trials: condition one continuous recording, find its presses, judge each on what was measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, bridge_gaps, samples_1d
from emg2vsa.extraction import Trials
from emg2vsa.extraction.cleaning import cleaned
from emg2vsa.extraction.emg_record import Chain, EmgRecord, emg_record, filter_chain, where_of
from emg2vsa.extraction.evidence import (
    gather_evidence,
    record_qualities,
    said_of_bias,
    said_of_held,
    said_of_movement,
    said_of_overload,
)
from emg2vsa.extraction.press_bias import alone, of_hum, of_lag, of_moments, of_zero, without_clipping
from emg2vsa.extraction.rests import rest_levels, rests_differ, rests_heard, tension
from emg2vsa.recordings import Channel
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.bias import BiasBudget, Cause, Shift, left_in, taken_out
from emg2vsa.signals.cocontraction import cocontraction_index
from emg2vsa.signals.delays import delay_budget
from emg2vsa.signals.filters import IirFilter
from emg2vsa.signals.floor import floor_change, floor_over_muscle, press_levels, subtract_floor
from emg2vsa.signals.force import ForceRecord, condition_force, doubt_by_emg
from emg2vsa.signals.force_doubts import exchanged, returns_to_zero, sampled_slowly
from emg2vsa.signals.lag import Lag
from emg2vsa.signals.level_drift import level_drift, level_trends
from emg2vsa.signals.movement import bridged, left_out
from emg2vsa.signals.overview import emg_overview
from emg2vsa.signals.pairing import (
    Clock,
    Instants,
    force_at,
    instants_between,
    rest_instants,
)
from emg2vsa.signals.plausibility import LARGE_LAG_S, force_unit_doubt, plausibility
from emg2vsa.signals.press_signals import Signals
from emg2vsa.signals.quality import ratio_db, window_means
from emg2vsa.signals.rest import Rest
from emg2vsa.signals.traits import traits_of
from emg2vsa.signals.verdicts import judge

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
    record = emg_record(emg)
    chain = filter_chain(filters, record, force.fs_hz)
    raw = record
    conditioned, force_missing, misread, slowly = _conditioned(force, raw, chain.low, force_channel, window)
    conditioned = replace(conditioned, rest=rests_heard(conditioned.rest, force.start_s, force.fs_hz, raw))
    force = replace(force, samples=np.empty(0))  # of a long record much, where the caller holds them no longer
    clean = cleaned(raw, force, force_missing, conditioned, chain, filters, force_channel, window)
    record, lag = clean.record, clean.lag
    moved_s = lag.lag_s if filters.align == "lag" and lag.certain else 0.0
    delay, shifts = delay_budget(filters.phase, chain.band, chain.envelope, chain.low, force_channel.delay_s, moved_s)
    emg_clock = Clock(record.start_s - shifts.emg_s, record.fs_hz, record.samples[0].size)
    force_clock = Clock(force.start_s - shifts.force_s, force.fs_hz, force_missing.size)
    presses = conditioned.presses
    start_s, stop_s = presses.start_s + force_clock.start_s, presses.stop_s + force_clock.start_s
    instants = instants_between(start_s, stop_s, emg_clock, force_clock, chain.step)
    force_n = force_at(conditioned.force_n, instants, emg_clock, force_clock)

    resting = rest_instants(conditioned.rest, emg_clock, force_clock, chain.step)
    measured_v, resting_v = chain.envelopes(record, instants, resting)
    reach = chain.envelope.before, chain.envelope.after
    gone: dict[Cause, NDArray[np.bool_]] = {
        "contact artefact": left_out(clean.moved, instants.samples(), *reach),
        "lost samples": left_out(clean.gaps.lost, instants.samples(), *reach),
    }
    disturbed_v = measured_v
    if any(own is not one for own, one in zip(raw.samples, clean.gaps.samples, strict=True)):
        spoilt = zip(record.samples, raw.samples, clean.gaps.samples, strict=True)
        disturbed = replace(record, samples=tuple(own + (one - other) for own, one, other in spoilt))
        disturbed_v, _ = chain.envelopes(disturbed, instants, resting)
    undisturbed_v, measured_v = measured_v, bridged(measured_v, np.any([*gone.values()], axis=0), instants.offsets)
    rest_v, floor_v, floor_error = rest_levels(resting_v, resting)
    left = lag if lag.certain and not moved_s else Lag(0.0, 0.0)
    signals = _looked_at(
        raw, chain, instants, conditioned.rest, emg_clock, force_clock, rest_v, force_n, measured_v, left.lag_s
    )
    seen = plausibility(signals)
    gone["spikes and bursts"] = np.zeros(force_n.size, dtype=np.bool_)
    for first, last in seen.bursts:
        gone["spikes and bursts"][first:last] = True
    all_gone = np.any([*gone.values()], axis=0)
    measured_v = bridged(measured_v, all_gone, instants.offsets)
    clipping: list[Shift] = []
    if seen.rails:
        rails = [seen.rails.get(muscle) for muscle in record.muscles]
        measured_v, shift = without_clipping(measured_v, rails, force_n, instants.offsets)
        clipping.append(shift)
    levels_v = press_levels(measured_v, force_n, instants.offsets)
    subtract = filters.rest_level == "subtract"
    envelopes_v = subtract_floor(measured_v, levels_v, floor_v) if subtract else measured_v
    crossing: list[Shift] = []
    if cocontraction.crosstalk:
        heard = cocontraction.crosstalk
        envelopes_v, crossed = alone(envelopes_v, record.muscles, heard, force_n, instants.offsets)
        crossing.append(crossed)
    floor_a, floor_b = floor_change(levels_v, floor_v, force_n, instants.offsets)
    over_muscle = floor_over_muscle(levels_v, floor_v, instants.offsets)
    differ = rests_differ(resting_v, resting, record.fs_hz / chain.step)
    told_above = TONE_CORRECTION if differ else LARGE_CORRECTION
    # where clocks differ by more, the rests of EMG are not those of force
    tense = tension(resting_v, resting) if differ and abs(lag.lag_s) < LARGE_LAG_S else 1.0
    trends = level_trends(envelopes_v, instants.offsets)
    shifts_of_b: list[Shift] = [
        taken_out("rest level", floor_b, np.abs(floor_b) * np.hypot(floor_error, NOISY * over_muscle)) if subtract
        else left_in("rest level", floor_a, floor_b),
        *of_hum(replace(raw, samples=clean.gaps.samples), clean, levels_v, force_n, instants),
        *clipping,
        *crossing,
        level_drift(envelopes_v, instants.offsets, *trends),
    ]  # fmt: skip
    errors: dict[Cause, Floats] = {"spikes and bursts": clean.gaps.spiked, "lost samples": clean.gaps.missed}
    shifts_of_b += of_moments(gone, errors, undisturbed_v, disturbed_v, force_n, levels_v, instants.offsets)
    envelopes_v = np.where(all_gone, np.nan, envelopes_v)
    shifts_of_b += of_zero(conditioned.zero_shift_n, force_n, levels_v, instants)
    activity, unit, said = cocontraction_index(envelopes_v, record.muscles, cocontraction)
    snr_db = ratio_db(window_means(measured_v, instants.offsets), rest_v[:, None])
    quality = record_qualities(raw, instants, chain.envelope)
    doubt = conditioned.sign_doubt or doubt_by_emg(
        force_n, measured_v, instants.offsets, rest_v, window.force_n, force_channel.sign
    )
    implausible = misread or force_unit_doubt(conditioned.force_n, window.force_n) or seen.fault
    rejects = window.implausible == "reject"
    # a channel that is not the force it should be is the cause of whatever sign or unit it seems to have
    fault = (implausible if rejects and (misread or not doubt) else "") or doubt
    remarks = (*slowly, *seen.remarks)
    remarks = remarks if rejects else (*filter(None, (implausible,)), *remarks)
    shifts_of_b += of_lag(lag, moved_s, stop_s, conditioned, instants, emg_clock, force_clock, force_n, levels_v)
    bias = BiasBudget.of(shifts_of_b, start_s.size)
    biased = said_of_bias(conditioned, bias, told_above, lag, lag.left_s(moved_s, stop_s), tense, window)
    loaded = said_of_overload(force, presses)
    shaken = said_of_movement(record.muscles, clean.moved, gone["contact artefact"], instants, record.fs_hz, bias)
    held = said_of_held(record.muscles, clean.gaps.held)
    other = [
        (*over, *gaps, *shook, *own, *((False, sign) for sign in signs))
        for over, gaps, shook, own, signs in zip(loaded, held, shaken, biased, seen.of_press, strict=True)
    ]
    evidence = gather_evidence(conditioned, instants, force_n, force_missing, quality, snr_db, record, fault, other)
    verdicts = [judge(trial, window) for trial in evidence]
    said += (fault,) if fault else ()
    overview = emg_overview(raw.samples, raw.fs_hz, emg_clock.start_s, signals.presses, signals.rests)
    traits = traits_of(
        record.muscles, raw.samples, raw.fs_hz, signals.rests, overview, rest_v,
        window_means(measured_v, instants.offsets), stop_s - start_s, presses.peak_n, lag.lag_s, force_n, measured_v,
        instants.offsets,
    )  # fmt: skip
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
        notes=(*notes, *conversions, *chain.notes, str(delay), *conditioned.notes, *clean.said, *said),
        lag_s=lag.lag_s,
        lag_se_s=lag.se_s,
        bias=bias,
        traits=traits,
        tare=conditioned.tare,
        zero_shift_n=conditioned.zero_shift_n,
        fault=fault,
        remarks=() if fault else remarks,
        rates_hz=(*(channel.fs_hz for channel in emg.values()), force.fs_hz),
        overviews=(overview,),
    )


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


def _looked_at(
    record: EmgRecord,
    chain: Chain,
    instants: Instants,
    rest: Rest,
    emg_clock: Clock,
    force_clock: Clock,
    rest_v: Floats,
    force_n: Floats,
    envelopes_v: Floats,
    lag_s: float,
) -> Signals:
    """What is asked whether it is plausible; arrays as in ``extract_trials``."""
    bounds_s = np.stack((force_clock.time_s(rest.start), force_clock.time_s(rest.stop)), axis=-1)
    return Signals(
        muscles=record.muscles,
        samples=record.samples,
        fs_hz=record.fs_hz,
        presses=np.stack((instants.first, instants.last + 1), axis=-1),
        rests=np.clip(emg_clock.index(bounds_s), 0, emg_clock.n_samples).astype(np.int64),
        rest_v=rest_v,
        force_n=force_n,
        envelopes_v=envelopes_v,
        envelope_fs_hz=record.fs_hz / chain.step,
        offsets=instants.offsets,
        lag_s=lag_s,
    )
