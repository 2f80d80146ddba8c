"""Mistakes that leave a recording readable and its numbers wrong, each recognised by what it does to the samples.

A remark says what was found and asks for the cause; ``emg2vsa.extraction.reasons`` holds the remedy of each. Limits
were set on simulated mishaps and on clean signals of many kinds (benchmarks/mishaps.py,
benchmarks/verdict_thresholds.py).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from emg2vsa.arrays import Floats, Ints, median, quantiles
from emg2vsa.signals.quality import MAINS_HZ

LEVEL_V = (1e-6, 5e-3)
"Envelope of surface EMG during a press."
USUAL_V = 50e-6
POWERS = (-6, -3, 3, 6)
"Of ten: a unit that is taken for another, or an amplifier's gain that was not divided out."
LARGEST_RATIO = 50.0
"Between the envelopes of two muscles of one forearm."
SAME, CROSSTALK = 0.9, 0.4
"Correlation of two raw channels."
BLOCK_S = 0.25
"Spectra are taken of blocks of this length."
MAINS_WIDTH_HZ = 6.0
"So far from a mains line its leakage is looked past."
LOWEST_FS_HZ = 400.0
"Below, a good part of the power of EMG lies above half the rate."
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
FADE, FADE_T, FADE_PRESSES = 0.3, 4.0, 5
"Change of a muscle's ln level over the recording, in units of its standard error, and from how many presses."
LARGE_LAG_S = 0.3
"Force and EMG that are further apart cannot be compared press by press."
FOLLOWS = 0.25
"Correlation of a muscle's envelope with ln F, median of the presses."
BURST_S, BURST, CONTACT = 0.1, 3.0, 0.5
"Length of a burst, its level over that of the other presses, and excess at contact over the level at half the force."
SPIKE_SD, SPIKE_HEIGHT = 15.0, 3.0
"A sample this far from its two neighbours' mean, in robust SDs of the press and over its loud parts, is no EMG."
BEAT_S, BEAT_LEVEL, BEATS, BEAT_RATE_HZ, BEAT_SPREAD = 0.03, 4.0, 5, (0.7, 3.3), 0.25
"Heart beats at rest: length, height over the median, how many at least, how often, and spread of their intervals."
PACKET, TWICE = 12, 0.005
"Samples in a row that no signal repeats by chance, and the share of such that is remarked."
FORCE_UNITS = {"lbf": 4.448222, "kgf": 9.80665, "gf": 1 / 101.97162, "mN": 1e-3, "kN": 1e3}
"Newtons in a unit that force may have been stored in."
PEAK_RANGE = (0.95, 1.5)
"Of the upper force of the window: where the peak of a press lies."

AT_EXTREME, MOST_AT_EXTREME = 0.99, 0.05
"A press with more than this share of its samples above this share of the largest was clipped; of EMG it is 0.1 %."


@dataclass(frozen=True)
class Plausibility:
    """fault : a mistake that is mended at the desk and spoils every press, or "". remarks : on the whole recording.

    of_press : warnings of each press.
    """

    fault: str
    remarks: tuple[str, ...]
    of_press: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Signals:
    """What is looked at: raw samples (n,) in volts by muscle at ``fs_hz``, and where the presses and the rests are.

    presses, rests : (p, 2), (r, 2) first and last-plus-one sample. rest_v : (m,) envelopes at rest, NaN if unknown.
    force_n : (N,) and envelopes_v : (m, N) of the
    presses, evenly sampled at ``envelope_fs_hz`` and cut by ``offsets`` (p + 1,).
    lag_s : force follows EMG so late.
    """

    muscles: tuple[str, ...]
    samples: tuple[Floats, ...]
    fs_hz: float
    presses: Ints
    rests: Ints
    rest_v: Floats
    force_n: Floats
    envelopes_v: Floats
    envelope_fs_hz: float
    offsets: Ints
    lag_s: float = 0.0


def plausibility(signals: Signals) -> Plausibility:
    """What is implausible about the EMG of a recording; nothing of one without presses."""
    stored = [_pieces(x, signals.presses, 8) for x in signals.samples]
    n_presses = len(signals.offsets) - 1
    if n_presses == 0 or not stored or not stored[0]:
        return Plausibility("", (), ((),) * n_presses)
    signals, wandering = _settled(signals, stored)
    pieces = [_pieces(x, signals.presses, 8) for x in signals.samples] if wandering else stored
    found = [_spectra(of, signals.fs_hz) for of in pieces]
    hz, spectra = found[0][0], [each for _, each in found]
    pairs = list(_correlations(signals, hz, spectra))
    shares = [_share_above(hz, each, EMG_ABOVE_HZ) for each in spectra]
    not_raw = dict(_not_raw(signals, pieces, shares))
    faults = [*not_raw.values(), *_levels(signals, not_raw), *_copies(pairs)]
    if faults:
        return Plausibility("; ".join(faults), (), ((),) * n_presses)
    beats, spikes = dict(_beats(signals)), [dict(_spikes(signals, press)) for press in range(n_presses)]
    profiles = [_Profile.of(signals, muscle) for muscle in range(len(signals.muscles))]
    contacts = dict(_contacts(signals, profiles)) if abs(signals.lag_s) < LARGE_LAG_S else {}
    explained = {muscle for told in (beats, contacts, *spikes) for muscle in told}
    remarks = (
        *wandering, *_rate(signals), *_crosstalk(pairs), *_ratios(signals), *_saturated(signals, pieces),
        *_fading(signals), *contacts.values(), *beats.values(), *_repeated(signals, stored),
        *(said for muscle, said in _deaf(signals) if muscle not in explained and abs(signals.lag_s) < LARGE_LAG_S),
    )  # fmt: skip
    of_press = []
    for press, own in enumerate(spikes):
        bursts = [said for muscle, said in _bursts(signals, profiles, press) if muscle not in explained]
        of_press.append((*own.values(), *bursts))
    return Plausibility("", remarks, tuple(of_press))


def _pieces(x: Floats, bounds: Ints, at_least: int) -> list[Floats]:
    return [x[i:j] for i, j in bounds.tolist() if j - i >= at_least]


def _settled(signals: Signals, stored: Sequence[Sequence[Floats]]) -> tuple[Signals, list[str]]:
    """The signals, EMG without a baseline that is far larger than it, and what is to be said of that.

    What lies on the baseline is EMG where its power spreads past that of an envelope's ripple, and rises over rest.
    """
    size = max(1, round(SLOW_S * signals.fs_hz))
    samples, said = list(signals.samples), []
    for m, (muscle, of) in enumerate(zip(signals.muscles, stored, strict=True)):
        blocks = np.concatenate([piece[: piece.size // size * size] for piece in of]).reshape(-1, size)
        means = blocks.mean(axis=1)
        if means.size < 2:
            continue
        wanders_v = float(np.subtract(*np.quantile(means, (0.95, 0.05))))
        if wanders_v <= WANDER * float(np.std(blocks - means[:, None])):
            continue
        sections = signal.butter(2, HIGH_PASS_HZ, "highpass", fs=signals.fs_hz, output="sos")
        fast = np.asarray(signal.sosfiltfilt(sections, samples[m]), dtype=np.float64)
        resting = _pieces(fast, signals.rests, round(BLOCK_S * signals.fs_hz))
        if not resting:
            continue
        hz, pressing = _spectra(_pieces(fast, signals.presses, 8), signals.fs_hz)
        above, broad, rest = (
            float(np.mean(np.sum(each[:, hz >= corner_hz].real ** 2 + each[:, hz >= corner_hz].imag ** 2, axis=1)))
            for each, corner_hz in (
                (pressing, EMG_ABOVE_HZ), (pressing, BROAD_HZ), (_spectra(resting, signals.fs_hz)[1], EMG_ABOVE_HZ),
            )
        )  # fmt: skip
        if broad > BROAD * above and above > RISES * rest:
            samples[m] = fast
            said.append(f"the baseline of {muscle} wanders by {_volts(wanders_v)}; it was removed")
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
        # a unit is wrong in every press, and a press that was clipped or lost its electrode says nothing of it
        clipped = [_is_clipped(samples[first:last]) for first, last in signals.presses.tolist()]
        cut = np.split(row, signals.offsets[1:-1])
        each_v = [quantiles(np.sort(one), 0.8)[0] for one, no in zip(cut, clipped, strict=True) if one.size and not no]
        level_v = sorted(each_v)[(len(each_v) - 1) // 2] if each_v else 0.0
        # a channel that shows nothing of the press is an electrode's matter, not a unit's
        if muscle in besides or level_v <= 0 or level_v < 2 * rest_v or LEVEL_V[0] <= level_v <= LEVEL_V[1]:
            continue
        power = min(POWERS, key=lambda p: abs(np.log10(level_v * 10.0**-p / USUAL_V)))
        if not LEVEL_V[0] <= level_v * 10.0**-power <= LEVEL_V[1]:
            continue
        if power > 0:
            unit = {3: "mV", 6: "uV"}[power]
            yield f"{muscle} is {_volts(level_v)} during a press; is its unit {unit}, or its gain 10^{power}?"
        else:
            yield f"{muscle} is {_volts(level_v)} during a press; is its unit larger by 10^{-power}, or its gain 1?"


def _volts(level_v: float) -> str:
    for scale, unit in ((1.0, "V"), (1e-3, "mV"), (1e-6, "uV"), (1e-9, "nV")):
        if level_v >= scale:
            return f"{level_v / scale:.2g} {unit}" if level_v < 99.5 * scale else f"{level_v / scale:.0f} {unit}"
    return f"{level_v:.1g} V"


def _not_raw(
    signals: Signals, pieces: Sequence[Sequence[Floats]], shares: Sequence[float]
) -> Iterator[tuple[str, str]]:
    """Rectified, enveloped, or no EMG at all: told by one-sidedness and by the power below 20 Hz."""
    for m, muscle in enumerate(signals.muscles):
        share = shares[m]
        if share < EMG_SHARE:
            follows = [
                _correlation(piece, np.interp(np.linspace(0, 1, piece.size), np.linspace(0, 1, force.size), force))
                for piece, force in zip(pieces[m], _cut(signals.force_n, signals.offsets), strict=False)
                if force.size > 1
            ]
            low = f"{100 * (1 - share):.0f} % of the power of {muscle} lies below {EMG_ABOVE_HZ:g} Hz"
            if follows and abs(median(np.array(follows))) > 0.5:
                yield muscle, f"{low}; is it an envelope, or another signal, instead of raw EMG?"
            elif share < EMG_SHARE / 2:
                yield muscle, f"{low}, and does not follow the force; is its electrode on?"
            continue
        joined = np.sort(np.concatenate(pieces[m]))
        lowest, middle, highest = quantiles(joined, 0.001, 0.5, 0.999)
        for side, near, far in (("negative", middle - lowest, highest - middle),
                                ("positive", highest - middle, middle - lowest)):  # fmt: skip
            edge = joined - lowest if side == "negative" else highest - joined
            clips = np.mean(joined == joined[0 if side == "negative" else -1]) > 0.001
            if near < ONE_SIDED * far and np.mean(edge < 0.1 * near) > PILED_UP and not clips:
                yield muscle, f"{muscle} is never {side}; is it rectified already?"


def _spectra(pieces: Sequence[Floats], fs_hz: float) -> tuple[Floats, NDArray[np.complex128]]:
    """Frequencies (F,) and spectra (q, F) of all whole blocks of a quarter of a second, less their means."""
    size = max(8, round(BLOCK_S * fs_hz))
    blocks = np.concatenate([piece[: piece.size // size * size] for piece in pieces]).reshape(-1, size)
    window = np.hanning(size)
    hz = np.fft.rfftfreq(size, 1 / fs_hz).astype(np.float64)
    return hz, np.fft.rfft((blocks - blocks.mean(axis=1, keepdims=True)) * window)


def _share_above(hz: Floats, spectra: NDArray[np.complex128], corner_hz: float) -> float:
    """Share of the power above a frequency; 1 where there is none."""
    power = np.sum(spectra.real**2 + spectra.imag**2, axis=0)
    total = float(power.sum())
    return float(power[hz >= corner_hz].sum()) / total if total > 0 else 1.0


def _correlations(signals: Signals, hz: Floats, spectra: Sequence[NDArray[np.complex128]]) -> Iterator[Pair]:
    """Muscles and correlation of every pair of raw channels, above 20 Hz and without the mains that all share."""
    mains = np.min([np.abs(hz - each * np.rint(hz / each)) for each in MAINS_HZ], axis=0)
    kept = (hz > EMG_ABOVE_HZ) & (mains > MAINS_WIDTH_HZ)
    rows = [each[:, kept].ravel() for each in spectra]
    power = [float(np.vdot(x, x).real) for x in rows]
    for i, j in combinations(range(len(rows)), 2):
        norm = float(np.sqrt(power[i] * power[j]))
        r = float(np.vdot(rows[i], rows[j]).real) / norm if norm > 0 else 0.0
        yield signals.muscles[i], signals.muscles[j], r


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
    level_v = np.quantile(signals.envelopes_v, 0.8, axis=1)
    loud, quiet = int(np.argmax(level_v)), int(np.argmin(level_v))
    if level_v[quiet] > 0 and level_v[loud] > LARGEST_RATIO * level_v[quiet]:
        ratio = level_v[loud] / level_v[quiet]
        one, other = signals.muscles[loud], signals.muscles[quiet]
        yield f"{one} is {ratio:.2g} times as loud as {other}; are their gains right?"


def _saturated(signals: Signals, pieces: Sequence[Sequence[Floats]]) -> Iterator[str]:
    """Samples of the last two fifths of each press crowd below their largest."""
    for m, (muscle, of) in enumerate(zip(signals.muscles, pieces, strict=True)):
        if np.mean(signals.envelopes_v[m]) < 1.2 * signals.rest_v[m]:
            continue
        late = np.concatenate([piece[int(0.6 * piece.size) :] - median(piece) for piece in of])
        if late.size < 500:
            continue
        late.sort()
        tails = []
        for side in (late, -late[::-1]):
            shoulder, tail = quantiles(side, 0.95, 0.9995)
            tails.append(tail / shoulder if shoulder > 0 else np.inf)
        if min(tails) < TAIL:
            yield f"{muscle} has no sample far above {_volts(float(np.quantile(np.abs(late), 0.95)))}; is it saturated?"


def _fading(signals: Signals) -> Iterator[str]:
    """A trend of the muscle's level over the presses that the other muscles do not share."""
    levels = np.log(np.maximum([[piece.mean() for piece in _cut(row, signals.offsets) if piece.size]
                                for row in signals.envelopes_v], 1e-12))  # fmt: skip
    n = levels.shape[1]
    if n < FADE_PRESSES:
        return
    place = np.linspace(-0.5, 0.5, n)
    sooner, later = np.triu_indices(n, 1)
    for muscle, row in zip(signals.muscles, levels, strict=True):
        # by medians, for one press with a burst must not hide the trend of the others (Theil 1950, Sen 1968)
        slope = median((row[later] - row[sooner]) / (place[later] - place[sooner]))
        left = row - slope * place
        spread = 1.4826 * median(np.abs(left - median(left)))
        error = spread / np.sqrt(float(place @ place))
        if abs(slope) > FADE and abs(slope) > FADE_T * error:
            yield f"{muscle} {'fades' if slope < 0 else 'grows'} to {100 * np.exp(slope):.0f} % over the presses"


