"""What a qbmove remembers, in what Maker Pro and Advanced differ, and what both write at length: the parameter list
(``get_param_list``) and the ASCII of GET_INFO (``infoPrepare``) of command_processing.c (v6.1).

The Advanced counts its encoders the other way round and turns signs on their way out; here everything keeps the sign it
has on the wire. Ticks are internal ones, 65536 to a turn.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

FIXED_POINT = 65536
"""Gains are kept as whole numbers of 1/65536, truncated."""
INTERNAL_PER_TICK = 2
"""At resolution 1, that of the factory."""
CONTROL_MODES = ("Position", "PWM", "Current", "Position and current", "Deflection", "Deflection and current")
INPUT_MODES = ("Usb", "Encoder 3")
FORMATS = {0: "B", 2: "B", 3: "h", 5: "i", 7: "f"}
"Formats of parameters by the number of their type."
_SINGLE = {
    1: "device_id",
    4: "startup",
    5: "input_mode",
    6: "control_mode",
    10: "limits_active",
    13: "current_limit_ma",
    14: "max_pwm_rate",
}
_SHAFT_DRIVES, _STARTS_ON = 1, 3
_SLOT_BYTES, _MENU_BYTES, _LIST_BYTES = 50, 150, 1199
"""The list without command and checksum."""
_MENUS = (
    b"0 -> Usb\n1 -> Shaft's position controls the motors\n",
    b"0 -> Position\n1 -> PWM\n2 -> Current\n3 -> Position-Current\n4 -> Deflection\n5 -> Deflection-Current\n",
    b"0 -> Deactivate [NO]\n1 -> Activate [YES]\n",
)


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

    def limited(self, ticks: int, motor: int) -> int:
        """Clamped to the position limits of motor 0 or 1, when those are on."""
        low, high = self.limits[2 * motor : 2 * motor + 2]
        return max(low, min(high, ticks)) if self.limits_active else ticks


def fixed(*gains: float) -> list[int]:
    """Gains in fixed point, as a C cast truncates them."""
    return [int(gain * FIXED_POINT) for gain in gains]


@dataclass(frozen=True, kw_only=True)
class Switches:
    """Switches by which one model differs from the other, as their sources of generation 6 do."""

    version: str
    counts_backwards: bool
    "Encoders count against the wire: offsets and references are negated on the way in."
    parameters: int
    watchdog_counts: int
    "Counts of the watchdog at the factory, and after each start."
    position_gains: tuple[float, float, float]
    current_gains: tuple[float, float, float]
    pwm_limit: int
    supply_mv: int = 24000
    motor_speed_rad_per_s: float
    stall_torque_nm: float
    "Load at which a motor stops."
    stall_current_ma: float
    "What it draws there at full PWM."
    max_pwm_rate: int = 0
    both_motors_or_none: bool
    "ACTIVATE with any bit switches both on."

    def factory(self, zeros_ticks: tuple[int, int, int] = (0, 0, 0)) -> Memory:
        """Settings as they leave it; ``zeros_ticks``: what motor 1, motor 2 and shaft read where they begin."""
        return Memory(
            offsets=[ticks * INTERNAL_PER_TICK for ticks in zeros_ticks],
            position_pid=fixed(*self.position_gains),
            current_pid=fixed(*self.current_gains),
            watchdog_counts=self.watchdog_counts,
            max_pwm_rate=self.max_pwm_rate,
        )


MAKER_PRO = Switches(
    version="QBMMP v6.1.0",
    counts_backwards=False,
    parameters=13,
    watchdog_counts=0,
    position_gains=(0.1, 0.0, 0.8),
    current_gains=(5.0, 0.0, 0.0),
    pwm_limit=43,  # the firmware's table at 24 V, for a motor of 8 V
    motor_speed_rad_per_s=3.75,  # nickparnenzini/qbmove_plugin, qbmove_project.pdf
    # of the same source: 8 V over 2.3 ohm, 0.8 N m/A, less 0.8 N m of friction
    stall_torque_nm=2.0,
    stall_current_ma=3480.0,
    both_motors_or_none=False,
)
ADVANCED = Switches(
    version="QBADV v6.1.6",
    counts_backwards=True,
    parameters=14,
    watchdog_counts=122,  # 5 s: the factory setting is the longest; which period runs before the first SET is unknown
    position_gains=(-0.1, 0.0, -0.8),
    current_gains=(3.0, 0.0, 0.0),
    pwm_limit=100,
    motor_speed_rad_per_s=6.0,  # default of the Gazebo plugin of NMMI, a simulation's number
    stall_torque_nm=6.0,  # of the same
    stall_current_ma=7500.0,  # 0.8 N m/A as in the Maker Pro: a guess
    both_motors_or_none=True,
)


def slots(memory: Memory) -> list[tuple[int, Sequence[float], str]]:
    """Type, values and text of each parameter, 1 to 14."""
    yes_no = (" NO", " YES")
    return [
        (2, (memory.device_id,), "1 - Device ID:"),
        (7, [gain / FIXED_POINT for gain in memory.position_pid], "2 - Position PID [P, I, D]:"),
        (7, [gain / FIXED_POINT for gain in memory.current_pid], "3 - Current PID [P, I, D]:"),
        (0, (memory.startup,), "4 - Startup Activation:" + yes_no[memory.startup != 0] + "\0\3"),
        (0, (memory.input_mode,), f"5 - Input mode: {INPUT_MODES[memory.input_mode]}\0\1"),
        (0, (memory.control_mode,), f"6 - Control mode: {CONTROL_MODES[memory.control_mode]}\0\2"),
        (2, memory.resolutions, "7 - Resolutions:"),
        (3, _offsets(memory), "8 - Measurement Offsets:"),
        (7, memory.multipliers, "9 - Multipliers:"),
        (0, (memory.limits_active,), "10 - Pos. limit active:" + yes_no[memory.limits_active != 0] + "\0\3"),
        (5, _limits(memory), "11 - Pos. limits [inf, sup]:"),
        (5, memory.max_steps, "12 - Max steps [neg, pos]:"),
        (3, (memory.current_limit_ma,), "13 - Current limit:"),
        (2, (memory.max_pwm_rate,), "14 - Max PWM rate:"),
    ]


def set_slot(memory: Memory, number: int, values: Sequence[float]) -> None:
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


def parameter_list(memory: Memory, count: int, list_bytes: int = _LIST_BYTES) -> bytes:
    """Count, slots and menus: the payload after the command, without checksum, filled with zeros to its length.

    Zeros stand too where the firmware copies nine bytes from beyond its last menu.
    """
    body = bytes((count,))
    for kind, values, text in slots(memory)[:count]:
        packed = struct.pack(f">{len(values)}{FORMATS[kind]}", *values)
        body += (bytes((kind, len(values))) + packed + text.encode("ascii")).ljust(_SLOT_BYTES, b"\0")
    body += b"".join(menu.ljust(_MENU_BYTES, b"\0") for menu in _MENUS)
    return body.ljust(list_bytes, b"\0")


def info_text(
    current: Memory, shadow: Memory, switches: Switches, *, references: Sequence[int], measurements: Sequence[int],
    currents_ma: Sequence[int], on: int, supply_mv: int,
) -> bytes:  # fmt: skip
    """The whole text, CR LF lines. Limits, stiffness and current limit come from what is set, not yet stored."""
    label = "Motor references - Position:" if switches.counts_backwards else "Motor references:"
    sign, limits = -1 if switches.counts_backwards else 1, _limits(shadow)
    lines = [
        "", f"Firmware version: {switches.version}.", "",
        "DEVICE INFO", f"ID: {current.device_id}", "Number of sensors: 3", f"PWM Limit: {switches.pwm_limit}", "",
        "MOTOR INFO", f"{label} {references[0]} {references[1]} ",
        f"Motor enabled: {'YES' if on & 3 else 'NO'}", "",
        "MEASUREMENTS INFO", "Sensor value:", *_numbered(measurements),
        f"Voltage (mV): {supply_mv}",
        *(f"Current {k} (mA): {current_ma}" for k, current_ma in enumerate(currents_ma, 1)), "",
        "DEVICE PARAMETERS", "PID Controller:", *_gains(current.position_pid),
        "Current PID Controller:", *_gains(current.current_pid), "",
        f"Startup activation: {'YES' if current.startup == _STARTS_ON else 'NO'}",
        f"Input mode: {'Sensor 3' if current.input_mode == _SHAFT_DRIVES else 'USB'}",
        f"Control Mode: {CONTROL_MODES[current.control_mode]}",
        "Sensor resolution:", *_numbered(current.resolutions),
        "Measurement Offset:", *_numbered(sign * ticks for ticks in _offsets(current)),
        "Measurement Multiplier:", *_numbered(f"{value:f}" for value in current.multipliers),
        f"Position limit active: {shadow.limits_active}",
        *(f"Position limit motor {k + 1}: inf -> {limits[2 * k]}  sup -> {limits[2 * k + 1]}" for k in (0, 1)),
        f"Max stiffness: {shadow.max_stiffness >> shadow.resolutions[0]}",
        f"Current limit: {shadow.current_limit_ma}",
        *([f"Max pwm rate: {shadow.max_pwm_rate}"] if switches.parameters > 13 else []),
        "debug: 0", "",
    ]  # fmt: skip
    return "\r\n".join(lines).encode("ascii")


def _numbered(values: Iterable[object]) -> list[str]:
    return [f"{k} -> {value}" for k, value in enumerate(values, 1)]


def _gains(gains: list[int]) -> list[str]:
    return [f"{name} -> {gain / FIXED_POINT:f}" for name, gain in zip("PID", gains, strict=True)]


def _offsets(memory: Memory) -> list[int]:
    return [offset >> bits for offset, bits in zip(memory.offsets, memory.resolutions, strict=True)]


def _limits(memory: Memory) -> list[int]:
    return [limit >> memory.resolutions[k // 2] for k, limit in enumerate(memory.limits)]
