"""``emg2vsa status``: what is fresh, what is stale and why, without computing anything."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, answer
from emg2vsa.cli.arguments import STUDY, WORK, study_of

if TYPE_CHECKING:
    from emg2vsa.pipeline.plan import StepPlan

STATUSES = ("fresh", "stale", "waits", "failed", "blocked")
SUMMARY = "Show which steps of a study are fresh, stale, waiting, failed or blocked. Nothing is computed."
EPILOG = """
Fresh: the result exists. Stale: emg2vsa run will run the step. Waits: an earlier step is stale, and this step runs only
if the earlier one gives a new result. Failed: the input of the step must change first. Blocked: an earlier step failed.
The exit status is 0 in each case.
"""
OPTIONS = f"""
{STUDY}
--explain  list every step that is not fresh, with its reasons
{WORK}{JSON}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "status", run, SUMMARY, EPILOG, OPTIONS)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.pipeline.plan import survey
    from emg2vsa.pipeline.stage_order import ORDER

    study, below = study_of(arguments)
    plan = survey(study, ORDER, lambda text: print(text, file=sys.stderr), below=below)
    steps = plan.steps.values()
    told = {s.id: {"status": s.status, "reasons": list(s.reasons), "message": s.message} for s in steps}
    answer(arguments.json, told, _lines(plan, arguments.explain))
    return 0


def _lines(plan: StepPlan, explain: bool) -> Iterator[str]:
    from emg2vsa.cli.progress import shortened
    from emg2vsa.pipeline.lock import holder
    from emg2vsa.pipeline.stage_order import ORDER

    counts = Counter((step.stage, step.status) for step in plan.steps.values())
    yield f"{'stage':<15}" + "".join(f"{status:>9}" for status in STATUSES)
    for stage in ORDER:
        yield f"{stage:<15}" + "".join(f"{counts[stage, status]:>9}" for status in STATUSES)
    if held := holder(plan.study.results):
        yield f"A run is under way: {held}."
    late = [step for step in plan.steps.values() if step.status != "fresh"]
    if explain:
        yield from (f"{step.status}: {step.id}: {shortened(step.reasons, 6) or step.message}" for step in late)
    elif late:
        yield "Reasons: emg2vsa status --explain"
