"""Mistakes that leave a recording readable and its numbers wrong, each recognised by what it does to the samples.

A remark says what was found and asks for the cause; ``emg2vsa.extraction.reasons`` holds the remedy of each. Limits
were set on simulated mishaps and on clean signals of many kinds (benchmarks/mishaps.py,
benchmarks/verdict_thresholds.py).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, combinations_with_replacement

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from emg2vsa.arrays import AT_ONCE, Floats, median, quantiles
from emg2vsa.signals.bias import means
from emg2vsa.signals.clipping import Rail, law_of
from emg2vsa.signals.level_drift import level_trends
from emg2vsa.signals.press_signals import Signals, by_press, correlation, pieces_of, volts
from emg2vsa.signals.quality import MAINS_HZ
from emg2vsa.signals.spikes import Profile, beats_of, bursts_of, repeated_of, spikes_of

LEVEL_V = (1e-6, 5e-3)
"Envelope of surface EMG during a press."
USUAL_V = 50e-6
POWERS = (-6, -3, 3, 6)
"Powers of ten: a unit that is taken for another, or an amplifier's gain that was not divided out."
LARGEST_RATIO, WITH_NOISE = 50.0, 5.0
"Between the envelopes of two muscles of one forearm; and where those at rest differ by as much, as by a gain."
SAME, CROSSTALK = 0.9, 0.4
"Correlation of two raw channels."
BLOCK_S = 0.25
"Spectra are taken of blocks of this length."
MAINS_WIDTH_HZ = 6.0
"So far from a mains line its leakage is looked past."
LOWEST_FS_HZ = 400.0
"Below this rate, a good part of the power of EMG lies above half the rate."
EMG_ABOVE_HZ, EMG_SHARE = 20.0, 0.2
"Raw EMG has more than this share of its power above this frequency."
SLOW_S, WANDER, HIGH_PASS_HZ = 0.05, 3.0, 10.0
"Baseline: means over this length, their spread over what is faster, and from where it is taken out to look past it."
BROAD_HZ, BROAD, RISES = 40.0, 0.48, 2.0
"""EMG on a baseline: share, of its power above 20 Hz, of what lies above 40 Hz (an envelope has up to 0.44, EMG from
0.51), and power over that at rest."""
PILED_UP, ONE_SIDED = 0.02, 0.4
"Rectified EMG: share of samples next to the lowest value, and lower over upper spread about the median."
TAIL = 1.32
"Upper tail over upper shoulder of EMG during the harder half of a press; a saturated amplifier has none."
PILED = (1.7, 1.5, 0.005)
"""... nor one whose tail is below this, where more samples lie in the last tenth below it than so many times those in
the tenth before, and more than this share."""
LAW_S = 0.2
"The law of the amplitude of a saturated channel is told by blocks of this length, in the softer parts of its presses."
LATE_S = 2.0
"Fewer seconds of it, as one press has, may lack a tail by chance: of a narrow band they hold few peaks."
LARGE_LAG_S = 0.3
"Force and EMG that are further apart cannot be compared press by press."
FOLLOWS, CLEARLY = 0.25, 3.0
"""Correlation of a muscle's envelope with ln F, median of the presses; lower ones are told unless their mean is so many
standard errors above none: envelopes of few motor units, or of a narrow band, are noisy, and follow all the same."""
FORCE_UNITS = {"lbf": 4.448222, "kgf": 9.80665, "gf": 1 / 101.97162, "mN": 1e-3, "kN": 1e3}
"Newtons in a unit that force may have been stored in."
PEAK_RANGE = (0.95, 1.5)
"Range of the peak of a press, as shares of the upper force of the window."

COARSE_VALUES, COARSE_PIECE, COARSE_LOOK = (3, 40), 4096, 256
"""EMG whose first samples of a press, so many, hold no more values than these is stored in steps of a fifth of its
level or more; one with fewer is flat, or no EMG. Most shows more values in its very first samples."""

NEAR_RAIL = 0.8
"Half of the presses reach so much of what a saturated channel ends at."
AT_EXTREME, MOST_AT_EXTREME = 0.99, 0.05
"A press with more than this share of its samples above this share of the largest was clipped; of EMG it is 0.1 %."


@dataclass(frozen=True)
class Plausibility:
    """fault : a mistake that is mended at the desk and spoils every press, or "". remarks : on the whole recording.

    of_press : warnings of each press. bursts : first and last-plus-one envelope of each. rails : by muscle, where a
    channel saturates.
    """

    fault: str
    remarks: tuple[str, ...]
    of_press: tuple[tuple[str, ...], ...]
    bursts: tuple[tuple[int, int], ...] = ()
    rails: Mapping[str, Rail] = field(default_factory=dict)


def plausibility(signals: Signals) -> Plausibility:
    """What is implausible about the EMG of a recording; nothing of one without presses."""
    stored = [pieces_of(x, signals.presses, 8) for x in signals.samples]
    n_presses = len(signals.offsets) - 1
    if n_presses == 0 or not stored or not stored[0]:
        return Plausibility("", (), ((),) * n_presses)
    signals, wandering = _settled(signals, stored)
    pieces = [pieces_of(x, signals.presses, 8) for x in signals.samples] if wandering else stored
    pairs, shares = _in_bands(signals, pieces)
    not_raw, alike = _not_raw(signals, pieces, shares)
    faults = [*not_raw.values(), *_levels(signals, not_raw), *_copies(pairs)]
    if faults:
        return Plausibility("; ".join(faults), (), ((),) * n_presses)
    coarse = dict(_coarse(signals, stored))
    beats, spikes = dict(beats_of(signals)), [dict(spikes_of(signals, press)) for press in range(n_presses)]
    if wandering:  # what was stored may repeat itself where what it was settled to does not
        alike = [sum(piece.size for piece in of) for of in stored]
    profiles = Profile.of(signals)
    rails, saturated = _saturated(signals, pieces)
    explained = {muscle for told in (beats, *spikes) for muscle in told}
    remarks = (
        *wandering, *_rate(signals), *_crosstalk(pairs), *_ratios(signals), *saturated,
        *_fading(signals), *beats.values(), *coarse.values(),
        *(said for muscle, said in repeated_of(signals, stored, alike) if muscle not in coarse),
        *(said for muscle, said in _deaf(signals) if muscle not in explained and abs(signals.lag_s) < LARGE_LAG_S),
    )  # fmt: skip
    of_press = [list(own.values()) for own in spikes]
    spans: list[tuple[int, int]] = []
    for number, (muscle, profile) in enumerate(zip(signals.muscles, profiles, strict=True)):
        for press, said, span in bursts_of(signals, number, profile) if muscle not in explained else ():
            of_press[press].append(said)
            spans.append(span)
    return Plausibility("", remarks, tuple(map(tuple, of_press)), tuple(spans), rails)


def _coarse(signals: Signals, stored: Sequence[Sequence[Floats]]) -> Iterator[tuple[str, str]]:
    """Channels whose converter's steps are coarse beside their EMG."""
    for muscle, pieces in zip(signals.muscles, stored, strict=True):
        samples = np.concatenate(pieces)[:COARSE_PIECE]
        if np.unique(samples[:COARSE_LOOK]).size > COARSE_VALUES[1]:
            continue
        values = np.unique(samples)
        if COARSE_VALUES[0] <= values.size <= COARSE_VALUES[1]:
            step_v = float(np.diff(values).min())
            if np.allclose(steps := np.diff(values) / step_v, np.rint(steps), atol=0.05):
                yield muscle, f"{muscle} is stored in steps of {volts(step_v)}, coarse beside its EMG"