def _deaf(signals: Signals) -> Iterator[tuple[str, str]]:
    for muscle, row in zip(signals.muscles, signals.envelopes_v, strict=True):
        r = [
            _correlation(v, np.log(np.maximum(force_n, 1e-3)))
            for v, force_n in zip(_cut(row, signals.offsets), _cut(signals.force_n, signals.offsets), strict=True)
            if v.size > 10
        ]
        if r and (typical := median(np.array(r))) < FOLLOWS:
            yield muscle, f"{muscle} does not rise with force (r = {typical:.2f})"


@dataclass(frozen=True)
class _Profile:
    """Level of one muscle by force: (B,) middle of each bin; (p, B) mean of each press; (B,) median of the presses."""

    ln_force: Floats
    v: Floats
    typical_v: Floats

    @staticmethod
    def of(signals: Signals, muscle: int) -> _Profile:
        inside = signals.force_n[signals.force_n > 0]
        low, high = (float(inside.min()), float(inside.max())) if inside.size else (0.5, 1.0)
        edges = np.linspace(np.log(low), np.log(max(high, low * 1.01)), 13)
        rows = []
        for v, force_n in zip(
            _cut(signals.envelopes_v[muscle], signals.offsets), _cut(signals.force_n, signals.offsets), strict=True
        ):
            which = np.clip(np.searchsorted(edges, np.log(np.maximum(force_n, low)), side="right") - 1, 0, 11)
            counts = np.bincount(which, minlength=12)
            sums = np.bincount(which, v, minlength=12)
            rows.append(np.where(counts > 0, sums / np.maximum(counts, 1), np.nan))
        each = np.array(rows)
        typical = np.array([median(c[np.isfinite(c)]) if np.isfinite(c).any() else np.nan for c in each.T])
        return _Profile((edges[1:] + edges[:-1]) / 2, each, typical)


