"""Driver of a qbmove: variable stiffness actuator on a serial line, generations 6 and 7, Maker Pro and Advanced; and
of the rigid motor on a board that speaks as a qbmove does.

Ticks are wire ticks, 32768 to a turn of the shaft at the default resolution. What a run speaks of in degrees and shares
of the full preset becomes ticks here.
Silence is read back: a command that the firmware does not answer is followed by a question, where one exists.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Sequence

from emg2vsa.devices.board import Board
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.protocols import LogColumns, Measurements, Parameter, Usable
from emg2vsa.devices.qbmove import REPLY_S, Generation, Model, packets
from emg2vsa.devices.qbmove.conversation import Conversation
from emg2vsa.devices.qbmove.info import (
    START_LIMIT_TICKS,
    QbmoveInfo,
    QbmoveLimits,
    decode_parameters,
    parse_info,
    stiffness_on_wire,
)
from emg2vsa.devices.qbmove.packets import Command, Wanted, frame
from emg2vsa.devices.qbmove.springs import SpringJoint
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK, LOG_COLUMNS, TICKS_PER_TURN, Ticks
from emg2vsa.devices.serial_line import ByteLine
from emg2vsa.errors import DeviceError

ON, OFF = 3, 0
_LONG_REPLY_S = 0.2
_SETTLE_S = 0.005
"""Time from ACTIVATE until GET_ACTIVATE tells: the 1 kHz loop hands the new state on once per turn."""
_ATTEMPTS = 3
_READINGS = 5
_WATCHDOG_STEPS_PER_S = 50
_OFF_ATTEMPTS = 10
_OFFSETS = 8
"""Parameter that holds what is added to the encoders."""
_ZERO_TICKS = 16
"""Two steps of the encoders."""


class Qbmove(Board):
    """One device. As a context manager it switches the motors off at the end, however that comes."""

    columns = LOG_COLUMNS

    def __init__(
        self,
        line: ByteLine,
        device_id: int,
        *,
        generation: Generation = "v6",
        model: Model = "maker-pro",
        rigid: bool = False,
        clock: Clock,
        stiffness_percent: tuple[float, float] = (20.0, 80.0),
        watchdog_s: float = 0.5,
        reply_s: float = REPLY_S,
    ) -> None:
        """``stiffness_percent``: the study's range, of the maximum preset. ``rigid``: the board of a rigid motor, whose
        motor 2 is not connected. ``watchdog_s``: how long the device waits for a word before it lets go. ``reply_s``:
        how long each of three attempts waits for a short reply."""
        self.device_id, self.generation, self.model, self.rigid = device_id, generation, model, rigid
        self.joint: SpringJoint | None = None
        "Joint of the device, once its motors have been switched on."
        self.where = f"{line.name}, qbmove {device_id}"
        self._line, self._talk = line, Conversation(line, clock)
        self.counts = self._talk.counts
        self._clock, self.stiffness_percent, self._reply_s = clock, stiffness_percent, reply_s
        self._watchdog = round(watchdog_s * _WATCHDOG_STEPS_PER_S)
        self._limits: QbmoveLimits | None = None
        self._commanded: tuple[float, float] | None = None
        "Position and preset of the newest command, within the limits, and its words."
        self._words = 0, 0
        self._read: tuple[int, ...] = 0, 0, 0
        self._at = Ticks(0, 0, 0).measurements()
        self._watching = False

    def close(self) -> None:
        """Give the line back."""
        self._line.close()

    def answers(self) -> bool:
        """True when the device answers."""
        return self._hear(Command.PING, packets.ping_reply(self.device_id)) is not None

    def serial_number(self) -> str:
        """Ten digits, from firmware 7.1 on; else empty."""
        reply = self._hear(Command.PING, packets.ping_reply(self.device_id))
        return f"{int.from_bytes(reply):010d}" if reply else ""

    def info(self) -> QbmoveInfo:
        """What the device says about itself. Generation 6 has no checksum here: two equal readings count.

        DeviceError : no answer, or no two equal ones.
        """
        if self.generation == "v7":
            payload = self._ask(Command.GET_INFO, packets.info_frame(self.device_id), b"\0\0", _LONG_REPLY_S)
            return parse_info(payload.rstrip(b"\0").decode("ascii", "replace"), self.where)
        request = frame(self.device_id, Command.GET_INFO, b"\0\0")
        seen: list[QbmoveInfo] = []
        for reading in range(_READINGS):
            text = self._talk.ask_text(request, timeout_s=_LONG_REPLY_S, again=reading > 0)
            try:
                info = parse_info(text, self.where)
            except DeviceError:
                if reading == _READINGS - 1 and not seen:
                    raise
                continue
            if info in seen:
                return info
            seen.append(info)
        raise self._trouble("info that reads the same twice", "different readings", "Check cable and baud rate.")

    def identify(self) -> QbmoveInfo:
        """`info` of a device as the rig file describes it. DeviceError: silent, or of another generation or model.

        The generations frame their text in different ways, so that a device asked in the wrong one seems to be silent;
        it is then asked in the other.
        """
        said, troubles = self.generation, []
        generations: tuple[Generation, ...] = ("v7", "v6") if said == "v7" else ("v6", "v7")
        for self.generation in generations:
            try:
                info = self.info()
            except DeviceError as error:
                troubles.append(error)
                continue
            finally:
                self.generation = said
            if info.generation != said:
                do = f'Set generation = "{info.generation}" in the rig file.'
                raise DeviceError(f"{self.where}, generation", wanted=f"firmware {said}", found=info.firmware, do=do)
            if not self.rigid:
                info.check_model(self.model, self.where)
                self.joint = self._joint_of(info)
            return info
        raise troubles[0]

    def _joint_of(self, info: QbmoveInfo) -> SpringJoint:
        return SpringJoint(f"qbmove-{self.model}", info.max_stiffness_ticks * DEG_PER_TICK)

    def usable(self, info: QbmoveInfo) -> Usable:
        """What a run may ask of the device of this ``info``: positions at which every stiffness has room."""
        low, high = info.position_limits_ticks[0] if self.rigid else info.roomy_ticks
        return Usable((low * DEG_PER_TICK, high * DEG_PER_TICK), info.max_stiffness_ticks * DEG_PER_TICK)

    def pressing(self) -> Qbmove | RigidMotor:
        """What a run commands: the device, or its motor 1 alone."""
        return RigidMotor(self) if self.rigid else self

    def activate(self) -> None:
        """Watchdog on, motors on, read back. DeviceError with the reason when the device refuses.

        The motors start at their references, which the firmware sets to where they are.
        """
        info = self.info()
        self._limits = QbmoveLimits(self.where, info, self.stiffness_percent)
        self._limits.check_ready()
        self._commanded = None
        self.joint = self._joint_of(info)
        self._watching = True
        for _ in range(_ATTEMPTS):
            self._set_watchdog()
            if self._switch(ON) == ON:
                self._set_watchdog()  # one lost frame must not leave even the first questions without it
                return
        raise self._refusal()

    def deactivate(self) -> None:
        """Motors off, read back. DeviceError only when the device does not confirm after many attempts."""
        self._watching = False
        if not any(self._switch(OFF) == OFF for _ in range(_OFF_ATTEMPTS)):
            raise self._trouble("motors off", "no confirmation", "Switch the power off.")

    def is_active(self) -> bool:
        """Both motors on? The question also feeds the watchdog. A device whose watchdog has run out says no.

        Once the motors have been switched on here, the watchdog's time is sent again with every question: SET_WATCHDOG
        is not answered, and one lost frame would leave the device without a watchdog."""
        if self._watching:
            self._set_watchdog()
        return self.ask_active()

    def ask_active(self) -> bool:
        """Both motors on, by what the device says? Nothing else is sent; the question still feeds a watchdog.
        DeviceError : no answer."""
        return self._ask(Command.GET_ACTIVATE, 1)[0] == ON

    def move_motors(self, motors_deg: Sequence[float]) -> None:
        """References of the two motors, to the nearest tick, whatever springs and study allow. DeviceError outside the
        device's limits."""
        limits = self._ready_limits()
        asked = (angle_deg / DEG_PER_TICK for angle_deg in motors_deg)
        motor_1_ticks, motor_2_ticks = self._whole("positions that are numbers", *asked)
        limits.check_motor(1, motor_1_ticks)
        limits.check_motor(2, motor_2_ticks)
        self._tell_ticks(Command.SET_INPUTS, motor_1_ticks, motor_2_ticks)

    def command(self, position_deg: float, preset: float) -> None:
        """Equilibrium (q1 + q2)/2, degrees, and preset (q1 - q2)/2, share of the device's own maximum; both to the
        nearest tick. DeviceError outside the device's or the study's limits."""
        limits = self._ready_limits()
        if (position_deg, preset) != self._commanded:
            self._words, self._commanded = self._words_of(limits, position_deg, preset), (position_deg, preset)
        self._tell_ticks(Command.SET_POS_STIFF, *self._words)

    def _words_of(self, limits: QbmoveLimits, position_deg: float, preset: float) -> tuple[int, int]:
        """Position and stiffness of SET_POS_STIFF."""
        asked = position_deg / DEG_PER_TICK, preset * limits.info.max_stiffness_ticks
        position_ticks, preset_ticks = self._whole("a position and a preset that are numbers", *asked)
        limits.check_position(position_ticks)
        limits.check_preset(preset_ticks)
        stiffness = stiffness_on_wire(preset_ticks, limits.info.max_stiffness_ticks)
        if stiffness > 0x7FFF:
            below = "a preset below the device's maximum"
            raise self._trouble(below, f"{preset_ticks} ticks", "Ask for one tick less.")
        return position_ticks, stiffness

    def position_deg(self) -> float:
        """Equilibrium (q1 + q2)/2 of the motors where they stand, degrees."""
        at = self.ticks()
        return (at.motor_1 + at.motor_2) / 2 * DEG_PER_TICK

    def measurements(self) -> Measurements:
        """Motors and shaft."""
        words = self._ask_words(Command.GET_MEASUREMENTS, 3)
        if words != self._read:
            self._read, self._at = words, Ticks(*words).measurements()
        return self._at

    def ticks(self) -> Ticks:
        """Motors and shaft as they are on the wire."""
        return Ticks(*self._ask_words(Command.GET_MEASUREMENTS, 3))

    def currents_a(self) -> tuple[float, ...]:
        """Motor currents, A, with the sign of the PWM. (134, currents and positions at once, loses the shaft.)"""
        first_ma, second_ma = self._ask_words(Command.GET_CURRENTS, 2)
        return first_ma / 1000, second_ma / 1000

    def current_limit_a(self) -> float:
        """Largest current of a motor, A, as the device told at its activation; its firmware keeps it only in the
        current modes, which no run uses. DeviceError : it was not activated."""
        return self._ready_limits().info.current_limit_ma / 1000

    def parameters(self) -> dict[int, Parameter]:
        """All parameters by number. Generation 6 shows what is stored, not what has been set since. DeviceError : no
        answer."""
        reply = packets.parameter_list(self.generation, self.device_id)
        return decode_parameters(self._ask(Command.GET_PARAM_LIST, reply, b"\0\0", _LONG_REPLY_S), self.where)

    def set_parameter(self, number: int, values: tuple[float, ...]) -> Parameter:
        """Set a parameter by its number, store all, and read the list back; the parameter as it is then.

        DeviceError : motors on, no such parameter, values that do not fit its type or count, or other values read back.
        """
        self._check_off("a parameter")
        before = self.parameters().get(number)
        if before is None:
            raise self._trouble("a parameter that the device lists", str(number), "See emg2vsa rig parameters RIG.")
        try:
            whole = before.form not in "fd"
            if whole and any(value != int(value) for value in values):
                raise struct.error("whole numbers wanted")
            payload = struct.pack(f">{len(before.values)}{before.form}", *(int(v) if whole else v for v in values))
        except (struct.error, OverflowError, ValueError) as error:
            wanted_text = f"{len(before.values)} values of type {before.form!r} for parameter {number}, {before.name}"
            raise self._trouble(wanted_text, f"{_shown(values)} ({error})", "Correct the values.") from error
        numbered = struct.pack(">h", number) + payload
        if self.generation == "v7":
            self._acknowledged(Command.GET_PARAM_LIST, numbered)
        else:  # generation 6 does not answer, and shows the new value only when it is stored
            self._talk.tell(frame(self.device_id, Command.GET_PARAM_LIST, numbered))
        self._acknowledged(Command.STORE_PARAMS)
        after = self.parameters()[number]
        if struct.pack(f">{len(after.values)}{after.form}", *after.values) != payload:
            found, do = _shown(after.values), "Read the parameters again; the device may limit this one."
            raise self._trouble(f"{_shown(values)} in parameter {number}, {before.name}", found, do)
        return after

    def set_zeros(self) -> Measurements:
        """Make the present place of motors and shaft their zero, store it, and return what is read then.

        DeviceError : motors on, or no zeros are read back; the offsets of before are then set again.
        """
        self._check_off("zeros")
        before = tuple(int(offset) for offset in self.parameters()[_OFFSETS].values)
        offsets = tuple(_wrapped(offset - at) for offset, at in zip(before, self.ticks(), strict=True))
        # an Advanced shows its motors' offsets with the other sign; whether SET_ZEROS takes them so is not published
        for payload in dict.fromkeys((offsets, (-offsets[0], -offsets[1], offsets[2]))):
            self._send_zeros(payload)
            if max(map(abs, self.ticks())) <= _ZERO_TICKS:
                self._acknowledged(Command.STORE_PARAMS)
                return self.measurements()
            if self.generation == "v7":
                break
        if self.generation == "v6":
            self._send_zeros(before)
        raise self._trouble("zeros within 16 ticks", _shown(self.ticks()), "Set parameter 8 with qbadmin.")

    def _send_zeros(self, offsets: tuple[int, ...]) -> None:
        """Generation 7 takes no offsets: it makes zero of where it is."""
        payload = b"" if self.generation == "v7" else struct.pack(">3h", *offsets)
        self._acknowledged(Command.SET_ZEROS, payload)
        self._clock.sleep_until(self._clock.now_s() + _SETTLE_S)

    def _acknowledged(self, command: Command, payload: bytes = b"") -> None:
        request = frame(self.device_id, command, payload)
        expected = packets.acknowledgement(self.generation, self.device_id, command)
        reply = self._talk.ask(request, expected, timeout_s=max(_LONG_REPLY_S, self._reply_s), attempts=1)
        done = reply is not None and (reply.payload[0] if self.generation == "v7" else reply.command) == 1
        if not done:
            found = "no answer" if reply is None else "a refusal"
            raise self._trouble(f"{command.name} done", found, "Read the device again: emg2vsa rig info.")

    def _check_off(self, what: str) -> None:
        if self._ask(Command.GET_ACTIVATE, 1)[0] != OFF:
            raise self._trouble(f"motors off while {what} are set", "motors on", "Run emg2vsa rig off first.")

    def _set_watchdog(self) -> None:
        self._talk.tell(frame(self.device_id, Command.SET_WATCHDOG, bytes((self._watchdog,))))

    def _switch(self, state: int) -> int | None:
        self._talk.tell(frame(self.device_id, Command.ACTIVATE, bytes((state,))))
        self._clock.sleep_until(self._clock.now_s() + _SETTLE_S)
        reply = self._hear(Command.GET_ACTIVATE, 1)
        return reply[0] if reply else None

    def _refusal(self) -> DeviceError:
        at = self.ticks()
        beyond = [f"{name} at {ticks}" for name, ticks in at._asdict().items() if abs(ticks) > START_LIMIT_TICKS]
        wanted_text = f"motors on, which needs every encoder within {START_LIMIT_TICKS} ticks of zero"
        if beyond:
            return self._trouble(wanted_text, ", ".join(beyond), "Turn it back by hand, or set the zeros anew.")
        return self._trouble("motors on", "a silent refusal, all encoders in range", "Check the motors' supply.")

    def _whole(self, wanted_text: str, *ticks: float) -> list[int]:
        if not all(map(math.isfinite, ticks)):
            raise self._trouble(wanted_text, _shown(ticks), "Correct the schedule.")
        return [round(each) for each in ticks]

    def _ready_limits(self) -> QbmoveLimits:
        if self._limits is None:
            raise self._trouble("known limits", "motors not activated yet", "Call activate first.")
        return self._limits

    def _tell_ticks(self, command: Command, first: int, second: int) -> None:
        self._talk.tell(frame(self.device_id, command, struct.pack(">hh", first, second)))

    def _ask_words(self, command: Command, count: int) -> tuple[int, ...]:
        return struct.unpack(f">{count}h", self._ask(command, 2 * count))

    def _ask(self, command: Command, expected: Wanted | int, payload: bytes = b"", least_s: float = 0.0) -> bytes:
        """The reply, of a length in bytes where no more is to be said of it."""
        reply = self._hear(command, expected, payload, least_s)
        if reply is None:
            found = f"none in {_ATTEMPTS} attempts of {max(least_s, self._reply_s):g} s"
            raise self._trouble(f"a reply to {command.name}", found, "Check power, cable, id and baud rate.")
        return reply

    def _hear(
        self, command: Command, expected: Wanted | int, payload: bytes = b"", least_s: float = 0.0
    ) -> bytes | None:
        request = frame(self.device_id, command, payload)
        if isinstance(expected, int):
            expected = packets.wanted(self.device_id, command, expected)
        reply = self._talk.ask(request, expected, timeout_s=max(least_s, self._reply_s), attempts=_ATTEMPTS)
        return None if reply is None else reply.payload

    def _trouble(self, wanted_text: str, found: str, do: str) -> DeviceError:
        return DeviceError(self.where, wanted=wanted_text, found=found, do=do)