def _settled(signals: Signals, stored: Sequence[Sequence[Floats]]) -> tuple[Signals, list[str]]:
    """The signals, EMG without a baseline that is far larger than it, and what is to be said of that.

    What lies on the baseline is EMG where its power spreads past that of an envelope's ripple, and rises over rest.
    """
    size = max(1, round(SLOW_S * signals.fs_hz))
    samples, said = list(signals.samples), []
    for m, (muscle, of) in enumerate(zip(signals.muscles, stored, strict=True)):
        if sum(piece.size // size for piece in of) < 2:
            continue
        blocks = np.concatenate([piece[: piece.size // size * size] for piece in of]).reshape(-1, size)
        means = blocks.mean(axis=1)
        blocks -= means[:, None]
        low_v, high_v = quantiles(np.sort(means), 0.05, 0.95)
        wanders_v = high_v - low_v
        if wanders_v <= WANDER * np.sqrt(float(np.square(blocks, out=blocks).sum()) / blocks.size):
            continue
        sections = signal.butter(2, HIGH_PASS_HZ, "highpass", fs=signals.fs_hz, output="sos")
        fast = np.asarray(signal.sosfiltfilt(sections, samples[m]), dtype=np.float64)
        resting = pieces_of(fast, signals.rests, round(BLOCK_S * signals.fs_hz))
        if not resting:
            continue
        hz, pressing = _spectra(pieces_of(fast, signals.presses, 8), signals.fs_hz)
        above, broad, rest = (
            float(np.mean(np.sum(each[:, hz >= corner_hz].real ** 2 + each[:, hz >= corner_hz].imag ** 2, axis=1)))
            for each, corner_hz in (
                (pressing, EMG_ABOVE_HZ), (pressing, BROAD_HZ), (_spectra(resting, signals.fs_hz)[1], EMG_ABOVE_HZ),
            )
        )  # fmt: skip
        if broad > BROAD * above and above > RISES * rest:
            samples[m] = fast
            said.append(f"the baseline of {muscle} wanders by {volts(wanders_v)}; it was removed")
    return (replace(signals, samples=tuple(samples)) if said else signals), said


def force_unit_doubt(force_n: Floats, window_n: tuple[float, float]) -> str:
    """Which unit the tared force (n,) may have been stored in, where as newtons it misses the window; else ""."""
    upper_n = window_n[1]
    peak_n = float(np.max(force_n, initial=0.0))
    if peak_n <= 0 or 0.5 * upper_n < peak_n < 20 * upper_n:
        return ""
    for unit, newtons in FORCE_UNITS.items():
        if PEAK_RANGE[0] * upper_n <= peak_n * newtons <= PEAK_RANGE[1] * upper_n:
            return f"force peaks at {peak_n:.3g} N; is its unit {unit} (1 {unit} = {newtons:.4g} N)?"
    return ""


def _is_clipped(samples: Floats) -> bool:
    """Whether (n,) samples lie at their extreme again and again."""
    size = np.abs(samples)
    at_extreme = size >= AT_EXTREME * np.max(size, initial=0.0)
    return bool(np.count_nonzero(at_extreme) > MOST_AT_EXTREME * samples.size)


def _levels(signals: Signals, besides: Collection[str]) -> Iterator[str]:
    for muscle, samples, row, rest_v in zip(
        signals.muscles, signals.samples, signals.envelopes_v, signals.rest_v.tolist(), strict=True
    ):
        of_press = [
            (quantiles(np.sort(v), 0.8)[0], bounds)
            for v, bounds in zip(by_press(row, signals.offsets), signals.presses.tolist(), strict=True) if v.size
        ]  # fmt: skip
        if muscle in besides or all(LEVEL_V[0] <= level_v <= LEVEL_V[1] for level_v, _ in of_press):
            continue
        # a unit is wrong in every press, and a press that was clipped or lost its electrode says nothing of it
        each_v = [level_v for level_v, (first, last) in of_press if not _is_clipped(samples[first:last])]
        level_v = sorted(each_v)[(len(each_v) - 1) // 2] if each_v else 0.0
        # a channel that shows nothing of the press is an electrode's matter, not a unit's
        if level_v <= 0 or level_v < 2 * rest_v or LEVEL_V[0] <= level_v <= LEVEL_V[1]:
            continue
        power = min(POWERS, key=lambda p: abs(np.log10(level_v * 10.0**-p / USUAL_V)))
        if not LEVEL_V[0] <= level_v * 10.0**-power <= LEVEL_V[1]:
            continue
        if power > 0:
            unit = {3: "mV", 6: "uV"}[power]
            yield f"{muscle} is {volts(level_v)} during a press; is its unit {unit}, or its gain 10^{power}?"
        else:
            yield f"{muscle} is {volts(level_v)} during a press; is its unit larger by 10^{-power}, or its gain 1?"


def _not_raw(
    signals: Signals, pieces: Sequence[Sequence[Floats]], shares: Sequence[float]
) -> tuple[dict[str, str], list[int]]:
    """Muscle to why it is rectified, enveloped, or no EMG at all: told by one-sidedness and by the power below 20 Hz.
    And how many samples of each have the value of another one."""
    told: dict[str, str] = {}
    alike = []
    for muscle, of, share in zip(signals.muscles, pieces, shares, strict=True):
        joined = np.concatenate(of)
        joined.sort()
        alike.append(int(np.count_nonzero(joined[1:] == joined[:-1])))
        if share < EMG_SHARE:
            follows = [
                correlation(piece, np.interp(np.linspace(0, 1, piece.size), np.linspace(0, 1, force.size), force))
                for piece, force in zip(of, by_press(signals.force_n, signals.offsets), strict=False)
                if force.size > 1
            ]
            low = f"{100 * (1 - share):.0f} % of the power of {muscle} lies below {EMG_ABOVE_HZ:g} Hz"
            if follows and abs(median(np.array(follows))) > 0.5:
                told[muscle] = f"{low}; is it an envelope, or another signal, instead of raw EMG?"
            elif share < EMG_SHARE / 2:
                told[muscle] = f"{low}, and does not follow the force; is its electrode on?"
            continue
        lowest, middle, highest = quantiles(joined, 0.001, 0.5, 0.999)
        for side, near, far in (("negative", middle - lowest, highest - middle),
                                ("positive", highest - middle, middle - lowest)):  # fmt: skip
            if not near < ONE_SIDED * far:
                continue
            edge = joined - lowest if side == "negative" else highest - joined
            clips = np.mean(joined == joined[0 if side == "negative" else -1]) > 0.001
            if np.mean(edge < 0.1 * near) > PILED_UP and not clips:
                told[muscle] = f"{muscle} is never {side}; is it rectified already?"
    return told, alike


def _spectra(pieces: Sequence[Floats], fs_hz: float) -> tuple[Floats, NDArray[np.complex128]]:
    """Frequencies (F,) and spectra (q, F) of all whole blocks of a quarter of a second, less their means."""
    size = max(8, round(BLOCK_S * fs_hz))
    blocks = np.concatenate([piece[: piece.size // size * size] for piece in pieces]).reshape(-1, size)
    window = np.hanning(size)
    hz = np.fft.rfftfreq(size, 1 / fs_hz).astype(np.float64)
    return hz, np.fft.rfft((blocks - blocks.mean(axis=1, keepdims=True)) * window)


def _in_bands(signals: Signals, pieces: Sequence[Sequence[Floats]]) -> tuple[list[Pair], list[float]]:
    """How every pair of raw channels correlates, above 20 Hz and without the mains that all share; and the share of
    each channel's power above 20 Hz, 1 where there is no power."""
    m = len(pieces)
    common, above, total = np.zeros((m, m)), np.zeros(m), np.zeros(m)
    sizes = np.cumsum([piece.size for piece in pieces[0]]) // AT_ONCE
    for group in np.split(np.arange(sizes.size), np.flatnonzero(np.diff(sizes)) + 1):
        found = [_spectra([of[k] for k in group.tolist()], signals.fs_hz) for of in pieces]
        hz = found[0][0]
        mains = np.min([np.abs(hz - each * np.rint(hz / each)) for each in MAINS_HZ], axis=0)
        kept = (hz > EMG_ABOVE_HZ) & (mains > MAINS_WIDTH_HZ)
        rows = [each[:, kept].ravel() for _, each in found]
        for i, j in combinations_with_replacement(range(m), 2):
            common[i, j] += float(np.vdot(rows[i], rows[j]).real)
        for i, (_, each) in enumerate(found):
            power = np.sum(each.real**2 + each.imag**2, axis=0)
            total[i] += float(power.sum())
            above[i] += float(power[hz >= EMG_ABOVE_HZ].sum())
    pairs = []
    for i, j in combinations(range(m), 2):
        norm = float(np.sqrt(common[i, i] * common[j, j]))
        pairs.append((signals.muscles[i], signals.muscles[j], common[i, j] / norm if norm > 0 else 0.0))
    return pairs, np.divide(above, total, out=np.ones(m), where=total > 0).tolist()


Pair = tuple[str, str, float]
"""Two muscles, and how their raw channels correlate."""


def _copies(pairs: Sequence[Pair]) -> Iterator[str]:
    for one, other, r in pairs:
        if abs(r) > SAME:
            yield f"{one} and {other} are one signal (r = {r:.2f}); was one channel exported twice?"


def _crosstalk(pairs: Sequence[Pair]) -> Iterator[str]:
    for one, other, r in pairs:
        if CROSSTALK < abs(r) <= SAME:
            share = (1 - np.sqrt(1 - r**2)) / abs(r)
            yield f"{one} and {other} share about {100 * share:.0f} % of their signal (r = {r:.2f}): crosstalk"


def _rate(signals: Signals) -> Iterator[str]:
    if signals.fs_hz < LOWEST_FS_HZ:
        yield f"EMG at {signals.fs_hz:.4g} Hz holds only what lies below {signals.fs_hz / 2:.3g} Hz"


def _ratios(signals: Signals) -> Iterator[str]:
    level_v = [quantiles(np.sort(row), 0.8)[0] for row in signals.envelopes_v]
    loud, quiet = int(np.argmax(level_v)), int(np.argmin(level_v))
    ratio = level_v[loud] / level_v[quiet] if level_v[quiet] > 0 else 0.0
    rests = signals.rest_v[loud] / signals.rest_v[quiet] if signals.rest_v[quiet] > 0 else 0.0
    if ratio > LARGEST_RATIO or min(ratio, rests) > WITH_NOISE:
        one, other = signals.muscles[loud], signals.muscles[quiet]
        yield f"{one} is {ratio:.2g} times as loud as {other}; are their gains right?"


def _saturated(signals: Signals, pieces: Sequence[Sequence[Floats]]) -> tuple[dict[str, Rail], list[str]]:
    """Samples of the last two fifths of each press crowd below their largest, by muscle; and what is said of it."""
    rails: dict[str, Rail] = {}
    said = []
    for m, (muscle, of) in enumerate(zip(signals.muscles, pieces, strict=True)):
        if np.mean(signals.envelopes_v[m]) < 1.2 * signals.rest_v[m]:
            continue
        late = np.concatenate([piece[int(0.6 * piece.size) :] - median(piece) for piece in of])
        if late.size < LATE_S * signals.fs_hz:
            continue
        late.sort()
        tails = []
        for side in (late, -late[::-1]):
            shoulder, top = quantiles(side, 0.95, 0.9995)
            tail = top / shoulder if shoulder > 0 else np.inf
            below, near = side.size - np.searchsorted(side, (0.8 * top, 0.9 * top))
            piled = tail < PILED[0] and near > PILED[1] * (below - near) and near > PILED[2] * side.size
            if piled or tail < TAIL:
                tails.append((tail, top, piled))
        if tails:
            early = [piece[: int(0.4 * piece.size)] - median(piece) for piece in of]
            _, top, piled = min(tails)
            if median(np.array([np.max(np.abs(piece - median(piece))) for piece in of])) < NEAR_RAIL * top:
                continue  # a press that lost its electrode shows mains, whose crest no other press comes near
            rails[muscle] = Rail(top, law_of(early, round(LAW_S * signals.fs_hz)), len(tails), bool(piled))
            shown = volts(float(np.quantile(np.abs(late), 0.95)))
            said.append(f"{muscle} has no sample far above {shown}; is it saturated?")
    return rails, said


def _fading(signals: Signals) -> Iterator[str]:
    """Muscles whose level has a trend over the presses."""
    for muscle, slope in zip(signals.muscles, level_trends(signals.envelopes_v, signals.offsets)[0], strict=True):
        if slope:
            yield f"{muscle} {'fades' if slope < 0 else 'grows'} to {100 * np.exp(slope):.0f} % over the presses"


def _deaf(signals: Signals) -> Iterator[tuple[str, str]]:
    offsets = signals.offsets
    counts = np.diff(offsets)
    x = np.log(np.maximum(signals.force_n, 1e-3))
    x = x - np.repeat(means(x, offsets), counts)
    y = signals.envelopes_v - np.repeat(means(signals.envelopes_v, offsets), counts, axis=1)
    norm = np.sqrt(means(x * x, offsets) * means(y * y, offsets))
    r = np.divide(means(x * y, offsets), norm, out=np.zeros_like(norm), where=norm > 0)[:, counts > 10]
    for muscle, each in zip(signals.muscles, r, strict=True):
        clear = each.size > 1 and each.mean() > CLEARLY * each.std(ddof=1) / np.sqrt(each.size)
        # one press tells no scatter, and falls short by chance more often
        if each.size and not clear and (typical := median(each)) < (FOLLOWS if each.size > 1 else FOLLOWS / 2):
            yield muscle, f"{muscle} does not rise with force (r = {typical:.2f})"
