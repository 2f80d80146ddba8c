"""Stiffness schedules: co-contraction mapped on the actuator's stiffness, step by step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from emg2vsa.figures.cocontraction import draw_schedules
from emg2vsa.figures.palette import ActivityScale, looks
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, named, with_interval
from emg2vsa.report.section import Quantities, Section, of_people
from emg2vsa.report.table import FEW_ON_PAGE, Column, Columns, Table, activity_column, table_of
from emg2vsa.report.wording import listed, number
from emg2vsa.schedules import Schedule
from emg2vsa.schedules.build import build_schedules

_RULES = {"bracket": "bracket", "paper": "κ/10 (paper)"}


def _quantities(results: StudyResults) -> Items:
    for schedule in results.recorded.schedules:
        yield from _schedule(schedule, f"schedules.{schedule.specimen}.{schedule.condition}")
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
        yield _beside(by_rule, q)


def _forces(schedule: Schedule) -> Columns:
    edges = schedule.step_force_n
    return {Column("from_n", "From (N)"): edges[:-1], Column("to_n", "To (N)"): edges[1:]}


def _beside(by_rule: Mapping[str, Schedule], q: Quantities) -> Table:
    first = next(iter(by_rule.values()))
    unit, new, columns = first.limits.export.unit, first.specimen, _forces(first)
    for key, head, of in ("percent", "stiffness (%)", "stiffness_percent"), (unit, f"preset ({unit})", "exported"):
        for rule, made in by_rule.items():
            columns[Column(f"{rule}_{key}", f"{_RULES[rule]}: {head}")] = getattr(made, of)
    weights = listed(
        [f"{number(float(q[f'profiles.{new}.by_{rule}.alpha']), 4)} by {_RULES[rule]}" for rule in by_rule]
    )
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
</p>
{{ folded("schedules", "Every schedule in numbers") }}
{{ folded("schedules_by_rule", "The new specimen's schedule by the bracket and by the paper's weight") }}
{% endif %}
"""

SCHEDULES = Section("schedules", "Stiffness schedules", _TEXT, of_people, _quantities, _tables, _drawings)
