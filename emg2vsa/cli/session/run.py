"""``emg2vsa session STUDY``: run one participant's session, with its two pages, to its verdict."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, add_options, answer
from emg2vsa.cli.arguments import STUDY, add_port, web_pages
from emg2vsa.cli.session import PARTICIPANT, REQUIRED, check_virtual, finish

if TYPE_CHECKING:
    from emg2vsa.session import Addresses, SessionEnd

SUMMARY = "Run a participant's session as [session] of the study file says, or go on with an interrupted one."
EPILOG = """
Two addresses are printed: the operator's page and the participant's. Samples and events are saved as they come; after
the last press the recordings are written in BIDS, and the session is judged as emg2vsa check judges it. Ctrl-C ends the
session, which --resume takes up again. Exit status 0: complete, and good or usable; 1: ended before its last press, or
to repeat; 2: study file or devices are unusable.
"""
OPTIONS = f"{STUDY}{PARTICIPANT}--resume  go on with the session that was interrupted\n{JSON}"
PAGES = """
--bind ADDRESS  a further address of this computer, for a second screen or a tablet
--no-page  with --virtual: an emulated operator instead of pages
"""
VIRTUAL = """
--virtual  an emulated participant behind emulated sensors
--mistake WORDS...  of the participant: dips@12, early@training-1, electrode-off:FDS@21-30; may be given again; kinds:
    emg2vsa session emulate --help
--speed X  times as fast as real time (default: 1; with --no-page: at once)
--seed N  of the participant (default: that of [simulation])
--truth FILE  at the end, write what is true of every press
"""


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "run", run, SUMMARY, EPILOG, OPTIONS, participant=REQUIRED)
    pages = parser.add_argument_group("pages")
    add_port(pages, 8421)
    add_options(pages, PAGES)
    add_options(parser.add_argument_group("without devices"), VIRTUAL, {"N": int})


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa import session
    from emg2vsa.cli.progress import progress
    from emg2vsa.study_file import load_study

    study, alone = load_study(arguments.study), arguments.no_page
    check_virtual(arguments)
    asked = {"seed": arguments.seed, "mistakes": tuple(arguments.mistake), "speed": arguments.speed}
    virtual = session.Virtual(**asked, truth=arguments.truth)
    say = partial(print, file=sys.stderr if arguments.json else sys.stdout, flush=True)

    def shown(pages: Addresses) -> None:
        network = "\nWhat these pages send over the network is not encrypted." if pages.on_network else ""
        say(f"operator:    {pages.operator}\nparticipant: {pages.participant}{network}")
        say("Ctrl-C ends the session; --resume takes it up again.")

    def ended(end: SessionEnd) -> None:
        newline = "\n" if end.why == "Ctrl-C" and not alone else ""
        say(f"{newline}{': '.join(filter(None, (end.how, end.why)))}; recorded in {end.folder}")
        if end.how != "completed":
            words = f"{arguments.study} --participant {arguments.participant}"
            say(f"Go on: emg2vsa session {words} --resume")
            say(f"Or write the recordings so far: emg2vsa session finish {words}")

    with web_pages("session"):
        end = (session.resume if arguments.resume else session.run)(
            study, arguments.participant, virtual=virtual if arguments.virtual else None, shown=shown, ended=ended,
            progress=progress(quiet=True),
            pages=None if alone else session.Pages(port=arguments.port, bind=arguments.bind),
        )  # fmt: skip
    judged, lines = (finish.as_json(end.judged), finish.lines(end.judged)) if end.judged else (None, ())
    answer(arguments.json, {"how": end.how, "why": end.why, "folder": str(end.folder), "judged": judged}, lines)
    return int(not end.good)
