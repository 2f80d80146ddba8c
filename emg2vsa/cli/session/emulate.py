"""``emg2vsa session emulate``: an emulated participant behind the devices that a study's [session] names."""

from __future__ import annotations

import argparse
import signal
import sys
import threading
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command
from emg2vsa.cli.arguments import add_study

if TYPE_CHECKING:
    from emg2vsa.rig.device_settings import ForceSettings
    from emg2vsa.session.emulated.participant import EmulatedParticipant
    from emg2vsa.session.emulated.serve import Served
    from emg2vsa.session_settings import SessionSettings
    from emg2vsa.study import Study

_HELP = """  place NAME             put a specimen under the finger
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
        "Then run emg2vsa session STUDY in another shell, and give its two addresses here with --page and "
        f"--operator-page. The truth of [simulation] is what the muscles do. Mistakes: {kinds}. Lines typed here put "
        "specimens on the table and faults on the devices; type help.",
    )
    add_study(parser)
    parser.add_argument("--participant", required=True, metavar="CODE", help="who is emulated: P03")
    parser.add_argument("--page", metavar="URL", help="address of the participant's page, which is obeyed")
    parser.add_argument(
        "--operator-page", metavar="URL", help="address of the operator's page, whose specimen is put on the table"
    )
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
        default=2.0,
        metavar="S",
        help="Trigno: from START to first samples (default: 2)",
    )
    parser.add_argument("--truth", type=Path, metavar="FILE", help="at the end, write what is true of every press")


def run(arguments: argparse.Namespace) -> int:
    from contextlib import ExitStack

    from emg2vsa.rig.clock import FastClock, WallClock
    from emg2vsa.session.emulated.page_follower import FollowedPage, FollowedTable
    from emg2vsa.session.emulated.serve import serve
    from emg2vsa.study_file import load_study

    _check(arguments)
    study = load_study(arguments.study)
    settings = _settings(study)
    person = _person(study, settings, arguments)
    clock = WallClock() if arguments.speed == 1 else FastClock(arguments.speed)
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with ExitStack() as stack:
            served = stack.enter_context(serve(person, settings, _force(study, settings), clock, arguments.start_delay))
            if arguments.page:
                person.watch(stack.enter_context(FollowedPage(arguments.page)))
            if arguments.operator_page:
                stack.enter_context(FollowedTable(arguments.operator_page, person.place))
            print(
                "\n".join([f"# {arguments.participant}", *served.lines, "# help for faults, Ctrl-C to end"]), flush=True
            )
            try:
                _obey(person, served, sys.stdin)
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

    if not 0.1 <= arguments.speed <= 100:
        found = f"{arguments.speed:g}"
        raise SettingError("--speed", wanted="0.1 to 100 times real time", found=found, do="Choose another.")
    if not 0 <= arguments.start_delay <= 60:
        found = f"{arguments.start_delay:g}"
        raise SettingError("--start-delay", wanted="0 to 60 s", found=found, do="Choose another.")
    if arguments.truth and not arguments.truth.absolute().parent.is_dir():
        found = "no such folder"
        raise SettingError(
            f"--truth {arguments.truth}", wanted="a file in a folder", found=found, do="Make the folder."
        )


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


def _obey(person: EmulatedParticipant, served: Served, lines: Iterable[str]) -> None:
    """Do what is typed, line by line, until the last one."""
    for line in lines:
        word, _, value = line.strip().partition(" ")
        if word == "quit":
            raise KeyboardInterrupt
        if word:
            print(_done(person, served, word, value.strip()), flush=True)


def _done(person: EmulatedParticipant, served: Served, word: str, value: str) -> str:
    """What was done, or why not."""
    if word == "help":
        return _HELP
    if word == "place":
        person.place(value)
        return f"on the table: {value}"
    faults: dict[str, Callable[[float], None]] = {}
    if (server := served.trigno) is not None:
        faults = {
            "drop": lambda frames: server.drop(int(frames)),
            "stall": server.stall,
            "disconnect": lambda _: server.disconnect(),
            "unpair": lambda slot: server.unpair(int(slot)),
        }
    if word not in faults:
        return f"{word!r} is none of {', '.join(['place', 'help', 'quit', *faults])}."
    try:
        faults[word](float(value or 1))
    except (ValueError, KeyError):
        return f"{word}: wanted a number, found {value!r}."
    return f"{word} {value}".strip()
