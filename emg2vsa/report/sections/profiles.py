"""Mean profiles, that of the new specimen, how well interpolation does; and the stiffness schedules made of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import get_args

import numpy as np

from emg2vsa.errors import Emg2vsaError
from emg2vsa.exemplary import Choice
from emg2vsa.figures.cocontraction import draw_interpolation, draw_schedules
from emg2vsa.figures.palette import ActivityScale, looks
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, most, named, with_interval
from emg2vsa.report.section import Quantities, Section, of_people
from emg2vsa.report.table import FEW_ON_PAGE, Column, Columns, Table, activity_column, from_quantities, table_of
from emg2vsa.report.wording import activity, listed, number, percent
from emg2vsa.schedules import Schedule
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import Curve


def _profile_items(results: StudyResults) -> Items:
    profiles, v = results.recorded.profiles, results.activity_suffix
    if profiles is None:
        return
    yield "profiles.participant", profiles.participant or "all"
    for profile in profiles.profiles:
        yield from _coefficients(profiles, profile, v)
        yield f"profiles.{profile.specimen}.n_trials", profile.n_trials
    if (choice := results.recorded.choice) is not None:
        yield "profiles.choice.medoid", choice.medoid
        points = float(np.ptp(results.study.schedule.stiffness_percent))
        for i, name in enumerate(choice.participants):
            for key in _DISTANCES:
                yield f"profiles.choice.{name}.{key}_percent", points * float(getattr(choice, key)[i])
    for left in profiles.leave_one_out:
        found = {f"rmse{v}": left.rmse_v, "relative": left.relative}
        yield from named(f"profiles.leave_one_out.{left.specimen}", **found)
    if profiles.new is not None:
        name = f"profiles.{profiles.new.specimen}"
        yield f"{name}.alpha", profiles.weight_alpha
        yield from _coefficients(profiles, profiles.new, v)
        for made in profiles.by_rule:
            yield f"{name}.by_{made.rule}.alpha", made.alpha
            if made.error is not None:
                yield f"{name}.by_{made.rule}.rmse{v}", made.error.rmse_v
        if (error := profiles.new_error) is not None:
            yield f"{name}.rmse{v}", error.rmse_v
            yield from named(name, measured_as=error.specimen, rmse_relative=error.relative)


def _coefficients(profiles: Profiles, profile: Profile, v: str) -> Items:
    for name, of, half in zip("ab", (profile.a_v, profile.b_v), profiles.half_widths(profile), strict=True):
        yield from with_interval(f"profiles.{profile.specimen}.{name}{v}", of, of - half, of + half)
    yield f"profiles.{profile.specimen}.half_width{v}", most(profiles.half_width_v(profile))


_HEADS = {"specimen": "Specimen", "stiffness_n_per_mm": "Stiffness κ (N/mm)", "source": "Source", "n_trials": "Trials"}


def _profile_tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    profiles, scale, v = results.recorded.profiles, results.scale, results.activity_suffix
    if profiles is None:
        return
    shown = [*profiles.profiles, *([profiles.new] if profiles.new else [])]
    columns: Columns = {
        **{Column(key, head): [getattr(p, key) for p in shown] for key, head in _HEADS.items()},
        **from_quantities(q, [f"profiles.{p.specimen}" for p in shown], {
            activity_column("a_v", "a", scale): f"a{v}", activity_column("b_v", "b", scale): f"b{v}",
            activity_column("b_low_v", "b low", scale): f"b{v}.low",
            activity_column("b_high_v", "b high", scale): f"b{v}.high",
            activity_column("half_width_v", "Band ±, at most", scale): f"half_width{v}",
        }),
    }  # fmt: skip
    scatter = _level(profiles, f"; intervals and bands: {{}}, from the scatter between {profiles.drawn}")
    yield table_of("profiles", f"Mean profiles of {profiles.participant or 'all participants'}{scatter}", columns)
    every = profiles.leave_one_out
    left_out: Columns = {
        Column("specimen", "Left out"): [left.specimen for left in every],
        Column("bracket", "Interpolated from"): [" and ".join(left.bracket) for left in every],
        activity_column("rmse_v", "RMSE", scale): [left.rmse_v for left in every],
        Column("relative", "RMSE (% of root mean square)", 100.0): [left.relative for left in every],
    }
    yield table_of("leave_one_out", "Each measured profile beside its interpolation from its neighbours", left_out)
    if results.recorded.choice is not None:
        yield _choice(results.recorded.choice, results, q)


def _level(profiles: Profiles, said: str) -> str:
    """``said`` with the confidence of the intervals; nothing where there are none."""
    return said.format(f"{100 * profiles.errors.confidence:g} %") if profiles.errors else ""


_DISTANCES = {
    "to_others": "Mean distance to the others (points)", "to_used": "Distance to the schedules used (points)",
    "largest": "Largest difference from them (points)",
}  # fmt: skip


def _choice(choice: Choice, results: StudyResults, q: Quantities) -> Table:
    names = [f"profiles.choice.{name}" for name in choice.participants]
    keys = {Column(f"{key}_percent", head): f"{key}_percent" for key, head in _DISTANCES.items()}
    columns = {Column("participant", "Participant"): choice.participants} | from_quantities(q, names, keys)
    low, high = results.study.schedule.stiffness_percent
    caption = (
        f"Schedules that each participant would give, in points of stiffness percent ({low:g} to {high:g} %): root "
        f"mean square over specimens and forces. The medoid is {choice.medoid}"
    )
    if choice.left_out:
        caption += f"; {listed(choice.left_out)} did not press every specimen"
    return table_of("exemplary", caption, columns, FEW_ON_PAGE)


def _profile_plot(results: StudyResults) -> Iterator[Drawing]:
    profiles, scale, order = results.recorded.profiles, results.scale, results.specimens
    if profiles is None or profiles.new is None:
        return
    new, measured = profiles.new, {profile.specimen: profile for profile in profiles.profiles}
    if profiles.new_measured:
        measured.setdefault(profiles.new_measured.specimen, profiles.new_measured)
    every = sorted(measured.values(), key=lambda profile: order.index(profile.specimen))
    beside = "nobody palpated a specimen of this stiffness"
    if error := profiles.new_error:
        rmse = f"{activity(error.rmse_v, scale)} ({percent(error.relative)})"
        beside = f"the RMSE to the measured {error.specimen} is {rmse}"
    whole = (
        f"The profile of {new.specimen} ({number(new.stiffness_n_per_mm)} N/mm){_level(profiles, ' and its {} band')}, "
        f"interpolated from {listed(profiles.bracket or ())}, beside the measured profiles; {beside}."
    )
    title = f"Interpolated profile of {new.specimen} beside measured profiles"
    lines = "; ".join(f"{p.specimen}: {activity(p.v[0], scale)} to {activity(p.v[-1], scale)}" for p in [*every, new])
    figure = draw_interpolation(every, new, profiles.half_width_v(new), looks(order), scale)
    yield Drawing("fig11_interpolation", title, f"Fig. 11. {whole}", f"{whole} {lines}.", figure)


_PROFILES = """
{% if not people.profiles %}
<p>{{ why_absent("profiles") }}</p>
{% else %}
{% if people.profiles.new %}
{{ figure("fig11_interpolation") }}
{% else %}
<p>The study names no new specimen, so nothing is interpolated.</p>
{% endif %}
{{ folded("profiles", "Coefficients of the profiles") }}
{{ folded("leave_one_out", "Each measured profile interpolated from its neighbours") }}
{% if not people.profiles.leave_one_out %}
<p>The study has too few specimens of known stiffness to leave one out.</p>
{% endif %}
{{ folded("exemplary", "Choice of the participant: how far the schedules would differ") }}
<details><summary>Notes on the profiles</summary>{{ people.profiles.notes | bullets }}</details>
{% endif %}
"""

PROFILES = Section(
    "profiles", "Profile of the new specimen", _PROFILES, of_people, _profile_items, _profile_tables, _profile_plot
)


_RULES = {"bracket": "bracket", "paper": "κ/10 (paper)"}


def _quantities(results: StudyResults) -> Items:
    for schedule in results.recorded.schedules:
        yield from _schedule(schedule, f"schedules.{schedule.specimen}.{schedule.condition}")
    yield from _apart(results)
    for rule, schedule in _by_rule(results).items():
        yield from _range(schedule, f"schedules.{schedule.specimen}.by_{rule}")


def _by_rule(results: StudyResults) -> dict[str, Schedule]:
    """The modular schedule of the new specimen by each rule of interpolation; none where only one can be."""
    profiles = results.recorded.profiles
    if profiles is None or not results.recorded.schedules or len(profiles.by_rule) < 2:
        return {}
    modular = replace(results.study.schedule, conditions=("modular",))
    made = {each.rule: replace(profiles, new=each.profile, weight_alpha=each.alpha) for each in profiles.by_rule}
    return {rule: build_schedules(other, modular, {})[-1] for rule, other in made.items()}


def _by_curve(results: StudyResults) -> dict[Curve, tuple[Schedule, ...]]:
    """The modular schedules by logarithms and by splines; none where only one can be."""
    profiles = results.recorded.profiles
    if profiles is None or not results.recorded.schedules:
        return {}
    modular = replace(results.study.schedule, conditions=("modular",))
    try:
        return {curve: build_schedules(profiles.along(curve), modular, {}) for curve in get_args(Curve)}
    except Emg2vsaError:  # no force bins, or a curve that does not vary
        return {}


def _apart(results: StudyResults) -> Items:
    """Largest difference of a preset between both curves, of each specimen and of all."""
    if not (made := _by_curve(results)):
        return
    largest: tuple[float, str, float] | None = None
    for log, spline in zip(made["log"], made["spline"], strict=True):
        apart = spline.stiffness_percent - log.stiffness_percent
        place = int(np.argmax(np.abs(apart)))
        yield f"schedules.{log.specimen}.spline_less_log_percent", float(apart[place])
        if largest is None or abs(apart[place]) > abs(largest[0]):
            largest = float(apart[place]), log.specimen, float(log.step_force_n[place : place + 2].mean())
    if largest is not None:
        percent, specimen, at_n = largest
        yield from named("schedules.curves_apart", percent=abs(percent), specimen=specimen, at_n=at_n)


def _range(schedule: Schedule, name: str) -> Items:
    percent = schedule.stiffness_percent
    ends = {"min_": percent.argmin(), "max_": percent.argmax()} if schedule.condition == "modular" else {"": 0}
    for end, place in ends.items():
        yield from with_interval(f"{name}.{end}percent", percent[place], *schedule.interval[:, place])


def _schedule(schedule: Schedule, name: str) -> Items:
    end = "max_" if schedule.condition == "modular" else ""
    if end:
        yield from named(name, steps=schedule.preset.size, last_step_short=bool(schedule.last_step_short))
    yield from _range(schedule, name)
    yield f"{name}.{end}nm_per_rad", float(schedule.stiffness_nm_per_rad.max())
    half = float(np.max(np.diff(schedule.interval, axis=0))) / 2
    yield from named(name, half_width_percent=half, duration_s=float(schedule.ramp.duration_s))


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    if results.recorded.schedules:
        yield _steps(results.recorded.schedules, results.scale)
    if by_rule := _by_rule(results):
        yield _beside(by_rule, results)


def _forces(schedule: Schedule) -> Columns:
    edges = schedule.step_force_n
    return {Column("from_n", "From (N)"): edges[:-1], Column("to_n", "To (N)"): edges[1:]}


def _beside(by_rule: Mapping[str, Schedule], results: StudyResults) -> Table:
    first = next(iter(by_rule.values()))
    unit, new, columns = first.limits.export.unit, first.specimen, _forces(first)
    for key, head, of in ("percent", "stiffness (%)", "stiffness_percent"), (unit, f"preset ({unit})", "exported"):
        for rule, made in by_rule.items():
            columns[Column(f"{rule}_{key}", f"{_RULES[rule]}: {head}")] = getattr(made, of)
    profiles = results.recorded.profiles
    weights = listed([f"{number(of.alpha, 4)} by {_RULES[of.rule]}" for of in (profiles.by_rule if profiles else ())])
    caption = f"Schedule of {new} by both rules of interpolation; weight α of the softer neighbour: {weights}"
    return table_of("schedules_by_rule", caption, columns)


def _steps(schedules: Sequence[Schedule], scale: ActivityScale) -> Table:
    export, limits, ramp = schedules[0].limits.export, schedules[0].limits, schedules[0].ramp
    every = [
        table_of("", "", {
            Column("specimen", "Specimen"): [s.specimen] * s.preset.size,
            Column("condition", "Condition"): [s.condition] * s.preset.size,
            **_forces(s),
            activity_column("activity_v", "Co-contraction", scale): s.activity_v,
            Column("stiffness_percent", "Stiffness (%)"): s.stiffness_percent,
            Column("stiffness_low_percent", "Low (%)"): s.interval[0],
            Column("stiffness_high_percent", "High (%)"): s.interval[1],
            Column(export.column, f"Preset ({export.unit})"): s.exported,
            Column("stiffness_nm_per_rad", "Stiffness at zero load (N·m/rad)"): s.stiffness_nm_per_rad,
        })
        for s in schedules
    ]  # fmt: skip
    rows = [tuple(each.rows) for each in every]
    shown = (
        own if s.condition == "modular" else ({**own[0], "to_n": own[-1]["to_n"]},)
        for s, own in zip(schedules, rows, strict=True)
    )  # fmt: skip
    caption = (
        "Stiffness schedules: every step where the stiffness changes, one row where it is constant. 100 % is "
        f"{export.exported(limits.full_preset)} {export.unit} of a {limits.actuator}. The probe moves "
        f"{number(ramp.travel_mm)} mm at {number(ramp.speed_mm_per_s)} mm/s"
    )
    if any(s.last_step_short and s.condition == "modular" for s in schedules):
        caption += ". The last force step is shorter than the others"
    if told := schedules[0].provenance.get("interval", "").rstrip("."):
        caption += f". Low and high: {told}. The presets do not depend on them"
    return Table("schedules", caption, every[0].columns, tuple(chain(*rows)), tuple(chain(*shown)), most=FEW_ON_PAGE)


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    schedules, profiles = results.recorded.schedules, results.recorded.profiles
    if not schedules or profiles is None:
        return
    figure = draw_schedules(schedules, looks(results.specimens, profiles.new.specimen if profiles.new else None))
    (low, high), scale = results.study.schedule.stiffness_percent, results.study.schedule.scale
    errors = profiles.errors if schedules[0].interval_percent is not None else None
    bands = f" Bands are {100 * errors.confidence:g} % intervals over {profiles.drawn}." if errors else ""
    caption = (
        f"Fig. 5. Stiffness presets, {low:g} to {high:g} % of the maximum {scale}. Left: modular stiffness against "
        f"force. Right: constant stiffness at minimum, mean and maximum of each profile.{bands}"
    )
    ends = ((s, dict.fromkeys(number(end(s.stiffness_percent)) for end in (np.min, np.max))) for s in schedules)
    levels = "; ".join(f"{s.specimen} {s.condition}: {' to '.join(of)} %" for s, of in ends)
    yield Drawing("fig05_schedules", "Stiffness preset against force", caption, f"{levels}.", figure)


_TEXT = """
{% if not people.schedules %}
<p>{{ why_absent("schedules") }}</p>
{% else %}
{{ figure("fig05_schedules") }}
<p>The preset follows the measured force.
{% if people.schedules[0].limits.export.remark %}
{{ people.schedules[0].limits.export.remark }}
{% endif %}
{% if 'schedules.curves_apart.percent' in q %}
The schedules follow {{ curve }}; by {{ other_curve }} presets would
differ by at most {{ q['schedules.curves_apart.percent'] | number(2) }} points of percent
({{ q['schedules.curves_apart.specimen'] }} at {{ q['schedules.curves_apart.at_n'] | number(2) }} N).
{% endif %}
</p>
{{ folded("schedules", "Every schedule in numbers") }}
{{ folded("schedules_by_rule", "The new specimen's schedule by the bracket and by the paper's weight") }}
{% endif %}
"""

_CURVES = {"log": "v = a + b ln F", "spline": "monotone splines through the force bins"}


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    own = results.study.profile.curve
    return {"curve": _CURVES[own], "other_curve": next(said for curve, said in _CURVES.items() if curve != own)}


SCHEDULES = Section("schedules", "Stiffness schedules", _TEXT, of_people, _quantities, _tables, _drawings, _words)
