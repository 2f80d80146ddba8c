"""A study whose runs have been looked up: those that an emulated rig is to make, or those that were measured."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.errors import DataError
from emg2vsa.readers.bids_sidecars import SideFileIndex
from emg2vsa.run_folders.find import RUNS_TABLE, find_runs, left_by_emulator, left_out, was_judged
from emg2vsa.settings import RIGID
from emg2vsa.study import RecordingEntry, RunEntry, RunsSource, Study

if TYPE_CHECKING:
    from emg2vsa.registration import Registered
    from emg2vsa.rig.experiment import ExperimentSettings, Run
    from emg2vsa.rig_file import RigFile
    from emg2vsa.worlds.bench.settings import EmulatedSettings

MOVED = "runs-virtual-0.1.0"


@dataclass(frozen=True)
class Campaign:
    """A study with its recordings and runs by key.

    rig : the rig file of an emulated rig; None for measured runs. notes : what is to be said of measured runs.
    """

    study: Study
    rig: RigFile | None = None
    notes: tuple[str, ...] = ()

    @cached_property
    def recordings(self) -> dict[str, RecordingEntry]:
        """``participant/specimen`` to the recording."""
        return {f"{entry.participant}/{entry.specimen}": entry for entry in self.study.recordings}

    @cached_property
    def cells(self) -> dict[str, tuple[str, ...]]:
        """Participant to the keys of their recordings."""
        found: dict[str, list[str]] = {}
        for key, entry in self.recordings.items():
            found.setdefault(entry.participant, []).append(key)
        return {participant: tuple(keys) for participant, keys in found.items()}

    @cached_property
    def side_files(self) -> SideFileIndex:
        """Listings of the folders of the recordings, each read once."""
        return SideFileIndex()

    @cached_property
    def runs(self) -> dict[str, RunEntry]:
        """``specimen_angle_condition`` to the run, with all its mountings."""
        return {entry.key: entry for entry in self.study.runs}

    @cached_property
    def designs(self) -> dict[str, tuple[str, ...]]:
        """``angle_condition`` to the keys of the runs there, wherever the new specimen was pressed."""
        found: dict[str, list[str]] = {}
        for key, entry in self.runs.items():
            found.setdefault(f"{entry.angle_deg:g}_{entry.condition}", []).append(key)
        new = self.study.profile.new_specimen
        pressed = {design for design, keys in found.items() if any(self.runs[key].specimen == new for key in keys)}
        return {design: tuple(keys) for design, keys in found.items() if design in pressed}

    @cached_property
    def mountings(self) -> dict[str, Run]:
        """Name of its folder to what the emulated rig is to press there, in the order of the experiment; empty for
        measured runs."""
        return {} if self.rig is None else {run.name: run for run in self.rig.experiment.ordered_runs()}

    @cached_property
    def places(self) -> dict[str, int]:
        """Name of a mounting's folder to its place in the order of the experiment, from 1."""
        return {name: place for place, name in enumerate(self.mountings, 1)}

    @cached_property
    def emulations(self) -> dict[str, tuple[ExperimentSettings, EmulatedSettings, EmulatedSettings]]:
        """Specimen to what its emulated runs have in common, as the same objects: each is converted for keys once.

        The experiment with this specimen alone, what is emulated of it, and this without the place of its tables.
        """
        specimens = dict.fromkeys(run.specimen for run in self.mountings.values())
        return {name: _emulation(self.rig, name) for name in specimens if self.rig is not None}

    @cached_property
    def registered(self) -> Registered | None:
        """The registration of the study with every deviation from it; None without one."""
        if self.study.registration is None:  # most studies: what claims need is not loaded
            return None
        found: Registered | None = importlib.import_module("emg2vsa.pipeline.registered").registered(self.study)
        return found


def _emulation(file: RigFile, specimen: str) -> tuple[ExperimentSettings, EmulatedSettings, EmulatedSettings]:
    assert file.emulated is not None
    schedule_of = {one: other for one, other in file.experiment.schedule_of.items() if one == specimen}
    alone: dict[str, Any] = {"specimens": (specimen,), "angles_deg": {}, "mountings": 1, "order": "listed", "seed": 0}
    emulated = file.emulated.of(specimen)
    return replace(file.experiment, schedule_of=schedule_of, **alone), emulated, replace(emulated, domes=None)


def campaign(study: Study) -> Campaign:
    """The study with its runs: those the rig file's experiment asks for, or those that were measured.

    Raises
    ------
    As `rig_of`. casr.errors.SettingError : tables of domes that are none.
    DataError : the measured runs have problems, or there is nothing else in the study and none was found.
    """
    source = study.runs_source
    if source is None:
        return Campaign(study)
    if source.domes is not None:
        # nor without tables for all that reads them
        importlib.import_module("casr.dome.library").read_library(source.domes)
    if source.rig is None:
        return _measured(study, source)
    rig = rig_of(study, source.rig)
    left = left_virtual_runs(study)
    notes = (
        f"{study.path.parent / 'runs'} holds {len(left)} run{'s' if len(left) != 1 else ''} that the emulated rig of "
        f"version 0.1.0 made. Move them away from measured ones: emg2vsa tools clean {study.path} --move-virtual",
    )
    runs: dict[tuple[str, float, str], list[Path]] = {}
    for run in sorted(rig.experiment.all_runs(), key=lambda run: run.mounting):
        runs.setdefault(run[:3], []).append(source.root / run.name)
    return Campaign(
        replace(study, runs=tuple(RunEntry(*cell, tuple(folders)) for cell, folders in runs.items())),
        rig,
        notes if left else (),
    )


def rig_of(study: Study, path: Path) -> RigFile:
    """The rig file that a study names.

    StudyError : it has problems. DataError : its experiment presses what the study does not know. ScheduleError : the
    study's schedules are for another actuator than it has.
    """
    # a study without a rig does not wait for all that a rig file loads
    rig: RigFile = importlib.import_module("emg2vsa.rig_file").load_rig(path)
    runs = rig.experiment.all_runs()
    unknown = sorted({run.specimen for run in runs} - set(study.pressed_n_per_mm))
    if unknown:
        raise DataError(
            f"{path}, experiment.specimens",
            wanted=f"specimens whose stiffness the study file gives ({', '.join(study.pressed_n_per_mm)})",
            found=", ".join(unknown),
            do="Leave them out, or give their stiffness in the study file.",
        )
    if any(run.condition != RIGID for run in runs):
        rig.check_actuator(study.schedule.actuator, f"{study.path}, schedule.actuator", "Set it to this one")
    return rig


def left_virtual_runs(study: Study) -> tuple[Path, ...]:
    """Runs in ``runs`` beside the study file that the emulated rig of version 0.1.0 made; they go elsewhere now."""
    source, before = study.runs_source, study.path.parent / "runs"
    if source is None or source.rig is None or source.root == before or not before.is_dir():
        return ()
    return left_by_emulator(before)


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


def _measured(study: Study, source: RunsSource) -> Campaign:
    runs = find_runs(source.root, study.pressed_n_per_mm)
    if not runs and not study.recordings:
        do = f"Give the folder of the runs as root under [runs], with its table {RUNS_TABLE}."
        raise DataError(source.root, wanted="one run or more", found="none", do=do)
    where = source.root / RUNS_TABLE
    notes = tuple(
        f"{source.root / name} holds presses of an unknown specimen: they are left out"
        if was_judged(source.root / name)
        else f"{source.root / name} holds frames but is no run: add it to {where}"
        for name in left_out(source.root, runs)
    )
    return Campaign(replace(study, runs=runs), notes=notes if runs else (*notes, f"no runs in {source.root}"))
