"""A qbmove of generation 6, to the byte: ``commProcess`` of command_processing.c in NMMI/qbmove-maker-pro (v6.1.0) and
NMMI/qbmove-advanced (v6.1.6), with its silences, its two copies of the settings and its faults.

What the sources leave open: stale bytes on the wire are zeros, command counters stay zero, CALIBRATE is deaf for its
time but changes nothing, and the bootloader never speaks.
"""

from __future__ import annotations

import copy
import math
import struct
from collections.abc import Callable, Sequence
from functools import lru_cache, partial

import numpy as np

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.qbmove.packets import Command, frame, lrc
from emg2vsa.worlds.far_ends.qbmove.loop import Loads, Loop, References, Shaft, limited, no_loads
from emg2vsa.worlds.far_ends.qbmove.memory import Memory, set_slot, slots
from emg2vsa.worlds.far_ends.qbmove.motors import Motors
from emg2vsa.worlds.far_ends.qbmove.parser import INFO_REQUEST, FrameParser
from emg2vsa.worlds.far_ends.qbmove.switches import Switches
from emg2vsa.worlds.far_ends.qbmove.texts import Now, info_text, parameter_list

START_LIMIT = 26000
"""Internal ticks beyond which ACTIVATE is refused: a rotation may have been lost."""
_LONGEST_WATCHDOG = 250
_CALIBRATION_S = 9.0
"""Two pauses of a second and half a degree every 0.1 s up to the default stiffness."""
_POSITION_MODES = (0, 3, 4, 5)
_LIMITED_MODES_OF_ADVANCED = (0, 3)
_FORMATS = {0: "B", 2: "B", 3: "h", 5: "i", 7: "f"}
_OFFSETS = 8
DONE = 1


