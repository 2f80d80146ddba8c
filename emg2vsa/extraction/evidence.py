"""What is known of each press of a recording before it is judged, and what makes its b other than the muscle's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints
from emg2vsa.extraction.emg_record import EmgRecord, Native
from emg2vsa.recordings import Channel
from emg2vsa.settings import WindowSettings
from emg2vsa.signals.bias import BiasBudget
from emg2vsa.signals.envelope import Smoother
from emg2vsa.signals.force import ForceRecord
from emg2vsa.signals.lag import LARGEST_S, Lag
from emg2vsa.signals.pairing import Clock, Instants
from emg2vsa.signals.quality import RawQuality, falling_share, raw_qualities
from emg2vsa.signals.segmentation import Presses
from emg2vsa.signals.verdicts import HELD_SHARE, Evidence

TOLD_BIAS = 0.01
"A press whose b is expected to be off by a larger share says so."
MOST_TOLD = 0.2
"The size of a larger bias is not told: it rests on the fit that it spoils."
TENSE = 2.0
"Muscles so many times louder in one rest than in another are tense: presses then seem to lag by different times."
MOST_LEFT_OUT = 0.5
"A press of which a larger share is left out is rejected."
REACH_S = 0.1
"A span of movement reaches into a press from so far."
TOLD_SHIFT_N = 0.1
"A press around which the zero of force moves further says so: 0.1 N is 5 % of b."


def record_qualities(record: EmgRecord, instants: Instants, envelope: Smoother) -> list[list[RawQuality]]:
    """Quality by muscle and trial, of all raw samples under the envelope's kernel."""
    starts = np.maximum(instants.first - envelope.before, 0)
    stops = instants.last + envelope.after + 1
    clock = Clock(record.start_s, record.fs_hz, record.samples[0].size)
    own = record.native or [
        Native(samples, missing, record.fs_hz, record.start_s)
        for samples, missing in zip(record.samples, record.missing, strict=True)
    ]
    qualities = []
    for each in own:
        bounds = [np.rint(each.index(clock.time_s(edge))).astype(np.int64) for edge in (starts, stops)]
        windows = [slice(max(i, 0), j) for i, j in zip(*(edge.tolist() for edge in bounds), strict=True)]
        samples, gone = [each.samples[w] for w in windows], [each.missing[w] for w in windows]
        qualities.append(raw_qualities(samples, gone, each.fs_hz))
    return qualities


def said_of_bias(
    force: ForceRecord, bias: BiasBudget, told_above: float, lag: Lag, left_s: Floats, tense: float,
    window: WindowSettings,
) -> list[tuple[tuple[bool, str], ...]]:  # fmt: skip
    """What makes b of each press other than the muscle's, and by how much; whether it rejects the press.

    left_s : (p,) lag of force in each press. told_above : the share by which the rest level, if it was subtracted, must
    have raised b to be told. tense : how many times louder a muscle is in its loudest rest than in its most silent.
    """
    said: list[tuple[tuple[bool, str], ...]] = []
    implausible = window.implausible == "reject"
    sure = implausible and lag.pieces > 2 and tense <= TENSE  # two presses, taps, or muscles tense between feign a lag
    rows = {cause: (bias.b[row], bias.corrected[row]) for row, cause in enumerate(bias.causes)}
    none = np.zeros((2, bias.b.shape[1]))
    (noise, subtracted), (humming, _), (lagging, _) = (
        rows.get(cause, none) for cause in ("rest level", "hum at the touch", "lag")
    )
    for i in range(bias.b.shape[1]):
        own: list[tuple[bool, str]] = []
        if force.tare == "impossible":
            own.append((implausible, 'force is not tared: the record never rests (tare = "none" where it is zeroed)'))
        if force.zero_shift_n[i] > TOLD_SHIFT_N:
            rejects = implausible and bool(force.zero_shift_n[i] > window.max_gap_force_n)
            own.append((rejects, f"the zero of force moves by {force.zero_shift_n[i]:.2f} N around this press"))
        if abs(subtracted[i]) > told_above:
            own.append((False, f"the rest level that was subtracted raises b by {-100 * subtracted[i]:.0f} %"))
        if abs(noise[i]) > TOLD_BIAS:
            own.append((False, f"noise at rest lowers b by about {-100 * noise[i]:.0f} %"))
        if humming[i] < -TOLD_BIAS:
            own.append(
                (False, f"hum changes when the specimen is touched, which lowers b by about {-100 * humming[i]:.0f} %")
            )
        apart = sure and bool(abs(left_s[i]) > LARGEST_S)
        if abs(lagging[i]) > TOLD_BIAS or apart:
            size = f"about {100 * abs(lagging[i]):.0f} %" if abs(lagging[i]) < MOST_TOLD else "more than 20 %"
            way = f"{'raises' if lagging[i] > 0 else 'lowers'} b by {size}"
            own.append((apart, f"force follows EMG by {1e3 * left_s[i]:.0f} ms, which {way}"))
        if lag.differs and tense > TENSE:
            times = f"up to {tense:.2g} times as much as when they rest most"
            own.append((False, f"muscles are tense between presses, {times}"))
        if lag.differs:
            own.append((apart or (sure and lag.between_s > LARGEST_S), lag.differs))
        said.append(tuple(own))
    return said


