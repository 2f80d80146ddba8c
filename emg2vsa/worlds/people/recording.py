"""One continuous recording of presses on cue, as a stream in volts and newtons, with the truth behind it.

The true force is a script: rest, loading ramp, short hold, release, rest. A whole recording is its collected stream.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.settings import SimulationSettings
from emg2vsa.worlds.people.person import cocontraction_v, spread
from emg2vsa.worlds.people.signals import Electrode, Faults, ForceSensor, around, gaussian_noise

FloatArray = NDArray[np.float64]

INITIAL_REST_S = 3.0
"Least rest before the first press."
PEAK_SHARE = (1.04, 1.15)
"Peak force, as a share of the upper force of the window."
TAPER = (0.3, 0.7)
"Share of a ramp that speeds up and slows down; 0 is a straight line, 1 a raised cosine."
SPEED_HARMONIC = 0.12
"Largest amplitude of each of three harmonics of the loading speed; together below 1, so that the ramp never falls."
HOLD_S, RELEASE_S, REACTION_S = (0.25, 0.5), (0.5, 1.0), (0.15, 0.35)
TREMOR_SHARE, TREMOR_HZ, TREMOR_WIDTH_HZ = 0.003, 9.0, 1.5
"Physiological tremor: rms as a share of the force, and its spectral peak."
HESITATION_CHANCE, HESITATION_SHARE, HESITATION_S = 0.05, (0.07, 0.11), 0.5
"Now and then a press hesitates: force gives way by a smooth bump (share of the upper force) and may fall a little."
_FINE = np.linspace(0.0, 1.0, 4001)


@dataclass(frozen=True)
class Presses:
    """True force and its events.

    force_n : (n,). onset_s, stop_s : (r,) last rise through the lower force before the upper is first reached, and that
    reach, interpolated between samples. peak_force_n, largest_fall_n : (r,) the latter is the deepest fall below
    the running maximum between onset and stop. cue_start_s, cue_stop_s : (r,) spoken or shown commands.
    """

    force_n: FloatArray
    onset_s: FloatArray
    stop_s: FloatArray
    peak_force_n: FloatArray
    largest_fall_n: FloatArray
    cue_start_s: FloatArray
    cue_stop_s: FloatArray


@dataclass(frozen=True)
class Truth:
    """What was put in. a_v, b_v : (r,) coefficients of each repetition; cocontraction_v : (n,) at every sample.

    force_offset_n : bias of the force sensor over the whole recording.
    """

    a_v: FloatArray
    b_v: FloatArray
    presses: Presses
    cocontraction_v: FloatArray
    force_offset_n: float


@dataclass(frozen=True)
class SyntheticRecording:
    """Sensor signals: emg_v maps muscle to (n,) volts at the electrode; force_n : (n,) compression positive, biased."""

    fs_hz: float
    emg_v: dict[str, FloatArray]
    force_n: FloatArray
    truth: Truth

    @property
    def duration_s(self) -> float:
        """Length of the recording, s."""
        return self.force_n.size / self.fs_hz

    @property
    def time_s(self) -> FloatArray:
        """(n,) s from the first sample."""
        return np.arange(self.force_n.size) / self.fs_hz


class RecordingStream:
    """A recording as it comes from its sensors; the same seed gives the same, whatever else is simulated.

    a_v, b_v : coefficients of this participant on this specimen; every repetition scales both by one random factor of
    relative spread ``settings.repetition_sd``. window_n : force window, newtons. force_delay_s : of the force sensor.
    ``truth`` : what is put in.
    """

    def __init__(
        self,
        seed: np.random.SeedSequence,
        settings: SimulationSettings,
        *,
        a_v: float,
        b_v: float,
        window_n: tuple[float, float],
        force_delay_s: float = 0.0,
    ) -> None:
        presses_rng, scale_rng, force_rng, *muscle_rngs = _streams(seed, 3 + len(settings.muscle_share))
        presses = make_presses(presses_rng, settings, window_n, settings.repetitions)
        scale = spread(scale_rng, settings.repetition_sd, settings.repetitions)
        level_v = cocontraction_v(presses.force_n, a_v, b_v, window_n[0])
        level_v = level_v * _scale_over_time(presses, scale, settings.fs_hz)
        offset_n = float(force_rng.uniform(-settings.force_offset_n, settings.force_offset_n))
        self.truth = Truth(a_v * scale, b_v * scale, presses, level_v, offset_n)
        self.fs_hz, self.samples, self._taken = settings.fs_hz, level_v.size, 0
        self._shares, self._delay_samples = settings.muscle_share, force_delay_s * settings.fs_hz
        of_emg = Faults(settings.emg_noise_v, settings.mains_v, settings.mains_hz)
        self._electrodes = [Electrode(rng, self.fs_hz, of_emg, self.samples) for rng in muscle_rngs]
        noise_n = settings.force_noise_n
        self._force = ForceSensor(force_rng, self.fs_hz, noise_n=noise_n, offset_n=offset_n, page=self.samples)

    def take(self, n: int) -> tuple[dict[str, FloatArray], FloatArray]:
        """The next ``n`` samples (n,), or what is left: EMG of each muscle, V, and the force, N."""
        number = np.arange(self._taken, min(self._taken + n, self.samples))
        self._taken += number.size
        level_v, force_n = self.truth.cocontraction_v[number], self.truth.presses.force_n
        channels = zip(self._shares.items(), self._electrodes, strict=True)
        emg_v = {muscle: electrode.take(share * level_v)[0] for (muscle, share), electrode in channels}
        late_n = np.interp(number - self._delay_samples, np.arange(force_n.size), force_n)
        return emg_v, self._force.take(late_n)

    def whole(self) -> SyntheticRecording:
        """All that is left, collected."""
        return SyntheticRecording(self.fs_hz, *self.take(self.samples), self.truth)


def _streams(seed: np.random.SeedSequence, n: int) -> list[np.random.Generator]:
    """One stream per part, so that a further muscle leaves force and the other muscles as they are."""
    # SeedSequence.spawn would count its calls, and a second recording from one seed would differ
    keys = [(*seed.spawn_key, part) for part in range(n)]
    return [np.random.default_rng(np.random.SeedSequence(seed.entropy, spawn_key=key)) for key in keys]


def _scale_over_time(presses: Presses, scale: FloatArray, fs_hz: float) -> FloatArray:
    """Each repetition's factor, changing smoothly from the one before it around the cue that precedes the press."""
    cue_s = presses.cue_start_s
    knots_s = np.column_stack([cue_s - 0.1, cue_s + 0.1]).ravel()
    levels = np.repeat(np.concatenate([scale[:1], scale]), 2)[1:-1]
    factor: FloatArray = np.interp(np.arange(presses.force_n.size) / fs_hz, knots_s, levels)
    return factor


