"""``emg2vsa status``: what is fresh, what is stale and why, without computing anything."""

from __future__ import annotations

import argparse
from collections import Counter

from emg2vsa.cli.arguments import Commands, add_command, add_json, add_study, print_json


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "status",
        run,
        "Say which steps of a study are fresh, stale, failed or blocked; nothing is computed.",
        "Fresh: its result is there. Stale: emg2vsa run would do it. Failed: its input must change first. Blocked: the "
        "step before it failed. The exit status is 0 in each case.",
    )
    add_study(parser)
    parser.add_argument("--explain", action="store_true", help="list every step that is not fresh, with its reasons")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import shortened
    from emg2vsa.pipeline.plan import survey
    from emg2vsa.pipeline.steps import stages_for
    from emg2vsa.study_file import load_study

    stages = stages_for(None)
    board = survey(load_study(arguments.study), stages)
    states = board.states.values()
    if arguments.json:
        print_json({s.step.id: {"status": s.status, "reasons": list(s.reasons), "message": s.message} for s in states})
        return 0
    print(f"{'stage':<15}{'fresh':>7}{'stale':>7}{'failed':>8}{'blocked':>9}")
    for stage in stages:
        count = Counter(state.status for state in states if state.step.stage == stage)
        print(f"{stage:<15}{count['fresh']:>7}{count['stale']:>7}{count['failed']:>8}{count['blocked']:>9}")
    if arguments.explain:
        for state in states:
            if state.status != "fresh":
                print(f"{state.status}: {state.step.id}: {shortened(state.reasons, 6) or state.message}")
    elif any(state.status != "fresh" for state in states):
        print("Reasons: emg2vsa status --explain")
    return 0
