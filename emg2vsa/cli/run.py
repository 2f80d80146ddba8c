"""``emg2vsa run``: recordings in, report out; only what is stale."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_options, answer
from emg2vsa.cli.arguments import COUNT, ON_STUDY, STUDY, jobs_of, say_not_used, study_of
from emg2vsa.cli.machines import add_machines, cluster_of
from emg2vsa.pipeline.stage_order import ORDER

if TYPE_CHECKING:
    from emg2vsa.study import Study

SUMMARY = "Run a study from its recordings to fits, tests, schedules and the report."
EPILOG = """
Only stale steps run. A stopped run continues where it was. A recording that cannot be used is named and left out. Exit
status 0: all steps of the whole study are done; 1: one of them failed; 2: the study file has problems, or the cluster
was lost. With --shard, 0: all its steps that could run did; 1: one failed for another reason than its input.
"""
PARTS = f"""
--only STAGE  stop after: {", ".join(ORDER)}
--human-only  only the recordings of people, without the runs of the rig; the report goes to its subfolder people
--casr-only  only the runs of the rig, with the schedules that they need; the report goes to its subfolder rig
"""
OPTIONS = f"""
--explain  say why each step runs
--profile  say for each stage which steps ran, which were skipped and why, what they took, and what was read, decoded
  and fitted
{ON_STUDY}
"""


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "run", run, SUMMARY, EPILOG, STUDY)
    add_options(parser.add_mutually_exclusive_group(), PARTS, only={"choices": ORDER})
    add_options(parser, OPTIONS, COUNT)
    add_machines(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline import run_words
    from emg2vsa.pipeline.profile import Profile
    from emg2vsa.pipeline.run_study import run_study

    start, shard = time.monotonic(), arguments.shard
    profile = Profile() if arguments.profile else None
    study, below = study_of(arguments)
    stages, shown = _stages(arguments, study), progress(arguments.explain, arguments.json)
    with run_words.ended_by_scheduler():
        plan = run_study(
            study, stages=stages, jobs=jobs_of(arguments), progress=shown, wait=not arguments.no_wait, below=below,
            cluster=cluster_of(arguments, study, stages, shown.say), shard=shard, profile=profile,
        )  # fmt: skip
    if not arguments.json:
        say_not_used(plan)
    told, lines = run_words.outcome(plan, shard, time.monotonic() - start)
    if profile:
        told, lines = told | {"profile": profile.as_json()}, [*lines, *profile.lines()]
    answer(arguments.json, told, lines)
    study_failed = any(item == "study" for item, _, _ in plan.failures())
    return int(run_words.to_try_again(plan) if shard else study_failed)


def _stages(arguments: argparse.Namespace, study: Study) -> tuple[str, ...]:
    from emg2vsa.errors import SettingError
    from emg2vsa.pipeline.shard import shared_stages
    from emg2vsa.pipeline.stage_order import stages_for, stages_of

    if arguments.human_only and not study.recordings:
        do = "Leave --human-only out, or add [participants], [recordings] and [channels]."
        raise SettingError(study.path, wanted="recordings of people", found="a study of runs only", do=do)
    if arguments.human_only or arguments.casr_only:
        stages = stages_of("people" if arguments.human_only else "rig", study)
    else:
        stages = stages_for(arguments.only)
    return shared_stages(stages) if arguments.shard else stages
