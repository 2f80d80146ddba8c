"""How a qbmove takes bytes from its line: ``interrupt_manager`` of interruptions.c (v6.1), state for state.

It matches two colons and nothing else, so a third one becomes an id; it waits for missing bytes without limit; frames
for others are skipped by their length.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

HEADER = b"::"
INFO_REQUEST = b"?\r\n"
BROADCAST_ID = 0
LEAST_LENGTH, MOST_LENGTH = 2, 128


class FrameParser:
    """Bytes in; out come the bodies of frames for this device or for all, checksum not yet looked at."""

    def __init__(self, own_id: Callable[[], int]) -> None:
        self._own_id = own_id
        self._last = b""
        self._body = bytearray()
        self._length = 0
        self._mine = False
        self._state = self._hunt

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Bodies, or ``INFO_REQUEST``, one at a time: what the one changes counts for the next."""
        at = 0
        while at < len(data):
            end = self._end_of_frame(data, at)
            if end:
                self._last, mine = b"", data[at + 2] in (BROADCAST_ID, self._own_id())
                body = data[at + 4 : end] if mine else b""
            else:
                end, body = at + 1, self._state(data[at])
            if body:
                yield body
            at = end

    def _end_of_frame(self, data: bytes, at: int) -> int:
        """Where the frame ends that begins there, of which all has come at once; 0 of any other byte."""
        if self._state != self._hunt or self._last[-1:] == HEADER[:1] or data[at : at + 2] != HEADER:
            return 0
        length = data[at + 3] if at + 3 < len(data) else 0
        end = at + 4 + length
        return end if LEAST_LENGTH <= length <= MOST_LENGTH and end <= len(data) else 0

    def _hunt(self, byte: int) -> bytes:
        self._last = (self._last + bytes((byte,)))[-3:]
        if self._last.endswith(HEADER):
            self._last = b""
            self._state = self._take_id
        return INFO_REQUEST if self._last == INFO_REQUEST else b""

    def _take_id(self, byte: int) -> bytes:
        self._mine = byte in (BROADCAST_ID, self._own_id())
        self._state = self._take_length
        return b""

    def _take_length(self, byte: int) -> bytes:
        self._length = byte
        self._body.clear()
        self._state = self._take_body if LEAST_LENGTH <= byte <= MOST_LENGTH else self._hunt
        return b""

    def _take_body(self, byte: int) -> bytes:
        self._body.append(byte)
        if len(self._body) < self._length:
            return b""
        self._state = self._hunt
        return bytes(self._body) if self._mine else b""
