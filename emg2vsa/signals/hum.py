"""Mains hum, fitted while the hand rests and subtracted from the whole record.

The frequency of the mains wanders by some 0.01 Hz within a minute, so one sine for the whole record would lose its
phase. Amplitude and phase of every harmonic are fitted in half seconds of rest; one frequency is the one at which
neighbouring half seconds agree, and between them amplitude and phase are interpolated.

A finger that touches the rig can take the hum away, or bring it. What was fitted at rest is therefore compared with
what the presses hold, and leaves them only where it is in them; what remains in them is measured.

Sines are fitted to pieces of the record, each under a Hann window (`sine_phasors`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints, slices, sums_of
from emg2vsa.signals.products import times
from emg2vsa.signals.quality import MAINS_HZ

Phasors = NDArray[np.complex128]

BLOCK = 128
"Samples in a block of a piece."


def sine_phasors(channels: Sequence[Floats], pieces: Sequence[tuple[int, int]], hz: Floats, fs_hz: float) -> Phasors:
    """Amplitudes and phases (m, q, h) of sines (h,) in the pieces [begin, end) of channels (n,).

    The phase is that at the first sample of the piece. A sine over k blocks is the sine over one block, turned k times:
    so one small table of sines serves all blocks of all pieces, and another turns the blocks. About the middle of a
    block a cosine is even and a sine is odd: half a block tells each.
    """
    longest = max((end - begin for begin, end in pieces), default=0)
    n_blocks = -(-longest // BLOCK)
    even, odd, turns = _tables(hz.tobytes(), fs_hz, n_blocks)
    found = np.empty((len(channels), len(pieces), hz.size), dtype=np.complex128)
    for part in slices(len(pieces), max(len(channels) * longest, 1)):
        padded = np.zeros((len(channels), part.stop - part.start, n_blocks * BLOCK))
        for i, (begin, end) in enumerate(pieces[part]):
            for row, samples in zip(padded, channels, strict=True):
                np.multiply(hann_of_sines(end - begin), samples[begin:end], out=row[i, : end - begin])
        halves = padded.reshape(-1, n_blocks, 2, BLOCK // 2)
        before, after = halves[:, :, 0, ::-1], halves[:, :, 1]
        of_block = np.empty((len(halves), n_blocks, hz.size), dtype=np.complex128)
        of_block.real = times(after + before, even)
        np.negative(times(after - before, odd), out=of_block.imag)
        found[:, part] = np.einsum("mbh,bh->mh", of_block, turns).reshape(found[:, part].shape)
    return found


@lru_cache(maxsize=16)
def _tables(hz: bytes, fs_hz: float, n_blocks: int) -> tuple[Floats, Floats, Phasors]:
    """Cosines and sines (BLOCK / 2, h) from the middle of a block on, and the turns (n_blocks, h) of all blocks: the
    recordings of a study ask for the same."""
    radians = 2 * np.pi / fs_hz * np.frombuffer(hz)
    within = np.multiply.outer(np.arange(BLOCK // 2) + 0.5, radians)
    turns = np.exp(-1j * np.multiply.outer(BLOCK * np.arange(n_blocks) + (BLOCK - 1) / 2, radians))
    return np.cos(within), np.sin(within), turns


@lru_cache(maxsize=64)
def hann_of_sines(size: int) -> Floats:
    """Hann's window (size,), symmetric about the middle, by which a sum of samples gives the amplitude of a sine."""
    window = np.sin(np.pi * (np.arange(size) + 0.5) / size) ** 2
    window *= 2 / window.sum()
    window.flags.writeable = False
    return window


HARMONICS = 6
PIECE_S = 0.5
"A window of Hann's of this length tells 50 Hz from 60 Hz."
OFFSET_HZ = 0.4
"The mains is looked for so far around its nominal frequency."
STEADY = 0.5
"A harmonic is subtracted where neighbouring pieces agree in so much of its power; noise alone agrees in none."
CLEAR = 4.0
"... and where it has so many times the power that is found between the harmonics."
ASIDE_HZ = 6.0
"Between the harmonics: so far below and above each."
FEWEST = 8
"Fewer half seconds of rest do not tell the frequency of the mains."
BLOCK_S = 0.25
"Amplitude and phase are constant within blocks of this length."
PRESENT = 0.5
"Hum of the rests leaves the presses where they hold more than this share of it: only so does their power fall."
TOUCH_S = 2.0
"Hum within presses is measured in pieces of at most this length, ..."
TOUCH_BLOCK_S, TOUCH_ROUNDS = 0.02, 3
"Hum of a press is fitted on means over a period of the mains, and so often, as what it leaves is known better."
TOUCH_REACH_S = 3.0
"So far before and after the loading phase it is looked for."
TOUCH_ASIDE_HZ = np.array([-8.0, -7.0, -6.0, -5.0, -4.0, 4.0, 5.0, 6.0, 7.0, 8.0])
"... against the power so far beside it, ..."
TOUCH_CHANCE = 0.002
"... and counts where noise alone would show as much with this probability, in any channel at any frequency asked."


