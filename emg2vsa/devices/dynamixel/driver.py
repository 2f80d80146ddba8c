"""Driver of a ROBOTIS Dynamixel X-series motor with current sensing: one joint whose stiffness is a position gain.

Nobody has tried it on a real motor. It was written from ROBOTIS' e-Manual (see ``registers``) and tried against an
emulated motor that was written from the same pages.

The motor runs in current-based position control. A command is a Goal Position (116) and, when the preset changes, a
Position P Gain (84); each is one write that the motor answers. Set Return Delay Time (9) to 0 for a loop of 200 Hz.
In that mode the motor keeps no position limits; the driver refuses what is outside them.

The Bus Watchdog (98) counts every packet. When it runs out the motor stops where it is, with its torque still on, and
refuses goals until the watchdog is set to 0, which only `Dynamixel.activate` and `Dynamixel.deactivate` do. With a
homing offset other than 0 some firmware is reported to run away instead (ROBOTIS-GIT/DynamixelSDK, issue 584): a proof
of the watchdog must see that the shaft stays where it is.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence

from emg2vsa.devices.board import Board, answering, no_address
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.dynamixel import DynamixelSettings, registers
from emg2vsa.devices.dynamixel.conversation import Conversation, Status
from emg2vsa.devices.dynamixel.joint import GainJoint
from emg2vsa.devices.dynamixel.registers import (
    CURRENT_UNIT_A,
    DEG_PER_PULSE,
    ZERO_PULSE,
    DynamixelInfo,
    Item,
    check_model,
    check_ready,
    fault_words,
    model_named,
    read_info,
)
from emg2vsa.devices.protocols import Measurements, Parameter, Usable
from emg2vsa.devices.registry import Around
from emg2vsa.devices.serial_line import ByteLine, SerialLine
from emg2vsa.errors import DeviceError

ON, OFF = 1, 0
_OFF_ATTEMPTS = 10
_ZERO_TOLERANCE_PULSES = 2
_DRIFT_PULSES = 11
"""1 degree: a goal may follow a shaft that creeps while the torque is off."""
_CREEP = 1
"""Units of Profile Velocity."""
_STILL_S, _STILL_PULSES, _STILL_LOOKS = 0.05, 1, 20
"""A shaft that turns by no more in that time rests; it has so many of them to come to rest."""


def open_dynamixel(settings: DynamixelSettings, around: Around) -> Dynamixel:
    """The motor, which answers; nothing is switched. Its user closes it.

    DeviceError : no such port or id, or no dynamixel-sdk. SettingError : the rig file names no port: none is guessed.
    """
    if settings.port is None:
        do = "emg2vsa rig scan --port PORT --kind dynamixel asks a port."
        raise no_address("actuator.port", "the serial port of the motor", do)
    board = Dynamixel(SerialLine(settings.port, settings.baud), settings, clock=around.clock)
    do = "Check power, cable, id and baud rate; emg2vsa rig scan lists who answers."
    return answering(board, board.answers, do)


class Dynamixel(Board):
    """One motor. As a context manager it switches the torque off at the end, however that comes."""

    creep_deg_per_s = _CREEP * registers.VELOCITY_DEG_PER_S

    def __init__(self, line: ByteLine, settings: DynamixelSettings, *, clock: Clock) -> None:
        self.device_id, self.settings = settings.id, settings
        self.where = f"{line.name}, dynamixel {settings.id}"
        supposed = registers.supposed_nm_per_rad(settings.model, settings.full_gain)
        self.joint = GainJoint(settings.full_stiffness_nm_per_rad or supposed, settings.full_gain)
        self._line, self._clock = line, clock
        self._talk = Conversation(line, clock, settings.reply_s)
        self.counts = self._talk.counts
        self._usable_deg: tuple[float, float] | None = None
        self._limit_a = 0.0
        self._gain: int | None = None
        self._unused: tuple[int, Measurements] | None = None

    def info(self) -> DynamixelInfo:
        """What the motor says about itself. DeviceError for a model that the driver does not know."""
        return read_info(self._get, self.where)

    def close(self) -> None:
        """Give the line back."""
        self._line.close()

    def answers(self) -> bool:
        """To a ping."""
        return self._talk.ping(self.device_id, 3) is not None

    def identify(self) -> DynamixelInfo:
        """As `info`. DeviceError: it is silent, or of another model than the rig file names."""
        info = self.info()
        check_model(info, self.settings, self.where)
        return info

    def usable(self, info: DynamixelInfo) -> Usable:
        """What a run may ask of it."""
        return Usable(info.limits_deg(), self.joint.full_preset)

    def about(self) -> Iterator[str]:
        """Facts, state, whether a run may use it and why not, and parameters: lines for people. DeviceError : it is
        silent."""
        info = self.identify()
        yield f"{model_named(info.model_number)}, firmware {info.firmware}, id {info.device_id}"
        yield f"operating mode {info.operating_mode}, drive mode {info.drive_mode}, protocol {info.protocol}"
        yield "position limits: {:.2f} to {:.2f} degrees".format(*info.limits_deg())
        yield f"homing offset {info.homing_pulses} pulses, current limit {info.current_limit_a:.3f} A"
        yield f"gains: P {info.p_gain}, I {info.i_gain}, D {info.d_gain}"
        yield f"supply {info.voltage_v:.1f} V, {info.temperature_c} degrees Celsius inside"
        current, at = self._decoded(self._good(self._read(registers.PRESENT), registers.PRESENT))
        yield f"torque {'on' if self._get(registers.TORQUE) else 'off'}, shaft at {at.shaft_deg:.2f} degrees"
        yield f"current {current * CURRENT_UNIT_A:.3f} A"
        if info.hardware_error:
            yield f"hardware error: {fault_words(info.hardware_error)[0]}"
        try:
            check_ready(info, self.settings, self.where)
            yield "set up for runs"
        except DeviceError as error:
            yield f"not ready for a run: {error}"
        stiffness = self.settings.full_stiffness_nm_per_rad
        yield f"full stiffness {stiffness:g} N m/rad" if stiffness else "full stiffness not commissioned: no schedules"

    def activate(self) -> None:
        """Values checked, watchdog set, torque on where the shaft has come to rest, all read back. DeviceError with the
        reason when the motor, or one of its values, refuses, or the shaft goes on turning; then the torque is not on.

        What presses against the probe pushes the shaft back first, so that the torque begins without a load."""
        info = self.info()
        check_ready(info, self.settings, self.where)
        usable = info.limits_deg()
        self._check_within(self._get(registers.PRESENT_POSITION), usable)
        watchdog = round(self.settings.watchdog_s / registers.WATCHDOG_STEP_S)
        goal_current = int(self.settings.goal_current_a / CURRENT_UNIT_A)
        for item, value in (
            (registers.TORQUE, OFF),
            (registers.WATCHDOG, 0),  # also clears one that has run out: goals are refused before
            (registers.P_GAIN, self.settings.full_gain),
            (registers.I_GAIN, 0),
            (registers.D_GAIN, self.settings.d_gain),
            (registers.FEEDFORWARD_1, 0),
            (registers.FEEDFORWARD_2, 0),
            (registers.GOAL_PWM, info.pwm_limit),
            (registers.GOAL_CURRENT, goal_current),
            (registers.PROFILE_ACCELERATION, 0),
            (registers.PROFILE_VELOCITY, 0),
        ):
            self._set_and_read(item, value)
        at = self._at_rest()
        self._check_within(at, usable)
        self._set_and_read(registers.GOAL_POSITION, at, within=_DRIFT_PULSES)
        self._set_and_read(registers.WATCHDOG, watchdog)
        self._set_and_read(registers.TORQUE, ON)
        self._usable_deg, self._limit_a = usable, goal_current * CURRENT_UNIT_A
        self._gain, self._unused = self.settings.full_gain, None

    def deactivate(self) -> None:
        """Torque and watchdog off, read back. DeviceError only when the motor does not confirm after many attempts."""
        self._gain = None
        for _ in range(_OFF_ATTEMPTS):
            for item in (registers.TORQUE, registers.WATCHDOG):
                self._talk.write(self.device_id, item.address, item.data(0), attempts=1)
            read = [self._read(item, attempts=1) for item in (registers.TORQUE, registers.WATCHDOG)]
            if all(status and status.data == b"\0" for status in read):
                return
        raise self._trouble("torque off", "no confirmation", "Switch the power off.")

    def is_active(self) -> bool:
        """Torque on, no hardware error, watchdog not run out? The question also feeds a watchdog that still runs."""
        return self.ask_active()

    def ask_active(self) -> bool:
        """As `is_active`: nothing is sent that would bring a stopped motor back. DeviceError : it is silent."""
        torque = self._good(self._read(registers.TORQUE), registers.TORQUE)
        watchdog = self._get(registers.WATCHDOG)
        return torque.data[0] == ON and not torque.alert and watchdog != registers.WATCHDOG_EXPIRED

    def command(self, position_deg: float, preset: float) -> None:
        """Equilibrium, degrees, and stiffness, a preset of 0 to 1. DeviceError outside the limits."""
        goal = self._goal(position_deg)
        if not 0 <= preset <= 1:
            raise self._trouble("a preset of 0 to 1", f"{preset:g}", "Correct the schedule.")
        gain = round(preset * self.settings.full_gain)
        if gain != self._gain:
            self._gain = None  # unknown until it is confirmed
            self._set(registers.P_GAIN, gain)
            self._gain = gain
        self._set(registers.GOAL_POSITION, goal)

    def move_motors(self, motors_deg: Sequence[float]) -> None:
        """Send a goal, degrees, that the motor may refuse, as it does once its watchdog has run out. DeviceError : it
        is silent."""
        item = registers.GOAL_POSITION
        if self._talk.write(self.device_id, item.address, item.data(self._goal(motors_deg[0]))) is None:
            raise self._silence(item)

    def creep(self, motors_deg: Sequence[float]) -> None:
        """Send the motor there, degrees, slowly, until the next activation. DeviceError : beyond the limits."""
        self._set(registers.PROFILE_VELOCITY, _CREEP)
        self._set(registers.GOAL_POSITION, self._goal(motors_deg[0]))

    def watchdog_ran_out(self) -> bool:
        """Does the motor say that its watchdog has run out? Only 0 written to it clears that."""
        return self._get(registers.WATCHDOG) == registers.WATCHDOG_EXPIRED

    def position_deg(self) -> float:
        """Where the shaft stands, degrees."""
        return self.measurements().shaft_deg

    def measurements(self) -> Measurements:
        """The shaft, which is the motor's. Current and position are read at once, for `currents_a` as well."""
        self._unused = self._reading()
        return self._unused[1]

    def currents_a(self) -> tuple[float, ...]:
        """The motor's current, with the sign of its torque: of the last `measurements`, or read anew when that has been
        asked for already."""
        current, _ = self._unused or self._reading()
        self._unused = None
        return (current * CURRENT_UNIT_A,)

    def current_limit_a(self) -> float:
        """The goal current, A, which the motor does not exceed, as it was read back at the activation. DeviceError : it
        is not active."""
        self._ready()
        return self._limit_a

    def parameters(self) -> dict[int, Parameter]:
        """What is kept without power, by address."""
        return {item.address: Parameter(item.address, item.name, (self._get(item),), "i") for item in registers.EEPROM}

    def set_parameter(self, number: int, values: tuple[float, ...]) -> Parameter:
        """Set what is kept without power and read it back; the parameter as it is then.

        DeviceError : torque on, no such parameter or none to be set here, a value outside its range, or another read.
        """
        item = next((item for item in registers.EEPROM if item.address == number), None)
        if item is None:
            raise self._trouble("a parameter of the motor", str(number), "See emg2vsa rig parameters RIG.")
        if item.range is None:
            raise self._trouble(f"another parameter than {number}, {item.name}", item.fixed, "Leave it as it is.")
        low, high = item.range
        if len(values) != 1 or not float(values[0]).is_integer() or not low <= values[0] <= high:
            found = ", ".join(f"{value:g}" for value in values)
            wanted = f"one whole number of {low} to {high} for parameter {number}, {item.name}"
            raise self._trouble(wanted, found, "Correct the value.")
        self._check_off(item.name)
        self._set_and_read(item, int(values[0]))
        return Parameter(number, item.name, (self._get(item),), "i")

    def set_zeros(self) -> Measurements:
        """Make the present place of the shaft the zero by the Homing Offset, and return what is read then.

        DeviceError : torque on, more than a turn away, or no zero is read back; the offset of before is then set again.
        """
        self._check_off("a zero")
        before, at = self._get(registers.HOMING_OFFSET), self._get(registers.PRESENT_POSITION)
        offset = before + ZERO_PULSE - at
        if abs(offset) > ZERO_PULSE:
            do = "Switch its power off and on, which forgets whole turns."
            raise self._trouble("a shaft within a turn of its encoder", f"{(at - before) / 4096:.1f} turns", do)
        self._set_and_read(registers.HOMING_OFFSET, offset)
        after = self.measurements()
        if abs(after.shaft_deg) > _ZERO_TOLERANCE_PULSES * DEG_PER_PULSE:
            self._set_and_read(registers.HOMING_OFFSET, before)
            raise self._trouble("a shaft at 0 degrees", f"{after.shaft_deg:.2f}", "Hold the shaft still.")
        return after

    def _reading(self) -> tuple[int, Measurements]:
        return self._decoded(self._well(self._read(registers.PRESENT), registers.PRESENT))

    def _decoded(self, present: Status) -> tuple[int, Measurements]:
        current, _, position = struct.unpack("<hii", present.data)
        return current, Measurements((_deg(position),), _deg(position))

    def _goal(self, position_deg: float) -> int:
        low, high = self._ready()
        if not low <= position_deg <= high:
            do = "Correct the schedule, or the limits."
            raise self._trouble(f"a position of {low:.2f} to {high:.2f} degrees", f"{position_deg:g}", do)
        return round(position_deg / DEG_PER_PULSE) + ZERO_PULSE

    def _at_rest(self) -> int:
        """Where the shaft stands, once it does."""
        at = self._get(registers.PRESENT_POSITION)
        for _ in range(_STILL_LOOKS):
            self._clock.sleep_until(self._clock.now_s() + _STILL_S)
            before, at = at, self._get(registers.PRESENT_POSITION)
            if abs(at - before) <= _STILL_PULSES:
                return at
        wanted = f"a shaft at rest within {_STILL_LOOKS * _STILL_S:g} s, its torque off"
        raise self._trouble(wanted, "one that turns", "Look what turns it.")

    def _check_within(self, pulses: int, usable_deg: tuple[float, float]) -> None:
        low, high = usable_deg
        if not low <= _deg(pulses) <= high:
            do = "Turn it there by hand with the power off: it counts its turns from power-on."
            raise self._trouble(f"a shaft at {low:.2f} to {high:.2f} degrees", f"{_deg(pulses):.2f}", do)

    def _ready(self) -> tuple[float, float]:
        if self._usable_deg is None:
            raise self._trouble("known limits", "a motor not activated yet", "Call activate first.")
        return self._usable_deg

    def _check_off(self, what: str) -> None:
        if self._get(registers.TORQUE) != OFF:
            raise self._trouble(f"torque off while {what} is set", "torque on", "Run emg2vsa rig off first.")

    def _read(self, item: Item, **attempts: int) -> Status | None:
        return self._talk.read(self.device_id, item.address, item.size, **attempts)

    def _get(self, item: Item) -> int:
        return item.value(self._good(self._read(item), item).data)

    def _set(self, item: Item, value: int) -> None:
        """Write in a run: a hardware error is told as well."""
        self._well(self._talk.write(self.device_id, item.address, item.data(value)), item)

    def _set_and_read(self, item: Item, value: int, within: int = 0) -> None:
        self._good(self._talk.write(self.device_id, item.address, item.data(value)), item)
        found = self._get(item)
        if abs(found - value) > within:
            self._tell_hardware_error()
            raise self._trouble(f"{value} in {item.name} ({item.address})", str(found), "Check the supply; try again.")

    def _well(self, status: Status | None, item: Item) -> Status:
        if status and status.alert:
            self._tell_hardware_error()
        return self._good(status, item)

    def _good(self, status: Status | None, item: Item) -> Status:
        if status is None:
            raise self._silence(item)
        if status.error:
            if item == registers.GOAL_POSITION and self.watchdog_ran_out():
                wanted = f"a packet at least every {self.settings.watchdog_s:g} s"
                do = "The motor has stopped. Find what held the program up, and start the run anew."
                raise self._trouble(wanted, "a watchdog that has run out", do)
            said = registers.ERRORS.get(status.error, f"error {status.error}")
            raise self._trouble(
                f"{item.name} ({item.address}) done", f"the motor says {said}", "Read emg2vsa rig info."
            )
        return status

    def _tell_hardware_error(self) -> None:
        """DeviceError when there is one."""
        if bits := self._get(registers.HARDWARE_ERROR):
            found, do = fault_words(bits)
            raise DeviceError(f"{self.where}, hardware error", wanted="none", found=found, do=do)

    def _silence(self, item: Item) -> DeviceError:
        found = f"none in 3 attempts of {self.settings.reply_s:g} s"
        return self._trouble(f"a reply to {item.name} ({item.address})", found, "Check power, cable, id and baud rate.")

    def _trouble(self, wanted: str, found: str, do: str) -> DeviceError:
        return DeviceError(self.where, wanted=wanted, found=found, do=do)


def _deg(pulses: int) -> float:
    return (pulses - ZERO_PULSE) * DEG_PER_PULSE
