"""The public SDK of the maker as the client, over a pseudo-terminal."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import pytest

from emg2vsa.devices.clock import WallClock
from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.firmware import DynamixelFirmware
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W350
from emg2vsa.worlds.far_ends.ports import VirtualSerialPort

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
ID = 1
PATIENCE_MS = 500
"""In place of the SDK's 16 ms for a USB bridge, so that a busy machine fails no test."""


class _Shaft:
    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        return motors_rad[0]


class Client:
    """SDK, port and what is at its other end."""

    def __init__(self, port: Any, motor: DynamixelFirmware, sdk: Any) -> None:
        self.port, self.motor, self.sdk = port, motor, sdk
        self.handler = sdk.PacketHandler(2.0)

    def write(self, address: int, value: int, size: int = 1) -> int:
        result, error = getattr(self.handler, f"write{size}ByteTxRx")(self.port, ID, address, value)
        assert result == self.sdk.COMM_SUCCESS, self.handler.getTxRxResult(result)
        return int(error)

    def read(self, address: int, size: int = 1) -> int:
        value, result, error = getattr(self.handler, f"read{size}ByteTxRx")(self.port, ID, address)
        assert (result, error) == (self.sdk.COMM_SUCCESS, 0), self.handler.getTxRxResult(result)
        return int(value)


@pytest.fixture
def client(monkeypatch: pytest.MonkeyPatch) -> Iterator[Client]:
    sdk = import_module("dynamixel_sdk")
    monkeypatch.setattr("dynamixel_sdk.port_handler.LATENCY_TIMER", PATIENCE_MS)
    clock = WallClock()
    motor = DynamixelFirmware(XM430_W350, _Shaft(), clock, motor_id=ID, home_deg=180.0)
    with VirtualSerialPort(motor, lambda: motor.due_s - clock.now_s()) as virtual:
        port = sdk.PortHandler(virtual.name)
        assert port.openPort()
        assert port.setBaudRate(1_000_000)
        yield Client(port, motor, sdk)
        port.closePort()


def test_a_ping_finds_it_and_nobody_else(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    assert client.handler.ping(client.port, ID) == (1020, 0, 0)
    found, result = client.handler.broadcastPing(client.port)
    assert (found, result) == ({ID: [1020, 45]}, client.sdk.COMM_SUCCESS)
    monkeypatch.setattr("dynamixel_sdk.port_handler.LATENCY_TIMER", 16)
    _, result, _ = client.handler.ping(client.port, 3)
    assert client.handler.getTxRxResult(result) == "[TxRxResult] There is no status packet!"


def test_reads_and_writes_of_all_sizes(client: Client) -> None:
    assert client.read(t.TEMPERATURE_LIMIT) == 80
    assert client.read(t.CURRENT_LIMIT, 2) == 1193
    assert client.read(t.PRESENT_POSITION, 4) == 2048
    assert client.write(t.LED, 1) == 0
    assert client.read(t.LED) == 1
    assert client.write(t.POSITION_P, 640, 2) == 0
    assert client.read(t.POSITION_P, 2) == 640
    assert client.write(t.OPERATING_MODE, 5) == 0
    assert client.write(t.GOAL_POSITION, -131073, 4) == 0, "stuffed both ways"
    assert client.read(t.GOAL_POSITION, 4) == 2**32 - 131073


def test_errors_are_named_as_the_sdk_names_them(client: Client) -> None:
    said = client.handler.getRxPacketError
    assert "out of range" in said(client.write(t.POSITION_P, 20000, 2))
    assert client.write(t.CURRENT_LIMIT, 100, 2) == 0
    assert "exceeds the limit" in said(client.write(t.GOAL_CURRENT, 101, 2))
    assert "length does not match" in said(client.write(t.GOAL_POSITION, 5, 2))
    assert "not available" in said(client.write(t.PRESENT_POSITION, 5, 4))
    assert client.write(t.TORQUE_ENABLE, 1) == 0
    assert "not available" in said(client.write(t.OPERATING_MODE, 5)), "EEPROM is locked"
    client.motor.motor.faults.temperature_c = 99
    time.sleep(0.01)
    assert "Hardware error" in said(client.write(t.LED, 1))


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
