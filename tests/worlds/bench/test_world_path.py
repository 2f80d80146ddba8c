"""What the world remembers of its shaft."""

from __future__ import annotations

import pytest

from emg2vsa.errors import DeviceError
from emg2vsa.worlds.bench.world import ShaftPath


def test_motion_is_straight_between_points_and_rest_is_flat() -> None:
    path = ShaftPath(0.0, 0.0)
    for time_s, angle_rad in ((1.0, 0.5), (2.0, 0.5), (4.0, 0.5), (5.0, 0.1)):
        path.append(time_s, angle_rad)
    times_s = (0.0, 0.5, 1.0, 1.5, 3.0, 4.0, 4.5, 5.0)
    expected = [0.0, 0.25, 0.5, 0.5, 0.5, 0.5, 0.3, 0.1]
    assert [path.angle_rad(time_s) for time_s in times_s] == pytest.approx(expected)
    assert (path.end_s, path.end_rad) == (5.0, 0.1)


def test_a_rest_of_any_length_is_remembered() -> None:
    path = ShaftPath(0.0, 0.2)
    for k in range(1, 200_000):
        path.append(k * 0.001, 0.7)
    assert path.angle_rad(0.0005) == pytest.approx(0.45)


def test_a_minute_of_motion_is_remembered_and_not_much_more() -> None:
    path = ShaftPath(0.0, 0.0)
    for k in range(1, 200_001):
        path.append(k * 0.001, k * 0.001)
    assert path.angle_rad(140.0005) == pytest.approx(140.0005)
    with pytest.raises(
        DeviceError,
        match=r"emulated world: expected a time from 1\d\d\.\d\d\d s on, but found "
        r"60\.000 s",
    ):
        path.angle_rad(60.0)
