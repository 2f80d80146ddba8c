"""Run what is stale, stage by stage; keep going when something fails; leave what is fresh alone. Remove what is old."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from casr.one_thread import one_thread
from emg2vsa.pipeline.lock import study_lock
from emg2vsa.pipeline.places import check_places, locked_places
from emg2vsa.pipeline.plan import Step, StepPlan, open_step_plan, survey
from emg2vsa.pipeline.profile import Profile
from emg2vsa.pipeline.stage_order import ORDER, PART_REPORTS, module_of, stage
from emg2vsa.pipeline.store import Store
from emg2vsa.pipeline.tasks import Ended, Task, Workers
from emg2vsa.study import Study

if TYPE_CHECKING:
    from emg2vsa.pipeline.cluster import ClusterWorkers

_TRIES = 3
"""So often a study is gone through: a result that turns out damaged is made again by itself."""


@dataclass(frozen=True)
class Progress:
    """What a screen may show while a study runs; every function may do nothing."""

    begin: Callable[[str, int], None]
    """A stage and the number of its steps that will run."""
    step: Callable[[Step], None]
    """A step ended."""
    end: Callable[[], None]
    """The stage ended."""
    say: Callable[[str], None]
    """Something to be read, such as who holds the study."""


def run_study(
    study: Study,
    *,
    stages: Sequence[str],
    jobs: int,
    progress: Progress,
    wait: bool = True,
    below: Path | None = None,
    cluster: ClusterWorkers | None = None,
    profile: Profile | None = None,
    asked: Collection[str] = (),
) -> StepPlan:
    """Bring the ``stages`` of a study up to date and say how every step ended.

    wait : for another run of the same study to end. below : results of the same study elsewhere, read and not written.
    cluster : workers that take the place of ``jobs`` processes. profile : is told what every step took. asked : stages
    on request that are to run; others of that kind never do.

    Raises
    ------
    StudyError, DataError : its rig file, or its table of measured runs, has problems, a folder cannot be written to, or
    another process holds the study (only without ``wait``); nothing was run.
    """
    check_places(study, stages)
    one_thread()  # workers inherit it
    with ExitStack() as held:
        for folder in locked_places(study, stages):
            held.enter_context(study_lock(folder, wait=wait, say=progress.say))
        Store(study.results).sweep()
        workers: Workers | ClusterWorkers = Workers(jobs) if cluster is None else cluster
        held.enter_context(workers)
        plan = open_step_plan(study, stages, progress.say, below=below, asked=asked)
        plan.ledger.compact()
        ran: set[str] = set()
        for last in range(_TRIES - 1, -1, -1):
            plan.steps.clear()
            try:
                again = [_run_stage(plan, stages[i:], workers, progress, ran, profile) for i in range(len(stages))]
            finally:
                plan.prints.save()
            if not any(again) or not last:
                break
        for step in ran:  # a later round finds fresh what an earlier one made
            plan.steps[step].status = "done" if plan.steps[step].status == "fresh" else plan.steps[step].status
            for removed in plan.store.keep_only(step, plan.ledger.keys(step)):
                plan.prints.forget(removed)  # its memory would grow with every run
        plan.prints.save()
        plan.ledger.compact()
        if profile is not None:
            profile.end(plan)
    return plan


def _run_stage(
    plan: StepPlan,
    stages: Sequence[str],
    workers: Workers | ClusterWorkers,
    progress: Progress,
    ran: set[str],
    profile: Profile | None,
) -> bool:
    """Run the stale steps of the first of ``stages``; whether a file it needs turned out unusable, so that all is
    looked up again. Workers are started for the stages after it as well."""
    name = stages[0]
    steps = plan.add_stage(name)
    stale = {step.id: step for step in steps if step.status == "stale" and step.key}
    if not stale:
        return False
    progress.begin(name, len(stale))
    again = False

    def on_end(ended: Ended) -> None:
        nonlocal again
        step = stale[ended.step]
        if ended.damaged:
            plan.prints.forget(ended.damaged)
            step.status, step.message, again = "failed", ended.message, True
        elif plan.end(step, ended.status, ended.message, final=ended.final, loaded=ended.loaded):
            again = True
        elif step.status == "done":
            ran.add(step.id)
        if profile is not None and ended.spent is not None:
            profile.add(step, ended.spent)
        progress.step(step)

    tasks = [_task(plan, step, profile is not None) for step in stale.values()]
    workers.run(tasks, on_end, alone=stage(name).alone, load=_loads(stages))
    progress.end()
    return again


def _loads(stages: Sequence[str]) -> list[str]:
    return [module for name in stages for module in (module_of(name), *stage(name).loads)]


def _task(plan: StepPlan, step: Step, profiled: bool) -> Task:
    store = plan.store
    store.claim(step.id).unlink(missing_ok=True)  # left by a killed process: nobody else may be at this step
    return Task(step.id, plan.given(step), store.unfinished(step.id, step.key), store.claim(step.id), profiled)


def clean(study: Study, *, wait: bool, say: Callable[[str], None]) -> tuple[int, int]:
    """Remove stored results that no key of the study as it is now needs; their number and size in bytes.

    The result of a step whose key is not known yet, as an input is stale, is kept. Recordings, runs and reports are
    never touched. Raises as ``survey`` and ``study_lock``.
    """
    with study_lock(study.results, wait=wait, say=say):
        plan = survey(study, (*ORDER, *PART_REPORTS), say, asked=ORDER)
        plan.store.sweep()
        removed = size = 0
        for step_id in list(plan.store.stored_steps()):
            step = plan.steps.get(step_id)
            kept = [] if step is None else [step.key] if step.key else plan.ledger.keys(step_id)[:1]
            for path in plan.store.results(step_id):
                if path.stem not in kept:
                    size += path.stat().st_size
                    path.unlink()
                    removed += 1
        for step_id in set(plan.ledger.steps()) - set(plan.steps):
            plan.ledger.drop(step_id)
        plan.store.drop_empty_folders()
        plan.ledger.compact(force=True)
    return removed, size
