"""The emulated qbmove on a port of the operating system, with pyserial at the other end."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import serial

from emg2vsa.devices.clock import VirtualClock, WallClock
from emg2vsa.devices.qbmove import BAUD, Generation
from emg2vsa.devices.qbmove.conversation import answers
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.serial_line import SerialLine
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.ports import VirtualSerialPort
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware
from emg2vsa.worlds.far_ends.qbmove.memory import MAKER_PRO
from tests.devices.qbmove.firmware_v7 import MAKER_PRO_V7, QbmoveFirmwareV7


class Free:
    """A shaft that stays halfway between its motors."""

    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        return sum(motors_rad) / 2


@pytest.fixture
def port() -> Iterator[str]:
    with VirtualSerialPort(QbmoveFirmware(MAKER_PRO, Free(), WallClock())) as virtual:
        yield virtual.name


def test_a_plain_client_sends_and_receives_bytes(port: str) -> None:
    with serial.Serial(port, 2_000_000, timeout=60) as client:
        client.write(bytes.fromhex("3a3a 01 02 84 84"))
        assert client.read(12) == bytes.fromhex("3a3a 01 08 84 0000 0000 0000 84")
        client.write(bytes.fromhex("3a3a 01 02 00 00") * 5)
        assert client.read(30) == bytes.fromhex("3a3a 01 02 00 00") * 5


def test_every_byte_value_passes_unchanged(port: str) -> None:
    # a terminal that is not raw would translate 0d, echo, or stop at 13
    with serial.Serial(port, 2_000_000, timeout=60) as client:
        client.write(bytes(range(256)).replace(b":", b"") + bytes.fromhex("3a3a 01 02 00 00"))
        assert client.read(6) == bytes.fromhex("3a3a 01 02 00 00")
        client.write(bytes.fromhex("3a3a 01 04 0c 0000 0c"))
        assert len(client.read(4 + 1201)) == 4 + 1201


@pytest.mark.parametrize("generation", ["v6", "v7"])
def test_the_driver_runs_over_the_port(generation: Generation) -> None:
    clock = WallClock()
    old = QbmoveFirmware(MAKER_PRO, Free(), clock)
    device = old if generation == "v6" else QbmoveFirmwareV7(MAKER_PRO_V7, Free(), clock)
    with VirtualSerialPort(device) as virtual:
        line = SerialLine(virtual.name, BAUD)
        with Qbmove(line, 1, generation=generation, clock=clock, watchdog_s=5.0, reply_s=2.0) as qbmove:
            qbmove.activate()
            assert qbmove.info().max_stiffness_ticks == 3000
            assert len(qbmove.parameters()) >= 13
            qbmove.command(0.0, 0.5)
            clock.sleep_until(clock.now_s() + 0.3)
            assert qbmove.ticks()[:2] == pytest.approx((1500, -1500), abs=8)
        assert not qbmove.is_active()
        line.close()


def test_scan_finds_the_device_and_clients_may_come_and_go(port: str) -> None:
    for _ in range(2):
        line = SerialLine(port, BAUD)
        assert list(answers(line, WallClock(), [1], 2.0)) == ["id 1"]
        line.close()


def test_a_port_that_goes_away_is_told_in_words() -> None:
    with VirtualSerialPort(QbmoveFirmware(MAKER_PRO, Free(), VirtualClock())) as virtual:
        line = SerialLine(virtual.name, BAUD)
        assert Qbmove(line, 1, clock=WallClock(), reply_s=2.0).answers()
    with pytest.raises(DeviceError, match="expected a line that answers"):
        Qbmove(line, 1, clock=WallClock(), reply_s=2.0).answers()
    line.close()


def test_a_port_that_is_not_there_is_told_in_words() -> None:
    with pytest.raises(DeviceError, match="Check cable, power and permission"):
        SerialLine("/dev/no-such-port", BAUD)


def test_a_port_in_use_is_told_so(port: str) -> None:
    line = SerialLine(port, BAUD)
    with pytest.raises(DeviceError, match="expected a free serial port, but found one that another program uses"):
        SerialLine(port, BAUD)
    line.close()
