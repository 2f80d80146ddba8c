"""Driver against emulated device, in the same process and on the same clock, with faults on the wire."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Literal

import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.qbmove import REPLY_S
from emg2vsa.devices.qbmove.conversation import answers
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.packets import Command
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.devices.serial_line import LoopbackLine
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.faults import FaultyWire
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware, QbmoveFrames
from emg2vsa.worlds.far_ends.qbmove.memory import ADVANCED, MAKER_PRO, Switches
from tests.devices.qbmove.firmware_v7 import ADVANCED_V7, MAKER_PRO_V7, QbmoveFirmwareV7

TICK_RAD = 2 * math.pi / 32768
FAST_ADVANCED = replace(ADVANCED, max_pwm_rate=10)
KINDS = {
    ("v6", "maker-pro"): (QbmoveFirmware, MAKER_PRO),
    ("v6", "advanced"): (QbmoveFirmware, FAST_ADVANCED),
    ("v7", "maker-pro"): (QbmoveFirmwareV7, MAKER_PRO_V7),
    ("v7", "advanced"): (QbmoveFirmwareV7, ADVANCED_V7),
}


class Free:
    """A shaft that stays halfway between its motors."""

    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        return sum(motors_rad) / 2


class Bench:
    """Device, wire, clock and driver."""

    def __init__(
        self, generation: str = "v6", model: str = "maker-pro", switches: Switches | None = None, at_ticks: int = 0
    ) -> None:
        self.clock = VirtualClock()
        kind, usual = KINDS[generation, model]
        motors_rad = (at_ticks * TICK_RAD + 1e-6,) * 2
        self.device = kind(switches or usual, Free(), self.clock, motors_rad=motors_rad)
        self.wire = FaultyWire(self.device, QbmoveFrames())
        self.line = LoopbackLine("bench", self.wire, self.clock)
        self.qbmove = Qbmove(self.line, 1, generation=generation, model=model, clock=self.clock)

    def wait(self, seconds: float) -> None:
        """Asking at 200 Hz, as the control loop does."""
        for _ in range(round(seconds * 200)):
            self.clock.sleep_until(self.clock.now_s() + 0.005)
            assert self.qbmove.is_active()


@pytest.fixture(params=KINDS, ids=lambda kind: " ".join(kind))
def bench(request: pytest.FixtureRequest) -> Bench:
    return Bench(*request.param)


def test_a_whole_run(bench: Bench) -> None:
    with bench.qbmove as qbmove:
        qbmove.activate()
        qbmove.command(1000 * DEG_PER_TICK, 1500 / 3000)
        bench.wait(1.0)
        assert qbmove.ticks() == pytest.approx((2500, -500, 1000), abs=8)
        qbmove.move_motors((-400 * DEG_PER_TICK, 400 * DEG_PER_TICK))
        bench.wait(1.0)
        assert qbmove.ticks() == pytest.approx((-400, 400, 0), abs=8)
    assert not qbmove.is_active()
    assert (qbmove.counts.lost, qbmove.counts.corrupt) == (0, 0)


def test_info(bench: Bench) -> None:
    info = bench.qbmove.info()
    assert info.max_stiffness_ticks == 3000
    assert info.position_limits_ticks == ((-15000, 15000), (-15000, 15000))
    assert info.voltage_mv == 24000


def test_parameters_are_listed(bench: Bench) -> None:
    listed = bench.qbmove.parameters()
    assert listed[1].values == (1,)
    assert listed[11].name == "Pos. limits [inf, sup]"
    assert listed[2].values == pytest.approx((listed[2].values[0], 0, listed[2].values[0] * 8), rel=1e-4)
    assert listed[13].values == (1500,)


def test_scan_names_serial_numbers_where_there_are_any() -> None:
    assert list(answers(Bench("v6").line, VirtualClock(), range(1, 4), 0.005)) == ["id 1"]
    assert list(answers(Bench("v7").line, VirtualClock(), range(1, 4), 0.005)) == ["id 1, serial number 0009961473"]


def test_a_refused_activation_names_the_encoders(bench: Bench) -> None:
    far = Bench(bench.qbmove.generation, bench.qbmove.model, at_ticks=13200)
    with pytest.raises(DeviceError, match="motor_1 at 13200, motor_2 at 13200, shaft at 13200"):
        far.qbmove.activate()


def test_an_advanced_that_cannot_move_is_not_activated() -> None:
    with pytest.raises(DeviceError, match="Set parameter 14"):
        Bench("v6", "advanced", switches=ADVANCED).qbmove.activate()


def test_stiffness_outside_the_study_is_refused_and_nothing_is_sent(bench: Bench) -> None:
    bench.qbmove.activate()
    bench.qbmove.command(0.0, 0.5)
    bench.wait(0.1)
    sent = bench.qbmove.counts.requests
    for position, preset in ((0, 599), (0, 2401), (12001, 1500), (-12001, 1500)):
        with pytest.raises(DeviceError, match="expected"):
            bench.qbmove.command(position * DEG_PER_TICK, preset / 3000)
    assert bench.qbmove.counts.requests == sent


def test_what_is_no_number_is_refused_and_nothing_is_sent(bench: Bench) -> None:
    bench.qbmove.activate()
    sent = bench.qbmove.counts.requests
    with pytest.raises(DeviceError, match="expected a position and a preset that are numbers, but found nan, 1500"):
        bench.qbmove.command(math.nan, 0.5)
    with pytest.raises(DeviceError, match="expected positions that are numbers, but found inf, 0"):
        bench.qbmove.move_motors((math.inf, 0.0))
    assert bench.qbmove.counts.requests == sent


def test_the_joint_is_that_of_the_device_once_it_is_known(bench: Bench) -> None:
    assert bench.qbmove.joint is None
    bench.qbmove.activate()
    assert bench.qbmove.joint is not None
    assert (bench.qbmove.joint.name, bench.qbmove.joint.full_ticks) == (f"qbmove-{bench.qbmove.model}", 3000)
    assert bench.qbmove.current_limit_a() == 1.5


def test_the_device_stops_by_itself_when_the_driver_falls_silent(bench: Bench) -> None:
    bench.qbmove.activate()
    bench.wait(2.0)
    bench.clock.sleep_until(bench.clock.now_s() + 0.6)
    assert not bench.qbmove.is_active()


@pytest.mark.parametrize(
    ("how", "what"),
    [
        *(("lose", ("to device", at)) for at in range(6)),
        # the checksum leaves the id out: a change that makes it 0, all devices, would even be answered
        *(("corrupt", ("to device", at, mask)) for at in range(6) for mask in (0x02, 0x40, 0xFF)),
        *((how, ("to host", at)) for how in ("lose", "corrupt") for at in range(12)),
    ],
)
def test_any_byte_lost_or_changed_costs_one_attempt(bench: Bench, how: str, what: tuple[Any, ...]) -> None:
    getattr(bench.wire, how)(*what)
    assert bench.qbmove.measurements().shaft_deg == 0
    assert bench.qbmove.counts.lost == 1


@pytest.mark.parametrize("at", range(7))
def test_activation_gets_through_a_damaged_frame(bench: Bench, at: int) -> None:
    bench.qbmove.activate()
    bench.qbmove.deactivate()
    bench.wire.lose("to device", at)
    bench.qbmove.deactivate()
    assert not bench.qbmove.is_active()


def test_a_mute_device_is_told_and_takes_its_time_on_the_clock(bench: Bench) -> None:
    bench.wire.mute = True
    start_s = bench.clock.now_s()
    with pytest.raises(DeviceError, match="a reply to GET_MEASUREMENTS, but found none in 3 attempts"):
        bench.qbmove.measurements()
    assert bench.clock.now_s() - start_s == pytest.approx(3 * REPLY_S)
    assert not bench.qbmove.answers()
    bench.wire.mute = False
    assert bench.qbmove.answers()


def test_the_end_of_a_run_with_a_mute_device_keeps_the_first_error(bench: Bench) -> None:
    def run() -> None:
        with bench.qbmove as qbmove:
            qbmove.activate()
            bench.wire.mute = True
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError) as caught:
        run()
    assert "expected motors off, but found no confirmation" in caught.value.__notes__[0]
    bench.wire.mute = False
    assert not bench.qbmove.is_active()
    with pytest.raises(DeviceError, match="no confirmation"), bench.qbmove:
        bench.wire.mute = True


def test_a_reset_in_the_middle_leaves_the_motors_off(bench: Bench) -> None:
    bench.qbmove.activate()
    bench.wait(0.1)
    bench.wire.reset()
    assert not bench.qbmove.is_active()


def test_info_with_a_changed_byte_is_read_until_it_agrees() -> None:
    bench = Bench()
    text = bench.device(bytes.fromhex("3a3a 01 04 06 0000 06"))
    bench.wire.corrupt("to host", text.index(b"Max stiffness: 3") + 15, mask=0x0A)
    assert bench.qbmove.info().max_stiffness_ticks == 3000


@pytest.mark.parametrize("way", ["to device", "to host"])
@pytest.mark.parametrize("at", [2, 6, 200, 500])
@pytest.mark.parametrize("count", [1, 8])
def test_info_with_lost_bytes_is_asked_for_again(way: Literal["to device", "to host"], at: int, count: int) -> None:
    bench = Bench()
    bench.wire.lose(way, at=at, count=count)
    bench.qbmove.activate()
    assert bench.qbmove.info().position_limits_ticks == ((-15000, 15000), (-15000, 15000))
    assert bench.qbmove.is_active()


def test_the_watchdog_is_set_again_with_every_question() -> None:
    """The frames of the start are lost, and a run that is killed later still ends with the motors off."""
    bench = Bench()
    heard: list[bytes] = []

    def deaf_to_it(data: bytes) -> bytes:
        is_watchdog = data[4:5] == bytes((Command.SET_WATCHDOG,))
        heard.extend([data] * is_watchdog)
        return bench.wire(b"" if is_watchdog else data)

    bench.line._device = deaf_to_it
    bench.qbmove.activate()
    assert heard
    bench.line._device = bench.wire
    bench.wait(0.1)
    bench.clock.sleep_until(bench.clock.now_s() + 1.0)
    assert not bench.qbmove.ask_active()


def test_nobody_else_s_watchdog_is_touched(bench: Bench) -> None:
    before = bench.device._watchdog_counts
    assert not bench.qbmove.is_active()
    assert bench.device._watchdog_counts == before
    bench.qbmove.activate()
    bench.qbmove.deactivate()
    assert bench.device._watchdog_counts == 12


@pytest.mark.parametrize("at_ticks", [0, 700, -3000])
def test_zeros_are_set_where_it_stands(bench: Bench, at_ticks: int) -> None:
    with bench.qbmove as qbmove:
        qbmove.activate()
        qbmove.move_motors([ticks * DEG_PER_TICK for ticks in (at_ticks + 300, at_ticks - 300)])
        bench.wait(1.0)
    at = bench.qbmove.set_zeros()
    assert max(map(abs, (*at.motors_deg, at.shaft_deg))) <= 16 * DEG_PER_TICK
    bench.device.reset()
    assert max(map(abs, bench.qbmove.ticks())) <= 16


def test_a_parameter_is_set_stored_and_read_back(bench: Bench) -> None:
    assert bench.qbmove.set_parameter(13, (1200,)).values == (1200,)
    assert bench.qbmove.set_parameter(2, (0.25, 0.0, 0.5)).values == pytest.approx((0.25, 0.0, 0.5))
    bench.device.reset()
    assert bench.qbmove.parameters()[13].values == (1200,)


@pytest.mark.parametrize(
    ("number", "values", "said"),
    [
        (99, (1,), "expected a parameter that the device lists, but found 99"),
        (13, (1, 2), "expected 1 values of type 'h' for parameter 13, Current limit, but found 1, 2"),
        (13, (1.5,), "found 1.5 \\(whole numbers wanted\\)"),
        (13, (1e6,), "expected 1 values of type 'h'"),
        (13, (math.nan,), "expected 1 values of type 'h'"),
    ],
)
def test_a_parameter_that_cannot_be(number: int, values: tuple[float, ...], said: str) -> None:
    with pytest.raises(DeviceError, match=said):
        Bench().qbmove.set_parameter(number, values)


def test_nothing_is_stored_with_motors_on(bench: Bench) -> None:
    bench.qbmove.activate()
    for change in (lambda: bench.qbmove.set_parameter(13, (1200,)), bench.qbmove.set_zeros):
        with pytest.raises(DeviceError, match=r"expected motors off while .* set, but found motors on"):
            change()
    bench.qbmove.deactivate()
