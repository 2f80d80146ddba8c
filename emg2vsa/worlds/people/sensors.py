"""What sensors measure of an emulated participant, and sources of kind "simulated" on them, within the process."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.streams import Block, StreamCounts, StreamInfo
from emg2vsa.session_settings import SessionSettings
from emg2vsa.study import Study
from emg2vsa.worlds.people.mistakes import Mistake
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import person_of
from emg2vsa.worlds.people.signals import Electrode, Faults, ForceSensor

FloatArray = NDArray[np.float64]

LIFTED_V, LIFTED_NOISE_V, HUM_V = 1.5e-3, 60e-6, 30e-6
"Mains hum and noise, rms, of an electrode in the air; hum of a bad ground."
OFFSET_N, TOO_LARGE = 0.25, 500.0
"Zero error of the force; factor of EMG that is clipped."
EMG_RANGE_V, EMG_HZ = 11e-3, 1000.0
FORCE_HZ, FORCE_RANGE_N = 1000.0, 290.0
_FACTS = {"manufacturer": "emg2vsa (emulated)", "model": "emulated participant"}
FRAME_S = 0.0135
LOST_SHARE = 0.05
"Share of lost frames of a radio that loses some."
_EMG, _FORCE, _LOST = 1, 2, 3
"Streams of random numbers of one seed; 0 are the hand's."


class Sampler:
    """Takes samples of the participant at ``fs_hz``, the first at ``start_s``. taken : samples so far."""

    def __init__(self, participant: EmulatedParticipant, fs_hz: float, start_s: float) -> None:
        self._participant, self.fs_hz, self._start_s, self.taken = participant, fs_hz, start_s, 0
        self._person = participant.person

    def _rng(self, *stream: int) -> np.random.Generator:
        seed, *key = self._person.seed
        return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(*key, *stream)))

    def due(self, time_s: float) -> int:
        """Samples measured by a time, s, and not yet taken."""
        return max(0, math.floor((time_s - self._start_s) * self.fs_hz + 1e-6) + 1 - self.taken)

    def lost(self, n: int, frame: int) -> NDArray[np.bool_]:
        """(n,) which of the ``n`` samples taken last are in a frame that a radio lost; of force none is."""
        return np.zeros(n, dtype=np.bool_)

    @property
    def newest_s(self) -> float:
        """When the last sample taken was measured, s."""
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
        range_v: float = EMG_RANGE_V,
        start_s: float = 0.0,
    ) -> None:
        super().__init__(participant, fs_hz, start_s)
        self._muscles, self._range_v, person = tuple(muscles), range_v, self._person
        of_emg = Faults(person.emg_noise_v, person.mains_v, person.mains_hz)
        self._electrodes = [Electrode(self._rng(_EMG, k), fs_hz, of_emg) for k in range(len(muscles))]

    def take(self, n: int) -> FloatArray:
        """(n, muscles) the next samples, V."""
        times_s = self._next_times_s(n)
        if not n:
            return np.zeros((0, len(self._muscles)))
        level_v = self._participant.cocontraction_v(times_s)
        afflictions = self._participant.afflicted(times_s[0], times_s[-1] + 1 / self.fs_hz)
        emg_v = np.empty((n, len(self._muscles)))
        for column, (muscle, electrode) in enumerate(zip(self._muscles, self._electrodes, strict=True)):
            channel_v, hum, white = electrode.take(self._person.muscle_share.get(muscle, 0.0) * level_v)
            for wrong in afflictions:
                during = (times_s >= wrong.start_s) & (times_s < wrong.end_s)
                if wrong.kind == "mains":
                    channel_v = np.where(during, channel_v + HUM_V * math.sqrt(2) * hum, channel_v)
                elif wrong.kind == "clipping":
                    channel_v = np.where(during, channel_v * TOO_LARGE, channel_v)
                elif (wrong.kind, wrong.muscle) == ("electrode-off", muscle):
                    channel_v = np.where(during, LIFTED_V * math.sqrt(2) * hum + LIFTED_NOISE_V * white, channel_v)
                elif (wrong.kind, wrong.muscle) == ("zeros", muscle):
                    channel_v = np.where(during, 0.0, channel_v)
            emg_v[:, column] = channel_v
        return np.clip(emg_v, -self._range_v, self._range_v, out=emg_v)

    def lost(self, n: int, frame: int) -> NDArray[np.bool_]:
        """(n,) which of the ``n`` samples taken last are in a frame of so many that a radio lost."""
        frames = np.arange(self.taken - n, self.taken) // frame
        begins_s = self._start_s + frames * frame / self.fs_hz
        found = np.zeros(n, dtype=np.bool_)
        for wrong in self._participant.afflicted(begins_s[0], begins_s[-1] + 1e-9) if n else ():
            during = (begins_s >= wrong.start_s) & (begins_s < wrong.end_s)
            if wrong.kind == "half-rate":
                found |= during & (frames % 2 == 1)
            elif wrong.kind == "radio-loss":
                chance = {each: self._rng(_LOST, each).random() for each in np.unique(frames).tolist()}
                found |= during & (np.array([chance[each] for each in frames.tolist()]) < LOST_SHARE)
        return found


class ForceSampler(Sampler):
    """The force sensor under the specimen, sample by sample; pressing is positive."""

    def __init__(self, participant: EmulatedParticipant, fs_hz: float, *, start_s: float = 0.0) -> None:
        super().__init__(participant, fs_hz, start_s)
        self._sensor = ForceSensor(self._rng(_FORCE), fs_hz, noise_n=self._person.force_noise_n)

    def take(self, n: int) -> FloatArray:
        """(n, 1) the next samples, N."""
        return self._sensor.take(felt_n(self._participant, self._next_times_s(n)))[:, None]


def felt_n(participant: EmulatedParticipant, times_s: FloatArray) -> FloatArray:
    """(n,) force, N, on the sensor at rising times, s, without its noise."""
    force_n = participant.force_n(times_s)
    if times_s.size:
        for wrong in participant.afflicted(times_s[0], times_s[-1] + 1e-9):
            if wrong.kind == "sensor-offset":
                force_n = force_n + OFFSET_N * ((times_s >= wrong.start_s) & (times_s < wrong.end_s))
    return force_n


class SimulatedSource:
    """A `emg2vsa.devices.streams.Source` on a sampler. ``delay_s`` : from the body to arrival."""

    def __init__(self, sampler: EmgSampler | ForceSampler, info: StreamInfo, clock: Clock) -> None:
        self._sampler, self._info, self._clock = sampler, info, clock
        self._first = 0

    @property
    def info(self) -> StreamInfo:
        return self._info

    def start(self) -> None:
        """What was before the start is not handed over."""
        self._sampler.take(self._sampler.due(self._clock.now_s() - self._info.delay_s))
        self._first = 0

    def read(self) -> list[Block]:
        now_s = self._clock.now_s()
        due = self._sampler.due(now_s - self._info.delay_s)
        if not due:
            return []
        samples = self._sampler.take(due)
        samples = samples[~self._sampler.lost(due, self._info.frame)]
        first, self._first = self._first, self._first + len(samples)
        return [Block(samples, first, now_s)] if len(samples) else []

    def counts(self) -> StreamCounts:
        return StreamCounts(self._first)

    def close(self) -> None:
        """Nothing is held."""


def simulated_emg(
    participant: EmulatedParticipant, muscles: Sequence[str], fs_hz: float, clock: Clock, delay_s: float = 0.0
) -> SimulatedSource:
    """The EMG of some muscles at ``fs_hz``, Hz. delay_s : from the body to arrival, s."""
    frame = max(1, round(FRAME_S * fs_hz))
    info = StreamInfo("emg", tuple(muscles), "V", fs_hz, EMG_RANGE_V, delay_s, _FACTS, frame)
    return SimulatedSource(EmgSampler(participant, muscles, fs_hz), info, clock)


def simulated_force(
    participant: EmulatedParticipant, clock: Clock, fs_hz: float = FORCE_HZ, delay_s: float = 0.0
) -> SimulatedSource:
    """The force at ``fs_hz``, Hz. delay_s : from the body to arrival, s."""
    info = StreamInfo("force", ("force",), "N", fs_hz, FORCE_RANGE_N, delay_s, _FACTS)
    return SimulatedSource(ForceSampler(participant, fs_hz), info, clock)


def simulate(
    study: Study, settings: SessionSettings, participant: str, clock: Clock, mistakes: Iterable[Mistake] = ()
) -> tuple[EmulatedParticipant, SimulatedSource, SimulatedSource]:
    """The participant, the source of the EMG and that of the force. SettingError as `person_of`."""
    person = EmulatedParticipant(person_of(study, participant), mistakes=mistakes, range_n=settings.force_n)
    fs_hz = getattr(settings.emg, "fs_hz", EMG_HZ)  # of whatever kind; others tell their rate when they are there
    emg = simulated_emg(person, tuple(person.person.muscle_share), fs_hz, clock, settings.emg.delay_s)
    return person, emg, simulated_force(person, clock, delay_s=settings.force.delay_s)
