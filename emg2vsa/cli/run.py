"""``emg2vsa run``: recordings in, report out; only what is stale."""

from __future__ import annotations

import argparse
import time
from collections import Counter
from typing import TYPE_CHECKING

from emg2vsa.cli.arguments import (
    Commands,
    add_command,
    add_jobs,
    add_json,
    add_study,
    jobs_of,
    print_json,
    say_not_used,
)

if TYPE_CHECKING:
    from emg2vsa.pipeline.plan import Board
    from emg2vsa.study import Study

STAGE_NAMES = (
    "trials", "fits", "hypotheses", "profiles", "schedules", "runs", "discrimination", "calibration", "pages", "report",
)  # fmt: skip


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "run",
        run,
        "Run a study: recordings in, fits, tests, schedules and report out.",
        "Only stale steps run; a stopped run goes on where it was. A recording that cannot be used is named and left "
        "out. Exit status 0: the study's own steps are done; 1: one of them failed; 2: the study file has problems.",
    )
    add_study(parser)
    part = parser.add_mutually_exclusive_group()
    part.add_argument("--only", choices=STAGE_NAMES, metavar="STAGE", help=f"stop after: {', '.join(STAGE_NAMES)}")
    part.add_argument("--human-only", action="store_true", help="people only: no runs of the rig")
    part.add_argument("--casr-only", action="store_true", help="the rig's runs only, with the schedules they need")
    parser.add_argument("--explain", action="store_true", help="say for every step why it runs")
    add_jobs(parser)
    add_json(parser)


def _stages(arguments: argparse.Namespace) -> tuple[str, ...]:
    from emg2vsa.pipeline.steps import CASR_STAGES, HUMAN_STAGES, stages_for

    if arguments.human_only:
        return HUMAN_STAGES
    return CASR_STAGES if arguments.casr_only else stages_for(arguments.only)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.run import run_study
    from emg2vsa.study_file import load_study

    start = time.monotonic()
    study = load_study(arguments.study)
    _check_people(arguments, study)
    board = run_study(
        study, stages=_stages(arguments), jobs=jobs_of(arguments), progress=progress(arguments.explain, arguments.json)
    )
    failures = board.failures()
    study_failed = any(item == "study" for item, _, _ in failures)
    ran = [state.step.id for state in board.states.values() if state.status == "done"]
    notes, rejected = _notes(board), _rejected(board)
    fresh = sum(state.status == "fresh" for state in board.states.values())
    if arguments.json:
        print_json(
            {
                "study": study.name,
                "ran": ran,
                "fresh": fresh,
                "failures": [dict(zip(("item", "stage", "message"), failure, strict=True)) for failure in failures],
                "notes": notes,
                "rejected_presses": rejected,
                "report": str(study.reports / "index.html"),
                "seconds": round(time.monotonic() - start, 3),
            }
        )
    else:
        say_not_used(board)
        for note in notes:
            print(f"note: {note}")
        for of in rejected:
            print(f"{of['run']}: {of['message']}")
        seconds, steps = time.monotonic() - start, "step" if len(ran) == 1 else "steps"
        print(
            f"{study.name}: {len(ran)} {steps} run, {fresh} fresh, {len(failures)} refused or failed, {seconds:.1f} s"
        )
        if arguments.only in {None, "report"} and not study_failed:
            print(f"Report: {study.reports / 'index.html'}")
    return 1 if study_failed else 0


def _check_people(arguments: argparse.Namespace, study: Study) -> None:
    from emg2vsa.errors import SettingError

    if arguments.human_only and not study.recordings:
        do = "Leave --human-only out, or add [participants], [recordings] and [channels]."
        raise SettingError(study.path, wanted="recordings of people", found="runs alone", do=do)


def _notes(board: Board) -> list[str]:
    """What the steps and the folders of runs have to say; the same words of several recordings once."""
    said = [state for state in board.states.values() if state.message and state.status in {"done", "fresh"}]
    of_study = [state.message for state in said if state.step.item == "study"]
    counts = Counter(state.message for state in said if state.step.item != "study" and state.step.stage != "runs")
    of_recordings = [f"{note} ({count} recording{'s' if count != 1 else ''})" for note, count in counts.items()]
    return [*board.campaign.notes, *of_recordings, *of_study]


def _rejected(board: Board) -> list[dict[str, str]]:
    """Runs with presses that could not be scored: how many, and why most of them."""
    return [
        {"run": state.step.item, "message": state.message}
        for state in board.states.values()
        if state.step.stage == "runs" and state.message and state.status in {"done", "fresh"}
    ]
