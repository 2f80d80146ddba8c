"""Mean profiles, the interpolated profile of the new specimen, and how well interpolation does."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.exemplary import Choice
from emg2vsa.figures.cocontraction import draw_interpolation
from emg2vsa.figures.palette import looks
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, most, named, with_interval
from emg2vsa.report.section import Quantities, Section, of_people
from emg2vsa.report.table import FEW_ON_PAGE, Column, Columns, Table, activity_column, from_quantities, table_of
from emg2vsa.report.wording import activity, listed, number, percent


def _quantities(results: StudyResults) -> Items:
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
            yield from named(
                name, measured_as=error.specimen, rmse_relative=error.relative, **{f"rmse{v}": error.rmse_v}
            )


def _coefficients(profiles: Profiles, profile: Profile, v: str) -> Items:
    for name, of, half in zip("ab", (profile.a_v, profile.b_v), profiles.half_widths(profile), strict=True):
        yield from with_interval(f"profiles.{profile.specimen}.{name}{v}", of, of - half, of + half)
    yield f"profiles.{profile.specimen}.half_width{v}", most(profiles.half_width_v(profile))


_HEADS = {"specimen": "Specimen", "stiffness_n_per_mm": "Stiffness κ (N/mm)", "source": "Source", "n_trials": "Trials"}


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
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
        Column("bracket", "Interpolated from"): [" and ".join(left.bracket or ()) or None for left in every],
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


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    profiles, scale, order = results.recorded.profiles, results.scale, results.specimens
    if profiles is None or profiles.new is None:
        return
    new, measured = profiles.new, {profile.specimen: profile for profile in profiles.profiles}
    if profiles.new_measured:
        measured.setdefault(profiles.new_measured.specimen, profiles.new_measured)
    every = sorted(measured.values(), key=lambda profile: order.index(profile.specimen))
    beside = "nobody palpated a specimen of this stiffness"
    if error := profiles.new_error:
        off = f"{activity(error.rmse_v, scale)} ({percent(error.relative)})"
        beside = f"the RMSE to the measured {error.specimen} is {off}"
    whole = (
        f"The profile of {new.specimen} ({number(new.stiffness_n_per_mm)} N/mm){_level(profiles, ' and its {} band')}, "
        f"interpolated from {listed(profiles.bracket or ())}, beside the measured profiles; {beside}."
    )
    title = f"Interpolated profile of {new.specimen} beside measured profiles"
    lines = "; ".join(f"{p.specimen}: {activity(p.v[0], scale)} to {activity(p.v[-1], scale)}" for p in [*every, new])
    figure = draw_interpolation(every, new, profiles.half_width_v(new), looks(order), scale)
    yield Drawing("fig11_interpolation", title, f"Fig. 11. {whole}", f"{whole} {lines}.", figure)


_TEXT = """
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

PROFILES = Section("profiles", "Profile of the new specimen", _TEXT, of_people, _quantities, _tables, _drawings)
