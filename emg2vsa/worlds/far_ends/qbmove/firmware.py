"""A qbmove of generation 6, to the byte: ``commProcess`` of command_processing.c in NMMI/qbmove-maker-pro (v6.1.0) and
NMMI/qbmove-advanced (v6.1.6), with its silences, its two copies of the settings and its faults.

It answers the commands that `emg2vsa.devices.qbmove` sends. What the sources leave open: stale bytes are zeros.
"""

from __future__ import annotations

import copy
import math
import struct
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache, partial

import numpy as np

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.qbmove.packets import HEADER, LONGEST_BODY, Command, frame, lrc
from emg2vsa.worlds.far_ends.actuator_end import Loads, Shaft, Torques, no_loads
from emg2vsa.worlds.far_ends.qbmove.memory import (
    FORMATS,
    Memory,
    Switches,
    info_text,
    parameter_list,
    set_slot,
    slots,
)  # fmt: skip
from emg2vsa.worlds.far_ends.qbmove.motors import Loop, Motors, References

START_LIMIT = 26000
"""Internal ticks beyond which ACTIVATE is refused: a rotation may have been lost."""
_LONGEST_WATCHDOG = 250
_OFFSETS = 8
DONE = 1

BROADCAST_ID = 0
LEAST_LENGTH = 2
_TWO_WORDS = struct.Struct(">Bhh")
_ID, _LENGTH, _COMMAND = 2, 3, 4
"""Where these stand in a frame."""


class QbmoveFrames:
    """Frames on a wire that fails, as `emg2vsa.worlds.far_ends.faults.Frames`."""

    position_commands: frozenset[int] = frozenset((Command.SET_POS_STIFF, Command.SET_INPUTS))
    watchdog_commands: frozenset[int] = frozenset((Command.SET_WATCHDOG,))

    def without(self, data: bytes, commands: frozenset[int]) -> bytes:
        """``data`` but for the frames of ``commands``; what is no whole frame stays as it is."""
        kept, at = b"", 0
        while (start := data.find(HEADER, at)) >= 0 and start + _COMMAND < len(data):
            end = start + _COMMAND + data[start + _LENGTH]
            kept += data[at : start if data[start + _COMMAND] in commands and end <= len(data) else end]
            at = end
        return kept + data[at:]

    def renamed(self, data: bytes, shift: int) -> bytes:
        """An answer under another id, which its checksum does not cover."""
        if data[:2] != HEADER or len(data) <= _ID:
            return data
        return data[:_ID] + bytes(((data[_ID] + shift) % 256,)) + data[_ID + 1 :]


