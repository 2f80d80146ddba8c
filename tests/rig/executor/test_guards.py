"""Each guard alone, just below and just above its limit."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from emg2vsa.devices.clock import Beat, VirtualClock
from emg2vsa.devices.protocols import ForceSample, Rating, SensorStatus
from emg2vsa.rig.executor.guards import GUARDS, Moment, Seen, laxer_guards, quiet, tripped
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings

LIMITS = GuardSettings(force_rate_n_per_s=200, stale_s=0.02)


def felt(*force_n: float, time_s: float = 4.999, torque_nm: float = 0.0, faults: tuple[str, ...] = ()) -> ForceSample:
    return ForceSample(time_s, force_n, (torque_nm, 0.0, 0.0), SensorStatus(faults=faults))


def pushed(force_n: float, before_n: float | None = None, time_s: float = 4.994) -> dict[str, Any]:
    """Along z, now and before."""
    before_n = force_n if before_n is None else before_n
    return {
        "force": felt(0, 0, force_n), "force_n": force_n,
        "before": felt(0, 0, before_n, time_s=time_s), "force_before_n": before_n,
    }  # fmt: skip


def across(lateral_n: float, angle_deg: float = 0.0) -> dict[str, Any]:
    return {"force": felt(lateral_n, 0, 3.0), "angle_deg": angle_deg}


def seen(**changes: Any) -> dict[str, Any]:
    return {"seen": Seen(**changes)}


GOOD = Moment(
    now_s=5.0, late_s=0.0, period_s=0.005, frame_s=4.9, depth_mm=2.0, travel_mm=15.0, active=True, seen=Seen(),
    angle_deg=0.0, phase="load", contact_n=0.5, rating=Rating((100.0, 100.0, 9.0), (0.5, 0.5, 0.5)), **pushed(3.0),
)  # fmt: skip
FRICTION = math.atan(GuardSettings().skin_friction)
TAN_30 = math.tan(math.radians(30) + FRICTION)
TAN_0 = math.tan(FRICTION)


@pytest.mark.parametrize(
    ("name", "below", "above"),
    [
        ("force limit", pushed(-8.9), pushed(-10.1)),
        ("force limit", {"force": felt(2.9, 0.0, 3.0)}, {"force": felt(0.0, 9.6, 3.0)}),
        ("force rate", pushed(3.99, 3.0), pushed(4.01, 3.0)),
        ("force rate", pushed(3.99, 3.0, 4.9989), pushed(1.99, 3.0, 4.9989)),
        ("lateral force", across(2.9 + 3 * TAN_0), across(3.1 + 3 * TAN_0)),
        ("lateral force", across(2.9 + 3 * TAN_30, 30.0), across(3.1 + 3 * TAN_30, 30.0)),
        (
            "lateral force",
            across(20.0) | {"phase": "retract"} | {"rating": None, "force": felt(8.0, 0, 3.0)},
            across(8.0),
        ),
        ("torque", {"force": felt(0, 0, 3, torque_nm=0.49)}, {"force": felt(0, 0, 3, torque_nm=1.01), "rating": None}),
        ("sensor overload", pushed(8.9), pushed(9.1)),
        ("sensor overload", {}, {"force": felt(0, 0, 3, torque_nm=-0.51)}),
        ("travel", {"depth_mm": 15.0}, {"depth_mm": 15.01}),
        ("no contact", seen(approach_mm=5.9), seen(approach_mm=6.1)),
        ("past contact", seen(past_contact_mm=9.9), seen(past_contact_mm=10.1)),
        ("way home", seen(rise_n=0.49), seen(rise_n=0.51)),
        ("spring limit", seen(spring_n=6.9, felt_n=3.0), seen(spring_n=-12.1, felt_n=-10.0)),
        ("untrusted force", seen(spring_n=6.9, felt_n=3.0), seen(spring_n=7.1, felt_n=3.0)),
        ("untrusted force", seen(spring_n=0.0, felt_n=3.5), seen(spring_n=0.0, felt_n=3.6)),
        ("untrusted force", seen(spring_n=4.0, felt_n=7.9), seen(spring_n=4.0, felt_n=8.1)),
        ("springs at rest", seen(spring_rest_n=-1.4), seen(spring_rest_n=-1.6)),
        ("untrusted force", {}, pushed(float("nan"))),
        ("untrusted force", {}, {"force": felt(0, 0, 3.0, faults=("gauge saturated",))}),
        ("frozen force", seen(still_mm=0.17), seen(still_mm=0.19)),
        ("frozen force", seen(still_s=0.19), seen(still_s=0.21)),
        ("following", seen(astray_deg=1.09), seen(astray_deg=1.11)),
        ("following", seen(unmoved_n=1.9), seen(unmoved_n=2.1)),
        ("motor current", seen(current_a=1.5), seen(current_a=1.501)),
        ("lost device", {}, {"active": False}),
        ("overrun", {"late_s": 0.05}, {"late_s": 0.051}),
        ("stale sensor", {"now_s": 5.018}, {"now_s": 5.02}),
        ("lost camera", {"frame_s": 4.51}, {"frame_s": 4.49}),
        ("lost camera", {"frame_s": None}, {"frame_s": 0.0}),
    ],
)
def test_guard(name: str, below: dict[str, Any], above: dict[str, Any]) -> None:
    assert tripped(replace(GOOD, **below), LIMITS) is None
    found = tripped(replace(GOOD, **above), LIMITS)
    assert found is not None
    assert found[0] == name
    assert GUARDS[name](replace(GOOD, **above), LIMITS) == found[1]


def test_a_limit_laxer_than_its_default_is_told() -> None:
    assert laxer_guards(RigSettings()) == []
    assert laxer_guards(RigSettings(guards=GuardSettings(force_n=8.0, following_deg_per_s=220.0))) == []
    for each in fields(GuardSettings):
        usual = getattr(GuardSettings(), each.name)
        lax = replace(GuardSettings(), **{each.name: usual * (0.9 if each.name == "following_deg_per_s" else 1.1)})
        (line,) = laxer_guards(RigSettings(guards=lax))
        assert line.startswith(f"rig.guards.{each.name} = ")
    assert len(laxer_guards(RigSettings(max_mm_per_s=50.0, escape_mm_per_s=10.0))) == 2


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


def any_moment(rng: np.random.Generator) -> Moment:
    """Most numbers small; some near their limits, beyond them, or none."""

    def near(limit: float) -> float:
        return float(
            rng.choice([0.0, 0.5, 0.99, 1.0, 1.01, 3.0, np.nan], p=[0.4, 0.3, 0.1, 0.1, 0.06, 0.03, 0.01]) * limit
        )

    def maybe(limit: float) -> float | None:
        return None if rng.random() < 0.5 else near(limit) * rng.choice([-1, 1])

    now = felt(near(3.0), near(2.0), near(10.0), torque_nm=near(1.0), time_s=5.0 - near(0.02))
    force_n = now.loads[2]
    spring_n = maybe(12.0)
    witnessed = Seen(
        between_s=0.005 + near(0.02), still_mm=near(0.18), still_s=maybe(0.2), astray_deg=near(1.0986328125),
        unmoved_n=near(2.0), spring_n=spring_n, felt_n=(spring_n or 0.0) + near(2.5), lag_n=near(1.0),
        starting=bool(rng.random() < 0.3), spring_rest_n=maybe(1.5), current_a=near(1.5), unfelt_a=maybe(0.3),
        jumped_deg=near(0.5), approach_mm=maybe(6.0), past_contact_mm=maybe(10.0), off_specimen=maybe(0.2),
        rise_n=maybe(0.5),
    )  # fmt: skip
    return replace(
        GOOD, force=now, force_n=force_n, before=felt(0, 0, 0, time_s=4.99), force_before_n=force_n - near(1.0),
        late_s=near(0.05), frame_s=None if rng.random() < 0.3 else 5.0 - near(0.5), depth_mm=near(15.0),
        active=bool(rng.random() < 0.98), seen=witnessed, angle_deg=float(rng.choice([0.0, 30.0, 45.0])),
        phase=rng.choice(["home", "approach", "contact", "load", "retract", "pause"]),
        rating=None if rng.random() < 0.3 else GOOD.rating,
    )  # fmt: skip


def test_where_one_look_finds_quiet_no_guard_speaks() -> None:
    rng = np.random.default_rng(40)
    moments = [any_moment(rng) for _ in range(20_000)]
    calm = [moment for moment in moments if quiet(moment, LIMITS)]
    assert 500 < len(calm) < 19_000
    for moment in calm:
        assert [name for name, check in GUARDS.items() if check(moment, LIMITS)] == []
    loud = [moment for moment in moments if any(check(moment, LIMITS) for check in GUARDS.values())]
    assert len(loud) > 1000
    assert all(tripped(moment, LIMITS) for moment in loud)


def test_a_guard_that_is_added_is_asked_where_all_others_are_quiet() -> None:
    calm = replace(GOOD, **pushed(1.0))
    assert quiet(calm, LIMITS)
    assert tripped(calm, LIMITS, GUARDS | {"own": lambda moment, limits: "never mind"}) == ("own", "never mind")
