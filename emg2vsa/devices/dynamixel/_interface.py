"""What the rig wants of an actuator, as far as this driver needs it, until the shared protocols hold it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Measurements(NamedTuple):
    """Encoder readings, degrees of the joint."""

    motors_deg: tuple[float, ...]
    shaft_deg: float


@dataclass(frozen=True)
class Parameter:
    """One parameter as the device lists it."""

    number: int
    name: str
    values: tuple[float, ...]
