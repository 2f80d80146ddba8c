"""The devices of a session: real ones, an emulated participant in their place, or one served to another process."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from emg2vsa.devices.clock import Clock, FastClock, WallClock
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.devices.rig_force import RigForceSettings
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.rig_file import load_rig
from emg2vsa.session.open_session import Makers, settings_of, source_makers
from emg2vsa.session_settings import SessionSettings
from emg2vsa.study import Study
from emg2vsa.worlds.far_ends.serve import Served, Table, serve
from emg2vsa.worlds.far_ends.trigno_server import START_DELAY_S
from emg2vsa.worlds.people.mistakes import Mistake, parse_mistakes
from emg2vsa.worlds.people.pages import EmulatedOperator, FollowedOperator, FollowedPage
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import person_of
from emg2vsa.worlds.people.sensors import simulate


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


_OPERATOR_S = 0.1
_HELP = """  page URL               obey the participant's page at this address
  operator-page URL      put on the table what the operator's page names
  place NAME             put a specimen under the finger
  drop N                 N frames of the EMG are lost on the radio
  stall S                no EMG for S seconds, and then all at once
  disconnect             every connection to the Trigno server is cut
  unpair N               the sensor of slot N is gone
  quit                   as Ctrl-C"""


class Emulation:
    """What happens at the participant's table while the devices are served. Any thread may call its methods.

    served : what stands at which address. Its ``trigno`` takes faults of the EMG: drop, stall, disconnect, unpair.
    """

    def __init__(
        self, person: EmulatedParticipant, served: Served, clock: Clock, operate: bool, stack: ExitStack
    ) -> None:
        self.served = served
        self._person, self._clock, self._operate, self._stack = person, clock, operate, stack
        self._ended = threading.Event()
        stack.callback(self._ended.set)

    def place(self, specimen: str) -> None:
        """Put a specimen under the finger."""
        self._person.place(specimen)

    def follow(self, address: str) -> None:
        """The participant obeys this page from now on. DeviceError when there is none."""
        self._person.watch(self._stack.enter_context(FollowedPage(address)))

    def follow_operator(self, address: str) -> None:
        """The specimens that this page names are put on the table, by an emulated operator where one was asked for.
        DeviceError when there is no such page."""
        page = self._stack.enter_context(FollowedOperator(address, None if self._operate else self.place))
        if self._operate:
            operator = EmulatedOperator(page, self.place)
            threading.Thread(target=self._let_operate, args=(operator,), daemon=True).start()

    def obey(self, line: str) -> str:
        """Do what an experimenter types; what was done, or why not. The line "help" lists the words."""
        word, _, value = line.strip().partition(" ")
        if word == "help":
            return _HELP
        acts: dict[str, Callable[[str], None]] = {
            "page": self.follow, "operator-page": self.follow_operator, "place": self.place
        }  # fmt: skip
        if (server := self.served.trigno) is not None:
            acts |= {
                "drop": lambda frames: server.drop(int(frames)),
                "stall": lambda seconds: server.stall(float(seconds)),
                "disconnect": lambda _: server.disconnect(),
                "unpair": lambda slot: server.unpair(int(slot)),
            }
        if word not in acts:
            return f"{word!r} is none of {', '.join(['help', 'quit', *acts])}."
        try:
            acts[word](value.strip())
        except DeviceError as error:
            return str(error)
        except (ValueError, KeyError):
            return f"{word}: expected a number, but found {value.strip()!r}."
        return f"done: {word} {value.strip()}".strip()

    def _let_operate(self, operator: EmulatedOperator) -> None:
        while not self._ended.is_set():
            self._clock.sleep_until(self._clock.now_s() + _OPERATOR_S)
            operator.turn(self._clock.now_s())


@contextmanager
def emulate(
    study: Study,
    participant: str,
    *,
    visit: str | None = None,
    virtual: Virtual = Virtual(),
    start_delay_s: float = START_DELAY_S,
    operate: bool = False,
) -> Iterator[Emulation]:
    """Serve emulated devices where [session] of the study says that they are, within a with statement.

    Parameters
    ----------
    participant : who is emulated, a code of the study's participants. visit : where the study has several.
    virtual : of the participant. speed None is real time.
    start_delay_s : of a Trigno, from START to the first samples, 0 to 60 s.
    operate : emulate the operator as well, at the page that `Emulation.follow_operator` names.

    Raises
    ------
    SettingError : the study has no [session] or no such participant; a device is of a kind that no other process can
        reach, or is not on this computer; an option cannot be used.
    DeviceError : a port is taken.

    Examples
    --------
    >>> from emg2vsa import session
    >>> with session.emulate(study, "P03") as table:  # doctest: +SKIP
    ...     table.follow("http://127.0.0.1:8421/.../participant/")
    ...     table.place("S1")
    """
    if not 0 <= start_delay_s <= 60:
        found = f"{start_delay_s:g}"
        raise SettingError("--start-delay", wanted="0 to 60 s", found=found, do="Choose a delay in this range.")
    study = study.at_visit(visit)
    settings = settings_of(study, participant)
    mistakes = virtual.planned(study)
    person = EmulatedParticipant(
        person_of(virtual.seeded(study), participant), mistakes=mistakes, range_n=settings.force_n
    )
    clock = virtual.clock()
    table = Table(person, settings, rig_force(study, settings), clock, start_delay_s)
    with serve(table) as served, ExitStack() as stack:
        yield Emulation(person, served, clock, operate, stack)
    virtual.keep_truth(person)
