"""Removing what no step needs any more: results of other keys, of steps that are gone, and of version 0.1.0."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from emg2vsa.errors import DataError
from emg2vsa.pipeline.campaign import left_virtual_runs
from emg2vsa.pipeline.lock import study_lock
from emg2vsa.pipeline.plan import survey
from emg2vsa.pipeline.stage_order import ORDER, PART_REPORTS
from emg2vsa.study import Study

MOVED = "runs-virtual-0.1.0"


def clean(study: Study, *, wait: bool, say: Callable[[str], None]) -> tuple[int, int]:
    """Remove stored results that no key of the study as it is now needs; their number and size in bytes.

    The result of a step whose key is not known yet, as an input is stale, is kept. Recordings, runs and reports are
    never touched. Raises as ``survey`` and ``study_lock``.
    """
    with study_lock(study.results, wait=wait, say=say):
        plan = survey(study, (*ORDER, *PART_REPORTS), say)
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


def move_virtual_runs(study: Study) -> Path | None:
    """Move them to a folder of their own; that folder, None where there is nothing to move.

    DataError : a run of that name is there already.
    """
    found, target = left_virtual_runs(study), study.path.parent / MOVED
    for folder in found:
        if (target / folder.name).exists():
            do = "Move or delete one of the two folders."
            raise DataError(
                target / folder.name, wanted="a name that no run has yet", found="a run of this name", do=do
            )
    for folder in found:
        target.mkdir(exist_ok=True)
        folder.rename(target / folder.name)
    return target if found else None
