"""An emulated participant behind emulated devices, for a session that another process runs."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from emg2vsa.devices.clock import Clock
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.lab.session_devices import Virtual, rig_force
from emg2vsa.session.open_session import settings_of
from emg2vsa.study import Study
from emg2vsa.worlds.far_ends.serve import serve
from emg2vsa.worlds.far_ends.table import Served, Table
from emg2vsa.worlds.far_ends.trigno.server import START_DELAY_S
from emg2vsa.worlds.people.operator import EmulatedOperator
from emg2vsa.worlds.people.page_follower import FollowedOperator, FollowedPage
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import person_of

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
    virtual: Virtual = Virtual(),  # noqa: B008  it is frozen
    start_delay_s: float = START_DELAY_S,
    operate: bool = False,
) -> Iterator[Emulation]:
    """Serve emulated devices where [session] of the study says that they are, within a with statement.

    Parameters
    ----------
    participant : who is emulated, a code of the study's participants.
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
