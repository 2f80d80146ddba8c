"""The making of trials: condition one continuous recording, find its presses, judge each on what was measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints, bridge_gaps, median, samples_1d
from emg2vsa.extraction import Trials
from emg2vsa.extraction.emg_record import Chain, EmgRecord, emg_record, filter_chain, where_of
from emg2vsa.extraction.evidence import (
    gather_evidence,
    record_qualities,
    said_of_bias,
    said_of_movement,
    said_of_overload,
)
from emg2vsa.recordings import Channel
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.bias import BiasBudget, Cause, Shift, left_in, line_change, taken_out
from emg2vsa.signals.clipping import Rail, unclipped
from emg2vsa.signals.cocontraction import cocontraction_index
from emg2vsa.signals.crosstalk import KNOWN_TO, without_crosstalk
from emg2vsa.signals.delays import delay_budget
from emg2vsa.signals.filters import IirFilter
from emg2vsa.signals.floor import floor_change, floor_over_muscle, press_levels, subtract_floor
from emg2vsa.signals.force import ForceRecord, condition_force, doubt_by_emg
from emg2vsa.signals.force_doubts import exchanged, returns_to_zero, sampled_slowly
from emg2vsa.signals.gaps import Bridged, bridge
from emg2vsa.signals.hum import remove_hum, remove_touch_hum, touch_hum
from emg2vsa.signals.lag import DIFFERS_S, Lag, curve_of, estimate_lag
from emg2vsa.signals.level_drift import level_drift, level_trends
from emg2vsa.signals.movement import bridged, change_by_disturbance, left_out, movement
from emg2vsa.signals.overview import emg_overview
from emg2vsa.signals.pairing import (
    Clock,
    Instants,
    force_at,
    instants_between,
    rest_instants,
    rest_samples,
)
from emg2vsa.signals.plausibility import LARGE_LAG_S, force_unit_doubt, plausibility
from emg2vsa.signals.press_signals import Signals, by_press
from emg2vsa.signals.quality import MAINS_HZ, ratio_db, window_means
from emg2vsa.signals.rest import Rest
from emg2vsa.signals.traits import traits_of
from emg2vsa.signals.verdicts import judge

OVERVIEW_HZ = 10.0
LARGE_CORRECTION = 0.05
"A press whose b is corrected by a larger share says so: the correction rests on the hand being at rest."
TONE_CORRECTION = 0.02
"... and where the rests differ, which muscle tone does and noise does not, above this share."
TONE_BLOCK_S = 0.1
"Rests are compared by the means of blocks of this length."
TONE_CHANCE = 1e-4
"Noise alone makes the rests of a muscle differ with this probability."
HUM_LEFT = 0.05
"Standard error of the correction for hum, as a share of it; what is seen to stay has its own share in the budget."
LAW_KNOWN_TO = 0.3
"Standard error of a correction for clipping, as a share of what lies between the two laws of amplitude."
NOISY = 0.5
"""Relative error of the correction for the rest level where the rest has the power of the muscles: 1 % of b at a third
of it (15 uV), and at twice of it (40 uV), where b came out 20 to 50 % too low, a third of b."""
ZERO_OFF = 0.6
"Standard error of the force in a press, as a share of how far its zero moves around it: it may be off by nearly all."
TOUCHED = 0.1
"The finger is on the specimen above this share of the window's lower force."


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
    force = replace(force, samples=np.empty(0))  # of a long record much, where the caller holds them no longer
    clean = _cleaned(raw, force, conditioned, chain, filters, force_channel, window)
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
    rest_v, floor_v, floor_error = _rest_levels(resting_v, resting)
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
        measured_v, shift = _unclipped(measured_v, rails, force_n, instants.offsets)
        clipping.append(shift)
    levels_v = press_levels(measured_v, force_n, instants.offsets)
    subtract = filters.rest_level == "subtract"
    envelopes_v = subtract_floor(measured_v, levels_v, floor_v) if subtract else measured_v
    crossing: list[Shift] = []
    if cocontraction.crosstalk:
        own_v = press_levels(envelopes_v, force_n, instants.offsets)
        envelopes_v, alone_v = without_crosstalk(envelopes_v, own_v, record.muscles, cocontraction.crosstalk)
        x = np.log(np.maximum(force_n, 1e-9))
        _, change = line_change(x, own_v.sum(axis=0), x, alone_v.sum(axis=0), alone_v.sum(axis=0), instants.offsets)
        crossing = [taken_out("crosstalk", change, 2 * KNOWN_TO * np.abs(change))]
    floor_a, floor_b = floor_change(levels_v, floor_v, force_n, instants.offsets)
    over_muscle = floor_over_muscle(levels_v, floor_v, instants.offsets)
    differ = _rests_differ(resting_v, resting, record.fs_hz / chain.step)
    told_above = TONE_CORRECTION if differ else LARGE_CORRECTION
    # where clocks differ by more, the rests of EMG are not those of force
    tense = _tension(resting_v, resting) if differ and abs(lag.lag_s) < LARGE_LAG_S else 1.0
    trends = level_trends(envelopes_v, instants.offsets)
    shifts_of_b: list[Shift] = [
        taken_out("rest level", floor_b, np.abs(floor_b) * np.hypot(floor_error, NOISY * over_muscle)) if subtract
        else left_in("rest level", floor_a, floor_b),
        *_of_hum(replace(raw, samples=clean.gaps.samples), clean, levels_v, force_n, instants),
        *clipping,
        *crossing,
        level_drift(envelopes_v, instants.offsets, *trends),
    ]  # fmt: skip
    errors: dict[Cause, Floats] = {"spikes and bursts": clean.gaps.spiked, "lost samples": clean.gaps.missed}
    shifts_of_b += _of_moments(gone, errors, undisturbed_v, disturbed_v, force_n, levels_v, instants.offsets)
    envelopes_v = np.where(all_gone, np.nan, envelopes_v)
    off_n = ZERO_OFF * np.repeat(np.nan_to_num(conditioned.zero_shift_n), instants.counts)
    if off_n.any():
        x, level_v = np.log(np.maximum(force_n, 1e-9)), levels_v.sum(axis=0)
        _, b = line_change(x, level_v, np.log(np.maximum(force_n, 1e-9) + off_n), level_v, level_v, instants.offsets)
        shifts_of_b.append(left_in("zero of force", np.zeros(b.size), np.zeros(b.size), np.abs(b)))
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
    shifts_of_b += _of_lag(lag, moved_s, stop_s, conditioned, instants, emg_clock, force_clock, force_n, levels_v)
    bias = BiasBudget.of(shifts_of_b, start_s.size)
    biased = said_of_bias(conditioned, bias, told_above, lag, tense, window)
    loaded = said_of_overload(force, presses)
    shaken = said_of_movement(record.muscles, clean.moved, gone["contact artefact"], instants, record.fs_hz, bias)
    other = [
        (*over, *shook, *own, *((False, sign) for sign in signs))
        for over, shook, own, signs in zip(loaded, shaken, biased, seen.of_press, strict=True)
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
    misread = exchanged(raw_n, force.fs_hz, emg.muscles, emg.samples, emg.fs_hz) or returns_to_zero(raw_n, force.fs_hz)
    slowly = tuple(sampled_slowly(raw_n, force.fs_hz))
    return condition_force(raw_n, force.fs_hz, low, force_channel, window), missing, misread, slowly


def _rest_levels(envelopes_v: Floats, resting: Instants) -> tuple[Floats, Floats, float]:
    """Median and lowest over the pieces of rest of the mean envelope (m,), (m,); NaN without any.

    Noise is the same in every rest and muscle tone is not, so the lowest is the better estimate of noise. Last: the
    relative error of b's correction for it, which grows as the power of what is subtracted.
    """
    if resting.counts.size == 0:
        unknown = np.full(len(envelopes_v), np.nan)
        return unknown, unknown, 0.0
    means = window_means(envelopes_v, resting.offsets)
    typical, lowest = np.array([median(row) for row in means]), means.min(axis=1)
    apart = np.divide(typical, lowest, out=np.ones_like(typical), where=lowest > 0) - 1
    return typical, lowest, min(2 * float(apart.max()), 1.0)


def _tension(envelopes_v: Floats, resting: Instants) -> float:
    """How many times as loud as in its most silent rest the muscle that rests least is in its loudest, (m, N)."""
    means = window_means(envelopes_v, resting.offsets)
    least = means.min(axis=1)
    return float(np.divide(means.max(axis=1), least, out=np.ones_like(least), where=least > 0).max())


def _rests_differ(envelopes_v: Floats, resting: Instants, fs_hz: float) -> bool:
    """Whether the levels of the rests, (m, N) at ``fs_hz``, differ in any muscle by more than the noise within them."""
    size = max(1, round(TONE_BLOCK_S * fs_hz))
    count = int(resting.counts.min(initial=10**9)) // size
    n = resting.counts.size
    if n < 2 or count < 2:
        return False
    begins = resting.offsets[:-1, None, None] + size * np.arange(count)[:, None] + np.arange(size)
    means = envelopes_v[:, begins].mean(axis=-1)
    between = count * np.var(means.mean(axis=-1), axis=-1, ddof=1)
    within = np.var(means, axis=-1, ddof=1).mean(axis=-1)
    return bool(np.any(between > special.fdtri(n - 1, n * (count - 1), 1 - TONE_CHANCE) * within))


def _force_at(samples: Ints, force_n: Floats, emg: Clock, force: Clock) -> Floats:
    """Force (k,) at successive samples (k,) of the EMG, of that (n,) on its own clock."""
    at = force.index(emg.time_s(samples))
    low = min(max(int(at[0]), 0), force.n_samples - 1)
    high = min(max(int(at[-1]) + 2, low + 1), force.n_samples)
    return np.interp(at, np.arange(low, high), force_n[low:high])


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


def _cleaned(
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
    lag = estimate_lag(samples, emg_clock, conditioned.force_n, force_clock, window.force_n[0], stop_s, moved)
    found = f"lag: force follows EMG by {1e3 * lag.lag_s:.0f} ms, "
    if lag.pieces > 1:
        said.append(f"{found}standard error {1e3 * lag.se_s:.0f} ms")
    else:
        said.append(f"{found}by one press" if lag.pieces else "lag: not known")
    if filters.align == "lag" and not lag.certain:
        said.append("lag: not certain, force is not moved")
    return Cleaned(replace(record, samples=samples), lag, touching_v, taken_v, moved, gaps, tuple(said))


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


def _of_hum(
    record: EmgRecord, clean: Cleaned, levels_v: Floats, force_n: Floats, instants: Instants
) -> Iterator[Shift]:
    """What hum of the presses does to them, that which stays and that which was taken from ``record``; arrays as in
    ``extract_trials``."""
    # a mean rectified value is sqrt(2 / pi) of the rms
    if clean.touching_v.any():
        stays_v = np.sqrt(2 / np.pi) * clean.touching_v
        yield left_in("hum at the touch", *floor_change(levels_v, stays_v, force_n, instants.offsets))
    size = max(1, round(record.fs_hz / min(MAINS_HZ)))
    taken_v = np.zeros_like(levels_v)
    begin = np.maximum(instants.samples() - size // 2, 0)
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


def _of_moments(
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


def _unclipped(
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


def _of_lag(
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
    """What the lag does to the presses where ``moved_s`` of it was taken out: one lag of all, one that grows, and one
    that each press has of its own."""
    level = levels_v.sum(axis=0)
    left = lag if lag.certain and not moved_s else Lag(0.0, 0.0)

    def change(lag_s: float) -> tuple[Floats, Floats]:
        """Of a and b where activity is paired with a force that is so late."""
        ahead = replace(force_clock, start_s=force_clock.start_s - lag_s)
        late_n = force_at(conditioned.force_n, instants, emg_clock, ahead)
        x, y = np.log(np.maximum(force_n, 1e-9)), np.log(np.maximum(late_n, 1e-9))
        read, true = curve_of(y, level, instants.offsets, (y, x))
        return line_change(x, read, x, true, level, instants.offsets)

    if lag.drift:
        own_s = lag.lag_s - moved_s + lag.drift * (stop_s - stop_s.mean())
        largest_s = float(np.abs(own_s).max())
        a, b = change(largest_s)
        error_s = np.hypot(lag.about_drift_s, lag.feigned_s)
        yield left_in("clock", a * own_s / largest_s, b * own_s / largest_s, np.abs(b) * error_s / largest_s)
        return
    if left.lag_s:
        a, b = change(left.lag_s)
        yield left_in("lag", a, b, np.abs(b) * np.hypot(np.nan_to_num(left.se_s), left.feigned_s) / abs(left.lag_s))
    # a lag that is not certain may be there all the same
    uncertain_s = 0.0 if lag.certain or lag.pieces < 2 else max(abs(lag.lag_s) - lag.feigned_s, 0.0)
    if (off_s := max(uncertain_s, lag.between_s if lag.between_s > DIFFERS_S else 0.0)) > 0:
        _, b = change(off_s)
        yield left_in("lag", np.zeros(b.size), np.zeros(b.size), np.abs(b))
