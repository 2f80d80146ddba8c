"""Where the shaft has been: devices read the world at times of their own, some of them a little in the past."""

from __future__ import annotations

from bisect import bisect_left

from emg2vsa.errors import DeviceError

_REMEMBERED = 60_000
"""Points kept at least: a minute of motion in steps of 1 ms, and any length of rest."""


class ShaftPath:
    """Angles over time, straight between points."""

    def __init__(self, time_s: float, angle_rad: float) -> None:
        self._times_s, self._angles_rad = [time_s], [angle_rad]

    @property
    def end_s(self) -> float:
        """Newest time."""
        return self._times_s[-1]

    @property
    def end_rad(self) -> float:
        """Newest angle."""
        return self._angles_rad[-1]

    def append(self, time_s: float, angle_rad: float) -> None:
        """One more point, later than the last."""
        times_s, angles_rad = self._times_s, self._angles_rad
        if len(times_s) > 1 and angles_rad[-2] == angles_rad[-1] == angle_rad:
            times_s[-1] = time_s
            return
        times_s.append(time_s)
        angles_rad.append(angle_rad)
        if len(times_s) > 2 * _REMEMBERED:
            del times_s[:_REMEMBERED], angles_rad[:_REMEMBERED]

    def angle_rad(self, time_s: float) -> float:
        """Angle at a time not after the end. DeviceError before what is remembered."""
        times_s, angles_rad = self._times_s, self._angles_rad
        if time_s < times_s[0]:
            raise DeviceError(
                "emulated world",
                wanted=f"a time from {times_s[0]:.3f} s on",
                found=f"{time_s:.3f} s",
                do="Read the devices more often.",
            )
        after = bisect_left(times_s, time_s)
        if times_s[after] == time_s:
            return angles_rad[after]
        share = (time_s - times_s[after - 1]) / (times_s[after] - times_s[after - 1])
        return angles_rad[after - 1] + share * (angles_rad[after] - angles_rad[after - 1])
