"""The half-duplex bus: who answers to a packet, in which order, and when.

Answers wait for the Return Delay Time of their motor on the clock. Bytes take no time on the bus, and the baud rate is
not emulated. In a chain of answers (Sync Read, Bulk Read) each motor waits for the one before it. Guesses: the chain
ends at the first one that is missing, and a fast read of more than a packet holds is not answered.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from typing import Protocol

from emg2vsa.devices.clock import Clock
from emg2vsa.worlds.far_ends.dynamixel.framing import (
    BROADCAST_ID,
    HEADER,
    MOST_LENGTH,
    Error,
    Instruction,
    bulk_writes,
    packet,
    reads,
    sealed,
    sync_writes,
)
from emg2vsa.worlds.far_ends.dynamixel.parser import Packet, PacketParser

_FAST = (Instruction.FAST_SYNC_READ, Instruction.FAST_BULK_READ)
_CHAINS = (Instruction.SYNC_READ, Instruction.BULK_READ, *_FAST)
_SPREAD = {Instruction.SYNC_WRITE: sync_writes, Instruction.BULK_WRITE: bulk_writes}
_ROUNDING_S = 1e-9
_Answer = tuple[float, bytes]
"""Delay after what came before, s, and bytes."""


class Listener(Protocol):
    """A motor on the bus."""

    @property
    def device_id(self) -> int: ...
    @property
    def return_delay_s(self) -> float: ...
    @property
    def listens(self) -> bool:
        """Not while it boots."""

    @property
    def answers_reads(self) -> bool:
        """By its Status Return Level."""

    def advance(self) -> None: ...
    def reset(self) -> None: ...
    def heard(self) -> None:
        """An instruction for it came."""

    def obey(self, instruction: int, parameters: bytes, broadcast: bool) -> bytes:
        """Error byte and parameters of the status packet; no bytes where there is none."""

    def spoilt(self) -> bytes:
        """The same to a packet with a wrong checksum."""

    def read(self, address: int, size: int) -> tuple[int, bytes]:
        """Error byte and data."""

    def write(self, address: int, data: bytes) -> Error: ...


class Bus:
    """Bytes in, bytes out, for several motors."""

    def __init__(self, clock: Clock, motors: Sequence[Listener]) -> None:
        self._clock, self._motors, self._parser = clock, motors, PacketParser()
        self._coming: deque[tuple[float, bytes]] = deque()

    def __call__(self, data: bytes) -> bytes:
        """Hear ``data`` at the clock's time; what is due by then comes back. The rest comes at `due_s`, with a call
        without bytes."""
        for motor in self._motors:
            motor.advance()
        now_s = self._clock.now_s()
        for heard in self._parser.feed(data, now_s):
            at_s = max(now_s, self._coming[-1][0]) if self._coming else now_s
            for delay_s, answer in self._answers(heard):
                at_s += delay_s
                self._coming.append((at_s, answer))
        arrived = b""
        while self._coming and self._coming[0][0] <= now_s + _ROUNDING_S:
            arrived += self._coming.popleft()[1]
        return arrived

    @property
    def due_s(self) -> float:
        """When the next answer comes; inf when none is on its way."""
        return self._coming[0][0] if self._coming else math.inf

    def reset(self) -> None:
        """Power off and on for all."""
        self._coming.clear()
        for motor in self._motors:
            motor.reset()

    def _answers(self, heard: Packet) -> Iterator[_Answer]:
        broadcast = heard.device_id == BROADCAST_ID
        if heard.instruction == Instruction.STATUS:
            return
        mine = [m for m in self._motors if m.listens and (broadcast or m.device_id == heard.device_id)]
        for motor in mine if heard.intact else ():
            motor.heard()
        if broadcast and heard.intact and heard.instruction in _CHAINS:
            yield from self._chain(heard.instruction, reads(heard.instruction, heard.parameters))
        elif broadcast and heard.intact and heard.instruction in _SPREAD:
            for device_id, address, data in _SPREAD[Instruction(heard.instruction)](heard.parameters):
                if motor_of_id := self._motor(device_id):
                    motor_of_id.write(address, data)
        else:
            yield from self._single(mine, heard, broadcast)

    def _single(self, mine: list[Listener], heard: Packet, broadcast: bool) -> Iterator[_Answer]:
        """A broadcast is answered by those alone who are pinged, in the order of their ids."""
        for motor in sorted(mine, key=lambda one: one.device_id):
            device_id, delay_s = motor.device_id, motor.return_delay_s
            answer = motor.obey(heard.instruction, heard.parameters, broadcast) if heard.intact else motor.spoilt()
            if answer and (not broadcast or (heard.intact and heard.instruction == Instruction.PING)):
                yield delay_s, packet(device_id, Instruction.STATUS, answer)

    def _chain(self, instruction: int, asked: list[tuple[int, int, int]]) -> Iterator[_Answer]:
        length = 1 + sum(4 + size for *_, size in asked)
        if instruction in _FAST and length > MOST_LENGTH:
            return
        whole, sent = HEADER + bytes((BROADCAST_ID, length & 0xFF, length >> 8 & 0xFF, Instruction.STATUS)), 0
        for device_id, address, size in asked:
            motor = self._motor(device_id)
            if motor is None or not motor.answers_reads:
                return
            error, data = motor.read(address, size)
            if instruction not in _FAST:
                yield motor.return_delay_s, packet(device_id, Instruction.STATUS, bytes((error,)) + data)
                continue
            # not stuffed, and each checksum covers all that was sent so far
            whole = sealed(whole + bytes((error, device_id)) + data.ljust(size, b"\0"))
            yield motor.return_delay_s, whole[sent:]
            sent = len(whole)

    def _motor(self, device_id: int) -> Listener | None:
        return next((m for m in self._motors if m.listens and m.device_id == device_id), None)
