"""What a run computed, what it skipped and why, and what each stage took: ``emg2vsa run --profile``."""

from __future__ import annotations

import contextlib
import os
import re
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.counts import COUNTED, counting

if TYPE_CHECKING:
    from emg2vsa.pipeline.plan import Step, StepPlan

if sys.platform != "win32":
    import resource

_STATUS = Path("/proc/self/status")
_TOLD = ("setting", "library")
"""Reasons that stand for many steps as they are. Of others the name differs from step to step, and the kind is told."""
_MOST_REASONS = 6


@dataclass
class Spent:
    """What a step took in its process.

    cpu_s : CPU seconds of the process and of the child processes that ended meanwhile, all threads. wall_s : seconds
    by the clock. peak_mb : largest resident memory, MB; None where the system does not tell. counts : by the names of
    ``casr.counts.COUNTED``.
    """

    cpu_s: float = 0.0
    wall_s: float = 0.0
    peak_mb: float | None = None
    counts: Mapping[str, int] = field(default_factory=dict)


@contextlib.contextmanager
def measured() -> Iterator[Spent]:
    """What is done inside; the numbers are there when it has ended, by an error too."""
    spent, before_s, since_s = Spent(), _cpu_s(), time.perf_counter()
    _forget_peak()
    with counting() as counts:
        try:
            yield spent
        finally:
            spent.cpu_s, spent.wall_s = _cpu_s() - before_s, time.perf_counter() - since_s
            spent.peak_mb, spent.counts = _peak_mb(), counts


def _cpu_s() -> float:
    ended = os.times()
    return time.process_time() + ended.children_user + ended.children_system


def _forget_peak() -> None:
    """Linux counts the peak anew from here, so that it is the step's and not that of a step before it."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5")


def _peak_mb() -> float | None:
    """Since ``_forget_peak`` on Linux; elsewhere since the process began, or not known."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            found = re.search(r"VmHWM:\s+(\d+) kB", _STATUS.read_text())
            return int(found[1]) * 1024 / 1e6 if found else None
    if sys.platform != "win32":
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)
    return None


@dataclass
class StageProfile:
    """One stage.

    computed, failed, fresh, left : steps that ran and gave a result, that ran and gave none, whose stored result holds,
    and that did not run: an input or their own last try failed. reasons : why steps ran, to how many of them. cpu_s,
    wall_s : sums over its steps. slowest_s, slowest : wall seconds of the slowest step, and its item. peak_mb : of the
    process that held most memory during a step; None where the system does not tell. counts : sums, by the names of
    ``casr.counts.COUNTED``.
    """

    computed: int = 0
    failed: int = 0
    fresh: int = 0
    left: int = 0
    reasons: Counter[str] = field(default_factory=Counter)
    cpu_s: float = 0.0
    wall_s: float = 0.0
    slowest_s: float = 0.0
    slowest: str = ""
    peak_mb: float | None = None
    counts: Counter[str] = field(default_factory=Counter)

    def add(self, step: Step, spent: Spent) -> None:
        """A step that ran and ended."""
        failed = step.status == "failed"
        self.computed += not failed
        self.failed += failed
        self.reasons.update(list(dict.fromkeys(map(kind_of, step.reasons))))
        self.cpu_s += spent.cpu_s
        self.wall_s += spent.wall_s
        if spent.wall_s >= self.slowest_s:
            self.slowest_s, self.slowest = spent.wall_s, step.item
        if spent.peak_mb is not None:
            self.peak_mb = max(self.peak_mb or 0.0, spent.peak_mb)
        self.counts.update(spent.counts)

    @property
    def counted(self) -> dict[str, int]:
        """What was counted, in the order of ``COUNTED``, and how many frames nobody asked for."""
        found = {what: self.counts[what] for what in COUNTED if self.counts[what]}
        if "frames in folder" in found:
            found["frames not decoded"] = self.counts["frames in folder"] - self.counts["frames decoded"]
        return found


class Profile:
    """The stages of a run, by name, in the order of the run; ``run_study`` fills it."""

    def __init__(self) -> None:
        self.stages: dict[str, StageProfile] = {}

    def add(self, step: Step, spent: Spent) -> None:
        """A step that ran, and what it took."""
        self.stages.setdefault(step.stage, StageProfile()).add(step, spent)

    def end(self, plan: StepPlan) -> None:
        """The steps that did not run, as the plan has them at the end."""
        ran, self.stages = self.stages, {}
        for step in plan.steps.values():
            own = self.stages.setdefault(step.stage, ran.get(step.stage, StageProfile()))
            own.fresh += step.status == "fresh"
        for name, own in self.stages.items():
            steps = sum(step.stage == name for step in plan.steps.values())
            own.left = max(steps - own.computed - own.failed - own.fresh, 0)

    def as_json(self) -> list[dict[str, Any]]:
        """The numbers of each stage, in the order of the run; seconds with six decimals."""
        return [
            {"stage": name}
            | vars(own)
            | {each: round(getattr(own, each), 6) for each in ("cpu_s", "wall_s", "slowest_s")}
            | {"peak_mb": None if own.peak_mb is None else round(own.peak_mb, 1)}
            | {"reasons": dict(own.reasons.most_common()), "counts": own.counted}
            for name, own in self.stages.items()
        ]

    def lines(self) -> Iterator[str]:
        """A table of the stages, and beneath it why their steps ran and what was done inside."""
        width = max(map(len, self.stages), default=0) + 2
        steps = f"{'computed':>9}{'failed':>8}{'fresh':>7}{'left':>6}"
        yield f"{'stage':<{width}}{steps}{'CPU s':>9}{'wall s':>9}{'slowest s':>11}{'peak MB':>9}"
        for name, own in self.stages.items():
            row = f"{name:<{width}}{own.computed:>9}{own.failed:>8}{own.fresh:>7}{own.left:>6}"
            if own.computed or own.failed:
                peak = "" if own.peak_mb is None else f"{own.peak_mb:.0f}"
                row += f"{own.cpu_s:>9.2f}{own.wall_s:>9.2f}{own.slowest_s:>11.2f}{peak:>9}"
            yield row
        for name, own in self.stages.items():
            for reason, n in own.reasons.most_common(_MOST_REASONS):
                yield f"{name}: {n} ran because: {reason}"
            if len(own.reasons) > _MOST_REASONS:
                yield f"{name}: {len(own.reasons) - _MOST_REASONS} more reasons; --json lists them"
        for name, own in self.stages.items():
            if said := ", ".join(f"{n} {what}" for what, n in own.counted.items()):
                yield f"{name}: {said}"


def kind_of(reason: str) -> str:
    """A reason without what differs from step to step: the name of a file, the item of an input."""
    verb, _, rest = reason.partition(" ")
    what, _, name = rest.partition(" ")
    if verb in _TOLD or what not in ("file", "input", "code"):
        return reason
    if what == "input":
        return f"{verb} input {name.partition('/')[0]}"
    return reason if what == "code" else f"{verb} file"
