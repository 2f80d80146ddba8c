"""A device that is not the one of its table is refused before anything moves; exchanged ports are called so."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.opencv_camera import OpenCvSettings
from emg2vsa.devices.qbmove import MotorSettings, QbmoveSettings
from emg2vsa.devices.serial_line import adapter_number
from emg2vsa.errors import DeviceError
from emg2vsa.rig.open_rig import open_board, open_own_board, open_rig
from emg2vsa.rig.rig_settings import DeviceSettings, GuardSettings, RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig, EmulatedServers
from emg2vsa.worlds.bench.settings import EmulatedSettings

OWN, MOTORS, SENSORS = "0000000017", "0000000018", "FT12345"
NUMBERS = {"actuator": OWN, "motor": MOTORS, "force": SENSORS}
RIG = RigSettings(guards=GuardSettings(stale_s=2.0, camera_s=5.0))
EXCHANGED = "The ports of [actuator] and [motor] are exchanged: exchange them in rig.toml."
Change = Callable[[DeviceSettings], DeviceSettings]


@pytest.fixture(scope="module")
def servers() -> Iterator[EmulatedServers]:
    bench = EmulatedRig(EmulatedSettings(), "S3", 0.0, False, WallClock(), numbers=NUMBERS)
    with EmulatedServers(bench) as served:
        yield served


@pytest.fixture
def devices(servers: EmulatedServers) -> DeviceSettings:
    force = servers.force
    return DeviceSettings(
        actuator=QbmoveSettings(port=servers.port, reply_s=2.0, serial_number=OWN),
        motor=MotorSettings(port=servers.idle_port, reply_s=2.0, serial_number=MOTORS),
        force=NetFtSettings(
            host="127.0.0.1", rdt_port=force.rdt_port, http_port=force.http_port, serial_number=SENSORS
        ),
    )


def exchanged(devices: DeviceSettings) -> DeviceSettings:
    actuator, motor = devices.actuator, devices.motor
    assert motor
    ports = motor.port, actuator.port
    return replace(devices, actuator=replace(actuator, port=ports[0]), motor=replace(motor, port=ports[1]))


def with_number(table: str, number: str | None) -> Change:
    return lambda devices: replace(devices, **{table: replace(getattr(devices, table), serial_number=number)})


def refusal(devices: DeviceSettings, condition: Any) -> str:
    with pytest.raises(DeviceError) as refused, open_rig(devices, RIG, condition, WallClock()):
        pass
    return str(refused.value)


@pytest.mark.parametrize("condition", ["modular", "high-stiffness"])
def test_the_devices_of_the_file_are_taken_and_their_numbers_recorded(devices: DeviceSettings, condition: Any) -> None:
    table = "motor" if condition == "high-stiffness" else "actuator"
    with open_rig(devices, RIG, condition, WallClock()) as opened:
        told = {name: each["number"] for name, each in opened.facts["serial_numbers"].items()}
    assert told == {table: NUMBERS[table], "force": SENSORS}


@pytest.mark.parametrize(
    ("change", "condition", "said"),
    [
        (exchanged, "modular", f"{OWN}, but found serial number {MOTORS}, told by the device. {EXCHANGED}"),
        (exchanged, "high-stiffness", f"{MOTORS}, but found serial number {OWN}, told by the device. {EXCHANGED}"),
        (lambda devices: with_number("actuator", None)(exchanged(devices)), "modular",
         f"expected another device than that of [motor], but found serial number {MOTORS}, told by the device. "
         f"{EXCHANGED}"),
        (with_number("actuator", "0000000099"), "modular",
         f"serial number 0000000099, but found serial number {OWN}, told by the device. Check port and cable"),
        (with_number("force", "FT1"), "modular", f"serial number FT1, but found serial number {SENSORS}, told by"),
    ],
)  # fmt: skip
def test_another_device_is_refused_before_it_is_switched(
    devices: DeviceSettings, monkeypatch: pytest.MonkeyPatch, change: Change, condition: Any, said: str
) -> None:
    for place in ("qbmove.driver.Qbmove.activate", "qbmove.driver.Qbmove._tell_ticks", "netft.driver.NetFt.start"):
        monkeypatch.setattr(f"emg2vsa.devices.{place}", lambda device, *given: pytest.fail("used"))
    found = refusal(change(devices), condition)
    assert said in found
    assert found.startswith("[")


def test_a_camera_tells_none(devices: DeviceSettings, servers: EmulatedServers) -> None:
    camera = OpenCvSettings(source=servers.camera_url, serial_number="1")
    said = "expected serial number 1, but found no serial number. Leave serial_number out: a device of this kind tells"
    assert said in refusal(replace(devices, camera=camera), "modular")


def test_the_number_of_the_adapter_counts_where_the_device_tells_none(
    devices: DeviceSettings, servers: EmulatedServers, monkeypatch: pytest.MonkeyPatch
) -> None:
    ports = [SimpleNamespace(device=servers.idle_port, serial_number=None),
             SimpleNamespace(device=servers.port, serial_number="FT9XYZ")]  # fmt: skip
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: ports)
    assert [adapter_number(port) for port in (servers.port, servers.idle_port, "/dev/none")] == ["FT9XYZ", "", ""]
    monkeypatch.setattr("emg2vsa.devices.qbmove.driver.Qbmove.serial_number", lambda board: "")
    of_adapter = with_number("actuator", "FT9XYZ")(devices)
    with open_rig(of_adapter, RIG, "modular", WallClock()) as opened:
        assert opened.numbers["actuator"].text == "serial number FT9XYZ, told by its USB adapter"
    assert "but found serial number FT9XYZ, told by its USB adapter" in refusal(devices, "modular")
    assert "but found no serial number. Leave" in refusal(devices, "high-stiffness")


def test_ports_are_called_exchanged_by_what_devices_say_where_there_are_no_numbers(devices: DeviceSettings) -> None:
    bare = with_number("motor", None)(with_number("actuator", None)(devices))
    assert bare.motor
    one, two = replace(bare.actuator, reply_s=0.3), replace(bare.motor, reply_s=0.3)
    hint = f"Or t{EXCHANGED[1:]}"
    # an actuator of id 2 at the port of [motor]: nobody answers to it there, but [motor]'s id does
    wrong_id = replace(bare, actuator=replace(one, id=2, port=two.port), motor=replace(two, port=one.port))
    assert hint in refusal(wrong_id, "modular")
    servo = DynamixelSettings(kind="dynamixel", port=two.port, reply_s=0.1)
    assert hint in refusal(replace(wrong_id, actuator=servo), "modular")
    # nobody answers in the words of either table
    assert hint not in refusal(replace(wrong_id, motor=replace(two, port=one.port, id=9)), "modular")
    # one port for both cannot be exchanged
    assert hint not in refusal(replace(wrong_id, motor=replace(two, port=two.port)), "modular")


def test_motors_of_any_device_can_be_switched_off(devices: DeviceSettings) -> None:
    wrong = with_number("actuator", "0000000099")(devices)
    with closing(open_board(wrong.actuator, RIG, WallClock())) as board:
        board.deactivate()
    with pytest.raises(DeviceError, match="0000000099"):
        open_own_board(wrong, "modular", RIG, WallClock())
