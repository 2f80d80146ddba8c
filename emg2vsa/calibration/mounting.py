"""What presses of one mounting cannot show: by how much its angle is off, and both scores with it.

Under a probe that is tilted by theta the force along its axis is F = N cos(theta) of the normal force N, the
indentation takes 1 / cos(theta) of travel, and the camera sees cos(theta) of the contact's area. In a Hertz contact
(``forms``), over the same forces F, therefore

    dA/dF ~ cos(theta)^(1/3),  travel per newton ~ cos(theta)^(-5/3).

An error of theta moves CASR by -(1/3) tan(theta) of itself per radian and the millimetres per newton by
(5/3) tan(theta): nothing along the normal, and at 45 degrees 0.3 % and 1.5 % for half a degree.
"""

from __future__ import annotations

import math

CASR_POWER, INDENTATION_POWER = 1 / 3, -5 / 3


def mount_share(power: float, angle_deg: float, angle_sd_deg: float) -> float:
    """Change of a score that goes as cos(angle)^power for one standard deviation of the angle, as a share of it."""
    return -power * math.tan(math.radians(angle_deg)) * math.radians(angle_sd_deg)