@dataclass(frozen=True)
class Hum:
    """What was found at rest. hz : of the mains. harmonics : (h,) those of any channel. rms : (m,) of each.

    absent : (h,) those that the presses of a channel do not hold as the rests do, and that stay as they are in these.
    """

    hz: float
    harmonics: Ints
    rms: Floats
    absent: Ints


def remove_hum(
    channels: tuple[Floats, ...],
    fs_hz: float,
    start: Ints,
    stop: Ints,
    presses: tuple[Ints, Ints] | None = None,
    touched: Callable[[Ints], NDArray[np.bool_]] | None = None,
    *,
    only_absent: bool = False,
) -> tuple[tuple[Floats, ...], Hum | None]:
    """The channels (n,) without the hum that is found in their rests [start, stop) (r,), and what it was, or None.

    ``FEWEST`` pieces of half a second of rest are the least; hum that does not keep its phase between them stays.
    presses : first and last-plus-one sample (p,) of each. A harmonic that these do not hold stays where ``touched``
    says so of samples (k,); without both, none does.
    ``only_absent``: no other harmonic is subtracted, so that rests and presses hold the same hum.
    """
    size = round(PIECE_S * fs_hz)
    begins = np.concatenate([np.arange(a, b - size + 1, size) for a, b in zip(start, stop, strict=True)] or [start])
    if begins.size < FEWEST or fs_hz <= 4 * MAINS_HZ[0]:
        return channels, None
    time_s = (begins + (size - 1) / 2) / fs_hz
    best = _steadiest(*_phasors(channels, begins, size, fs_hz), time_s)
    if best is None:
        return channels, None
    hz, turned, orders = best
    hum_hz = hz * orders.astype(np.float64)
    present = np.ones(turned.shape[:2], dtype=np.bool_)
    if presses is not None and touched is not None:
        present = np.array([_present(*of, hum_hz, time_s, fs_hz, presses) for of in zip(channels, turned, strict=True)])
    everywhere = np.where((present & (not only_absent))[..., None], turned, 0.0)
    cleaned = []
    for samples, own, at_rest in zip(channels, everywhere, np.where(present[..., None], 0.0, turned), strict=True):
        left = _without(samples, own, hum_hz, time_s, fs_hz) if own.any() else samples
        if touched is not None and at_rest.any():
            resting = _without(left, at_rest, hum_hz, time_s, fs_hz)
            for part in slices(left.size):
                np.copyto(resting[part], left[part], where=touched(np.arange(part.start, part.stop)))
            left = resting
        cleaned.append(left)
    rms = np.sqrt(np.sum(np.mean(np.abs(turned) ** 2, axis=-1), axis=-1) / 2)
    return tuple(cleaned), Hum(hz, orders, rms, orders[~present.all(axis=0)])


def _steadiest(phasors: Phasors, orders: Ints, time_s: Floats) -> tuple[float, Phasors, Ints] | None:
    """Of the mains of 50 and 60 Hz the one with the most power that keeps its phase between pieces: its frequency,
    phasors (m, h, k) turned to it, 0 where they are not clear or steady, and harmonics (h,). None where none does."""
    found = np.mean(np.abs(phasors) ** 2, axis=-1)
    clear = found[:, :, 1] > CLEAR * (found[:, :, 0] + found[:, :, 2]) / 2
    best: tuple[float, float, Phasors] | None = None
    for mains, nominal_hz in enumerate(MAINS_HZ):
        if not clear[:, mains].any():
            continue
        own = phasors[:, mains, 1]
        offset_hz = _offset_hz(np.where(clear[:, mains, :, None], own, 0.0), time_s, orders)
        turned = own * np.exp(-2j * np.pi * offset_hz * orders[:, None] * time_s)
        agreed = np.mean((turned[..., 1:] * turned[..., :-1].conj()).real, axis=-1)
        steady = clear[:, mains] & (agreed > STEADY * found[:, mains, 1])
        power = float(np.sum(agreed[steady]))
        if steady.any() and (best is None or power > best[0]):
            best = (power, nominal_hz + offset_hz, np.where(steady[..., None], turned, 0.0))
    if best is None:
        return None
    _, hz, turned = best
    used = np.any(turned != 0, axis=(0, 2))
    return hz, turned[:, used], orders[used]


