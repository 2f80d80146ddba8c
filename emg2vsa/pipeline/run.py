"""Run what is stale, stage by stage; keep going when something fails; leave what is fresh alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.pipeline.campaign import Emulation
from emg2vsa.pipeline.plan import Board, State, open_board
from emg2vsa.pipeline.pool import Modules, run_tasks
from emg2vsa.pipeline.steps import STAGES, truth_files
from emg2vsa.pipeline.tasks import Ended, Task
from emg2vsa.readers.formats import reader_module
from emg2vsa.study import RecordingEntry, Study

ALONE = {"recording": 8, "run": 1, "participant": 64, "study": 1}
"""Up to so many tasks run in the calling process: starting workers costs about a second of imports."""


@dataclass(frozen=True)
class Progress:
    """What a screen may show while a study runs; every function may do nothing."""

    begin: Callable[[str, int], None]
    """Stages (joined by "+") and the number of their steps that will run."""
    step: Callable[[State], None]
    """A step ended."""
    end: Callable[[], None]
    """The stages ended."""


def run_study(study: Study, *, stages: Sequence[str], jobs: int, progress: Progress) -> Board:
    """Bring the ``stages`` of a study up to date and say how every step ended.

    Raises
    ------
    StudyError, DataError : its rig file, or its table of measured runs, has problems; nothing was run.
    """
    board = open_board(study, stages)
    try:
        for wave in _waves(stages, study.cocontraction.needs_session):
            _run_wave(board, wave, jobs, progress, stages)
    finally:
        board.prints.save()
    board.ledger.compact()
    return board


def _waves(stages: Sequence[str], needs_session: bool) -> list[tuple[str, ...]]:
    """Stages that run together: trials and fits of a recording in one task, unless fits wait for the whole session."""
    first = tuple(stage for stage in stages if STAGES[stage].per == "recording")
    rest = sorted((s for s in stages if s not in first), key=lambda s: (s == "report", STAGES[s].per != "participant"))
    return [*(((stage,) for stage in first) if needs_session else (first,)), *((stage,) for stage in rest)]


def _run_wave(board: Board, stages: Sequence[str], jobs: int, progress: Progress, all_stages: Sequence[str]) -> None:
    states = [state for stage in stages for state in board.add_stage(stage)]
    stale = [state for state in states if state.status == "stale"]
    if not stale:
        return
    progress.begin("+".join(stages), len(stale))

    def on_end(ended: Ended) -> None:
        board.end(ended.step, ended.status, ended.message, ended.final)
        progress.step(board.states[ended.step])

    alone = ALONE[STAGES[stages[0]].per]
    run_tasks(_tasks(board, stages, stale), jobs, on_end, alone=alone, modules=_modules(board, stale, all_stages))
    for state in stale:
        if state.status == "stale":  # fits whose trials failed in this very run
            state.status, state.message = "blocked", "its trials failed"
            progress.step(state)
    progress.end()


def _tasks(board: Board, stages: Sequence[str], stale: Sequence[State]) -> list[Task]:
    kind = STAGES[stages[0]].per
    if kind == "recording":
        return _recording_tasks(board, stale)
    if kind == "run":
        return [_run_task(board, state) for state in stale]
    if kind == "participant":
        return [_page_task(board, state) for state in stale]
    return [_study_task(board, state) for state in stale]


def _modules(board: Board, stale: Sequence[State], all_stages: Sequence[str]) -> Modules:
    """What these tasks load in the workers, and what the stages that run here will."""
    items = {state.step.item for state in stale if state.step.stage == "trials"}
    files = [entry.emg_file for entry in board.study.recordings if entry.key in items]
    workers = {module for path in files if (module := reader_module(path))}
    workers |= {_function(state.step.stage).partition(":")[0] for state in stale}
    here = {_function(stage).partition(":")[0] for stage in all_stages if STAGES[stage].per not in ("recording", "run")}
    return Modules(tuple(sorted(workers)), tuple(sorted(here)))


_REPORT_OF_RUNS = "emg2vsa.pipeline.runs_report_work:report"
_WORK = {"report": "report_work", "discrimination": "casr_work", "calibration": "casr_work"}


def _function(stage: str) -> str:
    match STAGES[stage].per:
        case "recording":
            return "emg2vsa.pipeline.recording_work:run"
        case "run":
            return "emg2vsa.pipeline.rig_work:run"
        case "participant":
            return "emg2vsa.pipeline.page_work:run"
        case _:
            return f"emg2vsa.pipeline.{_WORK.get(stage, 'study_work')}:{stage}"


def _recording_tasks(board: Board, stale: Sequence[State]) -> list[Task]:
    by_item: dict[str, list[State]] = {}
    for state in stale:
        by_item.setdefault(state.step.item, []).append(state)
    entries = {entry.key: entry for entry in board.study.recordings}
    tasks = []
    for item, states in by_item.items():
        arguments = {
            "entry": entries[item],
            "cocontraction": board.study.cocontraction,
            "fit": board.study.fit,
            "results": {"trials": board.result(f"trials/{item}")}
            | {state.step.stage: board.result(state.step.id) for state in states},
            "stages": tuple(state.step.stage for state in states),
            "session": _session(board, entries[item]),
        }
        tasks.append(Task(tuple(s.step.id for s in states), _function("trials"), arguments))
    return tasks


def _session(board: Board, entry: RecordingEntry) -> tuple[Path, ...]:
    """The trials that the activity of a recording depends on, besides its own."""
    return board.done("trials", f"{entry.participant}/") if board.study.cocontraction.needs_session else ()


def _run_task(board: Board, state: State) -> Task:
    study, rig = board.study, board.campaign.rig
    emulation = None
    if rig is not None and rig.emulated is not None:
        schedules = next(iter(board.done("schedules")), None)
        emulation = Emulation(rig.rig, rig.emulated, rig.experiment, schedules)
    arguments = {
        "entry": next(entry for entry in study.runs if entry.key == state.step.item),
        "source": study.runs_source,
        "scoring": study.scoring,
        "emulation": emulation,
        "result": board.result(state.step.id),
    }
    return Task((state.step.id,), _function("runs"), arguments)


def _page_task(board: Board, state: State) -> Task:
    prefix = f"{state.step.item}/"
    arguments = {
        "study": board.study,
        "participant": state.step.item,
        "trials": board.done("trials", prefix),
        "fits": board.done("fits", prefix),
        "failures": board.failures(prefix),
        "result": board.result(state.step.id),
    }
    return Task((state.step.id,), _function("pages"), arguments)


def _study_task(board: Board, state: State) -> Task:
    stage = state.step.stage
    arguments: dict[str, object] = {
        "study": board.study,
        "inputs": {need: board.done(need) for need in STAGES[stage].needs if need != "pages"},
        "result": board.result(state.step.id),
    }
    if stage == "report":
        arguments["failures"] = board.failures()
        if not board.study.recordings:
            return Task((state.step.id,), _REPORT_OF_RUNS, arguments)
        arguments["truth"] = next(iter(truth_files(board.study)), None)
    return Task((state.step.id,), _function(stage), arguments)