def _contacts(signals: Signals, profiles: Sequence[_Profile]) -> Iterator[tuple[str, str]]:
    """More EMG where the press begins than its curve from twice that force on allows."""
    for muscle, profile in zip(signals.muscles, profiles, strict=True):
        known = np.isfinite(profile.typical_v)
        above = known & (profile.ln_force > profile.ln_force[0] + np.log(2.2))
        begin = known & (profile.ln_force < profile.ln_force[0] + 0.5)
        if np.count_nonzero(above) < 4 or not begin.any():
            continue
        slope, level = np.polyfit(profile.ln_force[above], profile.typical_v[above], 1)
        middle = median(profile.typical_v[above])
        excess = profile.typical_v[begin] - np.maximum(level + slope * profile.ln_force[begin], 0)
        if middle > 0 and float(excess.max()) > CONTACT * middle:
            yield muscle, f"{muscle} is {_volts(float(excess.max()))} above its curve at contact; does its cable move?"


def _bursts(signals: Signals, profiles: Sequence[_Profile], press: int) -> Iterator[tuple[str, str]]:
    cut = slice(signals.offsets[press], signals.offsets[press + 1])
    size = max(1, round(BURST_S * signals.envelope_fs_hz))
    if len(signals.offsets) < 4 or cut.stop - cut.start < 2 * size:
        return
    force = np.log(np.maximum(signals.force_n[cut], 1e-3))
    for muscle, row, profile in zip(signals.muscles, signals.envelopes_v, profiles, strict=True):
        known = np.isfinite(profile.typical_v) & (profile.typical_v > 0)
        if np.count_nonzero(known) < 4:
            continue
        own = profile.v[press, known] / profile.typical_v[known]
        own = own[np.isfinite(own)]
        if own.size == 0:
            continue
        expected = np.interp(force, profile.ln_force[known], profile.typical_v[known]) * median(own)
        total = np.cumsum(np.concatenate(([0.0], row[cut])))
        ratio = float(np.max((total[size:] - total[:-size]) / size / expected[size // 2 :][: total.size - size]))
        if ratio > BURST:
            yield muscle, f"{muscle} has a burst of {ratio:.1f} times its level"


def _spikes(signals: Signals, press: int) -> Iterator[tuple[str, str]]:
    begin, end = signals.presses[press].tolist()
    for muscle, samples in zip(signals.muscles, signals.samples, strict=True):
        x = samples[begin:end]
        if x.size < 50:
            continue
        bend = np.abs(x[1:-1] - (x[2:] + x[:-2]) / 2)
        typical = median(bend) / 0.6745
        if not float(bend.max()) > SPIKE_SD * typical:
            continue
        # the potentials of few motor units stand out as well, but not from the loudest hundredth of the press
        loud = SPIKE_HEIGHT * float(np.quantile(np.abs(x - median(x)), 0.99))
        far = np.flatnonzero(bend > max(SPIKE_SD * typical, loud)) if typical > 0 else np.empty(0, np.int64)
        # a spike bends three samples; a burst of noise many in a row
        near = [np.count_nonzero(bend[max(i - 10, 0) : i + 11] > 0.4 * SPIKE_SD * typical) for i in far[:200].tolist()]
        n = sum(count <= 3 for count in near)
        if n:
            yield muscle, f"{muscle} has spikes: {n} samples far from their neighbours"


def _beats(signals: Signals) -> Iterator[tuple[str, str]]:
    """Heart beats: peaks of the rectified signal at rest, as regular as a pulse."""
    size = max(1, round(BEAT_S * signals.fs_hz))
    for muscle, samples in zip(signals.muscles, signals.samples, strict=True):
        n, seconds = 0, 0.0
        intervals: list[float] = []
        for begin, end in signals.rests.tolist():
            piece = samples[begin:end]
            if piece.size < 20 * size:
                continue
            total = np.cumsum(np.abs(piece - median(piece)))
            smooth = (total[size:] - total[:-size]) / size
            high = smooth > BEAT_LEVEL * median(smooth)
            at = np.flatnonzero(high)
            seconds += piece.size / signals.fs_hz
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


def _repeated(signals: Signals, pieces: Sequence[Sequence[Floats]]) -> Iterator[str]:
    """Stretches of samples that occur twice, as when a wireless link sends a packet again."""
    weights = np.random.default_rng(0).uniform(1, 2, PACKET // 2)
    for muscle, of in zip(signals.muscles, pieces, strict=True):
        joined = np.concatenate(of)
        n = joined.size - PACKET + 1
        if n < 2:
            continue
        print_of = np.zeros(n)
        changes = np.zeros(n, dtype=np.int8)
        for k, weight in enumerate(weights.tolist()):
            every_other = joined[2 * k : 2 * k + n]
            print_of += weight * every_other
            changes += every_other != joined[2 * k + 1 : 2 * k + 1 + n]
        own = np.sort(print_of[changes > PACKET // 4])
        share = np.count_nonzero(own[1:] == own[:-1]) / n
        if share > TWICE:
            yield f"{muscle} has {100 * share:.1f} % of its samples twice; did the link send packets again?"


def _cut(values: Floats, offsets: Ints) -> list[Floats]:
    return [values[i:j] for i, j in zip(offsets[:-1].tolist(), offsets[1:].tolist(), strict=True)]


def _correlation(x: Floats, y: Floats) -> float:
    n = min(x.size, y.size)
    x, y = x[:n] - x[:n].mean(), y[:n] - y[:n].mean()
    norm = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / norm if norm > 0 else 0.0