def make_presses(
    rng: np.random.Generator, settings: SimulationSettings, window_n: tuple[float, float], repetitions: int
) -> Presses:
    """Presses with loading phases (lower to upper force of ``window_n``) of ``settings.loading_s`` seconds."""
    fs_hz = settings.fs_hz
    rests_s = rng.uniform(*settings.rest_s, repetitions + 1)
    rests_s[0] += INITIAL_REST_S
    pieces: list[FloatArray] = []
    bounds = np.empty((repetitions, 3), np.int64)
    n = 0
    for index in range(repetitions):
        rest = np.zeros(round(rests_s[index] * fs_hz))
        loading, hold, release = _press(rng, settings, window_n)
        start = n + rest.size
        bounds[index] = start, start + loading.size + hold.size, start + loading.size + hold.size + release.size
        pieces += [rest, loading, hold, release]
        n = int(bounds[index, 2])
    pieces.append(np.zeros(_final_rest(n, rests_s[-1], fs_hz)))
    force_n = np.concatenate(pieces)
    tremor = gaussian_noise(rng, force_n.size, fs_hz, around(TREMOR_HZ, TREMOR_WIDTH_HZ))
    force_n *= 1 + TREMOR_SHARE * tremor
    reaction_s = rng.uniform(*REACTION_S, (2, repetitions))
    return _with_events(force_n, bounds, fs_hz, window_n, reaction_s)


def longest_record_s(settings: SimulationSettings, window_n: tuple[float, float]) -> float:
    """A bound on the length of a record: the window at the slowest ramp that keeps its loading time."""
    fastest = (1 + 3 * SPEED_HARMONIC) / (1 - TAPER[1] / 2)
    share = (window_n[1] - window_n[0]) / (PEAK_SHARE[1] * window_n[1])
    press_s = settings.loading_s[1] * fastest / share + HOLD_S[1] + RELEASE_S[1] + settings.rest_s[1]
    return INITIAL_REST_S + settings.repetitions * press_s + settings.rest_s[1] + 1


