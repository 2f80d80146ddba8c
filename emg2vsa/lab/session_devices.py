"""The devices of a session, or an emulated participant in their place."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from emg2vsa.devices.clock import Clock, FastClock, WallClock
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.devices.rig_force.settings import RigForceSettings
from emg2vsa.errors import SettingError
from emg2vsa.rig_file import load_rig
from emg2vsa.session.open_session import Makers
from emg2vsa.session.open_sources import source_makers
from emg2vsa.session_settings import SessionSettings
from emg2vsa.study import Study
from emg2vsa.worlds.people.mistakes import Mistake, parse_mistakes
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.simulated import simulate


@dataclass(frozen=True, kw_only=True)
class Virtual:
    """An emulated participant; the truth of [simulation] is what the muscles do.

    Parameters
    ----------
    seed : of the participant; None is that of [simulation].
    mistakes : planned at a press, as in words on the command line: "dips@12", "early@training-1",
        "electrode-off:FDS@21-30". `emg2vsa session emulate --help` lists the kinds.
    speed : times as fast as real time, 0.1 to 100. None is at once without pages, and real time with them.
    truth : file to which, at the end, what is true of every press is written as JSON; None for none.

    Raises
    ------
    SettingError : one of them cannot be. It names the option of the command line. Mistakes are read when the
        muscles are known: by `emg2vsa.session.run`.

    Examples
    --------
    >>> Virtual(seed=1, mistakes=("dips@12",)).speed is None
    True
    """

    seed: int | None = None
    mistakes: tuple[str, ...] = ()
    speed: float | None = None
    truth: Path | None = None

    def __post_init__(self) -> None:
        if self.speed is not None and not 0.1 <= self.speed <= 100:
            found = f"{self.speed:g}"
            raise SettingError("--speed", wanted="0.1 to 100 times real time", found=found, do="Choose another.")
        if self.truth is not None and not self.truth.absolute().parent.is_dir():
            do = "Make the folder."
            raise SettingError(f"--truth {self.truth}", wanted="a file in a folder", found="no such folder", do=do)
        if self.truth is not None and self.truth.is_dir():
            raise SettingError(f"--truth {self.truth}", wanted="a file", found="a folder", do="Name a file in it.")
        if self.seed is not None and not (isinstance(self.seed, int) and self.seed >= 0):
            raise SettingError(
                "--seed", wanted="a whole number from 0", found=str(self.seed), do="Choose a whole number."
            )

    def clock(self) -> WallClock | FastClock:
        """A clock of this speed."""
        return WallClock() if self.speed in (None, 1) else FastClock(self.speed)

    def seeded(self, study: Study) -> Study:
        """The study with this seed in [simulation]."""
        if study.simulation is None or self.seed is None:
            return study
        return replace(study, simulation=replace(study.simulation, seed=self.seed))

    def planned(self, study: Study) -> tuple[Mistake, ...]:
        """The mistakes. SettingError for words that say none."""
        return parse_mistakes(self.mistakes, study.simulation.muscle_share if study.simulation else {})

    def keep_truth(self, person: EmulatedParticipant) -> None:
        """Write what was true, where a file is named for it."""
        if self.truth is not None:
            person.write_truth(self.truth)


def rig_force(study: Study, settings: SessionSettings) -> ForceSettings | None:
    """The [force] of the rig file, where the force comes from a rig."""
    if not isinstance(settings.force, RigForceSettings):
        return None
    return load_rig(study.path.parent / settings.force.rig).devices.force


def devices(
    study: Study, settings: SessionSettings, participant: str, clock: Clock, virtual: Virtual | None
) -> tuple[EmulatedParticipant | None, Makers]:
    """What opens the devices of [session]; or an emulated participant, and what measures it."""
    if virtual is None:
        muscles = tuple(study.recordings[0].channels.emg)
        return None, source_makers(settings, muscles, clock, rig_force=rig_force(study, settings))
    person, emg, force = simulate(virtual.seeded(study), settings, participant, clock, virtual.planned(study))
    return person, (lambda: emg, lambda: force)
