"""What a Dynamixel says of itself, and whether a run may use it. A run checks EEPROM values and never changes them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from emg2vsa.devices.dynamixel.registers import (
    CURRENT_BASED_POSITION,
    DEG_PER_PULSE,
    LEAST_FIRMWARE,
    MOTORS,
    OVERLOAD,
    ZERO_PULSE,
    fault_words,
)
from emg2vsa.devices.dynamixel.settings import DynamixelSettings
from emg2vsa.errors import DeviceError


@dataclass(frozen=True)
class DynamixelInfo:
    """Values that a run depends on, as the motor has them."""

    model_number: int
    firmware: int
    device_id: int
    protocol: int
    operating_mode: int
    drive_mode: int
    "Bits: 1 reverse, 2 slave, 4 time-based profile, 8 torque on by a goal."
    homing_pulses: int
    "Added to the encoder; 4096 to a turn."
    limits_pulses: tuple[int, int]
    "Lowest and highest position; the motor itself keeps them only in position control, not in the mode of a run."
    pwm_limit: int
    "Of 885."
    current_limit_a: float
    startup: int
    shutdown: int
    "Hardware errors that switch the torque off, as bits."
    status_return: int
    hardware_error: int
    p_gain: int
    i_gain: int
    d_gain: int
    voltage_v: float
    temperature_c: int

    def limits_deg(self) -> tuple[float, float]:
        """The position limits as angles of the joint, whose zero is the middle of a turn."""
        low, high = ((pulses - ZERO_PULSE) * DEG_PER_PULSE for pulses in self.limits_pulses)
        return low, high

    def facts(self) -> Iterator[str]:
        """Lines for people."""
        yield f"{model_named(self.model_number)}, firmware {self.firmware}, id {self.device_id}"
        yield f"operating mode {self.operating_mode}, drive mode {self.drive_mode}, protocol {self.protocol}"
        yield "position limits: {:.2f} to {:.2f} degrees".format(*self.limits_deg())
        yield f"homing offset {self.homing_pulses} pulses, current limit {self.current_limit_a:.3f} A"
        yield f"gains: P {self.p_gain}, I {self.i_gain}, D {self.d_gain}"
        yield f"supply {self.voltage_v:.1f} V, {self.temperature_c} degrees Celsius inside"


def model_named(number: int) -> str | None:
    """The model with this Model Number; None for one that the driver does not know."""
    return next((name for name, motor in MOTORS.items() if motor.number == number), None)


def check_model(info: DynamixelInfo, settings: DynamixelSettings, where: str) -> None:
    """DeviceError for another model than the rig file names: the same gain is another stiffness on it."""
    number = MOTORS[settings.model].number
    if info.model_number != number:
        do = "Correct [actuator] model, and measure the stiffness of this motor."
        wanted = f"{number}, the {settings.model}"
        raise DeviceError(f"{where}, model number", wanted=wanted, found=str(info.model_number), do=do)


def check_ready(info: DynamixelInfo, settings: DynamixelSettings, where: str) -> None:
    """DeviceError at the first value with which a run would not do what it is told."""
    low, high = info.limits_pulses
    check_model(info, settings, where)
    goal_a = settings.goal_current_a
    set_it = "Set it: emg2vsa rig parameters RIG"
    rules = (
        ("firmware", f"{LEAST_FIRMWARE} or newer", info.firmware, info.firmware >= LEAST_FIRMWARE,
         "Update it with DYNAMIXEL Wizard: older ones lack what protects a run."),
        ("id", settings.id, info.device_id, info.device_id == settings.id,
         "It answers to a Secondary ID (12); give the rig file its own id."),
        ("protocol type", 2, info.protocol, info.protocol == 2, "Set Protocol Type (13) with DYNAMIXEL Wizard."),
        ("operating mode", f"{CURRENT_BASED_POSITION}, current-based position control", info.operating_mode,
         info.operating_mode == CURRENT_BASED_POSITION, f"{set_it} --set 11=5."),
        ("drive mode", "0: not reversed, no slave, no time-based profile, no torque by a goal", info.drive_mode,
         info.drive_mode == 0, f"{set_it} --set 10=0."),
        ("homing offset", f"-{ZERO_PULSE} to {ZERO_PULSE} pulses, half a turn", info.homing_pulses,
         abs(info.homing_pulses) <= ZERO_PULSE, "Run emg2vsa rig zero."),
        ("position limits", "two pulses of 0 to 4095, the lower below the higher", f"{low} and {high}",
         0 <= low < high <= 4095, "Set parameters 52 and 48: emg2vsa rig parameters RIG --set 52=0."),
        ("current limit", f"at least goal_current_a, {goal_a:g} A", f"{info.current_limit_a:.3f} A",
         info.current_limit_a >= goal_a, "Lower [actuator] goal_current_a, or raise parameter 38."),
        ("shutdown", f"overload among the errors that switch the torque off, bit 0x{OVERLOAD:02x}",
         f"0x{info.shutdown:02x}", bool(info.shutdown & OVERLOAD), f"{set_it} --set 63=52, as it leaves the factory."),
        ("startup configuration", "0: torque off and no stored values at power-on", info.startup, info.startup == 0,
         f"{set_it} --set 60=0."),
        ("status return level", "2, an answer to everything", info.status_return, info.status_return == 2,
         "Reboot it: power off and on."),
    )  # fmt: skip
    for name, wanted, found, good, do in rules:
        if not good:
            raise DeviceError(f"{where}, {name}", wanted=str(wanted), found=str(found), do=do)
    if info.hardware_error:
        found, do = fault_words(info.hardware_error)
        raise DeviceError(f"{where}, hardware error", wanted="none", found=found, do=do)
