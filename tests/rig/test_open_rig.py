"""Opening a rig: the right actuator, the device's own limits, and everything closed whatever happens."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from emg2vsa.devices.clock import VirtualClock, WallClock
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.netft.driver import NetFt
from emg2vsa.devices.ni_daq import NiGaugeSettings
from emg2vsa.devices.opencv_camera import OpenCvSettings
from emg2vsa.devices.opencv_camera.driver import OpenCvCamera
from emg2vsa.devices.qbmove import MotorSettings, QbmoveSettings
from emg2vsa.devices.qbmove.driver import Qbmove, RigidMotor
from emg2vsa.devices.qbmove.info import QbmoveInfo
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.devices.serial_line import LoopbackLine, SerialLine
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.rig.open_rig import open_force, open_rig, within_device
from emg2vsa.rig.rig_settings import DeviceSettings, GuardSettings, RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig, EmulatedServers
from emg2vsa.worlds.bench.settings import EmulatedSettings

WIDE = {"position_deg": (-20000 * DEG_PER_TICK, 20000 * DEG_PER_TICK)}
PATIENT = RigSettings(guards=GuardSettings(stale_s=2.0, camera_s=5.0))
INFO = QbmoveInfo(
    firmware="QBMMP v6.1.0", device_id=1, max_stiffness_ticks=3000,
    position_limits_ticks=((-15000, 15000), (-15000, 15000)), resolutions=(1, 1, 1), control_mode="Position",
    input_mode="USB", current_limit_ma=1500, max_pwm_rate=None, voltage_mv=24000,
)  # fmt: skip


@pytest.fixture(scope="module")
def servers() -> Iterator[EmulatedServers]:
    with EmulatedServers(EmulatedRig(EmulatedSettings(), "S3", 0.0, False, WallClock())) as served:
        yield served


@pytest.fixture
def settings(servers: EmulatedServers) -> DeviceSettings:
    return DeviceSettings(
        actuator=QbmoveSettings(port=servers.port, reply_s=2.0),
        motor=MotorSettings(port=servers.port, reply_s=2.0),
        force=NetFtSettings(host="127.0.0.1", rdt_port=servers.force.rdt_port, http_port=servers.force.http_port),
        camera=OpenCvSettings(source=servers.camera_url, delay_s=0.03),
    )


class Watched:
    """Which devices were closed, in their order."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.closed: list[str] = []
        for kind in (SerialLine, OpenCvCamera, NetFt):
            self.watch(monkeypatch, kind, kind.__name__)

    def watch(self, monkeypatch: pytest.MonkeyPatch, kind: Any, name: str) -> None:
        close = kind.close

        def closing(device: Any) -> None:
            self.closed.append(name)
            close(device)

        monkeypatch.setattr(kind, "close", closing)


def refused(
    settings: DeviceSettings, said: str, error: type[Exception] = DeviceError, condition: Any = "modular"
) -> None:
    with pytest.raises(error, match=said), open_rig(settings, PATIENT, condition, WallClock()):
        pass


def test_the_devices_of_the_file_are_open_and_closed_again(
    settings: DeviceSettings, servers: EmulatedServers, monkeypatch: pytest.MonkeyPatch
) -> None:
    watched = Watched(monkeypatch)
    with open_rig(settings, PATIENT, "modular", WallClock()) as opened:
        assert opened.info.max_stiffness_ticks == 3000
        assert opened.rig == PATIENT
        assert opened.devices.camera is not None
        assert (opened.devices.camera.shape, opened.devices.camera.delay_s) == ((300, 300), 0.03)
        assert abs(opened.devices.force.read().force_n[2]) < 1.0
        board, force, camera = (opened.facts[name] for name in ("board", "force", "camera"))
        assert (board["firmware"], force["calibration_serial"]) == (opened.info.firmware, "FT00000")
        assert force["biased_by"] is None
        assert camera["set"] == {"exposure": None, "gain": None, "white_balance_k": None}  # a network camera
        assert list(camera) == [
            "source", "height", "width", "rate_hz", "delay_s", "lock", "exposure", "gain", "white_balance_k", "name",
            "set",
        ]  # fmt: skip
        json.dumps(opened.facts)
        opened.devices.actuator.activate()
        opened.devices.actuator.command(0.0, 0.5)
        assert watched.closed == []
    assert watched.closed == ["OpenCvCamera", "NetFt", "SerialLine"]
    assert servers.bench.answer(bytes.fromhex("3a3a 01 02 81 81")) == bytes.fromhex("3a3a 01 03 81 00 81")  # motors off


def test_high_stiffness_takes_the_rigid_motor(settings: DeviceSettings) -> None:
    with open_rig(replace(settings, camera=None), PATIENT, "high-stiffness", WallClock()) as opened:
        assert isinstance(opened.devices.actuator, RigidMotor)
        assert opened.devices.camera is None
    said = r"expected a table \[motor\] for high-stiffness, but found none"
    refused(replace(settings, motor=None), said, SettingError, "high-stiffness")


