"""Where the electrode or its cable moves: a jump at contact, a tug. Told by power below EMG, and left out of the fit.

Movement has its power below some 20 Hz, where EMG has little. In steps of 10 ms the slow part of the raw signal (means
of two steps, less their running mean) is compared with what lies above it. Their ratio is a property of the recording;
a moment in which it is many times larger than usual is no EMG.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, median, quantiles, sums_of
from emg2vsa.signals.bias import Cause, Shift, line_change, means, taken_out

STEP_S = 0.01
WANDER_STEPS, SLOW_STEPS, FAST_STEPS = 15, 6, 15
"Running mean that is taken off as wander; power of the slow part, and of what is faster, is averaged over so many."
TIMES, TIMES_HIGH = 14.0, 6.5
"""Moments at which the ratio is so many times the usual one, and so many times what a tenth of the moments exceed,
begin a span (few motor units make it uneven), ..."""
EDGE = 5.0
"... which goes on while it is more than so many times that."
CONTACTS, CONTACT_STEPS, CONTACT_TIMES, CONTACT_BEGINS, CONTACT_EDGE = 5, 12, 2.1, 1.3, 0.9
"""Where EMG is slow itself, its ratio is high already. Of so many presses, by median, the highest ratio so near to the
lower force is compared with that of other stretches as long: above so many times it, electrodes move at contact, and
spans there begin and end at these lower limits."""
BEFORE_S = 0.5
"The press is looked at from so long before its lower force."
MARGIN_STEPS = 3
"A span is widened by so much: the means smear its ends."


def movement(samples: Sequence[Floats], fs_hz: float, presses: Ints, rests: Ints) -> list[NDArray[np.int64]]:
    """Spans (k, 2) of each muscle, first and last-plus-one sample, in which it moves; around the presses (p, 2).

    samples : raw EMG (n,) of each muscle. rests : (r, 2).
    """
    size = max(1, round(STEP_S * fs_hz))
    n = min(x.size for x in samples) // size if samples else 0
    if n < 4 * WANDER_STEPS or not len(presses):
        return [np.empty((0, 2), np.int64) for _ in samples]
    contacts = presses[presses[:, 0] < n * size, 0] // size
    near, inside, resting = (np.zeros(n, dtype=np.bool_) for _ in range(3))
    before = round(BEFORE_S * fs_hz)
    for first, last in presses.tolist():
        near[max(0, first - before) // size : -(-last // size)] = True
        inside[first // size : -(-last // size)] = True
    for first, last in rests.tolist():
        resting[first // size : last // size] = True
    return [_spans(x[: n * size].reshape(n, size), size, near, inside, resting, contacts) for x in samples]


def _spans(
    steps: Floats, size: int, near: NDArray[np.bool_], inside: NDArray[np.bool_], resting: NDArray[np.bool_],
    contacts: Ints,
) -> NDArray[np.int64]:  # fmt: skip
    means = sums_of(steps) / size
    fast = np.maximum(np.einsum("ij,ij->i", steps, steps) / size - means**2, 0.0)
    pairs = means.copy()
    pairs[:-1] += means[1:]
    pairs /= 2
    slow = _running(np.square(pairs - _running(pairs, WANDER_STEPS)), SLOW_STEPS)
    fast = _running(fast, FAST_STEPS)
    known = inside & (fast > 0)
    if not known.any():
        return np.empty((0, 2), np.int64)
    usual = median(slow[known] / fast[known])
    at_rest = median(slow[resting]) if resting.any() else 0.0
    expected = usual * fast + at_rest
    ratio = slow[known] / expected[known]
    least = np.full(slow.size, max(TIMES, TIMES_HIGH * quantiles(np.sort(ratio), 0.9)[0]))
    edge = np.full(slow.size, EDGE)
    times = np.divide(slow, expected, out=np.zeros(slow.size), where=expected > 0)
    elsewhere = median(_highest(times[inside], np.arange(0, np.count_nonzero(inside), CONTACT_STEPS)))
    if contacts.size >= CONTACTS and median(_highest(times, contacts)) > CONTACT_TIMES * elsewhere:
        for contact in contacts.tolist():
            at = slice(max(contact - CONTACT_STEPS, 0), contact + CONTACT_STEPS + 1)
            least[at], edge[at] = CONTACT_BEGINS * elsewhere, CONTACT_EDGE * elsewhere
    begun = near & (slow > least * expected)
    if not begun.any():
        return np.empty((0, 2), np.int64)
    goes_on = slow > edge * expected
    edges = np.flatnonzero(np.diff(np.concatenate(([0], goes_on.view(np.int8), [0]))))
    found = [
        (first - MARGIN_STEPS, last + MARGIN_STEPS)
        for first, last in edges.reshape(-1, 2).tolist()
        if begun[first:last].any()
    ]
    return np.maximum(np.array(found, dtype=np.int64), 0) * size


def _highest(values: Floats, at: Ints) -> Floats:
    """Largest of the values (n,) within ``CONTACT_STEPS`` of each place (k,)."""
    padded = np.concatenate((edge := np.zeros(CONTACT_STEPS), values, edge))
    return np.asarray(np.max(padded[at[:, None] + np.arange(2 * CONTACT_STEPS + 1)], axis=1))


def _running(values: Floats, width: int) -> Floats:
    """Mean over ``width`` neighbours of each."""
    return np.convolve(values, np.full(width, 1 / width), mode="same")


def left_out(spans: Sequence[NDArray[np.int64]], at: Ints, before: int, after: int) -> NDArray[np.bool_]:
    """Which envelopes (N,) at the samples ``at`` (N,) hold a span of any muscle; they remember so many samples."""
    found = np.zeros(at.size, dtype=np.bool_)
    for first, last in np.concatenate([*spans, np.empty((0, 2), np.int64)]).tolist():
        found |= (at > first - after) & (at < last + before)
    return found


def bridged(envelopes_v: Floats, gone: NDArray[np.bool_], offsets: Ints) -> Floats:
    """Envelopes (m, N) with straight lines over what is ``gone`` (N,), press by press; what checks look at."""
    filled = envelopes_v.copy()
    for begin, end in zip(offsets[:-1].tolist(), offsets[1:].tolist(), strict=True):
        own = gone[begin:end]
        if own.any() and not own.all():
            at = np.arange(end - begin)
            for row in filled:
                row[begin:end][own] = np.interp(at[own], at[~own], row[begin:end][~own])
    return filled


def change_by_disturbance(
    cause: Cause, force_n: Floats, level: Floats, offsets: Ints, disturbed: tuple[Floats, NDArray[np.bool_]],
    without: tuple[Floats, NDArray[np.bool_]], error: Floats | float = 0.0,
) -> Shift:  # fmt: skip
    """Change of b of each press by a cause that was taken out, as a share of what b is without it.

    disturbed, without : activity (N,), and which of its samples there would be with the cause, and are without it.
    """
    x = np.log(np.maximum(force_n, 1e-9))
    counted, slopes = [], []
    for activity, mask in (disturbed, without):
        cuts = np.concatenate(([0], np.cumsum(mask)))[offsets]
        _, change = line_change(x[mask], activity[mask], x[mask], x[mask], level[mask], cuts)
        slopes.append(change + 1)
        counted.append(np.where(mask, activity, 0.0))
    touched = means((counted[0] != counted[1]).astype(np.float64), offsets) > 0
    with np.errstate(divide="ignore", invalid="ignore"):
        b = np.where(touched, slopes[0] / slopes[1] - 1, 0.0)
    return taken_out(cause, np.nan_to_num(b, posinf=0.0, neginf=0.0), error)
