"""``emg2vsa session run`` and ``emulate``: a participant's session with its two pages, and emulated devices for it."""

from __future__ import annotations

import argparse
import signal
import sys
import threading
from functools import partial
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, add_options, answer, print_json
from emg2vsa.cli.arguments import STUDY, add_port, web_pages
from emg2vsa.cli.session import PARTICIPANT, REQUIRED
from emg2vsa.cli.session.recorded import finished_json, finished_lines

if TYPE_CHECKING:
    from emg2vsa.session import Addresses, SessionEnd

SUMMARY = "Run a participant's session as [session] of the study file says, or go on with an interrupted one."
EPILOG = """
Two addresses are printed: the operator's page and the participant's. Samples and events are saved as they come; after
the last press the recordings are written in BIDS, and the session is judged as emg2vsa check judges it. Ctrl-C ends the
session, which --resume takes up again. Exit status 0: complete, and good or usable; 1: ended before its last press, or
to repeat; 2: study file or devices are unusable.
"""
FORM = "--form FILE  the participant's answers to [session.form] (emg2vsa session form), for participants.tsv\n"
OPTIONS = f"{STUDY}{PARTICIPANT}{FORM}--resume  go on with the session that was interrupted\n{JSON}"
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
EMULATE = """
Then run emg2vsa session STUDY in another shell, and type its two addresses here: page URL, and operator-page URL. The
truth of [simulation] is what the muscles do. Mistakes: {kinds}. Lines typed here put specimens on the table and faults
on the devices; type help.
"""
EMULATED = f"""
{STUDY}--participant CODE  who is emulated: P03
--visit LABEL  one of [recordings] visits, where participants come more than once
--page URL  address of the participant's page, which is obeyed
--operator-page URL  address of the operator's page, whose specimen is put on the table
--operate  emulate the operator at that page too
--mistake WORDS...  planned at a press: dips@12, early@training-1, electrode-off:FDS@21-30; may be given again
--speed X = 1.0  times as fast as real time (default: 1)
--start-delay S = 1.8  Trigno: from START to first samples (default: 1.8)
--truth FILE  at the end, write what is true of every press
{JSON}"""


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "run", run, SUMMARY, EPILOG, OPTIONS, participant=REQUIRED)
    pages = parser.add_argument_group("pages")
    add_port(pages, 8421)
    add_options(pages, PAGES)
    add_options(parser.add_argument_group("without devices"), VIRTUAL, {"N": int})
    from emg2vsa.worlds.people.mistakes import OF_HAND, OF_SENSOR

    kinds = "; ".join(f"{kind}: {words}" for kind, words in (OF_HAND | OF_SENSOR).items())
    summary = "Emulate the devices of [session] and a participant at them, until Ctrl-C."
    add_command(commands, "emulate", emulate, summary, EMULATE.format(kinds=kinds), EMULATED, participant=REQUIRED)


def run(arguments: argparse.Namespace) -> int:
    """Run a session. SettingError : options of a virtual one without it."""
    from emg2vsa import session
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.registered import session_deviations
    from emg2vsa.session.open_session import missed_visits
    from emg2vsa.study_file import load_study

    study, alone = load_study(arguments.study), arguments.no_page
    _check_virtual(arguments)
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
            words += f" --visit {arguments.visit}" if arguments.visit else ""
            say(f"Go on: emg2vsa session {words} --resume")
            say(f"Or write the recordings so far: emg2vsa session finish {words}")

    at_visit, who = study.at_visit(arguments.visit), arguments.participant
    for told in (*session_deviations(study, who), *missed_visits(at_visit, who)):
        say(told)
    with web_pages("session"):
        end = (session.resume if arguments.resume else session.run)(
            study, arguments.participant, visit=arguments.visit, form=arguments.form,
            virtual=virtual if arguments.virtual else None, shown=shown, ended=ended, progress=progress(quiet=True),
            pages=None if alone else session.Pages(port=arguments.port, bind=arguments.bind),
        )  # fmt: skip
    judged, lines = (finished_json(end.judged), finished_lines(end.judged)) if end.judged else (None, ())
    answer(arguments.json, {"how": end.how, "why": end.why, "folder": str(end.folder), "judged": judged}, lines)
    return int(not end.good)


def _check_virtual(arguments: argparse.Namespace) -> None:
    """SettingError for an option of an emulated participant without --virtual."""
    from emg2vsa.errors import SettingError

    for option in ("no_page", "mistake", "speed", "seed", "truth"):
        if not arguments.virtual and getattr(arguments, option) != arguments.parser.get_default(option):
            name, wanted = f"--{option.replace('_', '-')}", "--virtual beside this option"
            raise SettingError(name, wanted=wanted, found="real devices", do=f"Leave {name} out.")


def emulate(arguments: argparse.Namespace) -> int:
    from emg2vsa import session
    from emg2vsa.study_file import load_study

    virtual = session.Virtual(mistakes=tuple(arguments.mistake), speed=arguments.speed, truth=arguments.truth)
    study = load_study(arguments.study)
    options = {"virtual": virtual, "start_delay_s": arguments.start_delay, "operate": arguments.operate}
    say = partial(print, file=sys.stderr if arguments.json else sys.stdout, flush=True)
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with session.emulate(study, arguments.participant, visit=arguments.visit, **options) as table:
            if arguments.page:
                table.follow(arguments.page)
            if arguments.operator_page:
                table.follow_operator(arguments.operator_page)
            if arguments.json:
                print_json({"participant": arguments.participant, "addresses": table.served.addresses})
                sys.stdout.flush()
            else:
                say("\n".join([f"# {arguments.participant}", *table.served.lines, "# help for faults, Ctrl-C to end"]))
            try:
                for line in sys.stdin:
                    if line.split()[:1] == ["quit"]:
                        break
                    if line.strip():
                        say(table.obey(line))
                else:
                    threading.Event().wait()  # nobody types: serve on
            except KeyboardInterrupt:
                pass
            say("\nend of the emulation")
    finally:
        signal.signal(signal.SIGTERM, before)
    return 0