class RigidMotor:
    """The paper's high-stiffness condition: motor 1 of a board, an actuator without springs; motor 2 is not connected.

    Watchdog, limits and read-back are the board's.
    """

    joint = None
    columns: LogColumns = LOG_COLUMNS

    def __init__(self, board: Qbmove) -> None:
        self._board, self.where = board, f"{board.where}, rigid motor"
        self.activate, self.deactivate, self.is_active = board.activate, board.deactivate, board.is_active
        self.currents_a, self.current_limit_a = board.currents_a, board.current_limit_a

    def command(self, position_deg: float, preset: float) -> None:
        """Send the motor there. DeviceError outside the board's limits, or for a preset other than 0."""
        if preset != 0:
            do = "Use the qbmove for a schedule of stiffness."
            raise DeviceError(self.where, wanted="preset 0: it has no springs", found=f"{preset:g}", do=do)
        self._board.move_motors((position_deg, 0.0))

    def position_deg(self) -> float:
        """Where motor 1 stands, degrees; motor 2, not connected, has no say."""
        return self._board.measurements().motors_deg[0]

    def measurements(self) -> Measurements:
        """Encoders; the shaft is motor 1's."""
        at = self._board.measurements()
        return Measurements(at.motors_deg, at.motors_deg[0])


def _wrapped(ticks: int) -> int:
    """An encoder knows its place only within a turn."""
    half = TICKS_PER_TURN // 2
    return (ticks + half) % TICKS_PER_TURN - half


def _shown(values: Iterable[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
