"""The public SDK of the maker as the client, over a pseudo-terminal."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import pytest
from emg2vsa.worlds.far_ends.dynamixel.bus import Bus

from emg2vsa.devices.clock import WallClock
from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.firmware import BOOT_S, DynamixelFirmware
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W210, XM430_W350
from emg2vsa.worlds.far_ends.ports import VirtualSerialPort

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
ID, OTHER = 1, 2
PATIENCE_MS = 500
"""In place of the SDK's 16 ms for a USB bridge, so that a busy machine fails no test."""


class _Shaft:
    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        return motors_rad[0]


class Client:
    """SDK, port and what is at its other end."""

    def __init__(self, port: Any, motors: tuple[DynamixelFirmware, ...], sdk: Any) -> None:
        self.port, self.motors, self.sdk = port, motors, sdk
        self.handler = sdk.PacketHandler(2.0)

    def write(self, address: int, value: int, size: int = 1, motor: int = ID) -> int:
        method = getattr(self.handler, f"write{size}ByteTxRx")
        result, error = method(self.port, motor, address, value)
        assert result == self.sdk.COMM_SUCCESS, self.handler.getTxRxResult(result)
        return int(error)

    def read(self, address: int, size: int = 1, motor: int = ID) -> int:
        value, result, error = getattr(self.handler, f"read{size}ByteTxRx")(self.port, motor, address)
        assert (result, error) == (self.sdk.COMM_SUCCESS, 0), self.handler.getTxRxResult(result)
        return int(value)


@pytest.fixture
def client(monkeypatch: pytest.MonkeyPatch) -> Iterator[Client]:
    sdk = import_module("dynamixel_sdk")
    monkeypatch.setattr("dynamixel_sdk.port_handler.LATENCY_TIMER", PATIENCE_MS)
    clock = WallClock()
    motors = (
        DynamixelFirmware(XM430_W350, _Shaft(), clock, motor_id=ID, home_deg=180.0),
        DynamixelFirmware(XM430_W210, _Shaft(), clock, motor_id=OTHER, home_deg=90.0),
    )
    bus = Bus(clock, motors)
    with VirtualSerialPort(bus, lambda: bus.due_s - clock.now_s()) as virtual:
        port = sdk.PortHandler(virtual.name)
        assert port.openPort()
        assert port.setBaudRate(1_000_000)
        yield Client(port, motors, sdk)
        port.closePort()


def test_ping_finds_each_and_all(client: Client) -> None:
    assert client.handler.ping(client.port, ID) == (1020, 0, 0)
    assert client.handler.ping(client.port, OTHER) == (1030, 0, 0)
    found, result = client.handler.broadcastPing(client.port)
    assert result == client.sdk.COMM_SUCCESS
    assert found == {ID: [1020, 45], OTHER: [1030, 45]}


