"""Raw data transfer (RDT) of ATI's Net F/T box and Ethernet Axia: datagrams, their numbers and their status words.

ATI manuals 9620-05 (Net F/T) and 9610-05 (Ethernet Axia). All numbers are big-endian.
"""

from __future__ import annotations

from enum import IntEnum
from functools import lru_cache
from struct import Struct
from typing import NamedTuple

from emg2vsa.devices.protocols import SensorStatus

INTERNAL_RATE_HZ = 7000
"Of a box's samples; it sends every one, or every second, third, ..."
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


_WRAP = 2**32


def steps(before: int, after: int) -> int:
    """From one 32-bit number to another, forwards or backwards, whichever is shorter."""
    return (after - before + _WRAP // 2) % _WRAP - _WRAP // 2


# the two products give the same bits of the status word different meanings
ANY_ERROR = 1 << 31

NETBOX = {
    30: "CPU or RAM error",
    29: "digital board error",
    28: "analog board error",
    27: "serial link error",
    26: "program verify error",
    25: "halted by configuration error",
    24: "settings validation error",
    23: "configuration and calibration do not match",
    22: "network error",
    21: "CAN error",
    20: "RDT error",
    19: "EtherNet/IP error",
    18: "DeviceNet error",
    17: "transducer saturation or A/D error",
    14: "watchdog reset",
    13: "stack error",
    12: "EEPROM I2C error",
    11: "flash SPI error",
    10: "analog watchdog reset",
    9: "excitation current too high",
    8: "excitation current too low",
    7: "analog ground out of range",
    6: "supply too high",
    5: "supply too low",
    4: "serial data not available",
    3: "reference voltage or power monitor error",
    2: "temperature out of range",
    1: "HTTP error",
}
"Net F/T box, manual 9620-05; bits 31 and 16 are not here: the summary, and a monitor condition, which is no fault."

MONITOR_CONDITION = 1 << 16

AXIA = {
    0: "temperature out of range",
    1: "supply voltage out of range",
    2: "broken gauge",
    3: "busy",
    5: "another error",
    27: "gauge out of range",
    28: "force is simulated",
    29: "calibration checksum error",
    30: "force or torque out of range",
}
"Ethernet Axia, manual 9610-05."


@lru_cache(maxsize=256)
def netbox_status(word: int) -> SensorStatus:
    """Status of a Net F/T box. A latched monitor condition (0x80010000) is a warning: somebody set a threshold."""
    warnings = ("monitor condition latched",) if word & MONITOR_CONDITION else ()
    return _status(word, NETBOX, word & ~MONITOR_CONDITION, warnings)


@lru_cache(maxsize=256)
def axia_status(word: int) -> SensorStatus:
    """Status of an Ethernet Axia."""
    return _status(word, AXIA, word, ())


def _status(word: int, names: dict[int, str], fault_bits: int, warnings: tuple[str, ...]) -> SensorStatus:
    causes = fault_bits & ~ANY_ERROR
    faults = [names.get(bit, f"status bit {bit}") for bit in range(30, -1, -1) if causes >> bit & 1]
    if word & ANY_ERROR and not faults and not warnings:
        faults = ["an error without a cause"]
    return SensorStatus(word, tuple(faults), warnings)
