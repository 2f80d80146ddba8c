"""ROBOTIS Dynamixel X-series motors with current sensing, as a joint whose stiffness is a position gain.

Here: how one is reached and what it may do, the table [actuator] of rig.toml with kind = "dynamixel".
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from emg2vsa.devices.device_settings import ActuatorSettings
from emg2vsa.devices.registry import Kind, Wrong
from emg2vsa.settings import Ge, Le, Positive
from emg2vsa.settings_class import settings_class

Model = Literal["xm430-w350", "xm430-w210", "xh430-w350", "xh430-w210", "xm540-w150", "xm540-w270"]
Baud = Literal[9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000]
ATTEMPTS = 3
"Attempts of each question."
REPLY_S = 0.016
"""Three attempts of it, and a turn of the loop before them, name a dead motor within 60 ms."""


@settings_class
class DynamixelSettings(ActuatorSettings):
    """A Dynamixel X-series motor with current sensing; its position gain is the joint's stiffness."""

    kind: Literal["dynamixel"]
    "dynamixel: needs the extra of this name."
    id: Annotated[int, Ge(0), Le(252)] = 1
    "Device id; 1 when it leaves the factory."
    baud: Baud = 1_000_000
    """Bits a second on the serial line. A motor leaves the factory with 57600, which is too slow for a loop of 200 Hz:
    set Baud Rate (8) to 3, which is 1000000, with DYNAMIXEL Wizard."""
    model: Model = "xm430-w350"
    "Model as on the label. Another model has another stiffness at the same gain."
    full_gain: Annotated[int, Ge(1), Le(16383)] = 800
    "Position P Gain (84) at the full preset. A preset is a share of it."
    d_gain: Annotated[int, Ge(0), Le(16383)] = 0
    "Position D Gain (80), the joint's damping; the same at every preset."
    full_stiffness_nm_per_rad: Positive | None = None
    """Stiffness of the joint at full_gain, N m/rad, as emg2vsa rig commission measures it: force over deflection
    against the sensor. Omitted: no schedule can run."""
    goal_current_a: Annotated[float, Ge(0.02), Le(10)] = 0.5
    """Largest current of the motor, A, and so its largest torque; beyond it the joint is no spring. It is rounded down
    to steps of 2.69 mA and must not be above the motor's Current Limit (38)."""
    watchdog_s: Annotated[float, Ge(0.06), Le(2.54)] = 0.5
    """The motor stops when the program has been silent for so long, in steps of 20 ms. Whether it does is unknown until
    emg2vsa rig prove-watchdog has shown it on this very motor."""
    reply_s: Annotated[float, Ge(0.001), Le(0.8)] = REPLY_S
    "How long each of three attempts waits for a reply; together not longer than watchdog_s."

    @property
    def full_preset(self) -> float | None:
        """The stiffness at the full gain."""
        return self.full_stiffness_nm_per_rad

    @property
    def unmeasured(self) -> str:
        """The stiffness, until it has been measured."""
        return "" if self.full_stiffness_nm_per_rad else "full_stiffness_nm_per_rad"


def _wrong(settings: DynamixelSettings) -> Iterator[Wrong]:
    if ATTEMPTS * settings.reply_s > settings.watchdog_s:
        wanted = f"at most {settings.watchdog_s / ATTEMPTS:.3g}, so that {ATTEMPTS} attempts end before watchdog_s"
        yield Wrong(("reply_s",), wanted, f"{settings.reply_s:g}")


DYNAMIXEL = Kind(
    "actuator", DynamixelSettings, check=_wrong,
    open="dynamixel.driver:open_dynamixel", about=lambda motor: motor.about(), scan="dynamixel.conversation:answers",
    joints=("dynamixel",), full_key="full_stiffness_nm_per_rad", export="emg2vsa.devices.dynamixel.joint:EXPORT",
)  # fmt: skip
