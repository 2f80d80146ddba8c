"""``emg2vsa check``: is this participant's session good, now?"""

from __future__ import annotations

import argparse
import dataclasses
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_jobs, add_study, add_work, jobs_of, study_of

if TYPE_CHECKING:
    from emg2vsa.pipeline.plan import Board
    from emg2vsa.session_verdict import SessionVerdict
    from emg2vsa.study import Study


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "check",
        run,
        "Check the study file, then judge each participant's session: good, usable, repeat or unreadable.",
        "Good: every press as wanted. Usable: go on, and read the remarks. Repeat: a recording has fewer than 80 % "
        "usable presses. Unreadable: a recording cannot be used before its file or the study file is mended. Exit "
        "status 0: all good or usable; 1: some repeat or unreadable; 2: the study file has problems.",
    )
    add_study(parser)
    parser.add_argument("participants", nargs="*", metavar="PARTICIPANT", help="sessions to judge (default: all)")
    add_work(parser)
    add_jobs(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.places import writable_or_temporary
    from emg2vsa.pipeline.run import run_study

    whole, below = study_of(arguments)
    with writable_or_temporary(_only(whole, arguments.participants), below, now=True) as (study, below):
        board = run_study(
            study,
            stages=("trials",),
            jobs=jobs_of(arguments),
            progress=progress(quiet=arguments.json),
            below=below,
        )
        failures = {item: message for item, _, message in board.failures()}
        verdicts = [_judge(board, participant, failures) for participant in board.campaign.cells]
    if arguments.json:
        print_json({verdict.participant: dataclasses.asdict(verdict) for verdict in verdicts})
    else:
        for verdict in verdicts:
            _print(verdict)
    return int(any(verdict.verdict in ("repeat", "unreadable") for verdict in verdicts))


def _only(study: Study, participants: list[str]) -> Study:
    """The study with the recordings of these participants."""
    from emg2vsa.errors import SettingError

    unknown = [name for name in participants if name not in study.participants]
    if unknown:
        raise SettingError(
            study.path, wanted=f"participants of the study ({', '.join(study.participants)})",
            found=", ".join(unknown), do="Check the spelling.",
        )  # fmt: skip
    chosen = participants or study.participants
    return dataclasses.replace(study, recordings=tuple(e for e in study.recordings if e.participant in chosen))


def _judge(board: Board, participant: str, failures: dict[str, str]) -> SessionVerdict:
    from emg2vsa import artifacts
    from emg2vsa.session_verdict import judge_session

    cells = board.campaign.cells[participant]
    entries = [board.campaign.recordings[cell] for cell in cells]
    return judge_session(
        participant,
        [artifacts.load(path) for path in board.done("trials", cells)],
        {entry.specimen: entry.window.expected_trials for entry in entries},
        {entry.specimen: failures[entry.key] for entry in entries if entry.key in failures},
    )


def _print(verdict: SessionVerdict) -> None:
    print(f"{verdict.participant}: {verdict.verdict.upper()}")
    for s in verdict.specimens:
        wanted = f" of {s.wanted}" if s.wanted is not None else ""
        presses = "press" if (s.wanted or s.found) == 1 else "presses"
        print(f"  {s.specimen:<10} {s.found:>3}{wanted} {presses}: {s.ok} ok, {s.warned} warned, {s.rejected} rejected")
    for advice in verdict.advice:
        print(f"  - {advice}")
