"""What sensors make of an emulated participant: EMG with its carrier, noise and hum, and a force with noise."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear_zpk, freqz_sos, sosfilt, zpk2sos

from emg2vsa.worlds.people.carrier import AMPLIFIER_BAND_HZ, MUSCLE_HIGH_HZ, MUSCLE_LOW_HZ
from emg2vsa.worlds.people.participant import Affliction, EmulatedParticipant

FloatArray = NDArray[np.float64]

LIFTED_V, LIFTED_NOISE_V, HUM_V = 1.5e-3, 60e-6, 30e-6
"Mains hum and noise, rms, of an electrode in the air; hum of a bad ground."
OFFSET_N, TOO_LARGE = 0.25, 500.0
"Zero error of the force; factor of EMG that is clipped."
_EDGE = 0.45
"Largest corner of a filter as a share of the rate."
_EMG, _FORCE, _PHASE = 1, 2, 3
"Streams of random numbers of one seed; 0 are the hand's."


def carrier_filter(fs_hz: float) -> FloatArray:
    """Second-order sections that turn white noise of variance 1 into EMG with a mean rectified value of 1.

    Power spectrum of `emg2vsa.worlds.people.carrier.muscle_spectrum`, by the bilinear transform of its poles and zeros.
    """

    def warped(hz: float) -> float:
        return 2 * fs_hz * math.tan(math.pi * min(hz, _EDGE * fs_hz) / fs_hz)

    low, high = warped(MUSCLE_LOW_HZ), warped(MUSCLE_HIGH_HZ)
    band = [warped(hz) for hz in AMPLIFIER_BAND_HZ]
    turn = np.exp(1j * math.pi * np.array([0.75, -0.75]))
    poles = np.concatenate([[-low, -high, -high], band[0] * turn, band[1] * turn])
    sos: FloatArray = zpk2sos(*bilinear_zpk(np.zeros(3), poles, 1.0, fs_hz))
    _, response = freqz_sos(sos, 1 << 14)
    sos[0, :3] *= math.sqrt(math.pi / 2) / math.sqrt(float(np.mean(np.abs(response) ** 2)))
    return sos


class Sampler:
    """Takes samples of the participant at ``fs_hz``, the first at ``start_s``. taken : samples so far."""

    def __init__(self, participant: EmulatedParticipant, fs_hz: float, start_s: float, stream: int) -> None:
        self._participant, self.fs_hz, self._start_s, self.taken = participant, fs_hz, start_s, 0
        seed, *key = participant.person.seed
        self._rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(*key, stream)))

    def due(self, time_s: float) -> int:
        """Samples measured by a time and not yet taken."""
        return max(0, math.floor((time_s - self._start_s) * self.fs_hz + 1e-6) + 1 - self.taken)

    @property
    def newest_s(self) -> float:
        """When the last sample taken was measured."""
        return self._start_s + (self.taken - 1) / self.fs_hz

    def _next_times_s(self, n: int) -> FloatArray:
        times_s: FloatArray = self._start_s + (self.taken + np.arange(n)) / self.fs_hz
        self.taken += n
        return times_s


class EmgSampler(Sampler):
    """The EMG of some muscles, sample by sample; the same however many are taken at a time.

    muscles : name of each channel's muscle; a channel of an unknown one has nothing but noise and hum.
    range_v : largest value of the device. start_s : of sample 0.
    """

    def __init__(
        self,
        participant: EmulatedParticipant,
        muscles: Sequence[str],
        fs_hz: float,
        *,
        range_v: float = 11e-3,
        start_s: float = 0.0,
    ) -> None:
        super().__init__(participant, fs_hz, start_s, _EMG)
        self._muscles, self._range_v = tuple(muscles), range_v
        self._shares = np.array([participant.person.muscle_share.get(muscle, 0.0) for muscle in muscles])
        self._sos = carrier_filter(fs_hz)
        self._state = np.zeros((len(self._sos), 2, len(muscles)))
        self._phases = math.tau * np.arange(len(muscles)) / 7

    def take(self, n: int) -> FloatArray:
        """(n, muscles) the next samples, V."""
        times_s = self._next_times_s(n)
        if not n:
            return np.zeros((0, len(self._muscles)))
        person = self._participant.person
        white = self._rng.standard_normal((n, 2, len(self._muscles)))
        carrier, self._state = sosfilt(self._sos, white[:, 0], axis=0, zi=self._state)
        emg_v: FloatArray = self._participant.cocontraction_v(times_s)[:, None] * self._shares * carrier
        hum = math.sqrt(2) * np.sin(math.tau * person.mains_hz * times_s[:, None] + self._phases)
        emg_v += person.mains_v * hum + person.emg_noise_v * white[:, 1]
        for wrong in self._participant.afflicted(times_s[0], times_s[-1] + 1 / self.fs_hz):
            during = (times_s >= wrong.start_s) & (times_s < wrong.end_s)
            emg_v[during] = self._afflicted(wrong, emg_v[during], hum[during], white[during, 1])
        return np.clip(emg_v, -self._range_v, self._range_v, out=emg_v)

    def _afflicted(self, wrong: Affliction, emg_v: FloatArray, hum: FloatArray, white: FloatArray) -> FloatArray:
        if wrong.kind == "mains":
            return emg_v + HUM_V * hum
        if wrong.kind == "clipping":
            return emg_v * TOO_LARGE
        if wrong.kind == "electrode-off":
            columns = [column for column, muscle in enumerate(self._muscles) if muscle == wrong.muscle]
            emg_v[:, columns] = LIFTED_V * hum[:, columns] + LIFTED_NOISE_V * white[:, columns]
        return emg_v


class ForceSampler(Sampler):
    """The force sensor under the specimen, sample by sample; pressing is positive."""

    def __init__(self, participant: EmulatedParticipant, fs_hz: float, *, start_s: float = 0.0) -> None:
        super().__init__(participant, fs_hz, start_s, _FORCE)

    def take(self, n: int) -> FloatArray:
        """(n, 1) the next samples, N."""
        times_s = self._next_times_s(n)
        force_n = felt_n(self._participant, times_s)
        return (force_n + self._participant.person.force_noise_n * self._rng.standard_normal(n))[:, None]


def felt_n(participant: EmulatedParticipant, times_s: FloatArray) -> FloatArray:
    """(n,) force on the sensor at rising times, without its noise."""
    force_n = participant.force_n(times_s)
    if times_s.size:
        for wrong in participant.afflicted(times_s[0], times_s[-1] + 1e-9):
            if wrong.kind == "sensor-offset":
                force_n = force_n + OFFSET_N * ((times_s >= wrong.start_s) & (times_s < wrong.end_s))
    return force_n
