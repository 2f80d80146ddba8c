"""Sources of kind "simulated": EMG and force of an emulated participant, within the process."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.streams import Block, StreamCounts, StreamInfo
from emg2vsa.session_settings import SessionSettings
from emg2vsa.study import Study
from emg2vsa.worlds.people.mistakes import Mistake
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import person_of
from emg2vsa.worlds.people.sensors import EmgSampler, ForceSampler

EMG_RANGE_V, EMG_HZ = 11e-3, 1000.0
FORCE_HZ, FORCE_RANGE_N = 1000.0, 290.0
_FACTS = {"model": "emulated participant"}


class SimulatedSource:
    """A `emg2vsa.devices.streams.Source` on a sampler. ``delay_s`` : from the body to arrival."""

    def __init__(self, sampler: EmgSampler | ForceSampler, info: StreamInfo, clock: Clock) -> None:
        self._sampler, self._info, self._clock = sampler, info, clock

    @property
    def info(self) -> StreamInfo:
        return self._info

    def start(self) -> None:
        self._skip()

    def read(self) -> list[Block]:
        now_s = self._clock.now_s()
        due = self._sampler.due(now_s - self._info.delay_s)
        if not due:
            return []
        first = self._sampler.taken - self._skipped
        return [Block(self._sampler.take(due), first, now_s)]

    def counts(self) -> StreamCounts:
        return StreamCounts(self._sampler.taken - self._skipped)

    def close(self) -> None:
        """Nothing is held."""

    def _skip(self) -> None:
        """What was before the start is not handed over."""
        self._sampler.take(self._sampler.due(self._clock.now_s() - self._info.delay_s))
        self._skipped = self._sampler.taken


def simulated_emg(
    participant: EmulatedParticipant, muscles: Sequence[str], fs_hz: float, clock: Clock, delay_s: float = 0.0
) -> SimulatedSource:
    """The EMG of some muscles."""
    info = StreamInfo("emg", tuple(muscles), "V", fs_hz, EMG_RANGE_V, delay_s, _FACTS)
    return SimulatedSource(EmgSampler(participant, muscles, fs_hz, range_v=EMG_RANGE_V), info, clock)


def simulated_force(
    participant: EmulatedParticipant, clock: Clock, fs_hz: float = FORCE_HZ, delay_s: float = 0.0
) -> SimulatedSource:
    """The force."""
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
