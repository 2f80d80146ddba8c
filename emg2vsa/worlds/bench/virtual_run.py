"""A run on the emulated rig in virtual time: minutes in seconds, and the same inputs give the same bytes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.atomic import write_text_atomic
from casr.by_name import module_named
from casr.frame_files import write_camera
from casr.frame_files.folder import CAMERA_FILE
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.errors import DeviceError
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.executor.guards import GUARDS, Check
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.experiment import run_name
from emg2vsa.rig.plan import RIGID, RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.new_folder import EMULATED_FILE
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.controls import ArtificialEffect
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.truth import TRUTH_FILE, truth_text

if TYPE_CHECKING:
    from emg2vsa.rig.kappa.live_kappa import KappaPlan


def run_virtual(
    plan: RunPlan,
    rig: RigSettings,
    emulated: EmulatedSettings,
    folder: Path,
    *,
    started: datetime,
    run: str = "",
    mounted: str = "",
    effect: ArtificialEffect | None = None,
    kappa: KappaPlan | None = None,
    guards: Mapping[str, Check] = GUARDS,
    actuator: Any = None,
) -> Ended:
    """Carry out ``plan`` and record it in ``folder``, with the real executor and drivers; how it ended.

    ``folder`` also gets emulated.json, which marks a run that no hardware made, and the camera.toml of what
    rendered its frames. ``started`` : date and time to write to the run. ``run`` : other names, other draws, so that a
    run that goes on in another folder does not repeat its presses; the run's own where none is given. ``effect`` :
    artificial, of a control world. ``mounted`` : as in `PressDraws`. ``kappa`` : judge each press while it goes on.
    ``guards`` : as in `execute`. ``actuator`` : its settings; a qbmove where none are given.

    Raises as `execute`, and SettingError as `EmulatedRig`.
    """
    check_plan(plan, rig)
    if folder.exists() and any(folder.iterdir()):
        do = "Choose another; no run is ever overwritten."
        raise DeviceError(folder, wanted="a new folder, or an empty one", found="files in it", do=do)
    clock = VirtualClock()
    name = run or run_name(plan.specimen, plan.angle_deg, plan.condition, plan.mounting)
    bench = EmulatedRig(
        emulated,
        plan.specimen,
        plan.angle_deg,
        plan.condition == RIGID,
        clock,
        rig=rig,
        run=name,
        plate=plan.plate,
        mounting=plan.mounting,
        effect=effect,
        mounted=mounted,
        actuator=actuator,
    )
    folder.mkdir(parents=True, exist_ok=True)
    write_text_atomic(folder / EMULATED_FILE, json.dumps(emulated.document(), indent=2) + "\n")
    devices = bench.devices(exact=emulated.exact)
    if plan.plate:
        devices = replace(devices, camera=None)
    else:
        write_camera(folder / CAMERA_FILE, bench.camera.scene.settings.camera)
    judging = None if kappa is None else module_named("emg2vsa.rig.kappa.judges")  # most runs are judged by nobody
    judge = judging and judging.SameProcess(kappa, folder / judging.KAPPA_FILE)
    try:
        ended = execute(plan, rig, devices, folder, clock, started=started, judge=judge, guards=guards)
    finally:
        if judge is not None:
            judge.close()
    if judging is not None and judge is not None:
        judging.write_about(folder, kappa, judge.tally)
    if not plan.plate:
        write_text_atomic(folder / TRUTH_FILE, truth_text(bench.loadings()))
    return ended
