"""What runs would send to the rig, and the limits that they are held against; nothing is sent."""

from __future__ import annotations

from collections.abc import Sequence

from emg2vsa.errors import InputError
from emg2vsa.rig.executor.dry_run import DryRun
from emg2vsa.rig.executor.dry_run import dry_run as tried
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, plans_of
from emg2vsa.rig_file.sequence import ordered


def dry_run(file: RigFile, runs: Sequence[Run] = ()) -> dict[Run, DryRun | str]:
    """What each run would send, or why it is not possible, in the order of the experiment. No device is opened.

    runs : none: all of the experiment. ScheduleError : a schedule is absent, or for another actuator.
    """
    runs = runs or file.experiment.all_runs()
    plans = dict(zip(runs, plans_of(file, runs), strict=True))
    told: dict[Run, DryRun | str] = {}
    for run in ordered(file.experiment).runs:
        if run in plans:
            try:
                told[run] = tried(plans[run], file.rig)
            except InputError as error:
                told[run] = str(error)
    return told


def limits(file: RigFile) -> dict[str, str]:
    """Of the rig file, in words."""
    rig = file.rig
    way_deg = rig.position_at(rig.travel_mm) - rig.home_deg
    return {
        "positions": "{:.6g} to {:.6g} degrees".format(*rig.position_deg),
        "presets": "{:g} to {:g} % of the full one".format(*rig.stiffness_percent),
        "travel": f"{rig.travel_mm:g} mm, {way_deg:+.6g} degrees from home",
        "force": f"{rig.guards.force_n:g} N, {rig.guards.force_rate_n_per_s:g} N/s",
    }
