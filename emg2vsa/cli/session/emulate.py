"""``emg2vsa session emulate``: an emulated participant behind the devices that a study's [session] names."""

from __future__ import annotations

import argparse
import signal
import sys
import threading
from functools import partial

from casr.command_line import JSON, Commands, add_command, print_json
from emg2vsa.cli.arguments import STUDY
from emg2vsa.cli.session import REQUIRED

OPTIONS = """\
--participant CODE  who is emulated: P03
--page URL  address of the participant's page, which is obeyed
--operator-page URL  address of the operator's page, whose specimen is put on the table
--operate  emulate the operator at that page too
--mistake WORDS...  planned at a press: dips@12, early@training-1, electrode-off:FDS@21-30; may be given again
--speed X = 1.0  times as fast as real time (default: 1)
--start-delay S = 1.8  Trigno: from START to first samples (default: 1.8)
--truth FILE  at the end, write what is true of every press
"""


def add_to(commands: Commands) -> None:
    from emg2vsa.worlds.people.mistakes import OF_HAND, OF_SENSOR

    kinds = "; ".join(f"{kind}: {words}" for kind, words in (OF_HAND | OF_SENSOR).items())
    add_command(
        commands,
        "emulate",
        run,
        "Emulate the devices of [session] and a participant at them, until Ctrl-C.",
        "Then run emg2vsa session STUDY in another shell, and type its two addresses here: page URL, and operator-page "
        f"URL. The truth of [simulation] is what the muscles do. Mistakes: {kinds}. Lines typed here put "
        "specimens on the table and faults on the devices; type help.",
        f"{STUDY}{OPTIONS}{JSON}",
        participant=REQUIRED,
    )


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa import session
    from emg2vsa.study_file import load_study

    virtual = session.Virtual(mistakes=tuple(arguments.mistake), speed=arguments.speed, truth=arguments.truth)
    study = load_study(arguments.study)
    options = {"virtual": virtual, "start_delay_s": arguments.start_delay, "operate": arguments.operate}
    say = partial(print, file=sys.stderr if arguments.json else sys.stdout, flush=True)
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with session.emulate(study, arguments.participant, **options) as table:
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
