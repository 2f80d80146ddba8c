"""``emg2vsa session STUDY``: run one participant's session, with its two pages, to its verdict."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command
from emg2vsa.cli.arguments import add_port, add_study, web_pages
from emg2vsa.cli.session import check_emulated

if TYPE_CHECKING:
    from emg2vsa.live.server import Listening
    from emg2vsa.rig.clock import Clock
    from emg2vsa.session.desk import SessionDesk
    from emg2vsa.session.emulated.participant import EmulatedParticipant
    from emg2vsa.session.open_session import Makers
    from emg2vsa.study import Study

_PORT = 8421
_SHOWN_S = 1.5
"""The pages stay so long after the end, to show it."""


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "run",
        run,
        "Run a participant's session as [session] of the study file says, or go on with an interrupted one.",
        "Two addresses are printed: the operator's page and the participant's. Samples and events are saved as they "
        "come; after the last press the recordings are written in BIDS, and the session is judged as emg2vsa check "
        "judges it. Ctrl-C ends the session, which --resume takes up again. Exit status 0: complete, and good or "
        "usable; 1: ended before its last press, or to repeat; 2: study file or devices are unusable.",
    )
    add_study(parser)
    parser.add_argument("--participant", required=True, metavar="CODE", help="a code of [participants]: P03")
    parser.add_argument("--resume", action="store_true", help="go on with the session that was interrupted")
    pages = parser.add_argument_group("pages")
    add_port(pages, _PORT)
    pages.add_argument(
        "--bind", metavar="ADDRESS", help="a further address of this computer, for a second screen or a tablet"
    )
    pages.add_argument("--no-page", action="store_true", help="with --virtual: an emulated operator instead of pages")
    virtual = parser.add_argument_group("without devices")
    virtual.add_argument("--virtual", action="store_true", help="an emulated participant behind emulated sensors")
    virtual.add_argument(
        "--mistake", action="append", default=[], metavar="WORDS",
        help="of the participant: dips@12, early@training-1, electrode-off:FDS@21-30; may be given again; kinds: "
        "emg2vsa session emulate --help",
    )  # fmt: skip
    virtual.add_argument(
        "--speed", type=float, metavar="X", help="times as fast as real time (default: 1; with --no-page: at once)"
    )
    virtual.add_argument("--seed", type=int, metavar="N", help="of the participant (default: that of [simulation])")
    virtual.add_argument("--truth", type=Path, metavar="FILE", help="at the end, write what is true of every press")


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.session.finish import finish
    from emg2vsa.rig.clock import VirtualClock
    from emg2vsa.session.open_session import folder_of, open_session, settings_of
    from emg2vsa.study_file import load_study

    study = load_study(arguments.study)
    settings_of(study, arguments.participant)
    _check(arguments)
    clock = _clock(arguments)
    person, makers = _devices(study, arguments, clock)
    at_once = isinstance(clock, VirtualClock)
    with (
        _port_taken(arguments) as at,
        open_session(study, arguments.participant, clock, makers, resume=arguments.resume, at_once=at_once) as desk,
    ):
        if at is None:
            _alone(desk, clock, person, at_once)
        else:
            _with_pages(desk, clock, person, at)
        ended = desk.session.ended
    if person is not None and arguments.truth:
        person.write_truth(arguments.truth)
    assert ended is not None
    print(f"{ended.how}{': ' if ended.why else ''}{ended.why}; recorded in {folder_of(study, arguments.participant)}")
    if ended.how != "completed":
        again = f"emg2vsa session {arguments.study} --participant {arguments.participant} --resume"
        print(f"Go on: {again}\nOr write the recordings so far: {again.replace('session', 'session finish', 1)[:-9]}")
        return 1
    return finish(arguments.study, arguments.participant)


def _check(arguments: argparse.Namespace) -> None:
    from emg2vsa.errors import SettingError

    virtual_only = {"--no-page": arguments.no_page, "--mistake": arguments.mistake, "--speed": arguments.speed,
                    "--seed": arguments.seed is not None, "--truth": arguments.truth}  # fmt: skip
    for name, value in virtual_only.items():
        if value and not arguments.virtual:
            raise SettingError(
                name, wanted="--virtual beside this option", found="real devices", do=f"Leave {name} out."
            )
    check_emulated(arguments)
    if arguments.seed is not None and arguments.seed < 0:
        raise SettingError(
            "--seed", wanted="a whole number from 0", found=str(arguments.seed), do="Choose a whole number."
        )


def _clock(arguments: argparse.Namespace) -> Clock:
    from emg2vsa.rig.clock import FastClock, VirtualClock, WallClock

    if arguments.no_page and arguments.speed is None:
        return VirtualClock()
    return WallClock() if arguments.speed in (None, 1) else FastClock(arguments.speed)


def _devices(study: Study, arguments: argparse.Namespace, clock: Clock) -> tuple[EmulatedParticipant | None, Makers]:
    """The devices of [session]; or a participant, and what measures it."""
    from emg2vsa.rig_file import load_rig
    from emg2vsa.session.open_sources import source_makers

    settings = study.session
    assert settings is not None
    if not arguments.virtual:
        muscles = tuple(study.recordings[0].channels.emg)
        rig = settings.force.rig if settings.force.kind == "rig" else None
        force = load_rig(study.path.parent / rig).devices.force if rig else None
        return None, source_makers(settings, muscles, clock, rig_force=force)
    from emg2vsa.session.emulated.mistakes import parse_mistakes
    from emg2vsa.session.emulated.simulated import simulate

    if study.simulation is not None and arguments.seed is not None:
        study = replace(study, simulation=replace(study.simulation, seed=arguments.seed))
    shares = study.simulation.muscle_share if study.simulation else {}
    mistakes = parse_mistakes(arguments.mistake, shares)
    person, emg, force_source = simulate(study, settings, arguments.participant, clock, mistakes)
    return person, (lambda: emg, lambda: force_source)


def _alone(desk: SessionDesk, clock: Clock, person: EmulatedParticipant | None, at_once: bool) -> None:
    """No pages: the operator is emulated as well."""
    from emg2vsa.rig.clock import undisturbed
    from emg2vsa.session.emulated.operator import EmulatedOperator

    assert person is not None
    person.watch(desk)
    operator = EmulatedOperator(desk, person.place)
    try:
        with nullcontext() if at_once else undisturbed():
            desk.run(clock, operator.turn)
    except KeyboardInterrupt:
        desk.session.end("ended", "Ctrl-C")


def _with_pages(desk: SessionDesk, clock: Clock, person: EmulatedParticipant | None, at: Listening) -> None:
    """The session turns in a thread of its own beside the server of the pages."""
    import threading
    import time

    from emg2vsa.live.server import HOST, serve
    from emg2vsa.live.session_routes import session_pages
    from emg2vsa.rig.clock import undisturbed

    failures: list[BaseException] = []
    over = threading.Event()

    def turn() -> None:
        try:
            with undisturbed():
                desk.run(clock, _placing(desk, person))
            time.sleep(_SHOWN_S)
        except BaseException as error:
            failures.append(error)
        finally:
            over.set()

    def ready(*addresses: str) -> None:
        operator, participant = addresses
        print(f"operator:    {operator}\nparticipant: {participant}")
        if at.host != HOST:
            print("What these pages send over the network is not encrypted.")
        print("Ctrl-C ends the session; --resume takes it up again.", flush=True)

    turning = threading.Thread(target=turn, name="session")
    if person is not None:
        person.watch(desk)
    turning.start()
    try:
        serve(session_pages(desk, clock), at, ready, over)
        over.wait()
    except KeyboardInterrupt:
        print()
    finally:
        desk.session.end("ended", "Ctrl-C")
        turning.join()
    if failures:
        raise failures[0]


def _placing(desk: SessionDesk, person: EmulatedParticipant | None) -> Callable[[float], None]:
    """The emulated participant gets the specimen that the operator is asked to place."""

    def place(now_s: float) -> None:
        state = desk.operator()[1]
        if person is not None and state.awaits == "specimen":
            person.place(state.specimen)

    return place


def _port_taken(arguments: argparse.Namespace) -> AbstractContextManager[Listening | None]:
    """Before the session begins, for it ends nothing that has begun. SettingError without the extra for web pages."""
    if arguments.no_page:
        return nullcontext()
    with web_pages("session"):
        from emg2vsa.live.server import listening
    return listening(arguments.port, arguments.bind)