def test_nobody_answers_for_an_id_that_is_not_there(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dynamixel_sdk.port_handler.LATENCY_TIMER", 16)
    _, result, _ = client.handler.ping(client.port, 3)
    assert client.handler.getTxRxResult(result) == "[TxRxResult] There is no status packet!"


def test_reads_and_writes_of_all_sizes(client: Client) -> None:
    assert client.read(t.TEMPERATURE_LIMIT) == 80
    assert client.read(t.CURRENT_LIMIT, 2) == 1193
    assert client.read(t.PRESENT_POSITION, 4) == 2048
    assert client.read(t.PRESENT_POSITION, 4, OTHER) == 1024
    assert client.write(65, 1) == 0
    assert client.read(65) == 1
    assert client.write(t.POSITION_P, 640, 2) == 0
    assert client.read(t.POSITION_P, 2) == 640
    assert client.write(t.OPERATING_MODE, 5) == 0
    assert client.write(t.GOAL_POSITION, -131073, 4) == 0, "stuffed both ways"
    assert client.read(t.GOAL_POSITION, 4) == 2**32 - 131073


def test_errors_are_named_as_the_sdk_names_them(client: Client) -> None:
    said = client.handler.getRxPacketError
    assert "out of range" in said(client.write(t.POSITION_P, 20000, 2))
    assert "exceeds the limit" in said(client.write(t.GOAL_POSITION, 5000, 4))
    assert "length does not match" in said(client.write(t.GOAL_POSITION, 5, 2))
    assert "not available" in said(client.write(t.PRESENT_POSITION, 5, 4))
    assert client.write(t.TORQUE_ENABLE, 1) == 0
    assert "not available" in said(client.write(t.OPERATING_MODE, 5)), "EEPROM is locked"
    client.motors[0].motor.faults.temperature_c = 99
    time.sleep(0.01)
    assert "Hardware error" in said(client.write(65, 1))


def test_sync_write_and_both_sync_reads(client: Client) -> None:
    sdk = client.sdk
    assert client.write(t.OPERATING_MODE, 5) == client.write(t.OPERATING_MODE, 5, 1, OTHER) == 0
    group = sdk.GroupSyncWrite(client.port, client.handler, t.GOAL_POSITION, 4)
    for motor, goal in ((ID, 2100), (OTHER, -131073)):
        assert group.addParam(motor, goal.to_bytes(4, "little", signed=True))
    assert group.txPacket() == sdk.COMM_SUCCESS
    reader = sdk.GroupSyncRead(client.port, client.handler, t.GOAL_POSITION, 4)
    assert reader.addParam(ID)
    assert reader.addParam(OTHER)
    for read in (reader.txRxPacket, reader.fastSyncRead):
        assert read() == sdk.COMM_SUCCESS
        assert reader.getData(ID, t.GOAL_POSITION, 4) == 2100
        assert reader.getData(OTHER, t.GOAL_POSITION, 4) == 2**32 - 131073


def test_bulk_write_and_both_bulk_reads(client: Client) -> None:
    sdk = client.sdk
    group = sdk.GroupBulkWrite(client.port, client.handler)
    assert group.addParam(ID, t.POSITION_P, 2, (321).to_bytes(2, "little"))
    assert group.addParam(OTHER, 65, 1, b"\x01")
    assert group.txPacket() == sdk.COMM_SUCCESS
    reader = sdk.GroupBulkRead(client.port, client.handler)
    assert reader.addParam(ID, t.POSITION_P, 2)
    assert reader.addParam(OTHER, 65, 1)
    for read in (reader.txRxPacket, reader.fastBulkRead):
        assert read() == sdk.COMM_SUCCESS
        assert (reader.getData(ID, t.POSITION_P, 2), reader.getData(OTHER, 65, 1)) == (321, 1)


def test_reg_write_waits_for_action(client: Client) -> None:
    result, error = client.handler.regWriteTxRx(client.port, ID, 65, 1, [1])
    assert (result, error) == (client.sdk.COMM_SUCCESS, 0)
    assert client.read(65) == 0
    assert client.read(t.REGISTERED) == 1
    assert client.handler.action(client.port, client.sdk.BROADCAST_ID) == client.sdk.COMM_SUCCESS
    assert client.read(65) == 1
    assert client.read(t.REGISTERED) == 0


def test_reboot_factory_reset_and_clear(client: Client) -> None:
    handler, port, done = client.handler, client.port, (client.sdk.COMM_SUCCESS, 0)
    assert client.write(t.OPERATING_MODE, 5) == client.write(65, 1) == 0
    assert handler.clearMultiTurn(port, ID) == done
    assert handler.reboot(port, ID) == done
    time.sleep(BOOT_S + 0.05)
    assert client.read(65) == 0
    assert client.read(t.OPERATING_MODE) == 5
    assert handler.factoryReset(port, ID, 0x02) == done
    time.sleep(BOOT_S + 0.05)
    assert client.read(t.OPERATING_MODE) == 3


def test_torque_on_moves_it_to_the_goal(client: Client) -> None:
    assert client.write(t.OPERATING_MODE, 5) == client.write(t.TORQUE_ENABLE, 1) == 0
    assert client.write(t.GOAL_POSITION, 2148, 4) == 0
    until_s = time.monotonic() + 10
    while client.read(t.PRESENT_POSITION, 4) < 2100:
        assert time.monotonic() < until_s
    assert client.write(t.TORQUE_ENABLE, 0) == 0


def test_the_watchdog(client: Client) -> None:
    """0.5 s, of which a busy machine takes no more than a part between two questions."""
    assert client.write(t.TORQUE_ENABLE, 1) == client.write(t.BUS_WATCHDOG, 25) == 0
    for _ in range(8):
        time.sleep(0.08)
        assert client.read(t.BUS_WATCHDOG) == 25
    time.sleep(0.6)
    assert client.read(t.BUS_WATCHDOG) == 255
    assert "out of range" in client.handler.getRxPacketError(client.write(t.GOAL_POSITION, 2000, 4))
    assert client.write(t.BUS_WATCHDOG, 0) == 0
    assert client.write(t.GOAL_POSITION, 2000, 4) == 0
