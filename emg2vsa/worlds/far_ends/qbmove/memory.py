"""What a qbmove remembers: ``memInit`` and ``get_param_list`` of command_processing.c (v6.1), in the wire's direction.

The Advanced counts its encoders the other way round and turns signs on their way out; here everything keeps the sign it
has on the wire. Ticks are internal ones, 65536 to a turn.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from dataclasses import dataclass, field

FIXED_POINT = 65536
"""Gains are kept as whole numbers of 1/65536, truncated."""
INTERNAL_PER_TICK = 2
"""At resolution 1, that of the factory."""
CONTROL_MODES = ("Position", "PWM", "Current", "Position and current", "Deflection", "Deflection and current")
INPUT_MODES = ("Usb", "Encoder 3")

_SINGLE = {
    1: "device_id",
    4: "startup",
    5: "input_mode",
    6: "control_mode",
    10: "limits_active",
    13: "current_limit_ma",
    14: "max_pwm_rate",
}


@dataclass
class Memory:
    """The settings, as left by the factory unless told otherwise."""

    device_id: int = 1
    position_pid: list[int] = field(default_factory=lambda: fixed(0.1, 0.0, 0.8))
    current_pid: list[int] = field(default_factory=lambda: fixed(5.0, 0.0, 0.0))
    startup: int = 0
    input_mode: int = 0
    control_mode: int = 0
    resolutions: list[int] = field(default_factory=lambda: [1, 1, 1])
    offsets: list[int] = field(default_factory=lambda: [0, 0, 0])
    multipliers: list[float] = field(default_factory=lambda: [1.0, 1.0, 1.0])
    limits_active: int = 1
    limits: list[int] = field(default_factory=lambda: [-30000, 30000, -30000, 30000])
    "Lowest and highest of motor 1, then of motor 2."
    max_steps: list[int] = field(default_factory=lambda: [0, 0])
    current_limit_ma: int = 1500
    max_pwm_rate: int = 0
    "Advanced 6.1.6 only. 0, its default, keeps a saturated move from ever starting."
    max_stiffness: int = 6000
    watchdog_counts: int = 0


def fixed(*gains: float) -> list[int]:
    """Gains in fixed point, as a C cast truncates them."""
    return [int(gain * FIXED_POINT) for gain in gains]


def slots(memory: Memory) -> list[tuple[int, bytes, str]]:
    """Type, values as bytes and text of each parameter, 1 to 14."""
    shift = memory.resolutions
    limits = [limit >> shift[k // 2] for k, limit in enumerate(memory.limits)]
    offsets = [offset >> bits for offset, bits in zip(memory.offsets, shift, strict=True)]
    yes_no = (" NO", " YES")
    return [
        (2, bytes((memory.device_id,)), "1 - Device ID:"),
        (7, _floats(gain / FIXED_POINT for gain in memory.position_pid), "2 - Position PID [P, I, D]:"),
        (7, _floats(gain / FIXED_POINT for gain in memory.current_pid), "3 - Current PID [P, I, D]:"),
        (0, bytes((memory.startup,)), "4 - Startup Activation:" + yes_no[memory.startup != 0] + "\0\3"),
        (0, bytes((memory.input_mode,)), f"5 - Input mode: {INPUT_MODES[memory.input_mode]}\0\1"),
        (0, bytes((memory.control_mode,)), f"6 - Control mode: {CONTROL_MODES[memory.control_mode]}\0\2"),
        (2, bytes(memory.resolutions), "7 - Resolutions:"),
        (3, struct.pack(">3h", *offsets), "8 - Measurement Offsets:"),
        (7, _floats(memory.multipliers), "9 - Multipliers:"),
        (0, bytes((memory.limits_active,)), "10 - Pos. limit active:" + yes_no[memory.limits_active != 0] + "\0\3"),
        (5, struct.pack(">4i", *limits), "11 - Pos. limits [inf, sup]:"),
        (5, struct.pack(">2i", *memory.max_steps), "12 - Max steps [neg, pos]:"),
        (3, struct.pack(">h", memory.current_limit_ma), "13 - Current limit:"),
        (2, bytes((memory.max_pwm_rate,)), "14 - Max PWM rate:"),
    ]


def set_slot(memory: Memory, number: int, values: tuple[float, ...]) -> None:
    """What GET_PARAM_LIST does with an index above 0."""
    whole = [int(value) for value in values]
    match number:
        case 2:
            memory.position_pid = fixed(*values)
        case 3:
            memory.current_pid = fixed(*values)
        case 7:
            memory.resolutions = whole
        case 8:
            memory.offsets = [value << bits for value, bits in zip(whole, memory.resolutions, strict=True)]
        case 9:
            memory.multipliers = list(values)
        case 11:
            memory.limits = [value << memory.resolutions[k // 2] for k, value in enumerate(whole)]
        case 12:
            negative, positive = memory.max_steps
            memory.max_steps = [whole[0] if whole[0] <= 0 else negative, whole[1] if whole[1] >= 0 else positive]
        case _ if number in _SINGLE:
            setattr(memory, _SINGLE[number], whole[0])


def _floats(values: Iterable[float]) -> bytes:
    return b"".join(struct.pack(">f", value) for value in values)
