"""What a qbmove writes at length: ASCII of GET_INFO (``infoPrepare``) and bytes of the parameter list (v6.1)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from emg2vsa.worlds.far_ends.qbmove.memory import CONTROL_MODES, FIXED_POINT, Memory, slots
from emg2vsa.worlds.far_ends.qbmove.switches import Switches

SLOT_BYTES = 50
_MENU_BYTES = 150
_MENUS = (
    b"0 -> Usb\n1 -> Shaft's position controls the motors\n",
    b"0 -> Position\n1 -> PWM\n2 -> Current\n3 -> Position-Current\n4 -> Deflection\n5 -> Deflection-Current\n",
    b"0 -> Deactivate [NO]\n1 -> Activate [YES]\n",
)
_SHAFT_DRIVES = 1
_STARTS_ON = 3


@dataclass(frozen=True)
class Now:
    """What the text says beside the settings, wire ticks and mA."""

    references: tuple[int, int]
    measurements: tuple[int, ...]
    currents_ma: tuple[int, int]
    on: int
    supply_mv: int


def parameter_list(memory: Memory, count: int, device_bytes: int) -> bytes:
    """Count, slots and menus: the payload after the command, without checksum, filled with zeros to its length.

    Zeros stand too where the firmware copies nine bytes from beyond its last menu.
    """
    body = bytes((count,))
    for kind, values, text in slots(memory)[:count]:
        size = {0: 1, 2: 1, 3: 2, 5: 4, 7: 4}[kind]
        body += (bytes((kind, len(values) // size)) + values + text.encode("ascii")).ljust(SLOT_BYTES, b"\0")
    body += b"".join(menu.ljust(_MENU_BYTES, b"\0") for menu in _MENUS)
    return body.ljust(device_bytes, b"\0")


def info_text(current: Memory, shadow: Memory, now: Now, switches: Switches) -> bytes:
    """The whole text, CR LF lines. Limits, stiffness and current limit come from what is set, not yet stored."""
    label = "Motor references - Position:" if switches.counts_backwards else "Motor references:"
    lines = [
        "", f"Firmware version: {switches.version}.", "",
        "DEVICE INFO", f"ID: {current.device_id}", "Number of sensors: 3", f"PWM Limit: {switches.pwm_limit}", "",
        "MOTOR INFO", f"{label} {now.references[0]} {now.references[1]} ",
        f"Motor enabled: {'YES' if now.on & 3 else 'NO'}", "",
        "MEASUREMENTS INFO", "Sensor value:", *_numbered(now.measurements),
        f"Voltage (mV): {now.supply_mv}",
        *(f"Current {k} (mA): {current_ma}" for k, current_ma in enumerate(now.currents_ma, 1)), "",
        "DEVICE PARAMETERS", "PID Controller:", *_gains(current.position_pid),
        "Current PID Controller:", *_gains(current.current_pid), "",
        f"Startup activation: {'YES' if current.startup == _STARTS_ON else 'NO'}",
        f"Input mode: {'Sensor 3' if current.input_mode == _SHAFT_DRIVES else 'USB'}",
        f"Control Mode: {CONTROL_MODES[current.control_mode]}",
        "Sensor resolution:", *_numbered(current.resolutions),
        "Measurement Offset:", *_numbered(_offsets(current, switches)),
        "Measurement Multiplier:", *_numbered(f"{value:f}" for value in current.multipliers),
        f"Position limit active: {shadow.limits_active}",
        *_limits(shadow),
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


def _offsets(memory: Memory, switches: Switches) -> list[int]:
    ticks = [offset >> bits for offset, bits in zip(memory.offsets, memory.resolutions, strict=True)]
    return [-value for value in ticks] if switches.counts_backwards else ticks


def _limits(memory: Memory) -> list[str]:
    ticks = [limit >> memory.resolutions[k // 2] for k, limit in enumerate(memory.limits)]
    return [f"Position limit motor {k + 1}: inf -> {ticks[2 * k]}  sup -> {ticks[2 * k + 1]}" for k in (0, 1)]
