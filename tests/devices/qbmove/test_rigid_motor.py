"""The driver of the rigid motor against the bytes of the protocol and against the emulated board."""

from __future__ import annotations

import math

import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import Actuator, Measurements
from emg2vsa.devices.qbmove.driver import Qbmove, RigidMotor
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.devices.serial_line import LoopbackLine
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.bench.probe import WorldSettings
from emg2vsa.worlds.bench.world import World
from emg2vsa.worlds.far_ends.qbmove.far_end import MOTOR_BOARD
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware

MM_PER_TICK = DEG_PER_TICK * 0.2
INACTIVE = bytes.fromhex("3a3a 01 03 81 00 81")


class Bench:
    """World, board, line that keeps what passes, and driver."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.world = World(self.clock, WorldSettings(springs=None))
        self.device = QbmoveFirmware(MOTOR_BOARD, self.world, self.clock, loads=self.world.loads_nm)
        self.heard: list[str] = []
        self.board = Qbmove(LoopbackLine("bench", self._keep, self.clock), 1, clock=self.clock)
        self.motor = RigidMotor(self.board)

    def _keep(self, data: bytes) -> bytes:
        self.heard.append(data.hex())
        return self.device(data)

    def wait(self, seconds: float) -> float:
        """Where the shaft is then, ticks."""
        for _ in range(round(seconds * 200)):
            self.clock.sleep_until(self.clock.now_s() + 0.005)
            assert self.motor.is_active()
        return self.motor.measurements().shaft_deg / DEG_PER_TICK

    def asked(self) -> bytes:
        return self.device(bytes.fromhex("3a3a 01 02 81 81"))


def test_a_whole_press() -> None:
    bench = Bench()
    actuator: Actuator = bench.motor
    with bench.board:
        actuator.activate()
        for k in range(400):
            actuator.command(9 * k * DEG_PER_TICK, 0.0)
            bench.clock.sleep_until(bench.clock.now_s() + 0.005)
        assert actuator.currents_a()[0] > 0
        assert bench.wait(0.5) == pytest.approx(3591, abs=8)
        assert bench.world.probe_mm(bench.clock.now_s()) == pytest.approx(3591 * MM_PER_TICK, abs=16 * MM_PER_TICK)
        assert bench.world.normal_force_n(bench.clock.now_s()) > 2
        actuator.command(0.0, 0.0)
        assert bench.wait(1.0) == pytest.approx(0, abs=8)
        assert bench.world.normal_force_n(bench.clock.now_s()) == 0.0
    assert bench.asked() == INACTIVE


@pytest.mark.parametrize(
    ("position_ticks", "request_hex"),
    [
        (1000, "3a3a 01 06 82 03e8 0000 69"),
        (4000, "3a3a 01 06 82 0fa0 0000 2d"),
        (-1000, "3a3a 01 06 82 fc18 0000 66"),
        (0, "3a3a 01 06 82 0000 0000 82"),
    ],
)
def test_the_bytes_of_a_position(position_ticks: int, request_hex: str) -> None:
    bench = Bench()
    bench.motor.activate()
    bench.motor.command(position_ticks * DEG_PER_TICK, 0.0)
    assert bench.heard[-1] == bytes.fromhex(request_hex).hex()


# what the third encoder of a board without one says is not known
@pytest.mark.parametrize(
    ("reply_hex", "at"),
    [("3a3a 01 08 84 03e8 0000 1234 49", (1000, 0, 1000)), ("3a3a 01 08 84 fc18 0010 0000 70", (-1000, 16, -1000))],
)
def test_shaft_and_position_are_motor_1(reply_hex: str, at: tuple[int, int, int]) -> None:
    replies = {bytes.fromhex("3a3a 01 02 84 84"): bytes.fromhex(reply_hex)}
    motor = RigidMotor(Qbmove(LoopbackLine("bench", replies.__getitem__), 1, clock=VirtualClock()))
    motor_1, motor_2, shaft = (ticks * DEG_PER_TICK for ticks in at)
    assert motor.measurements() == Measurements((motor_1, motor_2), shaft)
    assert motor.position_deg() == motor_1


@pytest.mark.parametrize(
    ("position_ticks", "preset", "message"),
    [
        (1000, 0.2, "expected preset 0: it has no springs, but found 0.2"),
        (15001, 0.0, "expected -15000 to 15000 ticks"),
        (math.nan, 0.0, "expected positions that are numbers, but found nan, 0"),
    ],
)
def test_what_the_motor_cannot_do_sends_nothing(position_ticks: float, preset: float, message: str) -> None:
    bench = Bench()
    bench.motor.activate()
    said = len(bench.heard)
    with pytest.raises(DeviceError, match=message):
        bench.motor.command(position_ticks * DEG_PER_TICK, preset)
    assert len(bench.heard) == said


def test_nothing_moves_before_activation() -> None:
    with pytest.raises(DeviceError, match="Call activate first"):
        Bench().motor.command(10.0, 0.0)


def test_whatever_happens_the_motor_is_off_at_the_end() -> None:
    bench = Bench()

    def press() -> None:
        with bench.board:
            bench.motor.activate()
            bench.motor.command(3000 * DEG_PER_TICK, 0.0)
            bench.wait(0.1)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        press()
    assert bench.asked() == INACTIVE
    assert bench.motor.measurements().shaft_deg > 500 * DEG_PER_TICK


def test_motor_off() -> None:
    bench = Bench()
    bench.motor.activate()
    assert bench.motor.is_active()
    bench.motor.deactivate()
    assert bench.asked() == INACTIVE
