"""A whole run on the virtual clock: executor, drivers, bytes, emulated devices and the one world behind them."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from casr.frame_files import open_frames
from casr.score import score
from casr.synthetic import SPECIMENS, PressSettings, Scene
from emg2vsa.rig.clock import VirtualClock
from emg2vsa.rig.datagrams import LoopbackDatagrams
from emg2vsa.rig.devices import Devices
from emg2vsa.rig.emulated.camera import EmulatedCamera
from emg2vsa.rig.emulated.qbmove_firmware import QbmoveFirmware
from emg2vsa.rig.emulated.qbmove_switches import MAKER_PRO
from emg2vsa.rig.emulated.rdt_box import BoxSettings, RdtBox
from emg2vsa.rig.emulated.rdt_pages import configuration_page
from emg2vsa.rig.emulated.world import World
from emg2vsa.rig.emulated.world_settings import WorldSettings
from emg2vsa.rig.execute import execute
from emg2vsa.rig.net_ft import NetFt
from emg2vsa.rig.netft_config import parse_config
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.qbmove import Qbmove
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.rig.transport import LoopbackLine

STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)


def emulated(specimen: str) -> tuple[VirtualClock, Devices]:
    """Started devices on one world."""
    clock = VirtualClock()
    world = World(clock, WorldSettings(stiffness_n_per_mm=SPECIMENS[specimen]))
    firmware = QbmoveFirmware(MAKER_PRO, world, clock)

    def wrench(time_s: float) -> np.ndarray:
        firmware.advance()
        return np.append(world.force_n(time_s), np.zeros(3))

    box = RdtBox(wrench, BoxSettings())
    force = NetFt(LoopbackDatagrams("box", box, clock), parse_config(configuration_page(box)), clock)
    scene = Scene(PressSettings(stiffness_n_per_mm=SPECIMENS[specimen]))
    camera = EmulatedCamera(scene, world.normal_force_n, clock)
    force.start()
    camera.start()
    return clock, Devices(Qbmove(LoopbackLine("bus", firmware, clock), 1, clock=clock), force, camera)


def test_a_run_is_completed_and_its_presses_can_be_scored(plan_of: Callable[..., RunPlan], tmp_path: Path) -> None:
    rates = []
    for specimen in ("S1", "S5"):
        clock, devices = emulated(specimen)
        plan = plan_of(angle_deg=0.0, repetitions=2, f_max_n=5.0)
        ended = execute(plan, RigSettings(), devices, tmp_path / specimen, clock, started=STARTED)
        assert (ended.how, ended.repetitions_done, ended.deactivated) == ("completed", 2, True), ended.why
        assert not devices.actuator.is_active()
        presses = sorted((tmp_path / specimen).glob("press-*"))
        assert len(presses) == 2
        scores = [score(open_frames(press)) for press in presses]
        rates.append(np.mean([found.rate.value for found in scores if found.rate is not None]))
        assert all(found.force_n is not None and found.force_n[-1] > 4.5 for found in scores)
    assert rates[1] > 1.2 * rates[0]  # the softer specimen spreads faster
