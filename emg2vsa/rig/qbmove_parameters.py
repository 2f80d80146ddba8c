"""The list of parameters that a qbmove keeps: one slot of 50 bytes each, with type, count, values and a name."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from emg2vsa.errors import DeviceError

SLOT_BYTES = 50
FORMATS = {0: "B", 1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 8: "d"}
"""Type byte to ``struct`` format: flag, then the integers by growing size, float and double."""


@dataclass(frozen=True)
class Parameter:
    """One parameter as the device lists it."""

    number: int
    name: str
    type: int
    values: tuple[float, ...]


def decode_parameters(payload: bytes, where: str) -> dict[int, Parameter]:
    """The payload of the list, after its command byte, by number from 1. DeviceError for a slot that makes no sense."""
    found = {}
    for number in range(1, payload[0] + 1):
        slot = payload[1 + SLOT_BYTES * (number - 1) :][:SLOT_BYTES]
        kind, count = slot[:2] if len(slot) >= 2 else (None, 0)
        size = struct.calcsize(f">{count}{FORMATS[kind]}") if kind in FORMATS else SLOT_BYTES
        if kind is None or 2 + size > len(slot):
            raise DeviceError(
                f"{where}, parameter {number}",
                wanted=f"a slot of type {min(FORMATS)} to {max(FORMATS)} within {SLOT_BYTES} bytes",
                found=f"{slot[:8].hex(' ')} ..." if slot else "the end of the list",
                do="Check the generation of the firmware.",
            )
        values = struct.unpack(f">{count}{FORMATS[kind]}", slot[2 : 2 + size])
        found[number] = Parameter(number, _name(slot[2 + size :]), kind, values)
    return found


def encode_values(parameter: Parameter, values: tuple[float, ...], where: str) -> bytes:
    """The payload that sets ``parameter``: its number, then the values. DeviceError when they do not fit its type."""
    whole = FORMATS[parameter.type] not in "fd"
    try:
        body = struct.pack(
            f">H{len(parameter.values)}{FORMATS[parameter.type]}", parameter.number, *_typed(values, whole)
        )
    except (struct.error, OverflowError, ValueError) as error:
        raise DeviceError(
            f"{where}, parameter {parameter.number} ({parameter.name})",
            wanted=f"{len(parameter.values)} {'whole numbers' if whole else 'numbers'} within its type",
            found=", ".join(map(str, values)) or "nothing",
            do=f"It holds {', '.join(map(str, parameter.values))} now.",
        ) from error
    return body


def _typed(values: tuple[float, ...], whole: bool) -> list[float]:
    if whole and any(value != int(value) for value in values):
        raise ValueError
    return [int(value) if whole else value for value in values]


def _name(text: bytes) -> str:
    return text.split(b":")[0].split(b"\0")[0].decode("ascii", "replace").partition(" - ")[2]
