"""The emulated board of the rigid motor: bytes in, probe down."""

from __future__ import annotations

import itertools
import struct

import pytest

from casr.specimens import SPECIMENS
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.worlds.bench.probe import WorldSettings
from emg2vsa.worlds.bench.world import World
from emg2vsa.worlds.far_ends.qbmove.far_end import MOTOR_BOARD, MOTOR_SPEED_RAD_PER_S
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware

ACTIVATE, DEACTIVATE = "3a3a 01 03 80 03 83", "3a3a 01 03 80 00 80"
GO_TO_4000, GO_TO_0 = "3a3a 01 06 82 0fa0 0000 2d", "3a3a 01 06 82 0000 0000 82"
MM_PER_TICK = 360 / 32768 * 0.2


class Bench:
    def __init__(self, kappa: float = 3.35) -> None:
        self.clock = VirtualClock()
        self.world = World(self.clock, WorldSettings(springs=None, stiffness_n_per_mm=kappa))
        self.board = QbmoveFirmware(MOTOR_BOARD, self.world, self.clock, loads=self.world.loads_nm)

    def say(self, data: str, after_ms: float = 0) -> str:
        self.clock.sleep_until(self.clock.now_s() + after_ms / 1000)
        return self.board(bytes.fromhex(data)).hex()

    def measured(self, after_ms: float) -> tuple[int, ...]:
        return struct.unpack(">3h", bytes.fromhex(self.say("3a3a 01 02 84 84", after_ms))[5:-1])

    def probe_mm(self) -> float:
        return self.world.probe_mm(self.clock.now_s())


PAIRS = [
    ("ping", "3a3a 01 02 00 00", "3a3a 01 02 00 00"),
    ("measurements at the start", "3a3a 01 02 84 84", "3a3a 01 08 84 0000 0000 0000 84"),
    ("motor off", "3a3a 01 02 81 81", "3a3a 01 03 81 00 81"),
    ("activate is silent", ACTIVATE, ""),
    ("set inputs is silent", GO_TO_4000, ""),
]


@pytest.mark.parametrize(("request_hex", "reply_hex"), [pair[1:] for pair in PAIRS], ids=[pair[0] for pair in PAIRS])
def test_bytes_in_bytes_out(request_hex: str, reply_hex: str) -> None:
    assert Bench().say(request_hex) == bytes.fromhex(reply_hex).hex()


@pytest.mark.parametrize("kappa", [SPECIMENS["S1"], SPECIMENS["S5"]])
def test_the_motor_drives_the_probe_whatever_pushes_back(kappa: float) -> None:
    bench = Bench(kappa)
    bench.say(ACTIVATE)
    bench.say(GO_TO_4000, after_ms=5)
    motor, _, shaft = bench.measured(after_ms=1500)
    assert motor == pytest.approx(4000, abs=8)
    assert motor % 8 == 0
    assert shaft == motor
    assert bench.probe_mm() == pytest.approx(4000 * MM_PER_TICK, abs=10 * MM_PER_TICK)
    assert bench.world.normal_force_n(bench.clock.now_s()) > 2
    bench.say(GO_TO_0)
    bench.measured(after_ms=1500)
    assert bench.world.normal_force_n(bench.clock.now_s()) == 0.0


def test_the_motor_keeps_to_its_speed() -> None:
    bench = Bench()
    bench.say(ACTIVATE)
    bench.say(GO_TO_4000, after_ms=5)
    ticks_per_ms = MOTOR_SPEED_RAD_PER_S * 5215.19 / 1000
    path = [bench.measured(after_ms=10)[0] for _ in range(100)]
    steps = [after - before for before, after in itertools.pairwise(path)]
    assert max(steps) == pytest.approx(10 * ticks_per_ms, abs=16)
    assert max(path) <= 4008


def test_a_motor_that_is_off_stays() -> None:
    bench = Bench()
    bench.say(GO_TO_4000)
    assert bench.measured(after_ms=1000) == (0, 0, 0)
    bench.say(ACTIVATE)
    bench.say(GO_TO_4000, after_ms=5)
    bench.say(DEACTIVATE, after_ms=100)
    stopped = bench.measured(after_ms=5)
    assert 0 < stopped[0] < 4000
    assert bench.measured(after_ms=1000) == stopped