def smooth_step(x: FloatArray, taper: float) -> FloatArray:
    """Rise (n,) from 0 at x = 0 to 1 at x = 1 whose speed is a Tukey window with the given tapered share (0, 1]."""
    edge = np.minimum(np.minimum(x, 1 - x), taper / 2)
    half = 0.5 * (edge - taper / (2 * np.pi) * np.sin(2 * np.pi * edge / taper))
    area = half + np.maximum(np.minimum(x, 1 - x) - taper / 2, 0)
    total = 1 - taper / 2
    return np.where(x <= 0.5, area, total - area) / total


def _press(
    rng: np.random.Generator, settings: SimulationSettings, window_n: tuple[float, float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Loading, hold and release of one press, newtons, without tremor."""
    fs_hz = settings.fs_hz
    peak_n = window_n[1] * rng.uniform(*PEAK_SHARE)
    taper, harmonics = rng.uniform(*TAPER), rng.uniform(-SPEED_HARMONIC, SPEED_HARMONIC, 3)
    lower, upper = np.interp(np.array(window_n) / peak_n, _ramp(_FINE, taper, harmonics), _FINE)
    ramp_s = rng.uniform(*settings.loading_s) / (upper - lower)
    loading = peak_n * _ramp(_fractions(ramp_s * fs_hz), taper, harmonics)
    hesitates, depth, centre = rng.random(), rng.uniform(*HESITATION_SHARE), rng.uniform(0.35, 0.65)
    if hesitates < HESITATION_CHANCE:
        loading -= depth * window_n[1] * _bump((_fractions(ramp_s * fs_hz) - centre) * ramp_s / HESITATION_S)
    hold = np.full(round(rng.uniform(*HOLD_S) * fs_hz), peak_n)
    release = peak_n * (1 - smooth_step(_fractions(rng.uniform(*RELEASE_S) * fs_hz), 1.0))
    return loading, hold, release


def _ramp(x: FloatArray, taper: float, harmonics: FloatArray) -> FloatArray:
    """Smooth step on a warped clock, whose rate is 1 + sum of harmonics k cos(2 pi k x)."""
    k = np.arange(1, harmonics.size + 1)
    warped = x + np.sin(2 * np.pi * np.multiply.outer(x, k)) @ (harmonics / (2 * np.pi * k))
    return smooth_step(np.clip(warped, 0.0, 1.0), taper)


def _bump(x: FloatArray) -> FloatArray:
    """Raised cosine of height 1 on [-0.5, 0.5]."""
    return np.where(np.abs(x) < 0.5, np.square(np.cos(np.pi * x)), 0.0)


def _fractions(samples: float) -> FloatArray:
    n = max(round(samples), 2)
    return np.arange(n) / n


def _final_rest(n: int, rest_s: float, fs_hz: float) -> int:
    """Samples of rest that end the record on a whole second (the record length of the files)."""
    second = max(round(fs_hz), 1)
    return -(-round(n + rest_s * fs_hz) // second) * second - n


def _with_events(
    force_n: FloatArray, bounds: NDArray[np.int64], fs_hz: float, window_n: tuple[float, float], reaction_s: FloatArray
) -> Presses:
    events = np.array([_loading_phase(force_n, start, end, window_n) for start, _, end in bounds])
    return Presses(
        force_n=force_n,
        onset_s=events[:, 0] / fs_hz,
        stop_s=events[:, 1] / fs_hz,
        peak_force_n=events[:, 2],
        largest_fall_n=events[:, 3],
        cue_start_s=bounds[:, 0] / fs_hz - reaction_s[0],
        cue_stop_s=bounds[:, 1] / fs_hz - reaction_s[1],
    )


def _loading_phase(
    force_n: FloatArray, start: int, end: int, window_n: tuple[float, float]
) -> tuple[float, float, float, float]:
    """Onset and stop in samples from the start of the record, peak and largest fall in newtons."""
    press = force_n[start:end]
    lower_n, upper_n = window_n
    reach = int(np.argmax(press >= upper_n))
    rise = int(np.flatnonzero(press[:reach] < lower_n)[-1]) + 1
    loading = press[rise : reach + 1]
    fall_n = float(np.max(np.maximum.accumulate(loading) - loading))
    return start + _crossing(press, rise, lower_n), start + _crossing(press, reach, upper_n), float(press.max()), fall_n


def _crossing(force_n: FloatArray, after: int, level_n: float) -> float:
    """Fractional sample at which force rises through the level, between ``after - 1`` and ``after``."""
    before_n, after_n = force_n[after - 1], force_n[after]
    return float(after - (after_n - level_n) / (after_n - before_n))
