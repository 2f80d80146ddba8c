"""``emg2vsa run`` and ``status``: recordings in, report out, only what is stale; or what that is and why."""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, add_options, answer, wanted
from emg2vsa.cli.arguments import COUNT, ON_STUDY, STUDY, WORK, jobs_of, say_not_used, study_of
from emg2vsa.pipeline.stage_order import ORDER

if TYPE_CHECKING:
    from emg2vsa.pipeline.cluster import ClusterWorkers
    from emg2vsa.pipeline.plan import StepPlan
    from emg2vsa.study import Study


RUN_SUMMARY = "Run a study from its recordings to fits, tests, schedules and the report."
RUN = """
Only stale steps run. A stopped run continues where it was. A recording that cannot be used is named and left out. Exit
status 0: all steps of the whole study are done; 1: one of them failed; 2: the study file has problems, or the cluster
was lost.
"""
PARTS = f"""
--only STAGE  stop after: {", ".join(ORDER)}
--human-only  only the recordings of people, without the runs of the rig; the report goes to its subfolder people
--casr-only  only the runs of the rig, with the schedules that they need; the report goes to its subfolder rig
--paths  the whole study, and how far each verdict hangs on choices of analysis: a minute more for 14 people and a rig.
  The report shows them until something that they depend on changes
"""
RUN_OPTIONS = f"""
--explain  say why each step runs
--profile  say for each stage which steps ran, which were skipped and why, what they took, and what was read, decoded
  and fitted
{ON_STUDY}
"""
_TIMEOUT_S = 60.0
_ADDRESS = re.compile(r"((tcp|tls|ws|wss)://)?([\w.-]+|\[[\da-fA-F:]+\]):\d{1,5}")
_ONE_OF = """
--scheduler ADDRESS  let the workers of this Dask scheduler carry out the steps of recordings and runs, for example
  tcp://10.0.0.1:8786
--cluster LOCAL  the same with N Dask workers that are started on this computer (default: --jobs, else all cores)
"""
_TIMEOUT = f"""
--timeout S  longest time to wait for the scheduler, and for a worker where there is none (default {_TIMEOUT_S:g} s)
"""
STATUSES = ("fresh", "stale", "waits", "failed", "blocked")
STATUS_SUMMARY = "Show which steps of a study are fresh, stale, waiting, failed or blocked. Nothing is computed."
STATUS = """
Fresh: the result exists. Stale: emg2vsa run will run the step. Waits: an earlier step is stale, and this step runs only
if the earlier one gives a new result. Failed: the input of the step must change first. Blocked: an earlier step failed.
The exit status is 0 in each case.
"""
STATUS_OPTIONS = f"""
{STUDY}
--explain  list every step that is not fresh, with its reasons
{WORK}{JSON}
"""


def add_to(commands: Commands) -> None:
    parser = add_command(commands, "run", run, RUN_SUMMARY, RUN, STUDY)
    add_options(parser.add_mutually_exclusive_group(), PARTS, only={"choices": ORDER})
    add_options(parser, RUN_OPTIONS, COUNT)
    _add_machines(parser)
    add_command(commands, "status", status, STATUS_SUMMARY, STATUS, STATUS_OPTIONS)


def run(arguments: argparse.Namespace) -> int:
    """Bring a study up to date. SettingError : stages that the study has not, or options that do not go together."""
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline import run_words
    from emg2vsa.pipeline.profile import Profile
    from emg2vsa.pipeline.run_study import run_study

    start = time.monotonic()
    profile = Profile() if arguments.profile else None
    study, below = study_of(arguments)
    stages, shown = _stages(arguments, study), progress(arguments.explain, arguments.json)
    if study.registration:
        from emg2vsa.registration import read_registration

        read_registration(study.registration, study.name)  # before anything runs
    with run_words.ended_by_scheduler():
        plan = run_study(
            study, stages=stages, jobs=jobs_of(arguments), progress=shown, wait=not arguments.no_wait, below=below,
            cluster=_cluster_of(arguments, study, stages, shown.say), profile=profile,
            asked=("paths",) if arguments.paths or arguments.only == "paths" else (),
        )  # fmt: skip
    if not arguments.json:
        say_not_used(plan)
    told, lines = run_words.outcome(plan, time.monotonic() - start)
    if registered := plan.campaign.registered:
        told, lines = told | {"registration": registered.as_json()}, [*lines, *registered.lines()]
    if profile:
        told, lines = told | {"profile": profile.as_json()}, [*lines, *profile.lines()]
    answer(arguments.json, told, lines)
    return int(any(item == "study" for item, _, _ in plan.failures()))


