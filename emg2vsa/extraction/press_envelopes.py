"""The envelopes of the presses of a recording: when they are, what of them is gone, what they would be without it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats
from emg2vsa.extraction.cleaning import Cleaned
from emg2vsa.extraction.emg_record import Chain, EmgRecord
from emg2vsa.extraction.press_bias import alone, without_clipping
from emg2vsa.extraction.rests import rest_levels
from emg2vsa.recordings import Channel
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings
from emg2vsa.signals.bias import Cause, Shift
from emg2vsa.signals.delays import DelayBudget, delay_budget
from emg2vsa.signals.floor import press_levels, subtract_floor
from emg2vsa.signals.force import ForceRecord
from emg2vsa.signals.lag import Lag
from emg2vsa.signals.movement import bridged, left_out
from emg2vsa.signals.pairing import Clock, Instants, force_at, instants_between, rest_instants
from emg2vsa.signals.plausibility import Plausibility, plausibility
from emg2vsa.signals.press_signals import Signals
from emg2vsa.signals.rest import Rest


@dataclass(frozen=True)
class Timeline:
    """The presses on both clocks. start_s, stop_s : (p,) loading phases. instants : of their envelopes; resting : of
    those of the rests. force_n : (N,) at ``instants``. delay : what the clocks allow for; moved_s : of the lag.
    """

    emg: Clock
    force: Clock
    start_s: Floats
    stop_s: Floats
    instants: Instants
    resting: Instants
    force_n: Floats
    delay: DelayBudget
    moved_s: float


@dataclass(frozen=True)
class PressEnvelopes:
    """Volts by muscle (m, N) at the instants of a timeline.

    envelopes_v : as they are fitted, but for what is ``gone``, which a line bridges. measured_v : with rest level and
    crosstalk. undisturbed_v, disturbed_v : before anything was bridged, without and with gaps and spikes. resting_v :
    of the rests. levels_v : smoothed over force. rest_v : (m,) of all rests; floor_v, floor_error : what is subtracted
    of them, and its error as a share. gone : by cause (N,). shifts : what clipping and crosstalk had done to b.
    """

    envelopes_v: Floats
    measured_v: Floats
    undisturbed_v: Floats
    disturbed_v: Floats
    resting_v: Floats
    levels_v: Floats
    rest_v: Floats
    floor_v: Floats
    floor_error: float
    gone: dict[Cause, NDArray[np.bool_]]
    shifts: tuple[Shift, ...]
    signals: Signals
    seen: Plausibility

    @property
    def all_gone(self) -> NDArray[np.bool_]:
        """(N,) by any cause."""
        return np.asarray(np.any([*self.gone.values()], axis=0))


def timeline(
    clean: Cleaned, conditioned: ForceRecord, force: Channel, n_force: int, chain: Chain, filters: FilterSettings,
    force_channel: ForceChannelSettings,
) -> Timeline:  # fmt: skip
    """When the presses are; the lag is taken out where the study says so and it is certain. n_force : samples."""
    record, lag = clean.record, clean.lag
    moved_s = lag.lag_s if filters.align == "lag" and lag.certain else 0.0
    delay, shifts = delay_budget(filters.phase, chain.band, chain.envelope, chain.low, force_channel.delay_s, moved_s)
    emg_clock = Clock(record.start_s - shifts.emg_s, record.fs_hz, record.samples[0].size)
    force_clock = Clock(force.start_s - shifts.force_s, force.fs_hz, n_force)
    presses = conditioned.presses
    start_s, stop_s = presses.start_s + force_clock.start_s, presses.stop_s + force_clock.start_s
    instants = instants_between(start_s, stop_s, emg_clock, force_clock, chain.step)
    force_n = force_at(conditioned.force_n, instants, emg_clock, force_clock)
    resting = rest_instants(conditioned.rest, emg_clock, force_clock, chain.step)
    return Timeline(emg_clock, force_clock, start_s, stop_s, instants, resting, force_n, delay, moved_s)


def press_envelopes(
    raw: EmgRecord, clean: Cleaned, chain: Chain, times: Timeline, rest: Rest, filters: FilterSettings,
    cocontraction: CocontractionSettings,
) -> PressEnvelopes:  # fmt: skip
    """Envelopes of the cleaned record without moments that are spoilt, clipping, rest level and crosstalk."""
    record, offsets, force_n = clean.record, times.instants.offsets, times.force_n
    undisturbed_v, resting_v = chain.envelopes(record, times.instants, times.resting)
    reach = chain.envelope.before, chain.envelope.after
    gone: dict[Cause, NDArray[np.bool_]] = {
        "contact artefact": left_out(clean.moved, times.instants.samples, *reach),
        "lost samples": left_out(clean.gaps.lost, times.instants.samples, *reach),
    }
    disturbed_v = _disturbed(raw, clean, chain, times, undisturbed_v)
    measured_v = bridged(undisturbed_v, np.any([*gone.values()], axis=0), offsets)
    rest_v, floor_v, floor_error = rest_levels(resting_v, times.resting)
    left = clean.lag if clean.lag.certain and not times.moved_s else Lag(0.0, 0.0)
    signals = _looked_at(raw, chain, times, rest, rest_v, measured_v, left.lag_s)
    seen = plausibility(signals)
    gone["spikes and bursts"] = np.zeros(force_n.size, dtype=np.bool_)
    for first, last in seen.bursts:
        gone["spikes and bursts"][first:last] = True
    measured_v = bridged(measured_v, np.any([*gone.values()], axis=0), offsets)
    shifts: list[Shift] = []
    if seen.rails:
        rails = [seen.rails.get(muscle) for muscle in record.muscles]
        measured_v, clipped = without_clipping(measured_v, rails, force_n, offsets)
        shifts.append(clipped)
    levels_v = press_levels(measured_v, force_n, offsets)
    envelopes_v = subtract_floor(measured_v, levels_v, floor_v) if filters.rest_level == "subtract" else measured_v
    if cocontraction.crosstalk:
        envelopes_v, crossed = alone(envelopes_v, record.muscles, cocontraction.crosstalk, force_n, offsets)
        shifts.append(crossed)
    return PressEnvelopes(
        envelopes_v, measured_v, undisturbed_v, disturbed_v, resting_v, levels_v, rest_v, floor_v, floor_error, gone,
        tuple(shifts), signals, seen,
    )  # fmt: skip


def _disturbed(raw: EmgRecord, clean: Cleaned, chain: Chain, times: Timeline, undisturbed_v: Floats) -> Floats:
    """Envelopes (m, N) with the gaps and spikes that were bridged."""
    if all(own is one for own, one in zip(raw.samples, clean.gaps.samples, strict=True)):
        return undisturbed_v
    spoilt = zip(clean.record.samples, raw.samples, clean.gaps.samples, strict=True)
    disturbed = replace(clean.record, samples=tuple(own + (one - other) for own, one, other in spoilt))
    return chain.envelopes(disturbed, times.instants, times.resting)[0]


def _looked_at(
    record: EmgRecord, chain: Chain, times: Timeline, rest: Rest, rest_v: Floats, envelopes_v: Floats, lag_s: float
) -> Signals:
    """What is asked whether it is plausible."""
    bounds_s = np.stack((times.force.time_s(rest.start), times.force.time_s(rest.stop)), axis=-1)
    instants = times.instants
    return Signals(
        muscles=record.muscles,
        samples=record.samples,
        fs_hz=record.fs_hz,
        presses=np.stack((instants.first, instants.last + 1), axis=-1),
        rests=np.clip(times.emg.index(bounds_s), 0, times.emg.n_samples).astype(np.int64),
        rest_v=rest_v,
        force_n=times.force_n,
        envelopes_v=envelopes_v,
        envelope_fs_hz=record.fs_hz / chain.step,
        offsets=instants.offsets,
        lag_s=lag_s,
    )
