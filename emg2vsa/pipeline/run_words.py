"""What a run of a study has to say at its end: of its steps, of its report, and of what a shard left to others."""

from __future__ import annotations

import signal
import threading
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from emg2vsa.pipeline.plan import DONE, Step, StepPlan
from emg2vsa.pipeline.shard import Shard
from emg2vsa.pipeline.stage_order import ORDER, REPORTS, stage


def outcome(plan: StepPlan, shard: Shard | None, seconds: float) -> tuple[dict[str, Any], list[str]]:
    """The end of a run, or of a shard of one: for programs, and in lines."""
    failures, said, not_scored = plan.failures(), notes(plan), rejected(plan)
    ran = [step.id for step in plan.steps.values() if step.status == "done"]
    fresh = sum(step.status == "fresh" for step in plan.steps.values())
    told = {
        "study": plan.study.name,
        "ran": ran,
        "fresh": fresh,
        "failures": [dict(zip(("item", "stage", "message"), failure, strict=True)) for failure in failures],
        "notes": said,
        "rejected_presses": not_scored,
        "seconds": round(seconds, 3),
    }
    left = left_of(plan)
    of_shard = {"left": [step.id for step in left], "needs": missing_for(plan, left)} if shard else {}
    part = f", shard {shard.number} of {shard.of}" if shard else ""
    lines = [
        *(f"note: {note}" for note in said),
        *(f"{of['run']}: {of['message']}" for of in not_scored),
        f"{plan.study.name}{part}: {len(ran)} step{'s' if len(ran) != 1 else ''} run, {fresh} fresh, {len(failures)} "
        f"refused or failed, {seconds:.1f} s",
        *([rest_in_words(plan)] if shard else report_lines(plan)),
    ]
    return told | (of_shard if shard else {"report": str(page_of(plan))}), lines


def notes(plan: StepPlan) -> list[str]:
    """What the steps and the folders of runs have to say; the same words of several recordings once."""
    said = [step for step in plan.steps.values() if step.message and step.status in {"done", "fresh"}]
    of_study = [step.message for step in said if step.item == "study"]
    counts = Counter(step.message for step in said if step.item != "study" and step.stage != "runs")
    of_recordings = [f"{note} ({count} recording{'s' if count != 1 else ''})" for note, count in counts.items()]
    return [*plan.campaign.notes, *of_recordings, *of_study]


def rejected(plan: StepPlan) -> list[dict[str, str]]:
    """Runs with presses that could not be scored: how many, and why most of them."""
    return [
        {"run": step.item, "message": step.message}
        for step in plan.steps.values()
        if step.stage == "runs" and step.message and step.status in {"done", "fresh"}
    ]


def page_of(plan: StepPlan) -> Path:
    """The page of the report that the run made, or would make."""
    name = next((step.stage for step in plan.steps.values() if step.stage in REPORTS), "report")
    return plan.folder(name, "study") / "index.html"


def report_lines(plan: StepPlan) -> Iterator[str]:
    """Where the report is, and what is missing from it."""
    if not any(step.stage in REPORTS for step in plan.steps.values()):
        return
    page = page_of(plan)
    why = {name: message for item, name, message in plan.failures() if item == "study"}
    if found := why.keys() & set(REPORTS):
        before = " The report in this place is from an earlier run." if page.exists() else ""
        yield f"Report: not written to {page}.{before} {why[found.pop()]}"
        return
    yield f"Report: {page}"
    for name, message in why.items():
        yield f"  {stage(name).gives} missing from it: {message}"


def left_of(plan: StepPlan) -> list[Step]:
    """Steps of a shard that did not run, as a step of the whole study that they need is not done."""
    return [step for step in plan.steps.values() if step.item != "study" and step.status in ("stale", "waits")]


def missing_for(plan: StepPlan, left: Sequence[Step]) -> list[str]:
    """Stages of the whole study that these steps need and that are not done."""
    needs = {need for step in left for need in stage(step.stage).needs if stage(need).per == "study"}
    return [name for name in ORDER if name in needs and plan.steps[f"{name}/study"].status not in DONE]


def rest_in_words(plan: StepPlan) -> str:
    """What a shard left, and what to do when all shards have ended."""
    left = left_of(plan)
    run = f"emg2vsa run {plan.study.path}"
    if not left:
        return f"This shard is done. When all shards are: {run}"
    counts = ", ".join(f"{name} {count}" for name, count in Counter(step.stage for step in left).items())
    missing = missing_for(plan, left)
    if not missing:
        return f"Not run: {counts}. Run this shard again."
    then = f"When all shards have ended: {run} --only {missing[-1]}, then the shards again."
    return f"Not run: {counts}. They need {missing[-1]}. {then}"


def to_try_again(plan: StepPlan) -> bool:
    """Whether a step of the shard failed by something else than its input, such as a full disk."""
    failed = (plan.ledger.last(step.id) for step in plan.steps.values() if step.status == "failed")
    return any(entry is None or not entry.final for entry in failed)


@contextmanager
def ended_by_scheduler() -> Iterator[None]:
    """Let SIGTERM, by which job schedulers end a job, end a run as Ctrl-C does: with its locks given back."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
