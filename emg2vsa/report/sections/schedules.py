"""Stiffness schedules: co-contraction mapped on the actuator's stiffness, step by step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.figures.palette import looks
from emg2vsa.figures.schedule_map import draw_schedules
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Claim, Quantities, Section, of_people
from emg2vsa.report.table import Column, Row, Table, activity_column, rows_of
from emg2vsa.report.wording import number
from emg2vsa.schedules import Schedule

_PAPER_PERCENT, _PAPER_STEP_N = (20.0, 80.0), 0.3


def _quantities(results: StudyResults) -> Items:
    for schedule in results.recorded.schedules:
        yield from _schedule(schedule, f"schedules.{schedule.specimen}.{schedule.condition}")


def _schedule(schedule: Schedule, name: str) -> Items:
    if schedule.condition == "modular":
        yield f"{name}.steps", int(schedule.stiffness_percent.size)
        yield f"{name}.last_step_short", bool(schedule.last_step_short)
        yield f"{name}.min_percent", float(schedule.stiffness_percent.min())
        yield f"{name}.max_percent", float(schedule.stiffness_percent.max())
        yield f"{name}.max_nm_per_rad", float(schedule.stiffness_nm_per_rad.max())
    else:
        yield f"{name}.percent", float(schedule.stiffness_percent[0])
        yield f"{name}.nm_per_rad", float(schedule.stiffness_nm_per_rad[0])
    yield f"{name}.duration_s", float(schedule.ramp.duration_s)


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    if results.recorded.schedules:
        yield _steps(results.recorded.schedules, results.scale)


def _steps(schedules: Sequence[Schedule], scale: ActivityScale) -> Table:
    columns = (
        Column("specimen", "Specimen"), Column("condition", "Condition"), Column("from_n", "From (N)"),
        Column("to_n", "To (N)"), activity_column("activity_v", "Co-contraction", scale),
        Column("stiffness_percent", "Stiffness (%)"), Column("preset_ticks", "Preset (ticks)"),
        Column("stiffness_nm_per_rad", "Stiffness at zero load (N·m/rad)"),
    )  # fmt: skip
    rows: list[Row] = []
    shown: list[Row] = []
    for s in schedules:
        own = rows_of(
            {
                "specimen": [s.specimen] * len(s.preset_ticks),
                "condition": [s.condition] * len(s.preset_ticks),
                "from_n": s.step_force_n[:-1],
                "to_n": s.step_force_n[1:],
                "activity_v": s.activity_v,
                "stiffness_percent": s.stiffness_percent,
                "preset_ticks": s.preset_ticks,
                "stiffness_nm_per_rad": s.stiffness_nm_per_rad,
            }
        )
        rows += own
        shown += own if s.condition == "modular" else [{**own[0], "to_n": own[-1]["to_n"]}]
    caption = "Stiffness schedules: every step where the stiffness changes, one row where it is constant"
    return Table("schedules", caption, columns, tuple(rows), tuple(shown))


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    schedules, profiles = results.recorded.schedules, results.recorded.profiles
    if not schedules:
        return
    new = profiles.new.specimen if profiles and profiles.new else None
    figure = draw_schedules(schedules, looks(results.specimens, new))
    low, high, scale = (*results.study.schedule.stiffness_percent, results.study.schedule.scale)
    caption = (
        f"Fig. 5. Co-contraction mapped on the actuator's stiffness, {low:g} to {high:g} % of the maximum {scale} over "
        "all exported specimens. Left: modular stiffness, step by step. Right: constant stiffness, at the "
        "minimum (lower bar), mean (mark) and maximum (upper bar) of each profile."
    )
    told = [
        f"{s.specimen} {s.condition}: {number(s.stiffness_percent.min())}"
        + (f" to {number(s.stiffness_percent.max())} %" if s.condition == "modular" else " %")
        for s in schedules
    ]
    title = "Stiffness preset against force"
    yield Drawing("fig05_schedules", title, caption, "; ".join(told) + ".", figure, None)


def _claims(results: StudyResults, q: Quantities) -> Iterator[Claim]:
    settings = results.study.schedule
    same = settings.stiffness_percent == _PAPER_PERCENT and settings.step_n == _PAPER_STEP_N
    low, high = settings.stiffness_percent
    yield Claim(
        "schedule_range",
        "profiles are mapped on 20 to 80 % stiffness in steps of 0.3 N",
        "20 to 80 %, 0.3 N",
        f"{low:g} to {high:g} %, {settings.step_n:g} N",
        f"{low:g} to {high:g} %, {settings.step_n:g} N",
        "holds" if same else "does not hold",
        why="Settings, not results.",
    )


_TEXT = """
{% if not people.schedules %}
<p>{{ why_absent("schedules") }}</p>
{% else %}
{% set ramp, limits = people.schedules[0].ramp, people.schedules[0].limits %}
<p>The preset follows the measured force while the probe moves {{ ramp.travel_mm | number }} mm at
{{ ramp.speed_mm_per_s | number }} mm/s. 100 % is {{ limits.max_preset_ticks }} ticks of a {{ limits.actuator }}.
{% if short %}The last force step is shorter than the others.{% endif %}</p>
{{ figure("fig05_schedules") }}
{{ folded("schedules", "Every schedule in numbers") }}
{% endif %}
"""


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    return {"short": any(s.last_step_short and s.condition == "modular" for s in results.recorded.schedules)}


SCHEDULES = Section(
    "schedules", "Stiffness schedules", _TEXT, of_people, _quantities, _tables, _drawings, _claims, _words
)
