"""What a run of a study has to say at its end: of its steps and of its report."""

from __future__ import annotations

import signal
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from emg2vsa.pipeline.plan import StepPlan
from emg2vsa.pipeline.stage_order import REPORTS, stage


def outcome(plan: StepPlan, seconds: float) -> tuple[dict[str, Any], list[str]]:
    """The end of a run: for programs, and in lines."""
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
        "report": str(page_of(plan)),
    }
    lines = [
        *(f"note: {note}" for note in said),
        *(f"{of['run']}: {of['message']}" for of in not_scored),
        f"{plan.study.name}: {len(ran)} step{'s' if len(ran) != 1 else ''} run, {fresh} fresh, {len(failures)} "
        f"refused or failed, {seconds:.1f} s",
        *report_lines(plan),
    ]
    return told, lines


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
