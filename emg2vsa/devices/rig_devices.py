"""Which devices a rig has, each of the kind that its table in rig.toml names."""

from __future__ import annotations

from dataclasses import dataclass

from emg2vsa.devices.device_settings import ActuatorSettings, CameraSettings, ForceSettings
from emg2vsa.devices.qbmove.settings import MotorSettings


@dataclass(frozen=True, kw_only=True)
class DeviceSettings:
    """All devices of a rig. motor : None without a rigid motor. camera : None where no frames are wanted."""

    actuator: ActuatorSettings
    force: ForceSettings
    motor: MotorSettings | None = None
    camera: CameraSettings | None = None
