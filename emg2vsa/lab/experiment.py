"""The experiment of a rig file from a program or a notebook: one run, all runs, plates, an unknown specimen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from emg2vsa.lab.adaptive_runs import AdaptiveRuns, press_adaptively
from emg2vsa.lab.judging import Judging
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.plate_runs import press_plates
from emg2vsa.lab.pressed import Pressed
from emg2vsa.lab.pressing import Pressing
from emg2vsa.lab.sequence import RunsDone, press_in_order, press_side_by_side
from emg2vsa.pipeline.pool import available_cores
from emg2vsa.rig.plan import Condition
from emg2vsa.rig_file import RigFile, load_rig
from emg2vsa.rig_file.plans import Run, chosen_runs
from emg2vsa.rig_file.sequence import run_order

WHOLE_PRESSES = Judging()


def load(path: str | Path) -> RigFile:
    """The rig file at ``path``: limits, devices, experiment and emulated rig, checked. StudyError lists every problem.

    >>> from emg2vsa import rig
    >>> file = rig.load("studies/palpation/rig.toml")
    """
    return load_rig(path)


def press(
    file: RigFile, specimen: str, angle_deg: float = 0.0, condition: Condition = "modular", *, mounting: int = 1,
    presses: int | None = None, folder: str | Path | None = None, virtual: bool = False,
    judging: Judging = WHOLE_PRESSES, person: Person = NOBODY,
) -> Pressed:  # fmt: skip
    """Press one specimen at one angle, degrees, under one condition of stiffness; where it is recorded, and its log.

    Parameters
    ----------
    specimen, angle_deg, condition, mounting : a run of the experiment of ``file``.
    presses : None: those that the run still lacks.
    folder : of the runs, in which this one gets a folder of its own; None: that of the rig file.
    virtual : on the emulated rig, faster than real time; else the devices of the rig file press, in real time.
    judging : calibrations that tell the stiffness of the specimen while it is pressed.
    person : who is told what goes on.

    Raises
    ------
    SettingError, ScheduleError, DataError : no such run, a limit of the rig that it breaks, a schedule that is absent,
    or a run that is done; nothing has moved. DeviceError : a device is absent, or another process uses the rig.

    Examples
    --------
    >>> run = rig.press(file, "S3", 0, "modular", virtual=True)
    >>> run.log.plot("depth_mm", "force_n")
    """
    (run,) = chosen_runs(file, [specimen], [angle_deg], [condition], [mounting])
    return _pressing(file, folder, virtual, person).press_run(run, judging, presses)


def sequence(
    file: RigFile, runs: Sequence[Run] = (), *, order: Literal["random", "listed"] | None = None,
    seed: int | None = None, folder: str | Path | None = None, virtual: bool = False, jobs: int | None = None,
    judging: Judging = WHOLE_PRESSES, person: Person = NOBODY,
) -> RunsDone:  # fmt: skip
    """All presses that the experiment still lacks, or only ``runs`` of it; a sequence that was stopped goes on.

    order, seed : None: those kept in the folder of the runs, else those of the rig file. jobs : processes of a virtual
    sequence; None: all cores. ``person`` is asked to place each specimen of a real one. Else as `press`.

    >>> done = rig.sequence(file, virtual=True)
    >>> [(run.name, one.ended.how) for run, one in done.pressed]
    """
    pressing = _pressing(file, folder, virtual, person)
    drawn = run_order(pressing.root, file.experiment, order, seed)
    runs = runs or file.experiment.all_runs()
    if virtual:
        return press_side_by_side(pressing, runs, drawn, judging, None, jobs or available_cores())
    return press_in_order(pressing, runs, drawn, judging)


def plates(
    file: RigFile, specimens: Sequence[str], *, folder: str | Path | None = None, virtual: bool = False,
    person: Person = NOBODY,
) -> tuple[Pressed, ...]:  # fmt: skip
    """Indent specimens with a flat plate, as [plate] says, for their stiffness (``emg2vsa stiffness``).

    The trials that a specimen still lacks are recorded in ``<folder>-plate/<specimen>``. Else as `press`.
    """
    return press_plates(_pressing(file, folder, virtual, person), specimens)


def adaptive(
    file: RigFile, specimen: str, judging: Judging, *, presses: int | None = None, folder: str | Path | None = None,
    virtual: bool = False, person: Person = NOBODY,
) -> AdaptiveRuns:  # fmt: skip
    """Press an unknown specimen until its stiffness is known: each next run is the one that `next_presses` chooses.

    judging : a calibration for every angle and condition that may be pressed, and the width that is enough.
    presses : at most. Else as `press`.

    >>> judging = rig.Judging(tuple(Path("calibrations").glob("*.json")), stop_at=0.1)
    >>> rig.adaptive(file, "S4", judging, virtual=True).belief
    """
    return press_adaptively(_pressing(file, folder, virtual, person), specimen, judging, presses)


def _pressing(file: RigFile, folder: str | Path | None, virtual: bool, person: Person) -> Pressing:
    usual = file.virtual_runs if virtual else file.runs
    return Pressing(file, usual if folder is None else Path(folder), virtual, person)
