"""Which steps are fresh, which are stale and why: the state of a study without computing anything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from emg2vsa.pipeline.campaign import Campaign, campaign
from emg2vsa.pipeline.fingerprint import Fingerprints
from emg2vsa.pipeline.ledger import Entry, Ledger, differences
from emg2vsa.pipeline.manifest import manifest_holds
from emg2vsa.pipeline.steps import FAILED, OF_RUNS, Step, items, make_step, step_id, upstream
from emg2vsa.study import Study

WRITES_FILES = frozenset({"pages", "report"})
"""Stages whose results are files outside the store."""


@dataclass
class State:
    """One step: ``fresh``, ``stale`` with its reasons, ``failed`` for good, or ``blocked`` by a failed input."""

    step: Step
    status: str
    reasons: tuple[str, ...] = ()
    message: str = ""


@dataclass
class Board:
    """The states of all steps so far; the one place that knows keys."""

    campaign: Campaign
    ledger: Ledger
    prints: Fingerprints
    states: dict[str, State] = field(default_factory=dict)

    @property
    def study(self) -> Study:
        """The study, with its runs."""
        return self.campaign.study

    def add_stage(self, stage: str) -> list[State]:
        """State of every step of a stage, given the states of the stages before it."""
        added = []
        for item in items(self.study, stage):
            keys = {name: self._key(name) for name in upstream(self.study, stage, item) if name in self.states}
            state = self._state(make_step(self.campaign, stage, item, keys, self.prints))
            self.states[state.step.id] = added_state = state
            added.append(added_state)
        return added

    def end(self, step: str, status: str, message: str, final: bool) -> None:
        """Record that a step has ended."""
        state = self.states[step]
        state.status, state.message = status, message
        self.ledger.record(Entry(step, state.step.key, status, message, final, state.step.parts))

    def result(self, step: str) -> Path:
        """Path of the step's result."""
        return self.ledger.result_path(step, self.states[step].step.key)

    def done(self, stage: str, item_prefix: str = "") -> tuple[Path, ...]:
        """Results of a stage that are there, in order."""
        names = [step_id(stage, item) for item in items(self.study, stage) if item.startswith(item_prefix)]
        there = [name for name in names if name in self.states]
        return tuple(self.result(name) for name in there if self.states[name].status in {"fresh", "done"})

    def failures(self, item_prefix: str = "") -> tuple[tuple[str, str, str], ...]:
        """(item, stage, message) of every failed step of the items."""
        failed = [s for s in self.states.values() if s.status == FAILED and s.step.item.startswith(item_prefix)]
        return tuple((s.step.item, s.step.stage, s.message) for s in failed)

    def _key(self, step: str) -> str:
        state = self.states[step]
        return FAILED if state.status in {FAILED, "blocked"} else state.step.key

    def _state(self, step: Step) -> State:
        last = self.ledger.last(step.id)
        own = step_id("trials", step.item)
        if own in step.parts.inputs and self.states[own].status == FAILED:
            return State(step, "blocked", message=f"{own} failed")
        if last is not None and last.key == step.key:
            if last.status == FAILED:
                return State(step, FAILED, message=last.message) if last.final else State(step, "stale", (_AGAIN,))
            if self._kept(step):
                return State(step, "fresh", message=last.message)
            return State(step, "stale", ("its result is missing",))
        if step.stage not in WRITES_FILES and self.ledger.result_path(step.id, step.key).exists():
            self.ledger.record(Entry(step.id, step.key, "done", "", False, step.parts))
            return State(step, "fresh")
        return State(step, "stale", _reasons(last, step))

    def _kept(self, step: Step) -> bool:
        path = self.ledger.result_path(step.id, step.key)
        return manifest_holds(path) if step.stage in WRITES_FILES else path.exists()


_AGAIN = "the last try ended unexpectedly"


def _reasons(last: Entry | None, step: Step) -> tuple[str, ...]:
    return ("never ran",) if last is None else tuple(differences(last.parts, step.parts))


def open_board(study: Study, stages: Sequence[str]) -> Board:
    """The board of a study, with its runs looked up where one of the ``stages`` needs them. Raises as ``campaign``."""
    found = campaign(study) if OF_RUNS & set(stages) else Campaign(study)
    return Board(found, Ledger(study.results), Fingerprints(study.results / "fingerprints.json"))


def survey(study: Study, stages: Sequence[str]) -> Board:
    """The state of all steps of the stages; nothing is computed, nothing but the fingerprint memory is written."""
    board = open_board(study, stages)
    for stage in stages:
        board.add_stage(stage)
    board.prints.save()
    return board