def _stages(arguments: argparse.Namespace, study: Study) -> tuple[str, ...]:
    from emg2vsa.errors import SettingError
    from emg2vsa.pipeline.stage_order import stages_for, stages_of

    if arguments.human_only and not study.recordings:
        do = "Leave --human-only out, or add [participants], [recordings] and [channels]."
        raise SettingError(study.path, wanted="recordings of people", found="a study of runs only", do=do)
    if arguments.casr_only and study.runs_source is None:
        do = "Leave --casr-only out, or add [runs]."
        raise SettingError(study.path, wanted="runs of a rig", found="a study of people only", do=do)
    if arguments.human_only or arguments.casr_only:
        return stages_of("people" if arguments.human_only else "rig", study)
    return stages_for(arguments.only)


def _add_machines(parser: argparse.ArgumentParser) -> None:
    """A scheduler, or a cluster of this computer."""
    group = parser.add_argument_group("more than one machine (docs/how-to/many-machines.md)")
    types = {
        "ADDRESS": wanted("an address such as tcp://10.0.0.1:8786", lambda text: _ADDRESS.fullmatch(text) and text),
        "LOCAL": wanted("local or local:N with N from 1", _local),
        "S": wanted("a number of seconds above 0", lambda text: s if 0 < (s := float(text)) < 1e6 else None),
    }
    add_options(group.add_mutually_exclusive_group(), _ONE_OF, types, cluster={"metavar": "local[:N]"})
    add_options(group, _TIMEOUT, types)


def _cluster_of(
    arguments: argparse.Namespace, study: Study, stages: Sequence[str], say: Callable[[str], None]
) -> ClusterWorkers | None:
    """The cluster that was asked for; None for processes of this computer. SettingError : options that do not go
    together."""
    from emg2vsa.errors import SettingError

    if arguments.jobs and arguments.scheduler:
        do = "Leave --jobs out."
        raise SettingError("emg2vsa run --scheduler", wanted="workers of the scheduler alone", found="--jobs", do=do)
    if arguments.scheduler is None and arguments.cluster is None:
        if arguments.timeout is not None:
            do = "Leave --timeout out."
            raise SettingError("emg2vsa run --timeout", wanted="--scheduler or --cluster", found="neither", do=do)
        return None
    from emg2vsa.pipeline.cluster import ClusterWorkers

    local = 0 if arguments.cluster is None else arguments.cluster or jobs_of(arguments)
    timeout_s = _TIMEOUT_S if arguments.timeout is None else arguments.timeout
    return ClusterWorkers(study, stages, address=arguments.scheduler or "", local=local, timeout_s=timeout_s, say=say)


def _local(text: str) -> int | None:
    """Number of workers; 0 where none is given."""
    found = re.fullmatch(r"local(:[1-9]\d{0,3})?", text)
    return int((found[1] or ":0")[1:]) if found else None


def status(arguments: argparse.Namespace) -> int:
    from emg2vsa.pipeline.plan import survey
    from emg2vsa.pipeline.stage_order import ORDER

    study, below = study_of(arguments)
    plan = survey(study, ORDER, lambda text: print(text, file=sys.stderr), below=below)
    steps = plan.steps.values()
    told: dict[str, object] = {
        s.id: {"status": s.status, "reasons": list(s.reasons), "message": s.message} for s in steps
    }
    told |= {"registration": registered.as_json()} if (registered := plan.campaign.registered) else {}
    kernels = plan.other_kernels()
    told |= {"made with other kernels of BLAS": kernels} if kernels else {}
    answer(arguments.json, told, _lines(plan, arguments.explain, kernels))
    return 0


def _lines(plan: StepPlan, explain: bool, kernels: Mapping[str, int]) -> Iterator[str]:
    from casr.blas_kernel import blas_kernel
    from emg2vsa.cli.progress import shortened
    from emg2vsa.pipeline.lock import holder
    from emg2vsa.pipeline.stage_order import ORDER

    counts = Counter((step.stage, step.status) for step in plan.steps.values())
    yield f"{'stage':<15}" + "".join(f"{status:>9}" for status in STATUSES)
    for stage in ORDER:
        yield f"{stage:<15}" + "".join(f"{counts[stage, status]:>9}" for status in STATUSES)
    if held := holder(plan.study.results):
        yield f"A run is under way: {held}."
    if registered := plan.campaign.registered:
        yield from registered.lines()
    for kernel, count in kernels.items():
        yield (
            f"Fresh, but made with the BLAS kernel {kernel}: {count}. This computer has {blas_kernel()}: "
            "if made here, they may differ in the last digits."
        )
    late = [step for step in plan.steps.values() if step.status != "fresh"]
    if explain:
        yield from (f"{step.status}: {step.id}: {shortened(step.reasons, 6) or step.message}" for step in late)
    elif late:
        yield "Reasons: emg2vsa status --explain"
