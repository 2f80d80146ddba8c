"""Driver against emulated motor, in the same process and on the same clock, with loads on the shaft and faults."""

from __future__ import annotations

import math
from typing import Any

import pytest

from emg2vsa.devices.clock import VirtualClock, WallClock
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.devices.dynamixel.conversation import answers
from emg2vsa.devices.dynamixel.driver import Dynamixel
from emg2vsa.devices.serial_line import SerialLine
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.dynamixel import table
from emg2vsa.worlds.far_ends.dynamixel.firmware import DynamixelFirmware
from emg2vsa.worlds.far_ends.dynamixel.packets import DynamixelFrames
from emg2vsa.worlds.far_ends.dynamixel.table import XM430_W350
from emg2vsa.worlds.far_ends.faults import FaultyWire, WireLine
from emg2vsa.worlds.far_ends.ports import VirtualSerialPort

FULL_NM_PER_RAD = XM430_W350.stiffness_nm_per_rad(800)
UNCERTAIN_NM = XM430_W350.friction_nm + FULL_NM_PER_RAD * math.radians(360 / 4096)
"""By friction, and by a pulse of the encoder."""


class Free:
    """Nothing is at the shaft but the load."""

    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        return motors_rad[0]


class Bench:
    """Motor, wire, clock and driver. The encoder is in the middle of its turn."""

    def __init__(self, home_deg: float = 180.0, **settings: Any) -> None:
        self.clock, self.load_nm = VirtualClock(), 0.0
        self.motor = DynamixelFirmware(
            XM430_W350, Free(), self.clock, home_deg=home_deg, loads=lambda _: (self.load_nm, 0.0)
        )
        self.motor.table.values[table.OPERATING_MODE] = 5
        self.wire = FaultyWire(self.motor, DynamixelFrames(), self.clock)
        self.line = WireLine("bench", self.wire, lambda: self.motor.due_s, self.clock)
        known = {"full_stiffness_nm_per_rad": FULL_NM_PER_RAD}
        self.dynamixel = Dynamixel(self.line, DynamixelSettings(kind="dynamixel", **known | settings), clock=self.clock)

    def hold(self, position_deg: float, preset: float, seconds: float = 2.0) -> None:
        """Turns of 5 ms, as the control loop does them."""
        for turn in range(round(seconds * 200)):
            self.clock.sleep_until(self.clock.now_s() + 0.005)
            self.dynamixel.command(position_deg, preset)
            self.dynamixel.measurements()
            self.dynamixel.currents_a()
            assert turn % 20 or self.dynamixel.is_active()

    def kept(self) -> dict[int, int]:
        """What is written to the motor's table, and not measured."""
        return {address: value for address, value in self.motor.table.values.items() if address < table.PRESENT_CURRENT}

    def wait(self, seconds: float) -> None:
        """In silence."""
        self.clock.sleep_until(self.clock.now_s() + seconds)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_whole_run(bench: Bench) -> None:
    with bench.dynamixel as dynamixel:
        dynamixel.activate()
        assert dynamixel.position_deg() == 0
        bench.hold(20.0, 1.0)
        assert dynamixel.position_deg() == pytest.approx(20, abs=0.2)
        bench.hold(-30.0, 0.5, 4.0)
        assert dynamixel.position_deg() == pytest.approx(-30, abs=0.4)
    assert not dynamixel.is_active()
    assert (dynamixel.counts.lost, dynamixel.counts.corrupt) == (0, 0)


def test_two_runs_follow_one_another(bench: Bench) -> None:
    for _ in range(2):
        with bench.dynamixel as dynamixel:
            dynamixel.activate()
            bench.hold(5.0, 1.0, 0.5)


