"""``emg2vsa session emulate``: an emulated participant behind the devices that a study's [session] names."""

from __future__ import annotations

import argparse
import signal
import sys
import threading
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Self

from casr.command_line import Commands, add_command
from emg2vsa.cli.arguments import add_study
from emg2vsa.cli.session import check_emulated

if TYPE_CHECKING:
    from emg2vsa.rig.clock import Clock
    from emg2vsa.rig.device_settings import ForceSettings
    from emg2vsa.session.emulated.operator import EmulatedOperator
    from emg2vsa.session.emulated.participant import EmulatedParticipant
    from emg2vsa.session.emulated.serve import Served
    from emg2vsa.session_settings import SessionSettings
    from emg2vsa.study import Study

_OPERATOR_S = 0.1
_HELP = """  page URL               obey the participant's page at this address
  operator-page URL      put on the table what the operator's page names
  place NAME             put a specimen under the finger
  drop N                 N frames of the EMG are lost on the radio
  stall S                no EMG for S seconds, and then all at once
  disconnect             every connection to the Trigno server is cut
  unpair N               the sensor of slot N is gone
  quit                   as Ctrl-C"""


def add_to(commands: Commands) -> None:
    from emg2vsa.session.emulated.mistakes import OF_HAND, OF_SENSOR

    kinds = "; ".join(f"{kind}: {words}" for kind, words in (OF_HAND | OF_SENSOR).items())
    parser = add_command(
        commands,
        "emulate",
        run,
        "Emulate the devices of [session] and a participant at them, until Ctrl-C.",
        "Then run emg2vsa session STUDY in another shell, and type its two addresses here: page URL, and operator-page "
        f"URL. The truth of [simulation] is what the muscles do. Mistakes: {kinds}. Lines typed here put "
        "specimens on the table and faults on the devices; type help.",
    )
    add_study(parser)
    parser.add_argument("--participant", required=True, metavar="CODE", help="who is emulated: P03")
    parser.add_argument("--page", metavar="URL", help="address of the participant's page, which is obeyed")
    parser.add_argument(
        "--operator-page", metavar="URL", help="address of the operator's page, whose specimen is put on the table"
    )
    parser.add_argument("--operate", action="store_true", help="emulate the operator at that page too")
    parser.add_argument(
        "--mistake",
        action="append",
        default=[],
        metavar="WORDS",
        help="planned at a press: dips@12, early@training-1, electrode-off:FDS@21-30; may be given again",
    )
    parser.add_argument("--speed", type=float, default=1.0, metavar="X", help="times as fast as real time (default: 1)")
    parser.add_argument(
        "--start-delay",
        type=float,
        default=1.8,
        metavar="S",
        help="Trigno: from START to first samples (default: 1.8)",
    )
    parser.add_argument("--truth", type=Path, metavar="FILE", help="at the end, write what is true of every press")


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.rig.clock import FastClock, WallClock
    from emg2vsa.session.emulated.serve import serve
    from emg2vsa.study_file import load_study

    _check(arguments)
    study = load_study(arguments.study)
    settings = _settings(study)
    person = _person(study, settings, arguments)
    clock = WallClock() if arguments.speed == 1 else FastClock(arguments.speed)
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with (
            serve(person, settings, _force(study, settings), clock, arguments.start_delay) as served,
            _Table(person, served, clock, arguments.operate) as table,
        ):
            if arguments.page:
                table.follow(arguments.page)
            if arguments.operator_page:
                table.follow_operator(arguments.operator_page)
            lines = f"# {arguments.participant}", *served.lines, "# help for faults, Ctrl-C to end"
            print("\n".join(lines), flush=True)
            try:
                table.obey(sys.stdin)
                threading.Event().wait()  # nobody types: serve on
            except KeyboardInterrupt:
                print("\nend of the emulation", flush=True)
    finally:
        signal.signal(signal.SIGTERM, before)
    if arguments.truth:
        person.write_truth(arguments.truth)
    return 0