def said_of_movement(
    muscles: tuple[str, ...], moved: Sequence[Ints], gone: NDArray[np.bool_], instants: Instants, fs_hz: float,
    bias: BiasBudget,
) -> list[tuple[tuple[bool, str], ...]]:  # fmt: skip
    """Per press which electrodes moved, for how long its envelope is left out, s, and what that would have changed.

    moved : of each muscle, (k, 2) first and last-plus-one sample. gone : (N,) instants that are left out.
    """
    offsets = instants.offsets
    changed = bias.corrected[bias.causes.index("contact artefact")] if "contact artefact" in bias.causes else None
    said: list[tuple[tuple[bool, str], ...]] = []
    for i, (first, last) in enumerate(zip(instants.first.tolist(), instants.last.tolist(), strict=True)):
        own = gone[offsets[i] : offsets[i + 1]]
        if not own.any():
            said.append(())
            continue
        reach = round(REACH_S * fs_hz)
        who = [
            muscle for muscle, spans in zip(muscles, moved, strict=True)
            if np.any((spans[:, 0] < last + reach) & (spans[:, 1] > first - reach))
        ]  # fmt: skip
        verb = "moves" if len(who) == 1 else "move"
        share = "" if changed is None else f", with which b would change by {100 * changed[i]:+.0f} %"
        left = f"{own.sum() * instants.step / fs_hz:.2g} s, which is left out"
        said.append(((bool(own.mean() > MOST_LEFT_OUT), f"{' and '.join(who)} {verb} for {left}{share}"),))
    return said


def said_of_overload(force: Channel, presses: Presses) -> list[tuple[tuple[bool, str], ...]]:
    """Per press whether the force transducer was beyond its range, where that is known."""
    if force.overloaded is None:
        return [()] * presses.start_s.size
    first = (presses.start_s * force.fs_hz).astype(np.int64)
    last = np.ceil(presses.stop_s * force.fs_hz).astype(np.int64) + 1
    counts = [int(np.count_nonzero(force.overloaded[a:b])) for a, b in zip(first, last, strict=True)]
    return [((True, f"transducer overloaded in {count} samples"),) if count else () for count in counts]


def said_of_held(muscles: Sequence[str], shares: Floats) -> list[tuple[tuple[bool, str], ...]]:
    """Per press the muscles whose samples are held, or on a line, in a larger share than can be left out; (m, p)."""
    return [
        tuple(
            (True, f"{muscle} is held, or a straight line, in {100 * share:.0f} % of its samples")
            for muscle, share in zip(muscles, own, strict=True) if HELD_SHARE < share < 1
        )
        for own in shares.T.tolist()
    ]  # fmt: skip


def gather_evidence(
    force: ForceRecord,
    instants: Instants,
    force_n: Floats,
    force_missing: NDArray[np.bool_],
    quality: list[list[RawQuality]],
    snr_db: Floats,
    record: EmgRecord,
    fault: str,
    said: list[tuple[tuple[bool, str], ...]],
) -> list[Evidence]:
    """What is known of each of p presses of a record.

    force_n : (N,) N at the instants. force_missing : (n,) of the record. quality : m rows of p. snr_db : (m, p) dB.
    said : of each press, whether a sentence is a fault, and the sentence.
    """
    presses, offsets = force.presses, instants.offsets
    fs_hz = force.fs_hz
    evidence = []
    for i, (start_s, stop_s) in enumerate(zip(presses.start_s, presses.stop_s, strict=True)):
        curve_n = force_n[offsets[i] : offsets[i + 1]]
        begin, end = int(start_s * fs_hz), min(int(np.ceil(stop_s * fs_hz)) + 1, force_missing.size)
        evidence.append(
            Evidence(
                fault=fault,
                duration_s=float(stop_s - start_s),
                peak_force_n=float(presses.peak_n[i]),
                reached=bool(presses.reached[i]),
                at_edge=bool(presses.at_edge[i]),
                covered=bool(instants.covered[i]),
                force_missing=int(np.count_nonzero(force_missing[begin:end])),
                falling_share=falling_share(curve_n, force.reversal_n),
                rest_gap_n=float(force.gap_n[i]),
                start_force_n=float(force.force_n[begin]),
                emg_fs_hz=record.fs_hz,
                emg={muscle: row[i] for muscle, row in zip(record.muscles, quality, strict=True)},
                snr_db=dict(zip(record.muscles, snr_db[:, i].tolist(), strict=True)),
                said=said[i],
            )
        )
    return evidence
