"""What is no EMG within EMG: spikes, bursts, heart beats, packets that were sent again.

Each says which muscle shows it and how much. Limits were set on simulated mishaps and on clean signals of many kinds
(benchmarks/mishaps.py, benchmarks/verdict_thresholds.py).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints, median, slices
from emg2vsa.signals.press_signals import Signals

BURST_S, BURST, BURST_EDGE = 0.1, 3.0, 1.5
"Length of a burst, its level over that of the other presses, and what still belongs to it."
SPIKE_SD, SPIKE_HEIGHT, SPIKE_SHARE, MOST_SPIKES = 15.0, 3.0, 0.25, 200
"""A sample this far from its two neighbours' mean, in robust SDs of the press and over its loud parts, is no EMG, where
few others near it are a quarter as far; of a press so many are looked at."""
BEAT_S, BEAT_LEVEL, BEATS, BEAT_RATE_HZ, BEAT_SPREAD = 0.03, 4.0, 5, (0.7, 3.3), 0.25
"Heart beats at rest: length, height over the median, how many at least, how often, and spread of their intervals."
PACKET, TWICE = 12, 0.005
"Samples in a row that no signal repeats by chance, and the share of such that is remarked."


@dataclass(frozen=True)
class Profile:
    """Level of one muscle by force: (B,) middle of each bin; (p, B) mean of each press; (B,) median of the presses."""

    ln_force: Floats
    v: Floats
    typical_v: Floats

    @staticmethod
    def of(signals: Signals) -> list[Profile]:
        """Spikes of each muscle."""
        inside = signals.force_n[signals.force_n > 0]
        low, high = (float(inside.min()), float(inside.max())) if inside.size else (0.5, 1.0)
        edges = np.linspace(np.log(low), np.log(max(high, low * 1.01)), 13)
        middle = (edges[1:] + edges[:-1]) / 2
        which = np.clip(np.searchsorted(edges, np.log(np.maximum(signals.force_n, low)), side="right") - 1, 0, 11)
        p = len(signals.offsets) - 1
        cell = which + 12 * np.repeat(np.arange(p), np.diff(signals.offsets))
        counts = np.bincount(cell, minlength=12 * p).reshape(p, 12)
        profiles = []
        for v in signals.envelopes_v:
            sums = np.bincount(cell, v, minlength=12 * p).reshape(p, 12)
            each = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
            ordered = np.sort(each, axis=0)
            known = np.count_nonzero(np.isfinite(each), axis=0)
            two = np.maximum(np.stack(((known - 1) // 2, known // 2)), 0)
            lower, upper = ordered[np.minimum(two, p - 1), np.arange(12)]
            profiles.append(Profile(middle, each, np.where(known > 0, (lower + upper) / 2, np.nan)))
        return profiles


def bursts_of(signals: Signals, muscle: int, profile: Profile) -> Iterator[tuple[int, str, tuple[int, int]]]:
    """Of one muscle: press, what is said, and first and last-plus-one sample of its envelope."""
    size = max(1, round(BURST_S * signals.envelope_fs_hz))
    known = np.isfinite(profile.typical_v) & (profile.typical_v > 0)
    if len(signals.offsets) < 4 or np.count_nonzero(known) < 4:
        return
    ln_force, typical_v, row = profile.ln_force[known], profile.typical_v[known], signals.envelopes_v[muscle]
    usual_v = np.interp(np.log(np.maximum(signals.force_n, 1e-3)), ln_force, typical_v)
    shares = profile.v[:, known] / typical_v
    total = np.zeros(row.size + 1)
    for press, (first, last) in enumerate(itertools.pairwise(signals.offsets.tolist())):
        own = shares[press][np.isfinite(shares[press])]
        if last - first < 2 * size or own.size == 0 or (louder := median(own)) <= 0:
            continue
        sums = total[: last - first + 1]
        np.cumsum(row[first:last], out=sums[1:])
        expected_v = usual_v[first + size // 2 : last][: sums.size - size] * louder
        ratio = (sums[size:] - sums[:-size]) / size / expected_v
        top = int(np.argmax(ratio))
        if ratio[top] > BURST:
            usual = np.flatnonzero(ratio < BURST_EDGE)
            begin = int(usual[usual < top].max(initial=-1)) + 1 + size // 2
            end = int(usual[usual > top].min(initial=ratio.size)) + size // 2
            span = (first if begin == size // 2 else first + begin, min(first + end, last))
            yield press, f"{signals.muscles[muscle]} has a burst of {ratio[top]:.1f} times its level", span


def spikes_in(x: Floats, first: int, last: int) -> Ints:
    """Samples of x (n,) that are spikes, or beside one; by what is usual in the press [first, last)."""
    press = x[first:last]
    if press.size < 50:
        return np.empty(0, np.int64)
    bend = x[2:] + x[:-2]
    bend /= 2
    np.abs(np.subtract(x[1:-1], bend, out=bend), out=bend)
    top, own = float(bend.max()), bend[first : last - 2]
    # where most are above that, so is their median, which costs more
    if 2 * np.count_nonzero(own >= 0.6745 / SPIKE_SD * top) > own.size:
        return np.empty(0, np.int64)
    typical = median(own) / 0.6745
    if not (typical > 0 and top > SPIKE_SD * typical):
        return np.empty(0, np.int64)
    # the potentials of few motor units stand out as well, but not from the loudest hundredth of the press
    loud = SPIKE_HEIGHT * float(np.quantile(np.abs(press - median(press)), 0.99))
    far = np.flatnonzero(bend > max(SPIKE_SD * typical, loud))
    # a spike bends three samples, two of them six; a burst of noise many in a row
    few = [
        np.count_nonzero(bend[max(i - 10, 0) : i + 11] > max(0.4 * SPIKE_SD * typical, SPIKE_SHARE * bend[i])) <= 6
        for i in far[:MOST_SPIKES].tolist()
    ]
    return far[:MOST_SPIKES][few] + 1


def spikes_of(signals: Signals, press: int) -> Iterator[tuple[str, str]]:
    begin, end = signals.presses[press].tolist()
    for muscle, samples in zip(signals.muscles, signals.samples, strict=True):
        n = spikes_in(samples[begin:end], 0, end - begin).size
        if n:
            yield muscle, f"{muscle} has spikes: {n} samples far from their neighbours"


def beats_of(signals: Signals) -> Iterator[tuple[str, str]]:
    """Heart beats: peaks of the rectified signal at rest, as regular as a pulse."""
    size = max(1, round(BEAT_S * signals.fs_hz))
    for muscle, samples in zip(signals.muscles, signals.samples, strict=True):
        n, seconds = 0, 0.0
        intervals: list[float] = []
        for begin, end in signals.rests.tolist():
            piece = samples[begin:end]
            if piece.size < 20 * size:
                continue
            rectified = piece - median(piece)
            total = np.cumsum(np.abs(rectified, out=rectified), out=rectified)
            smooth = total[size:] - total[:-size]
            seconds += piece.size / signals.fs_hz
            if 2 * np.count_nonzero(BEAT_LEVEL * smooth >= smooth.max()) > smooth.size:
                continue
            at = np.flatnonzero(smooth > BEAT_LEVEL * median(smooth))
            if at.size == 0:
                continue
            groups = np.split(at, np.flatnonzero(np.diff(at) > 0.2 * signals.fs_hz) + 1)
            peaks = [int(group[np.argmax(smooth[group])]) for group in groups]
            n += len(peaks)
            intervals += (np.diff(peaks) / signals.fs_hz).tolist()
        if n < BEATS or len(intervals) < BEATS - 2 or not BEAT_RATE_HZ[0] <= n / seconds <= BEAT_RATE_HZ[1]:
            continue
        spread = np.array(intervals)
        if float(np.std(spread)) < BEAT_SPREAD * float(np.mean(spread)):
            yield muscle, f"{muscle} shows the heart at rest, {60 / median(spread):.0f} beats a minute"


def repeated_of(
    signals: Signals, pieces: Sequence[Sequence[Floats]], alike: Sequence[int]
) -> Iterator[tuple[str, str]]:
    """Stretches of samples that occur twice, as when a wireless link sends a packet again: muscle and sentence.

    pieces : of each muscle, samples (k,) each. alike : how many samples of each muscle at most have a value that
        another one has.
    """
    weights = np.random.default_rng(0).uniform(1, 2, PACKET // 2)
    for muscle, of, most in zip(signals.muscles, pieces, alike, strict=True):
        n = sum(piece.size for piece in of) - PACKET + 1
        # a stretch that occurs twice begins with a sample that does
        if n < 2 or most <= TWICE * n:
            continue
        samples = np.concatenate(of)
        differs = (samples[1:] != samples[:-1]).view(np.int8)
        n_prints = 0
        for part in slices(n):
            print_of, changes = np.zeros(part.stop - part.start), np.zeros(part.stop - part.start, dtype=np.int8)
            for k, weight in enumerate(weights.tolist()):
                own = slice(2 * k + part.start, 2 * k + part.stop)
                print_of += weight * samples[own]
                changes += differs[own]
            kept = print_of[changes > PACKET // 4]
            samples[n_prints : n_prints + kept.size] = kept  # over samples that no later part needs
            n_prints += kept.size
        ordered = samples[:n_prints]
        ordered.sort()
        share = np.count_nonzero(ordered[1:] == ordered[:-1]) / n
        if share > TWICE:
            yield muscle, f"{muscle} has {100 * share:.1f} % of its samples twice; did the link send packets again?"