class QbmoveFirmware:
    """Bytes in, bytes out. A reset keeps what has been stored."""

    def __init__(
        self,
        switches: Switches,
        shaft: Shaft,
        clock: Clock,
        *,
        memory: Memory | None = None,
        motors_rad: tuple[float, float] = (0.0, 0.0),
        loads: Loads = no_loads,
        latency_s: float = 0.0,
    ) -> None:
        """``memory``: what is stored at the start, instead of the factory's settings. ``loads``: on the motors.
        ``latency_s``: from a command to the motors until their loop knows of it."""
        self._switches, self._clock = switches, clock
        self._stored = memory or switches.factory()
        self._default = copy.deepcopy(self._stored)
        self._loop = Loop(switches, shaft, clock, motors_rad, loads, latency_s)
        self._asked: dict[Command, Callable[[], Sequence[int]]] = {
            Command.GET_MEASUREMENTS: self._measured,
            Command.GET_CURRENTS: self._loop.motors.currents_ma,
        }
        self._handlers = self._commands()
        self._advanced_s: float | None = None
        self._start()

    due_s = math.inf
    "It answers at once."

    def __call__(self, data: bytes) -> bytes:
        """Hear ``data`` at the clock's time, and answer."""
        self.advance()
        if self._clock.now_s() < self._deaf_until_s:
            return b""
        if data:
            self._loop.feed_watchdog(self._watchdog_counts)
        return b"".join(map(self._answer, self._parser.feed(data)))

    def ask(self, command: Command) -> tuple[int, ...]:
        """The words that answer GET_MEASUREMENTS or GET_CURRENTS, as if a frame had come, for who needs no bytes."""
        self.advance()
        self._loop.feed_watchdog(self._watchdog_counts)
        return tuple(map(_word, self._asked[command]()))

    def ask_active(self) -> int:
        """What answers GET_ACTIVATE, likewise."""
        self.advance()
        self._loop.feed_watchdog(self._watchdog_counts)
        return self._loop.current.on

    def tell(self, command: Command, first: int, second: int) -> None:
        """SET_POS_STIFF or SET_INPUTS with two words, as if a frame had come."""
        self.advance()
        self._loop.feed_watchdog(self._watchdog_counts)
        struct.pack_into(">Bhh", self._buffer, 0, command, first, second)
        self._handlers[command]()

    def advance(self) -> None:
        """Run the control loop up to the clock, for those who look at the world and not at the line."""
        now_s = self._clock.now_s()
        if now_s != self._advanced_s:  # asked many times in a turn of the control loop
            self._loop.advance(self._current, self._shadow)
            self._advanced_s = now_s

    @property
    def motors(self) -> Motors:
        """Of this device, with their faults."""
        self.advance()
        return self._loop.motors

    @property
    def state(self) -> References:
        """What the control loop follows now."""
        self.advance()
        return self._loop.current

    def reset(self) -> None:
        """Power off and on: unstored settings, references and lost rotations are forgotten."""
        self.advance()
        self._start()

    def _start(self) -> None:
        self._current, self._shadow = copy.deepcopy(self._stored), copy.deepcopy(self._stored)
        self._parser = FrameParser(lambda: self._current.device_id)
        self._buffer = bytearray(128)
        self._deaf_until_s = 0.0
        self._watchdog_counts = self._shadow.watchdog_counts
        self._loop.restart(self._current.startup)
        self._loop.feed_watchdog(self._watchdog_counts)
        self._loop.motors.forget_turns(self._shadow)

    def _answer(self, body: bytes) -> bytes:
        if body == INFO_REQUEST:
            return self._info()
        if lrc(body[:-1]) != body[-1] or body[0] not in self._handlers:
            return b""
        # a payload that is too short is read on into what the last frame left behind
        self._buffer[: len(body)] = body
        return self._handlers[body[0]]()

    def _commands(self) -> dict[int, Callable[[], bytes]]:
        handlers: dict[int, Callable[[], bytes]] = {
            Command.PING: self._ping,
            Command.SET_ZEROS: self._set_zeros,
            Command.STORE_PARAMS: self._store,
            Command.STORE_DEFAULT_PARAMS: self._store_default,
            Command.RESTORE_PARAMS: lambda: self._restore(self._default, Command.RESTORE_PARAMS),
            Command.GET_INFO: lambda: self._info() if self._words(1) == (0,) else b"",
            Command.BOOTLOADER: lambda: self._deaf_for(math.inf, Command.BOOTLOADER),
            Command.INIT_MEM: self._init,
            Command.CALIBRATE: lambda: self._deaf_for(_CALIBRATION_S, Command.CALIBRATE),
            Command.GET_PARAM_LIST: self._parameter,
            Command.ACTIVATE: self._activate,
            Command.GET_ACTIVATE: lambda: self._reply(Command.GET_ACTIVATE, bytes((self._loop.current.on,))),
            Command.SET_INPUTS: self._set_inputs,
            Command.GET_INPUTS: self._get_inputs,
            **{command: partial(self._answer_words, command) for command in self._asked},
            Command.GET_CURR_AND_MEAS: self._currents_and_measurements,
            Command.SET_POS_STIFF: self._set_position_stiffness,
            Command.GET_VELOCITIES: lambda: self._reply_words(Command.GET_VELOCITIES, 0, 0, 0),
            Command.SET_WATCHDOG: self._set_watchdog,
            Command.SET_BAUDRATE: lambda: b"",
        }
        if self._switches.has_counters:
            handlers[Command.GET_COUNTERS] = lambda: self._reply_words(Command.GET_COUNTERS, *[0] * 20)
        return handlers

    def _words(self, count: int) -> tuple[int, ...]:
        return struct.unpack_from(f">{count}h", self._buffer, 1)

    def _reply(self, command: int, payload: bytes) -> bytes:
        # listens to the stored id, answers with the one that has been set
        return frame(self._shadow.device_id, command, payload)

    def _answer_words(self, command: Command) -> bytes:
        return self._reply_words(command, *self._asked[command]())

    def _reply_words(self, command: int, *values: int) -> bytes:
        return self._reply(command, struct.pack(f">{len(values)}h", *map(_word, values)))

    def _acknowledge(self, command: int, device_id: int) -> bytes:
        return frame(device_id, DONE)

    def _ping(self) -> bytes:
        return self._reply(Command.PING, b"")

    def _measured(self) -> list[int]:
        ticks = self._loop.motors.measured(self._shadow)
        return [value >> bits for value, bits in zip(ticks, self._shadow.resolutions, strict=True)]

    def _references(self) -> tuple[int, int]:
        first, second = (
            ticks >> bits for ticks, bits in zip(self._loop.old.ticks, self._shadow.resolutions, strict=False)
        )
        return first, second

    def _get_inputs(self) -> bytes:
        sign = -1 if self._switches.counts_backwards else 1
        return self._reply_words(Command.GET_INPUTS, *(sign * ticks for ticks in self._references()))

    def _currents_and_measurements(self) -> bytes:
        """Twice too large a step through the positions: two stale bytes after motor 1, and no shaft."""
        motor_1, motor_2, _ = self._measured()
        return self._reply_words(Command.GET_CURR_AND_MEAS, *self._loop.motors.currents_ma(), motor_1, 0, motor_2)

    def _set_inputs(self) -> bytes:
        ticks = [word << bits for word, bits in zip(self._words(2), self._shadow.resolutions, strict=False)]
        backwards = self._switches.counts_backwards
        if not backwards or self._shadow.control_mode in _LIMITED_MODES_OF_ADVANCED:
            sign = -1 if backwards else 1
            ticks = [sign * limited(sign * value, motor, self._current) for motor, value in enumerate(ticks)]
        self._loop.command((ticks[0], ticks[1]))
        return b""

    def _set_position_stiffness(self) -> bytes:
        position, stiffness = self._words(2)
        low, high, most = self._current.limits[0], self._current.limits[1], self._current.max_stiffness
        at = max(min(position << self._shadow.resolutions[0], high - most), low + most)
        preset = _preset(most, stiffness)
        self._loop.command((at + preset, at - preset))
        return b""

    def _activate(self) -> bytes:
        measured = self._loop.motors.measured(self._shadow)
        refused = any(abs(ticks) > START_LIMIT for ticks in measured)
        keeps = self._shadow.control_mode not in _POSITION_MODES
        ticks = self._loop.new.ticks if keeps else measured[:2]
        self._loop.bridge_on = None
        self._loop.activate(References(ticks, 0 if refused else self._buffer[1]))
        return b""

    def _set_watchdog(self) -> bytes:
        steps = min(self._buffer[1], _LONGEST_WATCHDOG)
        self._watchdog_counts = self._shadow.watchdog_counts = steps * 2 * 250 >> 10
        self._loop.feed_watchdog(self._watchdog_counts)
        return b""

    def _set_zeros(self) -> bytes:
        offsets = self._words(3)
        self._shadow.offsets = [ticks << bits for ticks, bits in zip(offsets, self._shadow.resolutions, strict=True)]
        self._loop.motors.forget_turns(self._shadow)
        return self._acknowledge(Command.SET_ZEROS, self._shadow.device_id)

    def _parameter(self) -> bytes:
        (index,) = self._words(1)
        if index == 0:
            return self._list()
        if 0 < index <= self._switches.parameters:
            self._set_parameter(index)
        return b""

    def _list(self) -> bytes:
        """The length in one byte, and the checksum over as much as that byte says: 176 of 1200."""
        payload = parameter_list(self._current, self._switches.parameters, self._switches.parameter_bytes)
        body = bytes((Command.GET_PARAM_LIST,)) + payload
        covered = len(body) & 0xFF
        return b"::" + bytes((self._shadow.device_id, len(body) + 1 & 0xFF)) + body + bytes((lrc(body[:covered]),))

    def _set_parameter(self, number: int) -> None:
        kind, shown, _ = slots(self._shadow)[number - 1]
        form = _FORMATS[kind]
        values = struct.unpack_from(f">{len(shown) // struct.calcsize(form)}{form}", self._buffer, 3)
        if number == _OFFSETS and self._switches.counts_backwards:
            values = (-values[0], -values[1], values[2])
        set_slot(self._shadow, number, values)
        if number == _OFFSETS:
            self._loop.motors.forget_turns(self._shadow)

    def _store(self) -> bytes:
        old_id = self._current.device_id
        if self._current.input_mode == 0:
            moved = [new - old for new, old in zip(self._shadow.offsets, self._current.offsets, strict=True)]
            ticks = [
                limited(at + by, k, self._current)
                for k, (at, by) in enumerate(zip(self._loop.new.ticks, moved, strict=False))
            ]
            self._loop.new = References((ticks[0], ticks[1]), self._loop.new.on)
        self._keep()
        return self._acknowledge(Command.STORE_PARAMS, old_id)

    def _keep(self) -> None:
        self._stored, self._current = copy.deepcopy(self._shadow), copy.deepcopy(self._shadow)

    def _store_default(self) -> bytes:
        self._current, self._default = copy.deepcopy(self._shadow), copy.deepcopy(self._shadow)
        return self._acknowledge(Command.STORE_DEFAULT_PARAMS, self._shadow.device_id)

    def _restore(self, memory: Memory, command: Command) -> bytes:
        self._shadow = copy.deepcopy(memory)
        self._keep()
        return self._acknowledge(command, self._shadow.device_id)

    def _init(self) -> bytes:
        self._default = self._switches.factory()
        return self._restore(self._default, Command.INIT_MEM)

    def _deaf_for(self, duration_s: float, command: Command) -> bytes:
        self._deaf_until_s = self._clock.now_s() + duration_s
        return self._acknowledge(command, self._shadow.device_id)

    def _info(self) -> bytes:
        motors = self._loop.motors
        supply_mv = 0 if motors.faults.unsupplied else self._switches.supply_mv
        on = self._loop.current.on
        now = Now(self._references(), tuple(self._measured()), motors.currents_ma(), on, supply_mv)
        return info_text(self._current, self._shadow, now, self._switches)


@lru_cache(maxsize=256)
def _preset(most: int, stiffness: int) -> int:
    """In single precision, as the firmware computes it."""
    return int(np.float32(most) / np.float32(32768) * np.float32(stiffness))


def _word(value: int) -> int:
    """As a C cast to int16 keeps it."""
    return (value + 0x8000) % 0x10000 - 0x8000
