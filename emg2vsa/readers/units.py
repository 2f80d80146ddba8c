"""Units as recording files spell them, and their way to volts and newtons."""

from __future__ import annotations

import re

_G = 9.80665  # standard gravity, m/s^2 (exact by definition)
_VOLT = {
    "v": 1.0,
    "volt": 1.0,
    "volts": 1.0,
    "millivolt": 1e-3,
    "millivolts": 1e-3,
    "microvolt": 1e-6,
    "microvolts": 1e-6,
}
_NEWTON = {"newton": 1.0, "newtons": 1.0}
_EXACT = {
    "mV": ("V", 1e-3), "uV": ("V", 1e-6), "nV": ("V", 1e-9),
    "N": ("N", 1.0), "mN": ("N", 1e-3), "kN": ("N", 1e3),
    "lbf": ("N", 0.45359237 * _G), "kgf": ("N", _G), "gf": ("N", 1e-3 * _G),
}  # fmt: skip
_TIME_S = {"s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
_OTHER = {
    "g", "G", "deg", "°", "deg/s", "°/s", "dps", "rad", "rad/s", "%", "%MVC", "% MVC", "MVC", "a.u", "a.u.", "au",
    "counts", "Nm", "Nmm", "N.m", "N·m", "mm", "cm", "m", "m/s", "m/s^2", "m/s²", "uT", "mT", "Hz", "bpm", "BPM",
    "BrPM", "L", "L/min", "mL/min", "Pa", "kPa", "hPa", "C", "°C", "A", "mA", "uA", "Ohm", "kOhm", "kg", "lb", "lbs",
}  # fmt: skip


def canonical(unit: str) -> str:
    """One spelling: both micro signs become u, stray bytes of a mis-decoded UTF-8 sign go."""
    return unit.replace("\u00c2", "").replace("\u00b5", "u").replace("\u03bc", "u").strip()


def si_factor(unit: str | None) -> tuple[str, float] | None:
    """("V" or "N", factor to it), or None where ``unit`` is neither a voltage nor a force. Case counts: mN, not MN."""
    if unit is None:
        return None
    text = canonical(unit)
    if text in _EXACT:
        return _EXACT[text]
    if text.lower() in _VOLT:
        return "V", _VOLT[text.lower()]
    return ("N", _NEWTON[text.lower()]) if text.lower() in _NEWTON else None


def seconds_per(unit: str) -> float | None:
    """Seconds in one time unit, or None where it is not one."""
    return _TIME_S.get(canonical(unit).lower())


_GLUED = re.compile(r"(.*[^\s_])_([munµμk]?[VN]|lbf|kgf|gf)")


def is_glued(label: str) -> bool:
    """Whether a unit of voltage or force ends the name, as in ``EDC_mV``."""
    return _GLUED.fullmatch(label.strip()) is not None


def split_unit(label: str, *, glued: bool = False) -> tuple[str, str | None]:
    """``"Fz [N]"`` -> ("Fz", "N"); ``"EDC (left)"`` -> ("EDC (left)", None), since left is no unit.

    glued : split ``EDC_mV`` too.
    """
    square = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]", label.strip())
    if square:
        return square[1].strip(), canonical(square[2]) or None
    round_ = re.fullmatch(r"(.*?)\s*\(([^()]*)\)", label.strip())
    if round_ and (not round_[2].strip() or is_unit(round_[2])):
        return round_[1].strip(), canonical(round_[2]) or None
    if glued and is_glued(label):
        name, _, unit = label.strip().rpartition("_")
        return name, canonical(unit)
    return label.strip(), None


def is_unit(text: str) -> bool:
    """Whether it is a unit of anything that is recorded."""
    unit = canonical(text)
    return unit in _OTHER or si_factor(unit) is not None or seconds_per(unit) is not None
