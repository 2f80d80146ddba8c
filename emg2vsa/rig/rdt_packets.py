"""Raw data transfer (RDT) of ATI's Net F/T box and Ethernet Axia: datagrams and nothing else.

ATI manuals 9620-05 (Net F/T) and 9610-05 (Ethernet Axia). All numbers are big-endian.
"""

from __future__ import annotations

from enum import IntEnum
from struct import Struct
from typing import NamedTuple

PORT = 49152
LARGEST_BUFFER = 40
"Records that one datagram carries at most in buffered mode."

_HEADER = 0x1234
_REQUEST = Struct(">HHI")
_RECORD = Struct(">III6i")


class Command(IntEnum):
    """What a client may ask for."""

    STOP = 0x0000
    STREAM = 0x0002
    "One record a datagram."
    BUFFERED = 0x0003
    "As many records a datagram as the box's RDT buffer size says."
    RESET_LATCH = 0x0041
    BIAS = 0x0042
    "Present load becomes zero; not answered."


class Record(NamedTuple):
    """One measurement as the box sends it.

    rdt_sequence : 1, 2, ... within one request.
    ft_sequence : internal samples since power-up.
    status : status word; which bit means what depends on the product.
    counts : Fx, Fy, Fz, Tx, Ty, Tz in counts; their size is told over HTTP.
    """

    rdt_sequence: int
    ft_sequence: int
    status: int
    counts: tuple[int, ...]


def request_bytes(command: Command, sample_count: int = 0) -> bytes:
    """A request for ``sample_count`` records, 0 for no end."""
    return _REQUEST.pack(_HEADER, command, sample_count)


def parse_request(data: bytes) -> tuple[int, int] | None:
    """Command and sample count; None for anything that is no request."""
    if len(data) != _REQUEST.size:
        return None
    header, command, count = _REQUEST.unpack(data)
    return (command, count) if header == _HEADER else None


def record_bytes(record: Record) -> bytes:
    """A record as it goes over the wire, 36 bytes."""
    return _RECORD.pack(record.rdt_sequence, record.ft_sequence, record.status, *record.counts)


def parse_records(data: bytes) -> list[Record]:
    """The records of a datagram; none when its length is no multiple of a record's."""
    if len(data) % _RECORD.size:
        return []
    return [Record(rdt, ft, status, tuple(counts)) for rdt, ft, status, *counts in _RECORD.iter_unpack(data)]
