"""The levels of the EMG in the rests of a recording: noise, and the tension of muscles that do not rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, median
from emg2vsa.extraction.emg_record import EmgRecord
from emg2vsa.signals.pairing import Instants
from emg2vsa.signals.quality import window_means
from emg2vsa.signals.rest import Rest
from emg2vsa.signals.verdicts import HELD_SHARE

TONE_BLOCK_S = 0.1
"Rests are compared by the means of blocks of this length."
TONE_CHANCE = 1e-4
"Noise alone makes the rests of a muscle differ with this probability."


def rests_heard(rest: Rest, start_s: float, fs_hz: float, record: EmgRecord) -> Rest:
    """Without the rests in which a muscle misses a tenth of its samples or more, or that begin after the EMG ends;
    start_s, fs_hz : of the force."""
    ends = (np.stack((rest.start, rest.stop), axis=-1) / fs_hz + start_s - record.start_s) * record.fs_hz
    missed = [
        max(
            (
                np.count_nonzero(part := gone[begin:end]) / part.size if begin < gone.size else 1.0
                for gone in record.missing
                if end > begin
            ),
            default=0.0,
        )
        for begin, end in np.maximum(np.rint(ends), 0).astype(np.int64).tolist()
    ]
    kept = np.array(missed, dtype=np.float64) < HELD_SHARE
    return replace(rest, **{name: getattr(rest, name)[kept] for name in ("start", "stop", "level_n", "slope")})


def rest_levels(envelopes_v: Floats, resting: Instants) -> tuple[Floats, Floats, float]:
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


def tension(envelopes_v: Floats, resting: Instants) -> float:
    """How many times as loud as in its most silent rest the muscle that rests least is in its loudest, (m, N)."""
    means = window_means(envelopes_v, resting.offsets)
    least = means.min(axis=1)
    return float(np.divide(means.max(axis=1), least, out=np.ones_like(least), where=least > 0).max())


def rests_differ(envelopes_v: Floats, resting: Instants, fs_hz: float) -> bool:
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
