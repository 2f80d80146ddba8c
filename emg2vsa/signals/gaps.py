"""Samples that are no EMG, and are few: spikes, values that are held or on a line, samples that are missing.

All are bridged.

A straight line takes their place before any filter, which would smear them. Where a gap is short beside the envelope's
memory that is all; a longer one is left out of the fit (``emg2vsa.signals.movement``).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, runs_of
from emg2vsa.signals.spikes import spikes_in
from emg2vsa.signals.verdicts import HELD_SHARE, HELD_WARNING_S, HELD_WARNING_SAMPLES

WIDEST = 8
"Most samples between two edges that are taken with them: of a short spike only the edges bend."
STRAIGHT = 1e-9
"""Share of the range of EMG around a press: samples that bend by less lie on a line, which somebody drew where they
were lost.
"""
REACH_S = 0.3
"Gaps are looked for so far before and after a press: the band-pass remembers them."


class Bridged(NamedTuple):
    """samples : (n,) of each muscle. lost : spans (k, 2) of each, first and last-plus-one sample, too long to bridge.

    spiked, missed : (p,) shares of the samples of each press, in the muscle that has most, that a line replaces.
    held : (m, p) shares of the samples of each press that are held, or lie on a line.
    """

    samples: tuple[Floats, ...]
    lost: list[Ints]
    spiked: Floats
    missed: Floats
    held: Floats


def bridge(samples: Sequence[Floats], missing: Sequence[NDArray[np.bool_]], fs_hz: float, presses: Ints) -> Bridged:
    """Raw EMG (n,) of each muscle without its gaps around the presses (p, 2); ``missing`` (n,) : already bridged.

    A muscle that holds values or misses samples for more than a tenth of a press keeps them there: that is no gap.
    """
    filled, lost = [], []
    shares, of_held = np.zeros((2, len(presses))), np.zeros((len(samples), len(presses)))
    reach, longest = round(REACH_S * fs_hz), max(HELD_WARNING_SAMPLES, round(HELD_WARNING_S * fs_hz))
    # the rests on either side belong to a press as well: their level is subtracted
    cuts = [0, *((presses[:-1, 1] + presses[1:, 0]) // 2).tolist(), min(map(len, samples), default=0)]
    for muscle, (x, absent) in enumerate(zip(samples, missing, strict=True)):
        left, spans = x, [np.empty((0, 2), np.int64)]
        for press, (first, last) in enumerate(presses.tolist()):
            begin, end = cuts[press : press + 2]
            near = slice(max(begin, first - reach), min(last + reach, end))
            most = HELD_SHARE * (last - first)
            spiked = spikes_in(x[begin:end], first - begin, last - begin)
            held, missed = _held(x[near], longest), np.count_nonzero(absent[first:last])
            held = held[~absent[near][held]]
            if not (held.size or spiked.size or missed):
                continue
            gone = np.zeros(end - begin, dtype=np.bool_)
            within = held + near.start
            of_held[muscle, press] = np.count_nonzero((within >= first) & (within < last)) / max(last - first, 1)
            if of_held[muscle, press] <= HELD_SHARE:
                gone[held + (near.start - begin)] = True
            if gone.any() or spiked.size:
                left = x.copy() if left is x else left
                replaced = gone.copy()
                replaced[spiked] = True
                for one, next_one in itertools.pairwise(spiked.tolist()):
                    replaced[one:next_one] |= next_one - one <= WIDEST
                at = np.arange(end - begin)
                left[begin:end][replaced] = np.interp(at[replaced], at[~replaced], x[begin:end][~replaced])
            inside = np.count_nonzero((spiked >= first - begin) & (spiked < last - begin))
            shares[0, press] = max(shares[0, press], inside / max(last - first, 1))
            if 0 < missed <= most:
                gone |= absent[begin:end]
                shares[1, press] = max(shares[1, press], missed / (last - first))
            if gone.any():
                runs = np.stack(runs_of(gone), axis=-1)
                spans.append(runs[runs[:, 1] - runs[:, 0] >= longest] + begin)
        filled.append(left)
        lost.append(np.concatenate(spans))
    return Bridged(tuple(filled), lost, shares[0], shares[1], of_held)


def _held(x: Floats, longest: int) -> Ints:
    """Which of the samples (n,) belong to a run of one value, or on one line, that is longer."""
    if x.size <= longest:
        return np.empty(0, np.int64)
    steps = x[1:] - x[:-1]
    straight = np.abs(steps[1:] - steps[:-1]) <= STRAIGHT * float(x.max() - x.min())
    # most runs are short: a converter's steps repeat by chance
    at, beyond = np.flatnonzero(straight), longest - 2
    if not (at[beyond:] - at[: max(at.size - beyond, 0)] == beyond).any():
        return np.empty(0, np.int64)
    first, last = runs_of(straight)
    long = last - first >= longest - 1
    return np.concatenate([*map(np.arange, first[long], last[long] + 2)])
