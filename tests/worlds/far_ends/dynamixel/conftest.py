"""A motor on its bus, and what is asked of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.worlds.far_ends.dynamixel.firmware import DynamixelFirmware
from emg2vsa.worlds.far_ends.dynamixel.packets import HEADER, INSTRUCTION, Instruction, packet, unstuffed
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W350, DynamixelModel


class Rigid:
    """A shaft that is the motor's, as that of a world without springs."""

    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        return motors_rad[0]


class Desk:
    """A motor on a virtual clock, a torque on its shaft, and a master who waits for all answers."""

    def __init__(self, model: DynamixelModel, home_deg: float, **changes: Any) -> None:
        self.clock = VirtualClock()
        self.load_nm: Callable[[float], float] = lambda angle_rad: 0.0
        self.motor = DynamixelFirmware(
            model, Rigid(), self.clock, home_deg=home_deg, **changes,
            loads=lambda motors_rad: (self.load_nm(motors_rad[0]), 0.0),
        )  # fmt: skip
        self.device: Any = self.motor

    def send(self, data: bytes) -> bytes:
        """All that comes back, however late."""
        answer = self.device(data)
        while self.device.due_s < math.inf:
            self.clock.sleep_until(self.device.due_s)
            answer += self.device(b"")
        return answer

    def ask(self, instruction: int, parameters: bytes = b"", device_id: int = 1) -> tuple[int, bytes]:
        """Error byte and parameters of the one answer."""
        answer = self.send(packet(device_id, instruction, parameters))
        assert answer[:4] == HEADER
        assert answer[INSTRUCTION] == Instruction.STATUS
        body = unstuffed(answer[INSTRUCTION:-2])
        return body[1], body[2:]

    def write(self, address: int, value: int, size: int) -> int:
        """The error byte."""
        data = address.to_bytes(2, "little") + value.to_bytes(size, "little", signed=value < 0)
        return self.ask(Instruction.WRITE, data)[0]

    def read(self, address: int, size: int, *, signed: bool = False) -> int:
        error, data = self.ask(Instruction.READ, address.to_bytes(2, "little") + size.to_bytes(2, "little"))
        assert error & 0x7F == 0
        return int.from_bytes(data, "little", signed=signed)

    def wait(self, seconds: float, *, period_s: float = 0.005) -> list[float]:
        """Angles of the first motor, rad, meanwhile."""
        angles_rad, end_s = [], self.clock.now_s() + seconds
        while self.clock.now_s() < end_s - 1e-9:
            self.clock.sleep_until(self.clock.now_s() + period_s)
            angles_rad.append(self.motor.angles_rad()[0])
        return angles_rad

    def hold(self, position_p_gain: int, goal: int = 2048) -> None:
        """Current-based position mode, torque on."""
        assert self.write(11, 5, 1) == 0
        assert self.write(84, position_p_gain, 2) == 0
        assert self.write(116, goal, 4) == 0
        assert self.write(64, 1, 1) == 0


@pytest.fixture
def desk() -> Callable[..., Desk]:
    """One XM430-W350 in the middle of its turn, unless told else."""

    def make(model: DynamixelModel = XM430_W350, home_deg: float = 180.0, **changes: Any) -> Desk:
        return Desk(model, home_deg, **changes)

    return make