def remove_touch_hum(
    channels: tuple[Floats, ...], fs_hz: float, start: Ints, stop: Ints, hz: float | None,
    force_at: Callable[[Ints], Floats],
) -> tuple[tuple[Floats, ...], Floats]:  # fmt: skip
    """The channels (n,) without the hum that their presses [start, stop) (p,) hold, and its rms (m,); 0 where none is
    clear.

    Of each press one phase a harmonic is fitted, and an amplitude that is linear in force, weighted by the inverse of
    the power that is left, so that the loud end of the press does not spoil its quiet begin; it is subtracted as far
    around the press as the record holds it. The share of the EMG's own power that goes with it is that of a band of
    1.5 / duration, some tenths of a percent.
    hz : of the mains, None: whichever of both holds more. force_at : newtons at samples of the channels.
    """
    mains_hz, powers = _clear_powers(channels, fs_hz, start, stop, hz)
    if not powers.any():
        return channels, np.zeros(len(channels))
    cleaned = []
    for samples, own in zip(channels, powers, strict=True):
        orders = np.flatnonzero(own) + 1
        if orders.size:
            samples = _without_touch(samples, mains_hz, orders, fs_hz, start, stop, force_at)
        cleaned.append(samples)
    return tuple(cleaned), np.asarray(np.sqrt(powers.sum(axis=1)))


