"""``emg2vsa status``: what is fresh, what is stale and why, without computing anything."""

from __future__ import annotations

import argparse
import sys
from collections import Counter

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_study, add_work, study_of

STATUSES = ("fresh", "stale", "waits", "failed", "blocked")


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "status",
        run,
        "Show which steps of a study are fresh, stale, waiting, failed or blocked. Nothing is computed.",
        "Fresh: the result exists. Stale: emg2vsa run will run the step. Waits: an earlier step is stale, and this "
        "step runs only if the earlier one gives a new result. Failed: the input of the step must change "
        "first. Blocked: an earlier step failed. The exit status is 0 in each case.",
    )
    add_study(parser)
    parser.add_argument("--explain", action="store_true", help="list every step that is not fresh, with its reasons")
    add_work(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import shortened
    from emg2vsa.pipeline.lock import holder
    from emg2vsa.pipeline.plan import survey
    from emg2vsa.pipeline.stage_order import ORDER

    study, below = study_of(arguments)
    plan = survey(study, ORDER, lambda text: print(text, file=sys.stderr), below=below)
    steps = plan.steps.values()
    held = holder(study.results)
    if arguments.json:
        told = {s.id: {"status": s.status, "reasons": list(s.reasons), "message": s.message} for s in steps}
        print_json(told)
        return 0
    counts = Counter((step.stage, step.status) for step in steps)
    print(f"{'stage':<15}" + "".join(f"{status:>9}" for status in STATUSES))
    for stage in ORDER:
        print(f"{stage:<15}" + "".join(f"{counts[stage, status]:>9}" for status in STATUSES))
    if held:
        print(f"A run is under way: {held}.")
    if arguments.explain:
        for step in steps:
            if step.status != "fresh":
                print(f"{step.status}: {step.id}: {shortened(step.reasons, 6) or step.message}")
    elif any(step.status != "fresh" for step in steps):
        print("Reasons: emg2vsa status --explain")
    return 0