@pytest.mark.parametrize("absent", ["camera", "force", "actuator", "id"])
def test_what_was_open_is_closed_when_something_is_absent(
    absent: str, settings: DeviceSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    watched = Watched(monkeypatch)
    wrong = {
        "camera": replace(settings, camera=OpenCvSettings(source="/no/such/camera")),
        "force": replace(settings, force=replace(settings.force, http_port=1)),
        "actuator": replace(settings, actuator=QbmoveSettings(port="/dev/no-such-port")),
        "id": replace(settings, actuator=replace(settings.actuator, id=7, reply_s=0.01)),
    }[absent]
    wanted = {"camera": "frames a second", "force": "the box's configuration", "actuator": "a serial port"}
    refused(wrong, wanted.get(absent, "qbmove 7: expected a device that answers, but found no answer"))
    closed = {"camera": ["OpenCvCamera", "NetFt", "SerialLine"], "force": ["SerialLine"], "id": ["SerialLine"]}
    assert watched.closed == closed.get(absent, [])


@pytest.mark.parametrize("key", ["actuator.port", "force.host"])
def test_an_address_that_is_not_written_is_not_guessed(key: str, settings: DeviceSettings) -> None:
    table, name = key.split(".")
    bare = replace(settings, camera=None, **{table: replace(getattr(settings, table), **{name: None})})
    refused(bare, rf"{key}: expected the .*, but found none\. Write it into the rig file, or use", SettingError)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"model": "advanced"},
         'model: expected firmware of the advanced .*, but found QBMMP v6.1.0. Set model = "maker-pro"'),
        ({"generation": "v7", "reply_s": 0.1},
         'generation: expected firmware v7, but found QBMMP v6.1.0. Set generation = "v6"'),
    ],
)  # fmt: skip
def test_another_device_than_the_file_says_is_refused(
    change: dict[str, Any], said: str, settings: DeviceSettings
) -> None:
    refused(replace(settings, camera=None, actuator=replace(settings.actuator, **change)), said)


def test_an_error_of_the_run_closes_everything_too(settings: DeviceSettings, monkeypatch: pytest.MonkeyPatch) -> None:
    watched = Watched(monkeypatch)
    with pytest.raises(ZeroDivisionError), open_rig(settings, PATIENT, "modular", WallClock()):
        raise ZeroDivisionError
    assert watched.closed == ["OpenCvCamera", "NetFt", "SerialLine"]


def test_bias_makes_the_load_of_the_start_the_zero(settings: DeviceSettings, servers: EmulatedServers) -> None:
    servers.bench.box._bias = (0.0, 0.0, -5.0, 0.0, 0.0, 0.0)  # what the box takes off: it reads 5 N too much
    without_camera = replace(settings, camera=None)
    with open_rig(without_camera, PATIENT, "modular", WallClock()) as opened:
        assert opened.devices.force.read().force_n[2] == pytest.approx(5.0, abs=0.1)
    biased = replace(without_camera, force=replace(settings.force, bias=True))
    clock = WallClock()
    with open_rig(biased, PATIENT, "modular", clock) as opened:
        clock.sleep_until(clock.now_s() + 0.1)
        assert opened.devices.force.read().force_n[2] == pytest.approx(0.0, abs=0.1)


def test_a_card_without_its_calibration_is_told(tmp_path: Any) -> None:
    daq = NiGaugeSettings(channels="Dev1/ai0:5", cal_file=str(tmp_path / "none.cal"))
    with pytest.raises(DeviceError, match=r"none\.cal"):
        open_force(daq, GuardSettings(), WallClock())


@pytest.mark.parametrize(
    ("device", "rig", "rigid", "positions", "percent"),
    [
        ({}, {}, False, (-12000, 12000), (20.0, 80.0)),
        ({}, WIDE, False, (-12000, 12000), (20.0, 80.0)),
        ({}, WIDE, True, (-15000, 15000), (20.0, 80.0)),
        ({}, {"position_deg": (-100 * DEG_PER_TICK, 9000 * DEG_PER_TICK)}, False, (-100, 9000), (20.0, 80.0)),
        ({"max_stiffness_ticks": 2400}, WIDE, False, (-12600, 12600), (25.0, 80.0)),
        ({"max_stiffness_ticks": 4000}, WIDE, False, (-11000, 11000), (20.0, 60.0)),
    ],
)
def test_limits_are_the_device_s_and_no_wider_than_the_file_s(
    device: dict[str, Any], rig: dict[str, Any], rigid: bool, positions: tuple[int, int], percent: tuple[float, float]
) -> None:
    info = replace(INFO, **device)
    board = Qbmove(LoopbackLine("bench", bytes), 1, rigid=rigid, clock=VirtualClock())
    narrowed = within_device(RigSettings(**rig), board.usable(info))
    assert narrowed.position_deg == tuple(ticks * DEG_PER_TICK for ticks in positions)
    assert narrowed.stiffness_percent == pytest.approx(percent)
    assert narrowed.full_preset == info.max_stiffness_ticks * DEG_PER_TICK