class FrameParser:
    """Bytes in; out come the bodies of frames for this device or for all, checksum not yet looked at: what the
    ``interrupt_manager`` of interruptions.c (v6.1) does.

    It matches two colons and nothing else, so a third one becomes an id; it waits for missing bytes without limit;
    frames for others are skipped by their length.
    """

    def __init__(self, own_id: Callable[[], int]) -> None:
        self._own_id, self._unread = own_id, bytearray()

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Bodies, one at a time: what the one changes counts for the next."""
        unread = self._unread
        unread += data
        while (start := unread.find(HEADER)) >= 0:
            del unread[:start]
            if len(unread) < _COMMAND:
                return
            length = unread[_LENGTH]
            if not LEAST_LENGTH <= length <= LONGEST_BODY:
                del unread[:_COMMAND]
                continue
            if len(unread) < _COMMAND + length:
                return
            device_id, body = unread[_ID], bytes(unread[_COMMAND : _COMMAND + length])
            del unread[: _COMMAND + length]
            if device_id in (BROADCAST_ID, self._own_id()):
                yield body
        del unread[:-1]


class QbmoveFirmware:
    """Bytes in, bytes out. A reset keeps what has been stored."""

    def __init__(
        self,
        switches: Switches,
        shaft: Shaft,
        clock: Clock,
        *,
        memory: Memory | None = None,
        motors_rad: Torques = (0.0, 0.0),
        loads: Loads = no_loads,
        latency_s: float = 0.0,
        serial_number: str = "",
    ) -> None:
        """``memory``: what is stored at the start, instead of the factory's settings. ``loads``: on the motors.
        ``latency_s``: from a command to the motors until their loop knows of it. ``serial_number``: decimal
        digits, told with a ping as by firmware from 7.1 on."""
        self._number = int(serial_number).to_bytes(4) if serial_number else b""
        self._switches, self._clock = switches, clock
        self._stored = memory or switches.factory()
        self._loop = Loop(switches, shaft, clock, motors_rad, loads, latency_s)
        self._asked: dict[Command, Callable[[], Sequence[int]]] = {
            Command.GET_MEASUREMENTS: self._measured,
            Command.GET_CURRENTS: self._loop.motors.currents_ma,
        }
        self._told: dict[Command, Callable[[int, int], None]] = {
            Command.SET_INPUTS: self._set_inputs,
            Command.SET_POS_STIFF: self._set_position_stiffness,
        }
        self._handlers = self._commands()
        self._advanced_s: float | None = None
        self._start()

    due_s = math.inf
    "It answers at once."

    def __call__(self, data: bytes) -> bytes:
        """Hear ``data`` at the clock's time, and answer."""
        if data:
            self._hear()
        else:
            self.advance()
        return b"".join(map(self._answer, self._parser.feed(data)))

    def ask(self, command: Command) -> tuple[int, ...]:
        """The words that answer GET_MEASUREMENTS or GET_CURRENTS, as if a frame had come, for who needs no bytes."""
        self._hear()
        return tuple([(value + 0x8000) % 0x10000 - 0x8000 for value in self._asked[command]()])  # ``_word``, in line

    def ask_active(self) -> int:
        """What answers GET_ACTIVATE, likewise."""
        self._hear()
        return self._loop.current.on

    def tell(self, command: Command, first: int, second: int) -> None:
        """SET_POS_STIFF or SET_INPUTS with two words, as if a frame had come."""
        self._hear()
        _TWO_WORDS.pack_into(self._buffer, 0, command, first, second)
        self._told[command](first, second)

    def _hear(self) -> None:
        if self._clock.now_s() != self._advanced_s:
            self.advance()
        self._loop.feed_watchdog(self._watchdog_counts)

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
        self._watchdog_counts = self._shadow.watchdog_counts
        self._loop.restart(self._current.startup)
        self._loop.feed_watchdog(self._watchdog_counts)
        self._loop.motors.forget_turns(self._shadow)

    def _answer(self, body: bytes) -> bytes:
        if lrc(body[:-1]) != body[-1] or body[0] not in self._handlers:
            return b""
        # a payload that is too short is read on into what the last frame left behind
        self._buffer[: len(body)] = body
        return self._handlers[body[0]]()

    def _commands(self) -> dict[int, Callable[[], bytes]]:
        return {
            Command.PING: self._ping,
            Command.SET_ZEROS: self._set_zeros,
            Command.STORE_PARAMS: self._store,
            Command.GET_INFO: lambda: self._info() if self._words(1) == (0,) else b"",
            Command.GET_PARAM_LIST: self._parameter,
            Command.ACTIVATE: self._activate,
            Command.GET_ACTIVATE: lambda: self._reply(Command.GET_ACTIVATE, bytes((self._loop.current.on,))),
            **{command: partial(self._hear_words, command) for command in self._told},
            **{command: partial(self._answer_words, command) for command in self._asked},
            Command.SET_WATCHDOG: self._set_watchdog,
        }

    def _words(self, count: int) -> tuple[int, ...]:
        return struct.unpack_from(f">{count}h", self._buffer, 1)

    def _reply(self, command: int, payload: bytes) -> bytes:
        # listens to the stored id, answers with the one that has been set
        return frame(self._shadow.device_id, command, payload)

    def _hear_words(self, command: Command) -> bytes:
        first, second = self._words(2)
        self._told[command](first, second)
        return b""

    def _answer_words(self, command: Command) -> bytes:
        values = self._asked[command]()
        return self._reply(command, struct.pack(f">{len(values)}h", *map(_word, values)))

    def _acknowledge(self, command: int, device_id: int) -> bytes:
        return frame(device_id, DONE)

    def _ping(self) -> bytes:
        return self._reply(Command.PING, self._number)

    def _measured(self) -> tuple[int, int, int]:
        (first, second, shaft), bits = self._loop.motors.measured(self._shadow), self._shadow.resolutions
        return first >> bits[0], second >> bits[1], shaft >> bits[2]

    def _set_inputs(self, first: int, second: int) -> None:
        limited, bits = self._current.limited, self._shadow.resolutions
        sign = -1 if self._switches.counts_backwards else 1
        ticks = sign * limited(sign * (first << bits[0]), 0), sign * limited(sign * (second << bits[1]), 1)
        self._loop.command(ticks)

    def _set_position_stiffness(self, position: int, stiffness: int) -> None:
        low, high, most = self._current.limits[0], self._current.limits[1], self._current.max_stiffness
        at = max(min(position << self._shadow.resolutions[0], high - most), low + most)
        preset = _preset(most, stiffness)
        self._loop.command((at + preset, at - preset))

    def _activate(self) -> bytes:
        measured = self._loop.motors.measured(self._shadow)
        refused = any(abs(ticks) > START_LIMIT for ticks in measured)
        self._loop.activate(References(measured[:2], 0 if refused else self._buffer[1]))
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
        if 0 < index <= self._switches.parameters:
            self._set_parameter(index)
        if index:
            return b""
        # the length in one byte, and the checksum over as much as that byte says: 176 of 1200
        body = bytes((Command.GET_PARAM_LIST,)) + parameter_list(self._current, self._switches.parameters)
        covered = len(body) & 0xFF
        return b"::" + bytes((self._shadow.device_id, len(body) + 1 & 0xFF)) + body + bytes((lrc(body[:covered]),))

    def _set_parameter(self, number: int) -> None:
        kind, shown, _ = slots(self._shadow)[number - 1]
        values = struct.unpack_from(f">{len(shown)}{FORMATS[kind]}", self._buffer, 3)
        if number == _OFFSETS and self._switches.counts_backwards:
            values = (-values[0], -values[1], values[2])
        set_slot(self._shadow, number, values)
        if number == _OFFSETS:
            self._loop.motors.forget_turns(self._shadow)

    def _store(self) -> bytes:
        old_id = self._current.device_id
        moved = [new - old for new, old in zip(self._shadow.offsets, self._current.offsets, strict=True)]
        first, second = (
            self._current.limited(at + by, k)
            for k, (at, by) in enumerate(zip(self._loop.new.ticks, moved, strict=False))
        )
        self._loop.new = References((first, second), self._loop.new.on)
        self._stored, self._current = copy.deepcopy(self._shadow), copy.deepcopy(self._shadow)
        return self._acknowledge(Command.STORE_PARAMS, old_id)

    def _info(self) -> bytes:
        motors = self._loop.motors
        supply_mv = 0 if motors.faults.unsupplied else self._switches.supply_mv
        resolutions = self._shadow.resolutions
        references = [ticks >> bits for ticks, bits in zip(self._loop.old.ticks, resolutions, strict=False)]
        return info_text(
            self._current, self._shadow, self._switches, references=references, measurements=self._measured(),
            currents_ma=motors.currents_ma(), on=self._loop.current.on, supply_mv=supply_mv,
        )  # fmt: skip


@lru_cache(maxsize=256)
def _preset(most: int, stiffness: int) -> int:
    """In single precision, as the firmware computes it."""
    return int(np.float32(most) / np.float32(32768) * np.float32(stiffness))


def _word(value: int) -> int:
    """As a C cast to int16 keeps it."""
    return (value + 0x8000) % 0x10000 - 0x8000