def _without_touch(
    samples: Floats, mains_hz: float, orders: Ints, fs_hz: float, start: Ints, stop: Ints,
    force_at: Callable[[Ints], Floats],
) -> Floats:  # fmt: skip
    left = samples.copy()
    size = max(1, round(TOUCH_BLOCK_S * fs_hz))
    reach = round(TOUCH_REACH_S * fs_hz) // size * size
    for first, last in zip(start.tolist(), stop.tolist(), strict=True):
        last -= (last - first) % size
        if last - first < round(PIECE_S * fs_hz):
            continue
        low = first - min(reach, first // size * size)
        high = low + (min(samples.size, last + reach) - low) // size * size
        # what another press took is not taken again
        around = left[low:high].copy()
        begin, end = first - low, last - low
        force_n = force_at(np.arange(low, high))
        shapes = np.stack((np.ones(force_n.size), force_n / max(float(force_n.max()), 1e-9)))
        # first by the loading phase alone, then by all of the contact, which holds the phase over the release too
        for _ in range(2):
            hum = _fitted(around, shapes, begin, end, mains_hz, orders, fs_hz, size)
            begin, end = _held(around, hum, size, first - low, last - low)
        left[low + begin : low + end] -= hum[begin:end]
    return left


def _fitted(
    around: Floats, shapes: Floats, begin: int, end: int, mains_hz: float, orders: Ints, fs_hz: float, size: int
) -> Floats:
    """The hum (n,) of samples (n,), fitted in [begin, end), a multiple of ``size``: one frequency, and of each harmonic
    one phase and a size of each of the shapes (2, n)."""
    offsets_hz = np.linspace(-OFFSET_HZ, OFFSET_HZ, 81)
    strongest = orders[0]
    piece = around[begin:end]
    middle_s = (np.arange(0, piece.size, size) + (size - 1) / 2) / fs_hz
    of_block = shapes[:, begin:end].reshape(len(shapes), -1, size).mean(axis=2)
    turns = _turning(-offsets_hz * strongest * size / fs_hz, (1 - 1 / size) / 2, middle_s.size, BLOCK // 8)
    turned = {
        order: (piece * _turning(-order * mains_hz / fs_hz, 0, piece.size, size)).reshape(-1, size).mean(axis=1)
        for order in orders.tolist()
    }
    rest, hz = piece - piece.mean(), mains_hz
    phasors: dict[int, Phasors] = {}
    for _ in range(TOUCH_ROUNDS):
        weights = of_block / np.maximum(sums_of(np.square(rest).reshape(-1, size)) / size, 1e-300)
        powers, axes = np.linalg.eigh(weights @ of_block.T)
        known = powers > 1e-6 * powers.max()  # not where force and a constant are one
        solver = np.divide(axes, powers, out=np.zeros_like(axes), where=known) @ axes.T
        right = turns @ (weights * turned[strongest]).T
        offset_hz = offsets_hz[int(np.argmax(_in_one_phase(right, solver)[1]))]
        phasors = {}
        for order, own in turned.items():
            right = weights @ (own * np.exp(-2j * np.pi * order * offset_hz * middle_s))
            phase = _in_one_phase(right, solver)[0]
            phasors[order] = 2 * phase * (solver @ (right * phase.conj()).real)
        hz = mains_hz + offset_hz
        rest = piece - _waves(phasors, shapes[:, begin:end], hz / fs_hz, 0, size)
    return _waves(phasors, shapes, hz / fs_hz, -begin, size)


def _in_one_phase(right: Phasors, solver: Floats) -> tuple[Phasors, Floats]:
    """The phase (...), of size 1, that all shapes share, and twice the power that they then explain: of the right sides
    (..., 2) of normal equations, ``solver`` (2, 2) their inverse.

    The shapes explain r' S r with r = Re(right / phase), which is largest where the phase is half that of right' S
    right. Were the phase free to go with force, it would follow a frequency that is a little off.
    """
    solved = right @ solver
    turning, power = np.sum(right * solved, axis=-1), np.sum(right.conj() * solved, axis=-1).real
    return np.exp(0.5j * np.angle(turning)), power + np.abs(turning)


def _held(samples: Floats, hum: Floats, size: int, first: int, last: int) -> tuple[int, int]:
    """How far around [first, last) samples (n,) hold the hum (n,), to a block of ``size``: where it is most likely."""
    with_it, without, both, own = (
        sums_of(x.reshape(-1, size)) for x in ((samples - hum) ** 2, samples**2, samples * hum, hum**2)
    )
    likely = (both - own / 2) / np.maximum(np.minimum(with_it, without), 1e-300)
    before, after = likely[: first // size][::-1], likely[-(-last // size) :]
    most = [int(np.argmax(np.concatenate(([0.0], np.cumsum(each))))) for each in (before, after)]
    return (first // size - most[0]) * size, (-(-last // size) + most[1]) * size


def _waves(phasors: dict[int, Phasors], shapes: Floats, cycles: float, first: int, size: int) -> Floats:
    """Sum (n,) of the harmonics of a sine of so many cycles a sample, from sample ``first`` on."""
    found = np.zeros(shapes.shape[1])
    for order, own in phasors.items():
        turning = _turning(order * cycles, first, found.size, size)
        found += own.real @ shapes * turning.real - own.imag @ shapes * turning.imag
    return found


def _turning(cycles: Floats | float, first: float, n: int, size: int) -> Phasors:
    """exp(2 pi i t cycles) (..., n) from t = ``first`` on: blocks of ``size``, each the first one, turned."""
    of_block, within = (
        np.exp(2j * np.pi * np.multiply.outer(cycles, at)) for at in (first + np.arange(0, n, size), np.arange(size))
    )
    found = of_block[..., :, None] * within[..., None, :]
    return np.asarray(found.reshape(*np.shape(cycles), -1)[..., :n])


def _harmonics(mains_hz: float, fs_hz: float) -> Floats:
    """Those (h,) that are measured: with room beside them below half the rate."""
    hz = np.arange(1.0, HARMONICS + 1) * mains_hz
    return np.asarray(hz[hz + TOUCH_ASIDE_HZ[-1] < fs_hz / 2], dtype=np.float64)


def touch_hum(channels: tuple[Floats, ...], fs_hz: float, start: Ints, stop: Ints, hz: float | None) -> Floats:
    """Rms (m,) of the hum within the presses [start, stop) (p,), in the unit of the channels; 0 where none is clear.

    channels : m of (n,) at ``fs_hz``, Hz. hz : of the mains; None: whichever of both holds more.
    """
    return np.asarray(np.sqrt(_clear_powers(channels, fs_hz, start, stop, hz)[1].sum(axis=1)))


def _clear_powers(
    channels: tuple[Floats, ...], fs_hz: float, start: Ints, stop: Ints, hz: float | None
) -> tuple[float, Floats]:
    """The mains, and the mean squares (m, h) of its harmonics in the presses, 0 of those that are not clear of their
    surroundings; arguments as of ``touch_hum``."""
    pieces = _touch_pieces(start, stop, fs_hz)
    size = np.array([[np.vdot(own[a:b], own[a:b]) / (b - a) for a, b in pieces] for own in channels])
    known = np.all(size > 0, axis=1) & bool(pieces)
    weights = np.where(known[:, None], size, 1.0) ** -2.0
    weights /= weights.sum(axis=1, keepdims=True)
    asked = [
        (each, np.add.outer(_harmonics(each, fs_hz), np.append(0.0, TOUCH_ASIDE_HZ)))
        for each in ((hz,) if hz else MAINS_HZ)
    ]
    phasors = sine_phasors(channels, pieces, np.concatenate([around.ravel() for _, around in asked]), fs_hz)
    left = phasors.real**2 + phasors.imag**2
    found = []
    for mains_hz, around in asked:
        own, left = np.split(left, [around.size], axis=2)
        power = own.reshape(*own.shape[:2], *around.shape)
        beside = power[..., 1:].mean(axis=-1)
        aside = np.einsum("mq,mqh->mh", weights, beside)
        excess = np.einsum("mq,mqh->mh", weights, power[..., 0]) - aside
        most = _most_by_chance(pieces, weights, beside, fs_hz)
        found.append((mains_hz, np.where(known[:, None] & (excess > (most - 1) * aside), excess / 2, 0.0)))
    return max(found, key=lambda each: float(each[1].sum()))


def _most_by_chance(pieces: list[tuple[int, int]], weights: Floats, aside: Floats, fs_hz: float) -> Floats:
    """How many times (m, h) the power beside a sine noise alone shows at it, but with probability ``TOUCH_CHANCE``.

    The power of a piece has two degrees of freedom; that of pieces (q,), by their weights (m, q) and powers (m, q, h),
    the more the more of them there are, and fewer where they overlap. Their ratio has Snedecor's distribution.
    """
    if not pieces:
        return np.ones((aside.shape[0], aside.shape[2]))
    begin, end = np.array(pieces, dtype=np.float64).T
    size = end - begin
    apart = np.minimum(np.abs(np.subtract.outer(begin, begin)) / np.minimum.outer(size, size), 1.0)
    # autocorrelation of Hann's window
    shared = (1 - apart) * (2 + np.cos(2 * np.pi * apart)) / 3 + np.sin(2 * np.pi * apart) / (2 * np.pi)
    parts = weights[..., None] * aside
    spread = np.einsum("mqh,qr,mrh->mh", parts, shared**2, parts)
    total = parts.sum(axis=1)
    freedom = 2 * np.divide(total**2, spread, out=np.ones_like(total), where=spread > 0)
    # both sides span 4 Hz each; under Hann's window powers are independent some 1.5 / duration apart
    beside = min(TOUCH_ASIDE_HZ.size, 2 * (1 + 4 * float(np.mean(size)) / fs_hz / 1.5))
    asked = len(MAINS_HZ) * aside.shape[0] * aside.shape[2]
    return np.asarray(special.fdtri(freedom, beside * freedom, 1 - TOUCH_CHANCE / asked))


def _present(
    samples: Floats, turned: Phasors, hz: Floats, time_s: Floats, fs_hz: float, presses: tuple[Ints, Ints]
) -> NDArray[np.bool_]:
    """Which sines (h,), interpolated from the rests as ``_without`` does, lower the power of the presses."""
    pieces = _touch_pieces(*presses, fs_hz, PIECE_S)
    bounds = np.array(pieces, dtype=np.float64).reshape(-1, 2)
    middle_s = np.asarray((bounds.sum(axis=1) - 1) / 2 / fs_hz, dtype=np.float64)
    expected = _interpolated(middle_s, time_s, turned)
    at_zero = np.exp(-2j * np.pi / fs_hz * np.multiply.outer(hz, bounds[:, 0]))
    found = sine_phasors((samples,), pieces, hz, fs_hz)[0].T * at_zero
    weights = [1 / max(float(np.vdot(samples[a:b], samples[a:b])) / (b - a), 1e-300) for a, b in pieces]
    both, own = (found * expected.conj()).real @ weights, np.abs(expected) ** 2 @ weights
    return np.asarray((own == 0) | (both > PRESENT * own))


def _interpolated(at_s: Floats, time_s: Floats, turned: Phasors) -> Phasors:
    """Phasors (h, k) at the times (k,), between those (h, p) at ``time_s`` (p,)."""
    return np.array([np.interp(at_s, time_s, row.real) + 1j * np.interp(at_s, time_s, row.imag) for row in turned])


def _touch_pieces(start: Ints, stop: Ints, fs_hz: float, longest_s: float = TOUCH_S) -> list[tuple[int, int]]:
    """Pieces of the presses, each overlapping half of the next or more; presses below half a second have none."""
    pieces = []
    for a, b in zip(start.tolist(), stop.tolist(), strict=True):
        size = min(b - a, round(longest_s * fs_hz))
        if size >= round(PIECE_S * fs_hz):
            further = -(-2 * (b - a - size) // size)
            step = (b - size - a) / max(further, 1)
            begins = *(int(i * step + a) for i in range(further)), b - size
            pieces += [(begin, begin + size) for begin in begins]
    return pieces


def _phasors(channels: Sequence[Floats], begins: Ints, size: int, fs_hz: float) -> tuple[Phasors, Ints]:
    """Amplitude and phase at time 0 of sines in pieces of channels (n,) from ``begins`` (p,) on, and the orders (h,).

    (m, 2, 3, h, p): of both mains, below, at and above each of their harmonics. Each is the nearest bin of the piece's
    spectrum: at the middle of a symmetric window its phase is that of the sine, wherever within the bin that stands.
    """
    orders = np.arange(1, HARMONICS + 1)
    orders = orders[orders * max(MAINS_HZ) < 0.45 * fs_hz]
    hz = np.multiply.outer(MAINS_HZ, orders)[:, None, :] + np.array([-ASIDE_HZ, 0.0, ASIDE_HZ])[:, None]
    bins = np.rint(hz * size / fs_hz).astype(np.int64)
    found = np.empty((len(channels), begins.size, *bins.shape), dtype=np.complex128)
    for own, samples in zip(found, channels, strict=True):
        for part in slices(begins.size, size):
            pieces = samples[begins[part, None] + np.arange(size)]
            own[part] = np.fft.rfft(pieces * hann_of_sines(size))[:, bins]
    middle = (size - 1) / 2
    to_middle = np.exp(2j * np.pi * bins * middle / size)
    at_zero = np.exp(-2j * np.pi / fs_hz * np.multiply.outer(hz, begins + middle))
    return np.moveaxis(found * to_middle, 1, -1) * at_zero, orders


def _offset_hz(phasors: Phasors, time_s: Floats, orders: Ints) -> float:
    """Difference of the mains from its nominal frequency, Hz: where neighbouring pieces agree best."""
    strongest = int(np.argmax(np.sum(np.abs(phasors) ** 2, axis=(0, 2))))
    order, phasor = int(orders[strongest]), phasors[:, strongest]
    product = np.sum(phasor[:, 1:] * phasor[:, :-1].conj(), axis=0)
    grid_hz = np.linspace(-OFFSET_HZ, OFFSET_HZ, 161)
    agreed = np.sum((np.exp(-2j * np.pi * order * np.outer(grid_hz, np.diff(time_s))) * product).real, axis=1)
    at = int(np.argmax(agreed))
    if 0 < at < grid_hz.size - 1:
        low, top, high = agreed[at - 1 : at + 2]
        return float(grid_hz[at] + (grid_hz[1] - grid_hz[0]) * (high - low) / (2 * (2 * top - low - high)))
    return float(grid_hz[at])


def _without(samples: Floats, turned: Phasors, hz: Floats, time_s: Floats, fs_hz: float) -> Floats:
    """Samples (n,) minus the sines whose phasors (h, p) at ``time_s`` (p,) turn slowly about the frequencies (h,)."""
    size = max(1, round(BLOCK_S * fs_hz))
    starts = np.arange(0, samples.size, size)
    middle_s = (starts + (size - 1) / 2) / fs_hz
    slow = _interpolated(np.asarray(middle_s, dtype=np.float64), time_s, turned) * np.exp(
        2j * np.pi / fs_hz * np.outer(hz, starts)
    )
    wave = np.exp(2j * np.pi / fs_hz * np.outer(hz, np.arange(size)))
    left = np.zeros(starts.size * size)
    left[: samples.size] = samples
    for part in slices(starts.size, size):
        blocks = left.reshape(-1, size)[part]
        for own, turning in zip(slow[:, part], wave, strict=True):
            blocks -= own.real[:, None] * turning.real - own.imag[:, None] * turning.imag
    return left[: samples.size]
