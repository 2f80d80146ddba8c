"""Noise without an end on the wire of a device ends as a lost device, and never as a wait without an end."""

from __future__ import annotations

import contextlib
import os
import random
import select
import socket
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from threading import Event, Thread
from typing import Any

import pytest

from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.devices.dynamixel.conversation import answers as dynamixels
from emg2vsa.devices.dynamixel.driver import Dynamixel
from emg2vsa.devices.netft.box import NetFtConfig
from emg2vsa.devices.netft.datagrams import UdpLine
from emg2vsa.devices.netft.driver import NetFt
from emg2vsa.devices.qbmove import BAUD
from emg2vsa.devices.qbmove.conversation import answers as qbmoves
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.serial_line import SerialLine
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.bench.world import World
from emg2vsa.worlds.far_ends.faults import FaultyWire
from emg2vsa.worlds.far_ends.ports import VirtualSerialPort
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware, QbmoveFrames
from emg2vsa.worlds.far_ends.qbmove.memory import MAKER_PRO

if sys.platform == "win32":
    pytest.skip("no pseudo-terminals", allow_module_level=True)
import pty
import tty

LONGEST_S = 30.0
"""After which a flood gives up, so that a driver that waits for its end fails the test."""


@dataclass
class Flood:
    """Calls ``pour`` from a thread of its own, again and again."""

    pour: Callable[[bytes], object]
    _over: Event = field(default_factory=Event)

    def __enter__(self) -> Flood:
        self._thread = Thread(target=self._run)
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._over.set()
        self._thread.join()

    @property
    def goes_on(self) -> bool:
        return self._thread.is_alive()

    def _run(self) -> None:
        end_s, noise = time.monotonic() + LONGEST_S, random.Random(1).randbytes(1 << 16)
        while not self._over.is_set() and time.monotonic() < end_s:
            with contextlib.suppress(BlockingIOError, ConnectionRefusedError):
                self.pour(noise)


@pytest.fixture
def port() -> Iterator[tuple[str, Flood]]:
    device, host = pty.openpty()
    tty.setraw(host)
    os.set_blocking(device, False)

    def pour(noise: bytes) -> None:
        select.select([], [device], [], 0.05)
        with contextlib.suppress(BlockingIOError):
            os.read(device, 1 << 16)  # what the host says
        os.write(device, noise)

    try:
        yield os.ttyname(host), Flood(pour)
    finally:
        os.close(device)
        os.close(host)


def dynamixel(line: SerialLine) -> Dynamixel:
    return Dynamixel(line, DynamixelSettings(kind="dynamixel"), clock=WallClock())


@pytest.mark.parametrize(
    ("made", "asked"),
    [
        (lambda line: Qbmove(line, 1, clock=WallClock()), Qbmove.measurements),
        (lambda line: Qbmove(line, 1, clock=WallClock()), Qbmove.identify),
        (lambda line: Qbmove(line, 1, clock=WallClock(), generation="v7"), Qbmove.identify),
        (lambda line: Qbmove(line, 1, clock=WallClock()), Qbmove.deactivate),
        (dynamixel, Dynamixel.measurements),
        (dynamixel, Dynamixel.identify),
        (dynamixel, Dynamixel.deactivate),
    ],
)
def test_a_serial_line_full_of_noise(
    port: tuple[str, Flood], made: Callable[[SerialLine], Any], asked: Callable[[Any], object]
) -> None:
    name, flood = port
    line = SerialLine(name, 1_000_000)
    with flood, contextlib.closing(made(line)) as board:
        assert not board.answers()
        with pytest.raises(DeviceError):
            asked(board)
        assert flood.goes_on


def test_the_flood_of_the_emulated_rig_over_a_port() -> None:
    clock = WallClock()
    wire = FaultyWire(QbmoveFirmware(MAKER_PRO, World(clock), clock), QbmoveFrames(), clock)
    with (  # at the end nobody reads any more, and the port ends all the same
        VirtualSerialPort(wire, lambda: wire.due_s - clock.now_s()) as virtual,
        contextlib.closing(Qbmove(SerialLine(virtual.name, BAUD), 1, clock=clock, reply_s=0.5)) as board,
    ):
        assert board.answers()
        wire.flooded = True
        board.answers()  # what was asked before the flood may still be answered
        assert not board.answers()
        wire.flooded = False
        assert board.answers()
        wire.flooded = True
        board.answers()


@pytest.mark.parametrize("answers", [qbmoves, dynamixels])
def test_nobody_is_found_in_noise(port: tuple[str, Flood], answers: Callable[..., Iterator[str]]) -> None:
    name, flood = port
    with flood, contextlib.closing(SerialLine(name, 1_000_000)) as line:
        assert list(answers(line, WallClock(), [1, 2], 0.005)) == []
        assert flood.goes_on


@pytest.mark.parametrize("size", [36, 35])
def test_a_force_sensor_that_sends_noise(size: int) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as box:
        box.bind(("127.0.0.1", 0))
        line = UdpLine(*box.getsockname())
        address = line._socket.getsockname()
        noise = iter(range(1 << 40))

        def pour(some: bytes) -> None:
            at = 7 * next(noise) % (1 << 15)
            box.sendto(some[at : at + size], address)

        sensor = NetFt(line, NetFtConfig(1e-6, 1e-6, 1000.0), WallClock())
        with Flood(pour) as flood, contextlib.closing(sensor):
            with pytest.raises(DeviceError, match="1000 records a second"):
                sensor.start()
            assert sensor.counts().refused > 0
            assert flood.goes_on
