"""The bench: devices on one world, presses that differ, faults by name."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.devices.clock import VirtualClock, WallClock
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.netft.driver import open_net_ft
from emg2vsa.devices.opencv_camera.driver import OpenCvCamera
from emg2vsa.devices.protocols import Devices
from emg2vsa.devices.qbmove import BAUD
from emg2vsa.devices.qbmove.driver import Qbmove, RigidMotor
from emg2vsa.devices.qbmove.springs import SPRINGS
from emg2vsa.devices.registry import Around
from emg2vsa.devices.serial_line import LoopbackLine, SerialLine
from emg2vsa.errors import DeviceError
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.press_counts import BUSY
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig, EmulatedServers
from emg2vsa.worlds.bench.faults import faults_of, help_text, put
from emg2vsa.worlds.bench.press_draws import PressDraws
from emg2vsa.worlds.bench.settings import EmulatedSettings

MAKER_PRO = SPRINGS["qbmove-maker-pro"]
ELASTIC = EmulatedSettings(world="elastic")


@pytest.fixture
def bench() -> EmulatedRig:
    return EmulatedRig(ELASTIC, "S1", 0.0, False, VirtualClock())


def press_to(bench: EmulatedRig, devices: Devices, depth_mm: float) -> float:
    """Force, N, a second after the probe was sent there."""
    for _ in range(10):
        devices.actuator.command(RigSettings().position_at(depth_mm), 0.0 if bench.rigid else 0.5)
        bench.clock.sleep_until(bench.clock.now_s() + 0.1)
        assert devices.camera
        devices.camera.frames()
    return float(devices.force.read().force_n[2])


def draws(**changes: object) -> PressDraws:
    return PressDraws(EmulatedSettings(**{"world": "elastic"} | changes), "S1", 30.0, MAKER_PRO, RigSettings(), "run")  # type: ignore[arg-type]


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, -0.6, 0.8), (0, 0, -1), (0.04, 0, -0.999), (0, 0, -0.9995), (1, 0, 0)])
def test_the_push_is_felt_along_the_axis_of_the_rig_file(axis: tuple[float, float, float]) -> None:
    bench = EmulatedRig(EmulatedSettings(), "S1", 30.0, True, VirtualClock(), rig=RigSettings(push_axis=axis))
    turned = bench._mounting
    np.testing.assert_allclose(turned.T @ turned, np.eye(3), atol=1e-12)
    assert np.linalg.det(turned) == pytest.approx(1)
    np.testing.assert_allclose(turned[:, 2], np.array(axis) / np.linalg.norm(axis), atol=1e-12)


def test_presses_differ_and_come_again() -> None:
    settings = ELASTIC
    worlds = [draws().world(press) for press in range(50)]
    assert worlds == [draws().world(press) for press in range(50)]
    assert len({world.angle_deg for world in worlds}) == 1
    assert worlds[0] != PressDraws(settings, "S1", 30.0, MAKER_PRO, RigSettings(), "another run").world(0)
    stiffness = np.array([world.stiffness_n_per_mm for world in worlds])
    assert np.std(stiffness / 7.63) == pytest.approx(settings.stiffness_sd, rel=0.3)
    assert np.abs(stiffness / 7.63 - 1).max() == pytest.approx(2 * settings.stiffness_sd)
    assert np.std([world.gap_mm for world in worlds]) == pytest.approx(settings.gap_sd_mm, rel=0.3)
    assert draws().scene(0).centre_px != draws().scene(1).centre_px


def test_without_spread_all_presses_are_alike() -> None:
    still = draws(stiffness_sd=0.0, gap_sd_mm=0.0, angle_sd_deg=0.0, landing_sd_mm=0.0)
    assert still.world(0) == still.world(7)
    assert (still.world(0).angle_deg, still.scene(0).centre_px) == (30.0, still.scene(7).centre_px)


def test_the_next_press_begins_when_the_probe_is_off_the_specimen(bench: EmulatedRig) -> None:
    devices = bench.devices()
    devices.actuator.activate()
    first, seen = bench.world.settings, bench.camera.scene
    assert press_to(bench, devices, 4.5) > 1
    assert bench.world.settings is first
    assert press_to(bench, devices, 2.5) == pytest.approx(0, abs=0.1)  # half a millimetre off is not away
    assert bench.world.press == 0
    press_to(bench, devices, 0.0)
    assert bench.world.press == 1
    assert bench.world.settings != first
    assert bench.camera.scene is not seen
    assert bench.camera.scene.settings.stiffness_n_per_mm == bench.world.settings.stiffness_n_per_mm
    press_to(bench, devices, 0.0)
    assert bench.world.press == 1


@pytest.mark.parametrize("rigid", [False, True])
def test_the_other_board_presses_nothing(rigid: bool) -> None:
    bench = EmulatedRig(EmulatedSettings(), "S1", 0.0, rigid, VirtualClock())
    board = Qbmove(LoopbackLine("other bus", bench.idle, bench.clock), 1, clock=bench.clock)
    other = board if rigid else RigidMotor(board)
    devices = bench.devices()
    other.activate()
    other.command(RigSettings().position_at(6.0), 0.5 if rigid else 0.0)
    bench.clock.sleep_until(bench.clock.now_s() + 0.4)
    assert RigSettings().depth_at(other.measurements().shaft_deg) == pytest.approx(6.0, abs=0.3)
    assert abs(devices.force.read().force_n[2]) < 0.1


def test_frames_are_drawn_when_looked_at(bench: EmulatedRig, monkeypatch: pytest.MonkeyPatch) -> None:
    devices = bench.devices()
    assert devices.camera
    scene, drawn = bench.camera.scene, []
    image = type(scene).image
    monkeypatch.setattr(type(scene), "image", lambda self, *of: drawn.append(of) or image(self, *of))
    bench.clock.sleep_until(bench.clock.now_s() + 0.12)
    frames = devices.camera.frames()
    assert (len(frames), drawn) == (3, [])
    assert frames[2].image is frames[2].image
    assert [(state.normal_n, number) for state, number in drawn] == [(0.0, 2)]
    np.testing.assert_array_equal(frames[0].image, scene.image(0.0, 0))


def test_every_fault_has_its_effect(bench: EmulatedRig) -> None:
    box, camera, wire = bench.box.faults, bench.camera.faults, bench.wire
    for words in ("mute", "gap 3", "skip 7", "stuck on", "saturated", "silent on", "drop 2", "dark"):
        put(bench, words)
    assert (wire.mute, box.lose, box.skip, box.stuck, box.saturated, box.mute) == (True, 3, 7, True, True, True)
    assert (camera.drop, camera.mute) == (2, True)
    put(bench, "stuck off")
    assert (box.stuck, box.mute) == (False, True)
    assert put(bench, "off") == "all faults off"
    assert not any((wire.mute, box.stuck, box.saturated, box.mute, camera.mute))


def test_faults_of_the_actuator_by_name(bench: EmulatedRig) -> None:
    ping = bytes.fromhex("3a3a 01 02 00 00")
    put(bench, "lose 2")
    assert bench.answer(ping) == ping[:-2]
    put(bench, "corrupt")
    assert bench.answer(ping) == ping[:-1] + b"\xff"
    actuator = bench.devices().actuator
    actuator.activate()
    put(bench, "reset")
    assert not actuator.is_active()
    put(bench, "mute on")
    with pytest.raises(DeviceError):
        actuator.is_active()


def test_help_names_every_fault(bench: EmulatedRig) -> None:
    assert all(f"  {name}" in help_text(bench) for name in (*faults_of(bench), "off", "quit"))


def test_a_press_in_real_time(plan: Callable[..., RunPlan], tmp_path: Path) -> None:
    """The rigid motor over real ports; a machine with other work must not trip the guards."""
    guards = GuardSettings(force_n=250, force_rate_n_per_s=1e5, stale_s=20, late_s=20, camera_s=20)
    rig = RigSettings(guards=guards)
    clock = WallClock()
    with EmulatedServers(EmulatedRig(EmulatedSettings(gap_mm=2.0), "S1", 0.0, True, clock, rig=rig)) as servers:
        force = open_net_ft(
            NetFtSettings(host="127.0.0.1", rdt_port=servers.force.rdt_port, http_port=servers.force.http_port),
            Around(clock, 4),
        )
        camera = OpenCvCamera(servers.camera_url, clock, lost_s=20)
        line = SerialLine(servers.port, BAUD)
        board = RigidMotor(Qbmove(line, 1, clock=clock, watchdog_s=5.0, reply_s=4.0))
        force.start()
        camera.start()
        fast = plan("high-stiffness", specimen="S1", repetitions=1, f_max_n=3.0, ramp_mm_per_s=20.0, pause_s=0.0)
        started = datetime(2026, 3, 1, tzinfo=UTC)
        ended = execute(fast, rig, Devices(board, force, camera), tmp_path / "run", clock, started=started)
        camera.close()
        force.close()
        line.close()
    assert (ended.repetitions_done, ended.deactivated) == (1, True), ended.why
    assert ended.how == "completed" or BUSY in ended.why, ended.why
    assert (tmp_path / "run" / "press-001" / "frames.tif").stat().st_size > 90_000
