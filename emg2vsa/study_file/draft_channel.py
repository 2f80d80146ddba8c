"""A channel as a drafted study file has it, with what a person must look at."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

from emg2vsa.readers.units import si_factor

FILL = "FILL IN"
"""Marks every line that a person must look at."""
_OF_MASS = {"kg": "kgf", "g": "gf", "lb": "lbf", "lbs": "lbf"}


@dataclass(frozen=True)
class DraftChannel:
    """name : in the file. unit : the one it states, or None. fs_hz : where the file states none, else None.

    sign : of the force. said : what it was taken for, and why. no_rate : the file states no rate and nobody else did.
    is_force : else it is EMG. largest : value, whatever its sign. told_unit : that a person told; of a force it may be
    how many newtons a unit is. rivals : channels that may be the force as well.
    """

    name: str
    unit: str | None
    fs_hz: float | None = None
    sign: int = 1
    said: str = ""
    no_rate: bool = False
    is_force: bool = False
    largest: float = math.nan
    told_unit: str = ""
    rivals: tuple[str, ...] = ()

    @property
    def rival(self) -> str:
        """What else may be the force, in words."""
        return f"{', '.join(self.rivals)} may be the force as well as {self.name}"

    @property
    def is_unit_guessed(self) -> bool:
        """Whether neither the file nor a person states a unit of EMG or force."""
        known = si_factor(self.unit)
        return not self.told_unit and (known is None or known[0] != ("N" if self.is_force else "V"))

    @property
    def guessed_unit(self) -> str:
        """Of the EMG by its size: hardly any is above 20 mV, and below 20 uV none is usable."""
        if self.is_force:
            return _OF_MASS.get(self.unit or "", "N" if self.unit is None else "1")
        return "V" if self.largest < 0.02 else "uV" if self.largest > 20 else "mV"

    @property
    def unit_doubt(self) -> str:
        """Why the unit is a guess."""
        if self.is_force and self.unit in _OF_MASS:
            return f"the file states {self.unit}, a mass; is its weight meant?"
        stated = "no unit" if self.unit is None else self.unit
        size = "" if self.is_force or math.isnan(self.largest) else f", by the largest value, {self.largest:.3g}"
        return f"the file states {stated}; this is a guess{size}"


def channel_lines(channel: DraftChannel) -> list[str]:
    """The lines of its table."""
    lines = [f"# {channel.said}"] if channel.said else []
    lines += [f"# {FILL} another where it is the one: {channel.rival}"] if channel.rivals else []
    lines.append(f"name = {toml_text(channel.name)}")
    unit, doubt = channel.told_unit, ""
    if channel.is_unit_guessed:
        unit, doubt = channel.guessed_unit, f"   # {FILL}: {channel.unit_doubt}"
    if unit:
        is_number = unit[0].isdecimal()
        lines.append((f"newtons_per_unit = {float(unit)}" if is_number else f'unit = "{unit}"') + doubt)
    if channel.no_rate:
        lines.append(f"fs_hz = 1000   # {FILL}: the file has no time column; this is a guess")
    elif channel.fs_hz is not None:
        lines.append(f"fs_hz = {channel.fs_hz:g}")
    if channel.sign < 0:
        lines.append("sign = -1")
    return lines


def toml_text(text: str) -> str:
    """As TOML writes it, whose basic strings are JSON's but for one sign."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
