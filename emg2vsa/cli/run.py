"""``emg2vsa run``: recordings in, report out; only what is stale."""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_jobs, add_study, add_wait, add_work, jobs_of, say_not_used, study_of
from emg2vsa.cli.machines import (
    add_machines,
    cluster_of,
    ended_by_scheduler,
    left_of,
    missing_for,
    rest_in_words,
    to_try_again,
)
from emg2vsa.pipeline.stage_order import ORDER

if TYPE_CHECKING:
    from emg2vsa.pipeline.plan import StepPlan
    from emg2vsa.study import Study


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "run",
        run,
        "Run a study from its recordings to fits, tests, schedules and the report.",
        "Only stale steps run. A stopped run continues where it was. A recording that cannot be used is named and "
        "left out. Exit status 0: all steps of the whole study are done; 1: one of them failed; 2: the "
        "study file has problems, or the cluster was lost. With --shard, 0: all its steps that could run did; 1: one "
        "failed for another reason than its input.",
    )
    add_study(parser)
    part = parser.add_mutually_exclusive_group()
    part.add_argument("--only", choices=ORDER, metavar="STAGE", help=f"stop after: {', '.join(ORDER)}")
    part.add_argument(
        "--human-only",
        action="store_true",
        help="only the recordings of people, without the runs of the rig; the report goes to its subfolder people",
    )
    part.add_argument(
        "--casr-only",
        action="store_true",
        help="only the runs of the rig, with the schedules that they need; the report goes to its subfolder rig",
    )
    parser.add_argument("--explain", action="store_true", help="say why each step runs")
    parser.add_argument(
        "--profile",
        action="store_true",
        help="say for each stage which steps ran, which were skipped and why, what they took, and what was read, "
        "decoded and fitted",
    )
    add_work(parser)
    add_wait(parser)
    add_jobs(parser)
    add_machines(parser)
    add_json(parser)


def _stages(arguments: argparse.Namespace, study: Study) -> tuple[str, ...]:
    from emg2vsa.pipeline.shard import shared_stages
    from emg2vsa.pipeline.stage_order import stages_for, stages_of

    if arguments.human_only:
        stages = stages_of("people", study)
    else:
        stages = stages_of("rig", study) if arguments.casr_only else stages_for(arguments.only)
    return shared_stages(stages) if arguments.shard else stages


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.profile import Profile
    from emg2vsa.pipeline.run_study import run_study

    start = time.monotonic()
    profile = Profile() if arguments.profile else None
    study, below = study_of(arguments)
    _check_people(arguments, study)
    stages, shown = _stages(arguments, study), progress(arguments.explain, arguments.json)
    with ended_by_scheduler():
        plan = run_study(
            study,
            stages=stages,
            jobs=jobs_of(arguments),
            progress=shown,
            wait=not arguments.no_wait,
            below=below,
            cluster=cluster_of(arguments, study, stages, shown.say),
            shard=arguments.shard,
            profile=profile,
        )
    failures = plan.failures()
    study_failed = any(item == "study" for item, _, _ in failures)
    ran = [step.id for step in plan.steps.values() if step.status == "done"]
    notes, rejected = _notes(plan), _rejected(plan)
    fresh = sum(step.status == "fresh" for step in plan.steps.values())
    if arguments.json:
        told = {
            "study": study.name,
            "ran": ran,
            "fresh": fresh,
            "failures": [dict(zip(("item", "stage", "message"), failure, strict=True)) for failure in failures],
            "notes": notes,
            "rejected_presses": rejected,
            "seconds": round(time.monotonic() - start, 3),
        }
        told |= {"profile": profile.as_json()} if profile else {}
        print_json(told | (_of_shard(plan) if arguments.shard else {"report": str(_page(plan))}))
    else:
        say_not_used(plan)
        for note in notes:
            print(f"note: {note}")
        for of in rejected:
            print(f"{of['run']}: {of['message']}")
        seconds, steps = time.monotonic() - start, "step" if len(ran) == 1 else "steps"
        share = f", shard {arguments.shard.number} of {arguments.shard.of}" if arguments.shard else ""
        print(
            f"{study.name}{share}: {len(ran)} {steps} run, {fresh} fresh, {len(failures)} refused or failed, "
            f"{seconds:.1f} s"
        )
        lines = [rest_in_words(plan)] if arguments.shard else [*_report_lines(plan)]
        for line in (*lines, *(profile.lines() if profile else ())):
            print(line)
    return int(to_try_again(plan) if arguments.shard else study_failed)


def _of_shard(plan: StepPlan) -> dict[str, list[str]]:
    """What a shard left, for programs."""
    left = left_of(plan)
    return {"left": [step.id for step in left], "needs": missing_for(plan, left)}


def _page(plan: StepPlan) -> Path:
    """The page of the report that the run made, or would make."""
    from emg2vsa.pipeline.stage_order import REPORTS

    name = next((step.stage for step in plan.steps.values() if step.stage in REPORTS), "report")
    return plan.folder(name, "study") / "index.html"


def _report_lines(plan: StepPlan) -> Iterator[str]:
    """Where the report is, and what is missing from it."""
    from emg2vsa.pipeline.stage_order import REPORTS, stage

    if not any(step.stage in REPORTS for step in plan.steps.values()):
        return
    page = _page(plan)
    why = {name: message for item, name, message in plan.failures() if item == "study"}
    if found := why.keys() & set(REPORTS):
        before = " The report in this place is from an earlier run." if page.exists() else ""
        yield f"Report: not written to {page}.{before} {why[found.pop()]}"
        return
    yield f"Report: {page}"
    for name, message in why.items():
        yield f"  {stage(name).gives} missing from it: {message}"


def _check_people(arguments: argparse.Namespace, study: Study) -> None:
    from emg2vsa.errors import SettingError

    if arguments.human_only and not study.recordings:
        do = "Leave --human-only out, or add [participants], [recordings] and [channels]."
        raise SettingError(study.path, wanted="recordings of people", found="a study of runs only", do=do)


def _notes(plan: StepPlan) -> list[str]:
    """What the steps and the folders of runs have to say; the same words of several recordings once."""
    said = [step for step in plan.steps.values() if step.message and step.status in {"done", "fresh"}]
    of_study = [step.message for step in said if step.item == "study"]
    counts = Counter(step.message for step in said if step.item != "study" and step.stage != "runs")
    of_recordings = [f"{note} ({count} recording{'s' if count != 1 else ''})" for note, count in counts.items()]
    return [*plan.campaign.notes, *of_recordings, *of_study]


def _rejected(plan: StepPlan) -> list[dict[str, str]]:
    """Runs with presses that could not be scored: how many, and why most of them."""
    return [
        {"run": step.item, "message": step.message}
        for step in plan.steps.values()
        if step.stage == "runs" and step.message and step.status in {"done", "fresh"}
    ]