def _check(arguments: argparse.Namespace) -> None:
    from emg2vsa.errors import SettingError

    check_emulated(arguments)
    if not 0 <= arguments.start_delay <= 60:
        found = f"{arguments.start_delay:g}"
        raise SettingError("--start-delay", wanted="0 to 60 s", found=found, do="Choose a delay in this range.")


def _settings(study: Study) -> SessionSettings:
    from emg2vsa.errors import SettingError

    if study.session is None:
        do = "Add it (docs/reference/study-file.md)."
        raise SettingError(study.path, wanted="a table [session]", found="none", do=do)
    return study.session


def _force(study: Study, settings: SessionSettings) -> ForceSettings | None:
    """The [force] of the rig file, where the force comes from a rig."""
    from emg2vsa.rig_file import load_rig

    if settings.force.kind != "rig" or settings.force.rig is None:
        return None
    return load_rig(study.path.parent / settings.force.rig).devices.force


def _person(study: Study, settings: SessionSettings, arguments: argparse.Namespace) -> EmulatedParticipant:
    from emg2vsa.session.emulated.mistakes import parse_mistakes
    from emg2vsa.session.emulated.participant import EmulatedParticipant
    from emg2vsa.session.emulated.person import person_of

    person = person_of(study, arguments.participant)
    mistakes = parse_mistakes(arguments.mistake, person.muscle_share)
    return EmulatedParticipant(person, mistakes=mistakes, range_n=settings.force_n)


class _Table:
    """What happens at the participant's table while the devices are served."""

    def __init__(self, person: EmulatedParticipant, served: Served, clock: Clock, operate: bool) -> None:
        self._person, self._server, self._clock, self._operate = person, served.trigno, clock, operate
        self._pages = ExitStack()
        self._ended = threading.Event()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._ended.set()
        self._pages.close()

    def follow(self, address: str) -> None:
        """The participant obeys this page from now on. DeviceError when there is none."""
        from emg2vsa.session.emulated.page_follower import FollowedPage

        self._person.watch(self._pages.enter_context(FollowedPage(address)))

    def follow_operator(self, address: str) -> None:
        """The specimens that this page names are put on the table. DeviceError when there is none."""
        from emg2vsa.session.emulated.operator import EmulatedOperator
        from emg2vsa.session.emulated.page_follower import FollowedOperator

        place = self._person.place
        page = self._pages.enter_context(FollowedOperator(address, None if self._operate else place))
        if self._operate:
            operator = EmulatedOperator(page, place)
            threading.Thread(target=self._let_operate, args=(operator,), daemon=True).start()

    def _let_operate(self, operator: EmulatedOperator) -> None:
        while not self._ended.is_set():
            self._clock.sleep_until(self._clock.now_s() + _OPERATOR_S)
            operator.turn(self._clock.now_s())

    def obey(self, lines: Iterable[str]) -> None:
        """Do what is typed, line by line, until the last one."""
        from emg2vsa.errors import DeviceError

        for line in lines:
            word, _, value = line.strip().partition(" ")
            if word == "quit":
                raise KeyboardInterrupt
            try:
                if word:
                    print(self._done(word, value.strip()), flush=True)
            except DeviceError as error:
                print(error, flush=True)

    def _done(self, word: str, value: str) -> str:
        """What was done, or why not."""
        if word == "help":
            return _HELP
        acts: dict[str, Callable[[str], None]] = {
            "page": self.follow, "operator-page": self.follow_operator, "place": self._person.place
        }  # fmt: skip
        if (server := self._server) is not None:
            acts |= {
                "drop": lambda frames: server.drop(int(frames)),
                "stall": lambda seconds: server.stall(float(seconds)),
                "disconnect": lambda _: server.disconnect(),
                "unpair": lambda slot: server.unpair(int(slot)),
            }
        if word not in acts:
            return f"{word!r} is none of {', '.join(['help', 'quit', *acts])}."
        try:
            acts[word](value)
        except (ValueError, KeyError):
            return f"{word}: expected a number, but found {value!r}."
        return f"done: {word} {value}".strip()
