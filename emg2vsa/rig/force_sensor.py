"""What the rig wants of a force sensor, whatever carries its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class SensorStatus:
    """What the sensor says of itself.

    code : its status word; 0 when all is well.
    faults : why the force is not to be trusted.
    warnings : what a reader ought to know of a force that is good.
    """

    code: int = 0
    faults: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class ForceSample:
    """One reading.

    time_s : when it arrived, on the rig's clock.
    force_n, torque_nm : (3,) along x, y, z of the sensor, N and N·m.
    status : of this reading.
    gaps : readings lost since the one handed out before.
    """

    time_s: float
    force_n: NDArray[np.float64]
    torque_nm: NDArray[np.float64]
    status: SensorStatus = SensorStatus()
    gaps: int = 0


class ForceSensor(Protocol):
    """A sensor that measures by itself once started. It is never biased unless `bias` is called."""

    name: str

    def start(self) -> None:
        """Begin, and return once a first sample has come. DeviceError when none comes."""

    def read(self) -> ForceSample:
        """The newest sample; everything older is dropped, so a slow loop never lags. DeviceError when it is too old
        or has not changed for too long."""

    def read_all(self) -> list[ForceSample]:
        """Every sample since the last call of either read, oldest first. DeviceError as `read`."""

    def bias(self) -> None:
        """Make the present load the new zero."""

    def close(self) -> None:
        """Stop measuring and give the device back."""
