"""The rig's part of a study: which runs there are, and the emulated rig that makes them, if one does."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from emg2vsa.run_folders.find import find_runs
from emg2vsa.study import RunEntry, Study

if TYPE_CHECKING:
    from emg2vsa.rig.emulated.settings import EmulatedSettings
    from emg2vsa.rig.experiment import ExperimentSettings
    from emg2vsa.rig.rig_settings import RigSettings
    from emg2vsa.rig_file import RigFile


@dataclass(frozen=True)
class Campaign:
    """A study whose runs have been looked up. ``rig``: the rig file of an emulated rig; None for measured runs."""

    study: Study
    rig: RigFile | None = None


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
    StudyError : the rig file has problems. DataError : the table of measured runs has.
    """
    source = study.runs_source
    if source is None:
        return Campaign(study)
    if source.rig is None:
        return Campaign(replace(study, runs=find_runs(source.root)))
    # a study without a rig does not wait for all that a rig file loads
    rig: RigFile = importlib.import_module("emg2vsa.rig_file").load_rig(source.rig)
    return Campaign(replace(study, runs=tuple(RunEntry(*run, ()) for run in rig.experiment.all_runs())), rig)
