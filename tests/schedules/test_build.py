"""Mapping (7), the closed-form step means, and every limit a schedule keeps."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.collections import PolyCollection
from scipy.integrate import quad

from emg2vsa.devices.joints import joint_of
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.errors import ScheduleError
from emg2vsa.figures.canvas import ONE_COLUMN_MM, style
from emg2vsa.figures.cocontraction import draw_schedules
from emg2vsa.figures.palette import looks
from emg2vsa.profiles import Profile, Profiles, errors_of
from emg2vsa.schedules import Limits, Schedule, check
from emg2vsa.schedules.build import build_schedules, mean_over_steps
from emg2vsa.settings import ScheduleSettings

ADVANCED = joint_of("qbmove-advanced", 3000 * DEG_PER_TICK)


def profile(name: str, a: float, b: float, source: str = "measured") -> Profile:
    force = np.linspace(0.5, 7, 100)
    return Profile(name, 5.0, a, b, force, a + b * np.log(force), source, 10, np.full(100, 1e-6))


def profiles_of(*measured: Profile, new: Profile | None = None) -> Profiles:
    return Profiles(
        profiles=measured, new=new, weight_alpha=0.5397 if new else math.nan, bracket=("S1", "S3") if new else None,
        new_measured=None, new_error=None, leave_one_out=(), participant="P07", unit="V", notes=(),
    )  # fmt: skip


PROFILES = profiles_of(profile("S1", 42e-6, 20e-6), profile("S3", 28e-6, 13e-6), profile("S5", 16e-6, 7e-6))


def schedules(profiles: Profiles = PROFILES, **settings: Any) -> dict[tuple[str, str], Schedule]:
    built = build_schedules(profiles, ScheduleSettings(**settings), {"study": "palpation"})
    return {(s.specimen, s.condition): s for s in built}


@given(a=st.floats(-1, 1), b=st.floats(-1, 1), low=st.floats(0.01, 5), width=st.floats(1e-6, 20))
def test_closed_form_against_quadrature(a: float, b: float, low: float, width: float) -> None:
    high = low + width
    scale = abs(a) + abs(b) * (1 + max(abs(math.log(low)), abs(math.log(high))))
    # Where a and b log F nearly cancel, no quadrature reaches a relative error: rounding is a part of the scale.
    integral, _ = quad(
        lambda force: a + b * math.log(force), low, high, epsabs=1e-13 * scale * width + 1e-300, epsrel=1e-13
    )
    mean = mean_over_steps(a, b, np.array([low, high]))[0]
    assert mean == pytest.approx(integral / (high - low), abs=1e-12 * scale + 1e-300, rel=0)


def test_closed_form_of_narrow_steps_does_not_cancel() -> None:
    edges = np.array([3.0, 3.0 + 1e-9])
    assert mean_over_steps(0.0, 1.0, edges)[0] == pytest.approx(math.log(3.0), abs=1e-9)


def test_steps_of_the_study() -> None:
    schedule = schedules()["S1", "modular"]
    widths = np.diff(schedule.step_force_n)
    assert widths.size == 22
    np.testing.assert_allclose(widths[:-1], 0.3, rtol=1e-12)
    assert widths[-1] == pytest.approx(0.2, rel=1e-12)
    assert schedule.last_step_short
    assert (schedule.step_force_n[0], schedule.step_force_n[-1]) == (0.5, 7.0)


def test_steps_that_divide_the_window_leave_no_short_one() -> None:
    schedule = schedules(step_n=0.5)["S1", "modular"]
    assert schedule.activity_v.size == 13
    assert not schedule.last_step_short


@pytest.mark.parametrize("step_n", [0.001 / 3, 1 / 3, 6.5 / 7, 0.29999999])
def test_any_step_width_passes_its_own_check(step_n: float) -> None:
    check(schedules(step_n=step_n, conditions=("modular",))["S1", "modular"])


def test_one_step_over_the_whole_window() -> None:
    schedule = schedules(step_n=10.0)["S1", "modular"]
    np.testing.assert_array_equal(schedule.step_force_n, [0.5, 7])
    assert schedule.last_step_short


@pytest.mark.parametrize("ends", [(20.0, 80.0), (0.1, 33.3), (7.7, 100.0)])
def test_mapping_reaches_its_ends_exactly_and_only_over_all_specimens(ends: tuple[float, float]) -> None:
    made = schedules(stiffness_percent=ends)
    percent = np.concatenate([s.stiffness_percent for s in made.values()])
    assert (percent.min(), percent.max()) == ends
    assert made["S5", "modular"].stiffness_percent.min() == ends[0]
    assert made["S1", "modular"].stiffness_percent.max() == ends[1]
    assert ends[0] < made["S3", "modular"].stiffness_percent.min()
    assert made["S3", "modular"].stiffness_percent.max() < ends[1]


def test_mapping_is_linear_in_the_step_means() -> None:
    made = [s for (_, condition), s in schedules().items() if condition == "modular"]
    v, percent = (np.concatenate([getattr(s, name) for s in made]) for name in ("activity_v", "stiffness_percent"))
    p1 = 60 / (v.max() - v.min())
    np.testing.assert_allclose(percent, 20 + p1 * (v - v.min()), rtol=1e-12)
    np.testing.assert_allclose(made[0].activity_v, mean_over_steps(42e-6, 20e-6, made[0].step_force_n), rtol=0)


def test_ticks_and_stiffness_belong_to_the_percent() -> None:
    schedule = schedules()["S1", "modular"]
    assert schedule.exported[-1] == 2400
    np.testing.assert_array_equal(schedule.exported, np.rint(schedule.stiffness_percent * 30))
    assert schedule.exported.dtype == np.int64
    np.testing.assert_array_equal(schedule.preset, schedule.exported / 3000)
    np.testing.assert_array_equal(
        schedule.stiffness_nm_per_rad, ADVANCED.stiffness_nm_per_rad(schedule.exported / 3000)
    )


def test_constant_conditions() -> None:
    made = schedules()
    modular = made["S3", "modular"]
    for condition, level in {
        "constant-min": modular.stiffness_percent.min(),
        "constant-max": modular.stiffness_percent.max(),
    }.items():
        np.testing.assert_array_equal(made["S3", condition].stiffness_percent, level)
    mean = made["S3", "constant-mean"].activity_v
    assert np.ptp(mean) == 0
    assert mean[0] == pytest.approx(mean_over_steps(28e-6, 13e-6, np.array([0.5, 7]))[0], rel=1e-13)


def test_new_specimen_is_mapped_with_the_others() -> None:
    new = profile("S_new", 60e-6, 30e-6, "interpolated")
    made = schedules(profiles_of(*PROFILES.profiles, new=new))
    assert made["S_new", "modular"].stiffness_percent.max() == 80
    assert made["S1", "modular"].stiffness_percent.max() < 80
    origin = made["S_new", "modular"].provenance["profile"]
    assert "S1" in origin
    assert "0.5397" in origin


def test_the_new_specimen_replaces_the_measured_one_of_its_name() -> None:
    new = profile("S3", 27e-6, 12e-6, "interpolated")
    built = build_schedules(profiles_of(*PROFILES.profiles, new=new), ScheduleSettings(), {})
    assert [s.specimen for s in built if s.condition == "modular"] == ["S1", "S5", "S3"]
    assert built[-1].provenance["profile"].startswith("interpolated")


def test_stiffness_scale_is_linear_in_stiffness() -> None:
    schedule = schedules(profiles_of(PROFILES.profiles[0]), scale="stiffness")["S1", "modular"]
    maximum = float(ADVANCED.stiffness_nm_per_rad(1.0))
    share = (schedule.activity_v - schedule.activity_v[0]) / np.ptp(schedule.activity_v)
    # a whole tick of preset changes stiffness by up to 0.2 %
    np.testing.assert_allclose(schedule.stiffness_nm_per_rad, maximum * (0.2 + 0.6 * share), rtol=1e-3)
    assert schedule.stiffness_percent[0] > 60


def test_ramp() -> None:
    ramp = schedules()["S1", "modular"].ramp
    assert (ramp.speed_mm_per_s, ramp.speed_deg_per_s, ramp.travel_mm, ramp.duration_s) == (5, 25, 15, 3)


def test_provenance() -> None:
    provenance = schedules()["S5", "modular"].provenance
    assert provenance["study"] == "palpation"
    assert provenance["participant"] == "P07"
    assert "a = 1.6e-05, b = 7e-06" in provenance["fit"]
    p1, p2 = (float(text.split("=")[1]) for text in provenance["mapping"].split("; ")[1].split(", "))
    schedule = schedules()["S5", "modular"]
    np.testing.assert_allclose(p1 * schedule.activity_v + p2, schedule.stiffness_percent, rtol=1e-12)


MODULAR = ScheduleSettings(conditions=("modular",))
UNMOVED = build_schedules(PROFILES, MODULAR, {})


@given(shift=st.floats(-1, 1), scale=st.floats(1e-3, 1e3))
def test_mapping_ignores_unit_and_offset_of_the_activity(shift: float, scale: float) -> None:
    moved = [profile(p.specimen, scale * (1e6 * p.a_v + 100 * shift), scale * 1e6 * p.b_v) for p in PROFILES.profiles]
    for one, other in zip(build_schedules(profiles_of(*moved), MODULAR, {}), UNMOVED, strict=True):
        np.testing.assert_allclose(one.stiffness_percent, other.stiffness_percent, rtol=1e-9)


@pytest.mark.parametrize("a", [0.0, 1e-5, -1.0])
def test_flat_activity_cannot_be_mapped(a: float) -> None:
    with pytest.raises(ScheduleError, match="co-contraction that varies"):
        schedules(profiles_of(profile("S1", a, 0.0), profile("S3", a, 1e-12 * a)))


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"stiffness_percent": (80.0, 20.0)}, "two rising values"),
        ({"stiffness_percent": (20.0, 101.0)}, "two rising values from 0 to 100 %"),
        ({"max_preset_ticks": 20000}, "1 to 15000 ticks"),
        ({"stiffness_percent": (0.5, 80.0), "scale": "stiffness"}, "N m/rad at zero load"),
    ],
)
def test_settings_beyond_the_limits(settings: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ScheduleError, match=complaint):
        schedules(**settings)


def spoilt(name: str, row: int, value: float, base: tuple[str, str] = ("S1", "modular")) -> Schedule:
    schedule = schedules()[base]
    column = getattr(schedule, name).copy()
    column[row] = value
    return dataclasses.replace(schedule, **{name: column})


@pytest.mark.parametrize(
    ("name", "row", "value", "complaint"),
    [
        ("activity_v", 3, math.nan, "row 4, column activity_v: expected a finite number, but found nan"),
        ("stiffness_percent", 0, math.inf, "row 1, column stiffness_percent: expected 0 to 100 %, but found inf"),
        ("stiffness_percent", 21, 120.0, "row 22, column stiffness_percent: expected 0 to 100 %, but found 120"),
        ("stiffness_percent", 21, 80.1, "row 22, column stiffness_percent: expected 20 to 80 %"),
        ("stiffness_percent", 4, 40.0, "row 5, column preset_ticks: expected the ticks of its percent, 1200"),
        (
            "preset",
            1,
            3001 / 3000,
            "row 2, column preset_ticks: expected 0 to 3000 ticks, the device's maximum preset, but found 3001",
        ),
        (
            "preset",
            1,
            -1 / 3000,
            "row 2, column preset_ticks: expected 0 to 3000 ticks, the device's maximum preset, but found -1",
        ),
        (
            "preset",
            1,
            math.nan,
            "row 2, column preset_ticks: expected 0 to 3000 ticks, the device's maximum preset, but found nan",
        ),
        ("stiffness_nm_per_rad", 2, 9.0, "row 3, column stiffness_nm_per_rad: expected the stiffness of its ticks"),
        ("stiffness_nm_per_rad", 2, math.nan, "row 3, column stiffness_nm_per_rad"),
        ("step_force_n", 5, 1.0, "row 5, column force_to_n: expected a finite force above force_from_n"),
        ("step_force_n", 0, 0.0, "row 1, column force_from_n: expected a finite force above 0 N"),
        ("step_force_n", 5, 2.01, "row 5, column force_to_n: expected a step of 0.3 N"),
        ("step_force_n", 22, 7.2, "row 22, column force_to_n: expected a step of 0.3 N, and a shorter last one"),
        ("step_force_n", 22, math.nan, "row 22, column force_to_n: expected a finite force"),
    ],
)
def test_check_names_row_and_column(name: str, row: int, value: float, complaint: str) -> None:
    with pytest.raises(ScheduleError, match=complaint) as caught:
        check(spoilt(name, row, value))
    assert caught.value.where.startswith("schedule of S1, modular, row")


def test_check_of_a_constant_condition() -> None:
    base = schedules()["S1", "constant-mean"]
    other = schedules()["S1", "modular"]
    with pytest.raises(ScheduleError, match="it is constant"):
        check(dataclasses.replace(other, condition=base.condition))


def test_a_short_step_must_be_marked() -> None:
    with pytest.raises(ScheduleError, match=r"row 22, column force_to_n: expected a step of 0\.3 N, but found 7"):
        check(dataclasses.replace(schedules()["S1", "modular"], last_step_short=False))


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"condition": "soft"}, "condition: expected one of modular"),
        ({"specimen": ""}, "specimen: expected a name"),
        ({"provenance": {"study": 3}}, "provenance: expected only texts"),
        ({"limits": Limits((20.0, 80.0), 3000, "motor", "preset")}, "limits.actuator"),
        ({"limits": Limits((20.0, 80.0), 3000, "qbmove-advanced", "log")}, "limits.scale"),
        ({"limits": Limits((math.nan, 80.0), 3000, "qbmove-advanced", "preset")}, "limits.stiffness_percent"),
        ({"activity_v": np.zeros(3)}, "one value for each"),
        ({"step_force_n": np.array([0.5])}, "at least one force step"),
    ],
)
def test_check_of_the_head(change: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ScheduleError, match=complaint):
        check(dataclasses.replace(schedules()["S1", "modular"], **change))


@pytest.mark.parametrize("name", ["speed_mm_per_s", "gear_mm_per_degree", "speed_deg_per_s", "travel_mm", "duration_s"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, 7.0])
def test_check_of_the_ramp(name: str, value: float) -> None:
    schedule = schedules()["S1", "modular"]
    with pytest.raises(ScheduleError, match="ramp"):
        check(dataclasses.replace(schedule, ramp=dataclasses.replace(schedule.ramp, **{name: value})))


def test_the_figure_is_one_column_wide_and_marks_every_level() -> None:
    drawn = list(schedules().values())
    with style():
        figure = draw_schedules(drawn, looks(["S1", "S3", "S5"]))
    assert figure.get_size_inches() * 25.4 == pytest.approx((ONE_COLUMN_MM, 70))
    steps, levels = figure.axes
    assert steps.get_position().width == pytest.approx(3 * levels.get_position().width)
    constants = sorted(s.stiffness_percent[0] for s in drawn if s.condition != "modular")
    assert len(constants) == 9
    lines = [segment for bars in levels.collections for segment in bars.get_segments()]
    shown = [y for line in levels.lines for y in line.get_ydata()] + [y for line in lines for _, y in line]
    for percent in constants:
        assert np.min(np.abs(np.array(shown) - percent)) < 1e-9


def with_errors(n: int = 10, unit: str = "press", seed: int = 4, **settings: Any) -> list[Schedule]:
    """Schedules of three specimens whose n presses, or people, scatter by 10 %."""
    names, truth = ("S1", "S3", "S5"), np.array([[42e-6, 20e-6], [28e-6, 13e-6], [16e-6, 7e-6]])
    values = truth[:, None] * (1 + 0.1 * np.random.default_rng(seed).standard_normal((3, n, 2)))
    own = [
        dataclasses.replace(profile(name, *values[i].mean(axis=0).tolist()), weights=np.outer(np.eye(3)[i], [1, 1]))
        for i, name in enumerate(names)
    ]
    errors = errors_of(values, names, unit)  # type: ignore[arg-type]
    return list(
        build_schedules(dataclasses.replace(profiles_of(*own), errors=errors), ScheduleSettings(**settings), {})
    )


@pytest.mark.parametrize("unit", ["press", "person"])
@pytest.mark.parametrize("scale", ["preset", "stiffness"])
def test_every_schedule_has_an_interval_around_its_stiffness(unit: str, scale: str) -> None:
    for schedule in with_errors(unit=unit, scale=scale):
        assert schedule.interval_percent is not None
        low, high = schedule.interval_percent
        ends = schedule.limits.preset_percent(np.array(schedule.limits.stiffness_percent))
        assert np.all((ends[0] <= low) & (low <= schedule.stiffness_percent))
        assert np.all((schedule.stiffness_percent <= high) & (high <= ends[1]))
        end = (schedule.specimen, schedule.condition) in {("S1", "constant-max"), ("S5", "constant-min")}
        assert np.max(high - low) == 0 if end else np.max(high - low) > 0.5
        assert "95 % by Student's t" in schedule.provenance["interval"]


def test_an_end_without_rivals_has_no_width_and_presets_do_not_change() -> None:
    made = {(s.specimen, s.condition): s for s in with_errors()}
    lowest = made["S5", "modular"].interval_percent
    assert lowest is not None
    assert lowest[:, 0].tolist() == [20, 20]
    without = {(s.specimen, s.condition): s for s in build_schedules(PROFILES, ScheduleSettings(), {})}
    assert all(s.interval_percent is None and "interval" not in s.provenance for s in without.values())
    assert [s.preset.size for s in made.values()] == [s.preset.size for s in without.values()]


def test_the_figure_has_a_band_for_every_interval() -> None:
    drawn = with_errors()
    with style():
        steps, levels = draw_schedules(drawn, looks(["S1", "S3", "S5"])).axes
    bands = [each for axes in (steps, levels) for each in axes.collections if isinstance(each, PolyCollection)]
    assert len(bands) == len(drawn) == 12
    modular = drawn[0].interval
    extent = bands[0].get_paths()[0].get_extents()
    assert (extent.ymin, extent.ymax) == (pytest.approx(modular.min()), pytest.approx(modular.max()))


def test_ends_that_rival_each_other_widen_the_interval() -> None:
    """Two specimens with the same lowest activity: which of them is the end of the mapping is not known."""
    names, force = ("S1", "S3"), np.linspace(0.5, 7, 100)
    rng = np.random.default_rng(6)
    values = np.array([[[20.0, 20.0]], [[14.0, 7.0]]]) + rng.standard_normal((2, 10, 2))
    values += np.array([[20.0, 20.0], [14.0, 7.0]])[:, None] - values.mean(axis=1, keepdims=True)
    log_low = mean_over_steps(0.0, 1.0, np.array([0.5, 0.8]))[0]
    values[1, :, 0] += (20 + 20 * log_low) - (14 + 7 * log_low)
    own = [
        Profile(n, 5.0, *v.mean(axis=0), force, force, "measured", 10, force, np.outer(np.eye(2)[i], [1, 1]))
        for i, (n, v) in enumerate(zip(names, values, strict=True))
    ]
    profiles = dataclasses.replace(profiles_of(*own), errors=errors_of(values, names, "press"))
    for schedule in build_schedules(profiles, ScheduleSettings(conditions=("modular",)), {}):
        assert schedule.interval_percent is not None
        low, high = schedule.interval_percent[:, 0]
        assert low == pytest.approx(20)
        assert high > 20.5


def test_the_interval_of_a_linear_mapping_is_that_of_repeated_studies() -> None:
    """The half-width is Student's t times the SD of the stiffness over many studies."""
    how: dict[str, Any] = {"unit": "person", "conditions": ("modular",)}
    many = np.array([[s.stiffness_percent for s in with_errors(seed=i, **how)] for i in range(300)])
    halves = []
    for i in range(40):
        found = [s.interval_percent for s in with_errors(seed=1000 + i, **how)]
        halves.append([np.diff(f, axis=0)[0] / 2 for f in found if f is not None])
    np.testing.assert_allclose(np.mean(halves, axis=0)[1, 2:-2] / many.std(axis=0)[1, 2:-2], 2.26, rtol=0.15)


def test_one_press_of_a_specimen_leaves_all_without_an_interval() -> None:
    assert all(s.interval_percent is None for s in with_errors(n=1))
    assert all("interval" not in s.provenance for s in with_errors(n=1))


def test_a_wrong_interval_is_refused() -> None:
    schedule = with_errors()[0]
    assert schedule.interval_percent is not None
    with pytest.raises(ScheduleError, match="column stiffness_low_percent"):
        check(dataclasses.replace(schedule, interval_percent=schedule.interval_percent[::-1]))
    with pytest.raises(ScheduleError, match="one value for each in every column"):
        check(dataclasses.replace(schedule, interval_percent=schedule.interval_percent[:, :-1]))
