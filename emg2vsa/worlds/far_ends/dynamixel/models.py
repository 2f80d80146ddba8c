"""In what the models differ. Source: ROBOTIS e-Manual, a page a model, its control table and its specifications at 12 V
(_data/dxl_x_info.yml of ROBOTIS-GIT/emanual).

Nobody at ROBOTIS publishes inertia and friction. Those of the XM430-W350 are the joint of google-deepmind/
mujoco_menagerie, robotis_op3/op3.xml: armature 0.045 kg m2, friction loss 0.03 N m, damping 1.084 N m s/rad. Of that
damping the voltage behind the motor makes 0.85, its stall torque over its speed without load; the rest is the gear's.
All of the other models is a guess: the same rotor behind another gear, a rotor of three times the inertia in the 540.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

PULSES_PER_TURN = 4096
PULSES_PER_RAD = PULSES_PER_TURN / (2 * math.pi)
CURRENT_UNIT_A = 2.69e-3
_RAD_PER_S_PER_RPM = 2 * math.pi / 60


@dataclass(frozen=True)
class DynamixelModel:
    """One model. Torque, speed and inertia are of the shaft."""

    name: str
    number: int
    stall_torque_nm: float
    stall_current_a: float
    no_load_rad_per_s: float
    inertia_kg_m2: float
    current_limit: int = 1193
    "Default and greatest Current Limit, units of 2.69 mA."
    velocity_limit: int = 200
    position_p_gain: int = 800
    ports: int = 0
    "External ports, of the 540."
    friction_nm: float = 0.03
    viscous_nm_s: float = 0.2
    firmware_version: int = 45
    "The first of the 430 and 540 that knows the fast reads."

    @property
    def torque_constant_nm_per_a(self) -> float:
        """Stall torque over stall current, as nothing else is published; the friction of the gear is in it."""
        return self.stall_torque_nm / self.stall_current_a

    def stiffness_nm_per_rad(self, position_p_gain: float) -> float:
        """Torque over deflection in Current-based Position Control Mode, below the goal current.

        That a position error of one pulse times gain / 128 (e-Manual, Position PID Gain) is a current in units of
        2.69 mA is a guess. It agrees with the position mode of the op3, 21 N m/rad at a gain of 800."""
        return self.torque_constant_nm_per_a * CURRENT_UNIT_A * position_p_gain / 128 * PULSES_PER_RAD


XM430_W350 = DynamixelModel("XM430-W350", 1020, 4.1, 2.3, 46 * _RAD_PER_S_PER_RPM, 0.045)
XM430_W210 = DynamixelModel("XM430-W210", 1030, 3.0, 2.3, 77 * _RAD_PER_S_PER_RPM, 0.0163, velocity_limit=330)
XH430_W210 = DynamixelModel(
    "XH430-W210", 1010, 2.5, 1.3, 50 * _RAD_PER_S_PER_RPM, 0.0163, 648, velocity_limit=210, position_p_gain=900
)
XM540_W150 = DynamixelModel(
    "XM540-W150", 1130, 7.3, 4.4, 53 * _RAD_PER_S_PER_RPM, 0.025, 2047, velocity_limit=230, ports=3, viscous_nm_s=0.5
)
XM540_W270 = DynamixelModel(
    "XM540-W270", 1120, 10.6, 4.4, 30 * _RAD_PER_S_PER_RPM, 0.08, 2047, velocity_limit=128, ports=3, viscous_nm_s=0.5
)
MODELS = {model.name: model for model in (XM430_W350, XM430_W210, XH430_W210, XM540_W150, XM540_W270)}
