"""Each guard alone, just below and just above its limit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from emg2vsa.rig.clock import Beat, VirtualClock
from emg2vsa.rig.executor.guards import GUARDS, Moment, tripped
from emg2vsa.rig.rig_settings import GuardSettings

LIMITS = GuardSettings(force_n=10, force_rate_n_per_s=200, stale_s=0.02, camera_s=0.5, late_s=0.05)
GOOD = Moment(
    now_s=5.0, late_s=0.0, period_s=0.005, force_n=3.0, force_time_s=4.999, force_before_n=3.0, force_before_s=4.994,
    faults=(), frame_s=4.9, depth_mm=2.0, travel_mm=15.0, active=True,
)  # fmt: skip


@pytest.mark.parametrize(
    ("name", "below", "above"),
    [
        ("force limit", {"force_n": -9.9, "force_before_n": -9.9}, {"force_n": -10.1, "force_before_n": -10.1}),
        ("force rate", {"force_n": 3.99}, {"force_n": 4.01}),
        ("force rate", {"force_n": 3.99, "force_before_s": 4.9989}, {"force_n": 1.99, "force_before_s": 4.9989}),
        ("travel", {"depth_mm": 15.0}, {"depth_mm": 15.01}),
        ("lost device", {}, {"active": False}),
        ("overrun", {"late_s": 0.05}, {"late_s": 0.051}),
        ("stale sensor", {"now_s": 5.018}, {"now_s": 5.02}),
        ("lost camera", {"frame_s": 4.51}, {"frame_s": 4.49}),
        ("lost camera", {"frame_s": None}, {"frame_s": 0.0}),
        ("untrusted force", {}, {"force_n": float("nan")}),
        ("untrusted force", {}, {"faults": ("gauge saturated",)}),
    ],
)
def test_guard(name: str, below: dict[str, Any], above: dict[str, Any]) -> None:
    assert tripped(replace(GOOD, **below), LIMITS) is None
    found = tripped(replace(GOOD, **above), LIMITS)
    assert found is not None
    assert found[0] == name
    assert GUARDS[name](replace(GOOD, **above), LIMITS) == found[1]


def test_the_beat_leaves_out_what_is_over_and_counts_it() -> None:
    clock = VirtualClock()
    beat = Beat(clock, 0.005)
    assert [beat.wait()[0] for _ in range(3)] == pytest.approx([0, 0.005, 0.010])
    clock.sleep_until(0.027)
    assert beat.wait() == pytest.approx((0.027, 0.012))
    assert beat.wait()[0] == pytest.approx(0.030)
    timing = beat.timing()
    assert (timing.turns, timing.overruns) == (5, 2)
    assert timing.largest_s == pytest.approx(0.012)
