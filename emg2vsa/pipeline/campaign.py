"""The rig's part of a study: which runs there are, and the emulated rig that makes them, if one does."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from emg2vsa.errors import DataError
from emg2vsa.run_folders.find import RUNS_TABLE, find_runs, left_out
from emg2vsa.study import RunEntry, RunsSource, Study

if TYPE_CHECKING:
    from emg2vsa.rig.emulated.settings import EmulatedSettings
    from emg2vsa.rig.experiment import ExperimentSettings
    from emg2vsa.rig.rig_settings import RigSettings
    from emg2vsa.rig_file import RigFile


@dataclass(frozen=True)
class Campaign:
    """A study whose runs have been looked up.

    rig : the rig file of an emulated rig; None for measured runs. notes : what is to be said of measured runs.
    """

    study: Study
    rig: RigFile | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Emulation:
    """The emulated rig, and what it is to do. ``schedules``: their result file, None where none could be made."""

    rig: RigSettings
    emulated: EmulatedSettings
    experiment: ExperimentSettings
    schedules: Path | None


def campaign(study: Study) -> Campaign:
    """The study with its runs: those the rig file's experiment asks for, or those that were measured.

    Raises
    ------
    StudyError : the rig file has problems. DataError : the measured runs have, or there is nothing else in the study
    and none was found, or the experiment presses what the study does not know.
    """
    source = study.runs_source
    if source is None:
        return Campaign(study)
    if source.rig is None:
        return _measured(study, source)
    # a study without a rig does not wait for all that a rig file loads
    rig: RigFile = importlib.import_module("emg2vsa.rig_file").load_rig(source.rig)
    unknown = sorted({specimen for specimen, _, _ in rig.experiment.all_runs()} - set(study.pressed_n_per_mm))
    if unknown:
        raise DataError(
            f"{source.rig}, experiment.specimens",
            wanted=f"specimens whose stiffness the study file gives ({', '.join(study.pressed_n_per_mm)})",
            found=", ".join(unknown),
            do="Leave them out, or give their stiffness in the study file.",
        )
    return Campaign(replace(study, runs=tuple(RunEntry(*run, ()) for run in rig.experiment.all_runs())), rig)


def _measured(study: Study, source: RunsSource) -> Campaign:
    runs = find_runs(source.root, study.pressed_n_per_mm)
    if not runs and not study.recordings:
        do = f"Give the folder of the runs as root under [runs], with its table {RUNS_TABLE}."
        raise DataError(source.root, wanted="one run or more", found="none", do=do)
    where = source.root / RUNS_TABLE
    notes = tuple(
        f"{source.root / name} holds frames but is no run: add it to {where}" for name in left_out(source.root, runs)
    )
    return Campaign(replace(study, runs=runs), notes=notes if runs else (*notes, f"no runs in {source.root}"))
