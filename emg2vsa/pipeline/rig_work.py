"""The step of one run: let the emulated rig make it, where one does, and score its presses."""

from __future__ import annotations

import shutil
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from emg2vsa import artifacts
from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError
from emg2vsa.pipeline.campaign import Emulation
from emg2vsa.pipeline.tasks import Ended, guarded
from emg2vsa.rig.emulated.truth import true_areas_mm2
from emg2vsa.rig.emulated.virtual_run import run_virtual
from emg2vsa.rig.experiment import plan_of
from emg2vsa.rig.plan import RunPlan
from emg2vsa.run_folders.presses import is_simulated, read_presses, run_notes
from emg2vsa.runs import RunScores
from emg2vsa.runs.score_run import score_run
from emg2vsa.settings import RunSettings
from emg2vsa.study import RunEntry, RunsSource

_STARTED = datetime(2026, 1, 5, 9, 0, tzinfo=UTC)
"""Date of every emulated run: the same study gives the same bytes on any day."""


def run(
    entry: RunEntry, source: RunsSource, scoring: RunSettings, emulation: Emulation | None, result: Path
) -> list[Ended]:
    """Score the presses of one run and store them in ``result``."""

    def make() -> str:
        folders = entry.folders if emulation is None else (_emulated(entry, source.root, emulation),)
        scores = score_run(
            read_presses(folders, source.camera),
            scoring,
            specimen=entry.specimen,
            angle_deg=entry.angle_deg,
            condition=entry.condition,
            simulated=is_simulated(folders),
            notes=run_notes(folders),
        )
        if not scores.verdicts:
            do = "See that its folder holds the presses' frames."
            raise DataError(entry.key, wanted="one press or more", found="none", do=do)
        if emulation is not None:
            scores = replace(scores, true_a_c0=_true_a_c0(entry, scores, emulation))
        artifacts.save(result, scores)
        rejected = scores.verdicts.count("rejected")
        of_all = f"{rejected} of {len(scores.verdicts)} presses rejected: {scores.most_frequent_reason}"
        return of_all if rejected else ""

    return [guarded(f"runs/{entry.key}", make)]


def _emulated(entry: RunEntry, root: Path, emulation: Emulation) -> Path:
    """The folder of the run, made whole or not at all."""
    folder, unfinished = root / entry.key, root / f".{entry.key}.unfinished"
    if folder.exists() and not is_simulated((folder,)):
        do = "Choose another root under [runs], or leave rig out of it to score measured runs."
        raise DataError(folder, wanted="no measured run where an emulated one goes", found="one", do=do)
    plan = _plan(entry, emulation)
    for old in (unfinished, folder):
        shutil.rmtree(old, ignore_errors=True)
    run_virtual(plan, emulation.rig, emulation.emulated, unfinished, started=_STARTED)
    unfinished.rename(folder)
    return folder


def _plan(entry: RunEntry, emulation: Emulation) -> RunPlan:
    schedules = () if emulation.schedules is None else artifacts.load(emulation.schedules)
    return plan_of(emulation.experiment, entry.specimen, entry.angle_deg, entry.condition, schedules)  # type: ignore[arg-type]


def _true_a_c0(entry: RunEntry, scores: RunScores, emulation: Emulation) -> Floats:
    first_n = [curve.force_n[0] if curve.force_n.size else np.nan for curve in scores.curves]
    return true_areas_mm2(_plan(entry, emulation), emulation.rig, emulation.emulated, first_n)
