"""``emg2vsa check``: is this participant's session good, now?"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, answer, print_json
from casr.terminal import note
from emg2vsa.cli.arguments import COUNT, JOBS, STUDY, WORK, jobs_of, study_of

if TYPE_CHECKING:
    from emg2vsa.study import Study

SUMMARY = "Check the study file, then judge each participant's session: good, usable, repeat or unreadable."
EPILOG = """
Good: every press is as it should be. Usable: you can go on, but read the remarks. Repeat: a recording has fewer than
80 % usable presses. Unreadable: a recording cannot be used until its file or the study file is corrected. Exit
status 0: all good or usable; 1: some repeat or unreadable; 2: the study file has problems.
"""
OPTIONS = f"""
{STUDY}
participants [PARTICIPANT...]  sessions to judge (default: all)
--watch FOLDER  judge each recording when it appears in FOLDER, until you press Ctrl-C
{WORK}{JOBS}{JSON}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "check", run, SUMMARY, EPILOG, OPTIONS, COUNT)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.campaign import rig_of
    from emg2vsa.pipeline.judged_sessions import as_json, is_bad, judge, told
    from emg2vsa.pipeline.places import writable_or_temporary

    chosen, whole, below = _studies(arguments)
    if (source := whole.runs_source) and source.rig and source.rig.is_file():
        rig_of(whole, source.rig)
    with writable_or_temporary(chosen, below, now=True) as (study, below):
        if arguments.watch is not None:
            return _watch(arguments, study, whole, below)
        verdicts = judge(study, whole, jobs_of(arguments), progress(quiet=arguments.json), below)
    answer(arguments.json, {each.participant: as_json(each) for each in verdicts}, told(verdicts, sys.stdout))
    return int(any(is_bad(each.verdict) for each in verdicts))


def _studies(arguments: argparse.Namespace) -> tuple[Study, Study, Path | None]:
    from emg2vsa.pipeline.judged_sessions import of_participants

    whole, below = study_of(arguments)
    return of_participants(whole, arguments.participants), whole, below


def _watch(arguments: argparse.Namespace, study: Study, whole: Study, below: Path | None) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.judged_sessions import Awaited, as_json, counted, is_bad, told

    def say(text: str) -> None:
        print(f"emg2vsa: {text}", file=sys.stderr)

    awaited = Awaited(study, whole, arguments.watch, lambda: _studies(arguments)[:2], below, say)
    awaited.warm_up()
    verdicts: dict[str, str] = {}
    note(f"Watching {awaited.folder}; Ctrl-C ends.")
    try:
        for key, verdict in awaited.verdicts(progress(quiet=True)):
            verdicts[key] = verdict.verdict
            if arguments.json:
                print_json({key: as_json(verdict)})
            else:
                bell = "\a" if sys.stdout.isatty() and is_bad(verdict.verdict) else ""
                print(bell + "\n".join(told([verdict], sys.stdout)), flush=True)
    except KeyboardInterrupt:
        print(f"\n{counted(Counter(verdicts.values()))}", file=sys.stderr)
    return int(any(map(is_bad, verdicts.values())))
