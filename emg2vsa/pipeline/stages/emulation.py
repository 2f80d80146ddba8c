"""Emulation: one mounting of a run of the experiment, carried out by the emulated rig in virtual time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from emg2vsa.pipeline.shared_settings import emulated_domes, emulation_settings
from emg2vsa.pipeline.stage import Given, Input, Stage
from emg2vsa.settings import RIGID

if TYPE_CHECKING:
    from emg2vsa.devices.device_settings import ActuatorSettings
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.rig.plan import RunPlan
    from emg2vsa.rig.rig_settings import RigSettings
    from emg2vsa.worlds.bench.controls import ArtificialEffect
    from emg2vsa.worlds.bench.settings import EmulatedSettings

STARTED = "2026-01-05T09:00:00+00:00"
"""Date of every emulated run: the same study gives the same bytes on any day."""


def takes(campaign: Campaign, item: str) -> list[Input]:
    """The rigid motor follows no schedule."""
    return [] if campaign.mountings[item].condition == RIGID else [("schedules", "study")]


def folder(campaign: Campaign, item: str) -> Path:
    assert campaign.study.runs_source is not None
    return campaign.study.runs_source.root


def alone_in(campaign: Campaign, item: str) -> Path:
    return folder(campaign, item) / item


def run(given: Given) -> list[Path]:
    """Press one mounting, and give its files. What it makes is whole or not there.

    SettingError : guards that this program has changed. DataError : a measured run lies in its place.
    """
    import os
    import shutil

    from emg2vsa.errors import DataError, SettingError
    from emg2vsa.rig.experiment import plan_of
    from emg2vsa.rig.record.new_folder import EMULATED_FILE
    from emg2vsa.worlds.bench.controls import effect_of

    assert given.folder is not None
    if changed := given.settings.get("changed_guards"):
        raise SettingError(
            "guards", wanted="those of emg2vsa: a study keeps its runs, and cannot know what others do",
            found=f"{', '.join(changed)} changed by this program", do="Press with emg2vsa.rig.sequence, or undo it.",
        )  # fmt: skip
    made, unfinished = given.folder / given.item, given.folder / f".{given.item}.{os.getpid()}.unfinished"
    if made.exists() and not (made / EMULATED_FILE).is_file():
        do = "Choose another root under [runs], or leave rig out of it to score measured runs."
        raise DataError(made, wanted="a free folder for an emulated run", found="a measured run", do=do)
    used = given.settings
    known, schedules = used["emulated"].stiffness_n_per_mm, given.one("schedules") or ()
    plan = replace(plan_of(used["experiment"], used["run"], schedules, known), order=used["order"])
    for left in given.folder.glob(f".{given.item}.*unfinished"):  # by a process that was killed
        shutil.rmtree(left, ignore_errors=True)
    try:
        effect = effect_of(used["emulated"], plan.schedule, schedules)
        _record(plan, used["rig"], used["emulated"], unfinished, effect, used.get("actuator"))
        shutil.rmtree(made, ignore_errors=True)
        unfinished.rename(made)
    except BaseException:
        shutil.rmtree(unfinished, ignore_errors=True)
        raise
    return sorted(path for path in made.rglob("*") if path.is_file())


def _record(
    plan: RunPlan,
    rig: RigSettings,
    emulated: EmulatedSettings,
    folder: Path,
    effect: ArtificialEffect | None,
    actuator: ActuatorSettings | None,
) -> None:
    """Carry the run out, whole: what a guard of the emulated rig ends is a result, what the computer ends is none.

    OSError : it could not be recorded. KeyboardInterrupt : Ctrl-C, which the executor takes for the end of the run.
    """
    import errno
    from datetime import datetime

    from emg2vsa.errors import DeviceError
    from emg2vsa.rig.record.new_folder import how_ended
    from emg2vsa.worlds.bench.virtual_run import run_virtual

    try:
        started = datetime.fromisoformat(STARTED)
        ended = run_virtual(plan, rig, emulated, folder, started=started, effect=effect, actuator=actuator)
    except DeviceError as error:
        raise OSError(errno.EIO, str(error)) from error
    if ended.how == "interrupted":
        raise KeyboardInterrupt
    if ended.cause == "recording" or how_ended(folder) != ended.how:
        raise OSError(errno.EIO, ended.why or "; ".join(ended.notes))


STAGE = Stage(
    per="mounting", of="emulated rig", needs=("schedules",), run=run, loads=("emg2vsa.worlds.bench.virtual_run",),
    settings=emulation_settings, files=emulated_domes, takes=takes, folder=folder, alone_in=alone_in,
)  # fmt: skip