@pytest.mark.parametrize("preset", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("load_nm", [-0.5, 0.5])
def test_the_deflection_tells_the_load(bench: Bench, preset: float, load_nm: float) -> None:
    with bench.dynamixel as dynamixel:
        dynamixel.activate()
        bench.hold(10.0, preset)
        bench.load_nm = load_nm  # the emulated motor's load pulls towards smaller angles
        bench.hold(10.0, preset, 2.0)
        at = dynamixel.measurements()
        assert dynamixel.joint.torque_nm(at, 10.0, preset) == pytest.approx(-load_nm, abs=UNCERTAIN_NM)
        torque_nm = dynamixel.currents_a()[0] * XM430_W350.torque_constant_nm_per_a
        assert torque_nm == pytest.approx(load_nm, abs=UNCERTAIN_NM)


def test_a_soft_joint_gives_way_in_proportion(bench: Bench) -> None:
    deflections = []
    with bench.dynamixel as dynamixel:
        dynamixel.activate()
        bench.load_nm = 0.6
        for preset in (1.0, 0.5, 0.25):
            bench.hold(0.0, preset, 2.0)
            deflections.append(-dynamixel.position_deg())
    assert deflections[1] / deflections[0] == pytest.approx(2, rel=0.15)
    assert deflections[2] / deflections[1] == pytest.approx(2, rel=0.1)


def test_the_goal_current_is_the_largest() -> None:
    bench = Bench(goal_current_a=0.2)
    with bench.dynamixel as dynamixel:
        dynamixel.activate()
        assert dynamixel.current_limit_a() == pytest.approx(0.199, abs=0.0005)
        bench.load_nm = 0.6  # more than 0.36 N m of the goal current
        bench.hold(0.0, 1.0, 0.3)
        dynamixel.measurements()
        assert dynamixel.currents_a()[0] == pytest.approx(0.199, abs=0.003)
        assert dynamixel.position_deg() < -5


def test_the_motor_stops_by_itself_when_the_driver_falls_silent(bench: Bench) -> None:
    bench.dynamixel.activate()
    bench.hold(0.0, 1.0, 0.5)
    bench.wait(0.4)
    assert bench.dynamixel.is_active()
    bench.dynamixel.command(40.0, 1.0)
    bench.wait(0.51)
    stopped_deg = bench.dynamixel.position_deg()
    assert not bench.dynamixel.is_active()
    assert bench.dynamixel.watchdog_ran_out()
    with pytest.raises(DeviceError, match="a watchdog that has run out"):
        bench.dynamixel.command(0.0, 1.0)
    bench.dynamixel.move_motors((0.0,))  # refused
    bench.wait(1.0)
    assert bench.dynamixel.position_deg() == pytest.approx(stopped_deg, abs=0.3)
    assert not bench.dynamixel.is_active()


def test_an_activation_ends_what_the_watchdog_did(bench: Bench) -> None:
    bench.dynamixel.activate()
    bench.wait(0.6)
    assert not bench.dynamixel.is_active()
    bench.dynamixel.activate()
    bench.hold(10.0, 1.0)
    assert bench.dynamixel.position_deg() == pytest.approx(10, abs=0.2)


def test_a_motor_that_goes_on_in_silence_is_seen_to_do_so(bench: Bench) -> None:
    bench.motor.motor.faults.flag_only = True
    bench.dynamixel.activate()
    bench.dynamixel.command(40.0, 1.0)
    bench.wait(0.02)
    before_deg = bench.dynamixel.position_deg()
    bench.wait(2.0)
    assert bench.dynamixel.watchdog_ran_out()
    assert not bench.dynamixel.ask_active()
    assert bench.dynamixel.position_deg() - before_deg > 30


def test_a_watchdog_that_is_not_kept_is_told_before_the_torque_is_on(bench: Bench) -> None:
    bench.motor.motor.faults.deaf_watchdog = True
    with pytest.raises(DeviceError, match=r"expected 25 in Bus Watchdog \(98\), but found 0"):
        bench.dynamixel.activate()
    assert bench.motor.table.values[table.TORQUE_ENABLE] == 0


@pytest.mark.parametrize(
    ("bit", "told"), [(8, "motor encoder"), (16, "electrical shock. Check the supply"), (32, "overload. Take the load")]
)
def test_a_hardware_error_stops_a_run_until_a_reboot(bench: Bench, bit: int, told: str) -> None:
    bench.dynamixel.activate()
    bench.hold(5.0, 1.0, 0.5)
    bench.motor.motor.faults.hardware_error = bit
    bench.wait(0.005)
    assert not bench.dynamixel.is_active()
    with pytest.raises(DeviceError, match=f"hardware error: expected none, but found {told}"):
        bench.dynamixel.command(5.0, 1.0)
    bench.dynamixel.deactivate()
    bench.motor.motor.faults.hardware_error = 0
    with pytest.raises(DeviceError, match="Then reboot it"):
        bench.dynamixel.activate()
    bench.motor.reset()
    bench.wait(0.5)
    bench.dynamixel.activate()


@pytest.mark.parametrize(
    ("fault", "value", "told"),
    [("temperature_c", 90.0, "overheating. Let it cool"), ("supply_v", 8.0, "input voltage. Check the supply")],
)
def test_heat_and_supply_are_told(bench: Bench, fault: str, value: float, told: str) -> None:
    bench.dynamixel.activate()
    setattr(bench.motor.motor.faults, fault, value)
    bench.wait(0.005)
    assert not bench.dynamixel.is_active()
    with pytest.raises(DeviceError, match=told):
        bench.dynamixel.measurements()
    bench.dynamixel.deactivate()


def test_a_motor_that_has_lost_its_power_is_not_active(bench: Bench) -> None:
    bench.dynamixel.activate()
    bench.motor.reset()
    with pytest.raises(DeviceError, match="a reply to Torque Enable"):
        bench.dynamixel.is_active()
    bench.wait(0.5)
    assert not bench.dynamixel.is_active()


@pytest.mark.parametrize(
    ("address", "value", "told"),
    [
        (table.HOMING_OFFSET, 4096, "homing offset: expected -2048 to 2048"),
        (table.MAX_POSITION, 1000, "a shaft at -180.00 to -92.11 degrees, but found 0.00"),
    ],
)
def test_a_motor_that_is_not_set_up_is_refused_and_keeps_its_values(
    bench: Bench, address: int, value: int, told: str
) -> None:
    bench.motor.table.values[address] = value
    before = bench.kept()
    with pytest.raises(DeviceError, match=told):
        bench.dynamixel.activate()
    assert bench.kept() == before


def test_a_motor_from_the_factory_is_set_up_by_parameters(bench: Bench) -> None:
    bench.motor.table.values[table.OPERATING_MODE] = table.POSITION
    dynamixel = bench.dynamixel
    with pytest.raises(DeviceError, match=r"--set 11=5"):
        dynamixel.activate()
    for number, value in ((11, 5), (9, 0), (52, 1024), (48, 3072), (38, 400), (20, -5)):
        assert dynamixel.set_parameter(number, (value,)).values == (value,)
    found = {number: parameter.values for number, parameter in dynamixel.parameters().items()}
    assert (found[11], found[9], found[52], found[20]) == ((5,), (0,), (1024,), (-5,))
    assert "position limits: -90.00 to 90.00 degrees" in list(dynamixel.about())
    dynamixel.activate()
    with pytest.raises(DeviceError, match="torque off while Return Delay Time is set"):
        dynamixel.set_parameter(9, (250.0,))
    with pytest.raises(DeviceError, match="torque off while a zero is set"):
        dynamixel.set_zeros()
    assert dynamixel.is_active()


@pytest.mark.parametrize("home_deg", [3.0, 91.3, 300.0, 359.9])
def test_zeros_hold_over_a_loss_of_power(home_deg: float) -> None:
    bench = Bench(home_deg)
    assert bench.dynamixel.set_zeros().shaft_deg == 0
    bench.motor.reset()
    bench.wait(0.5)
    assert bench.dynamixel.position_deg() == 0
    with bench.dynamixel as dynamixel:
        dynamixel.activate()
        bench.hold(12.0, 1.0)
        assert dynamixel.position_deg() == pytest.approx(12, abs=0.2)


@pytest.mark.parametrize(
    ("way", "at"), [*(("to device", at) for at in range(14)), *(("to host", at) for at in range(21))]
)
@pytest.mark.parametrize("how", ["lose", "corrupt"])
def test_any_byte_lost_or_changed_costs_one_attempt(bench: Bench, way: str, at: int, how: str) -> None:
    getattr(bench.wire, how)(way, at)
    assert bench.dynamixel.measurements().shaft_deg == 0
    assert bench.dynamixel.counts.lost == 1


def test_a_run_gets_through_a_line_that_loses_bytes(bench: Bench) -> None:
    bench.wire.lost_share = 0.0005
    with bench.dynamixel as dynamixel:
        dynamixel.activate()
        bench.hold(15.0, 0.8, 3.0)
        assert dynamixel.position_deg() == pytest.approx(15, abs=0.3)
    assert 5 < dynamixel.counts.lost < 60


def test_a_scan_finds_the_motor(bench: Bench) -> None:
    assert list(answers(bench.line, bench.clock, range(5), 0.005)) == ["id 1, xm430-w350, firmware 45"]


def test_the_driver_speaks_on_a_serial_port_as_well() -> None:
    clock = WallClock()
    motor = DynamixelFirmware(XM430_W350, Free(), clock, home_deg=180.0)
    motor.table.values[table.OPERATING_MODE] = 5
    with VirtualSerialPort(motor, lambda: motor.due_s - clock.now_s()) as port:
        line = SerialLine(port.name, 1_000_000)
        try:
            settings = DynamixelSettings(
                kind="dynamixel", full_stiffness_nm_per_rad=20, d_gain=1500, reply_s=0.5, watchdog_s=2.5
            )
            with Dynamixel(line, settings, clock=clock) as dynamixel:
                dynamixel.activate()
                dynamixel.command(3.0, 1.0)
                until_s, at_deg = clock.now_s() + 5, 0.0
                while abs(at_deg - 3) > 0.3 and clock.now_s() < until_s:
                    clock.sleep_until(clock.now_s() + 0.02)
                    at_deg = dynamixel.position_deg()
                assert at_deg == pytest.approx(3, abs=0.3)
                assert dynamixel.counts.corrupt == 0
        finally:
            line.close()
