"""Mean profiles, the interpolated profile of the new specimen, and how well interpolation does."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.exemplary import Choice
from emg2vsa.figures.canvas import PairBar, hazen_box
from emg2vsa.figures.cocontraction import draw_cocontraction, draw_interpolation
from emg2vsa.figures.palette import looks
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.report.drawing import STARS, Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, most, with_interval
from emg2vsa.report.section import Quantities, Section, of_people
from emg2vsa.report.table import Column, Columns, Table, activity_column, table_of
from emg2vsa.report.wording import activity, count, listed, number, p_text, percent

_ALL_PAIRS_UP_TO = 4
_PAPER_ALPHA, _PAPER_RMSE_V = 0.532, 0.0002


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
        percent_of = float(np.ptp(results.study.schedule.stiffness_percent))
        for i, name in enumerate(choice.participants):
            for key in ("to_others", "to_used", "largest"):
                yield f"profiles.choice.{name}.{key}_percent", percent_of * float(getattr(choice, key)[i])
    for left in profiles.leave_one_out:
        yield f"profiles.leave_one_out.{left.specimen}.rmse{v}", left.rmse_v
        yield f"profiles.leave_one_out.{left.specimen}.relative", left.relative
    if profiles.new is not None:
        name = f"profiles.{profiles.new.specimen}"
        yield f"{name}.alpha", profiles.weight_alpha
        yield from _coefficients(profiles, profiles.new, v)
        for made in profiles.by_rule:
            yield f"{name}.by_{made.rule}.alpha", made.alpha
            if made.error is not None:
                yield f"{name}.by_{made.rule}.rmse{v}", made.error.rmse_v
        if profiles.new_error is not None:
            yield f"{name}.measured_as", profiles.new_error.specimen
            yield f"{name}.rmse{v}", profiles.new_error.rmse_v
            yield f"{name}.rmse_relative", profiles.new_error.relative


def _coefficients(profiles: Profiles, profile: Profile, v: str) -> Items:
    for name, of, half in zip("ab", (profile.a_v, profile.b_v), profiles.half_widths(profile), strict=True):
        yield from with_interval(f"profiles.{profile.specimen}.{name}{v}", of, of - half, of + half)
    yield f"profiles.{profile.specimen}.half_width{v}", most(profiles.half_width_v(profile))


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    profiles, scale = results.recorded.profiles, results.scale
    if profiles is None:
        return
    shown = [*profiles.profiles, *([profiles.new] if profiles.new else [])]
    half_b = np.array([profiles.half_widths(profile)[1] for profile in shown])
    b = np.array([profile.b_v for profile in shown])
    columns: Columns = {
        Column("specimen", "Specimen"): [p.specimen for p in shown],
        Column("stiffness_n_per_mm", "Stiffness κ (N/mm)"): [p.stiffness_n_per_mm for p in shown],
        Column("source", "Source"): [p.source for p in shown],
        Column("n_trials", "Trials"): [p.n_trials for p in shown],
        activity_column("a_v", "a", scale): [p.a_v for p in shown],
        activity_column("b_v", "b", scale): b,
        activity_column("b_low_v", "b low", scale): b - half_b,
        activity_column("b_high_v", "b high", scale): b + half_b,
        activity_column("half_width_v", "Band ±, at most", scale): [most(profiles.half_width_v(p)) for p in shown],
    }
    caption = f"Mean profiles of {_whose(profiles)}"
    yield table_of("profiles", f"{caption}; {_interval_of(profiles)}" if profiles.errors else caption, columns)
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


def _interval_of(profiles: Profiles) -> str:
    """What the intervals of profiles are; only where there are some."""
    assert profiles.errors is not None
    return f"intervals and bands: {100 * profiles.errors.confidence:g} %, from the scatter between {profiles.drawn}"


def _whose(profiles: Profiles) -> str:
    return profiles.participant or "all participants"


def _choice(choice: Choice, results: StudyResults, q: Quantities) -> Table:
    distances = {
        "to_others_percent": "Mean distance to the others (points)",
        "to_used_percent": "Distance to the schedules used (points)",
        "largest_percent": "Largest difference from them (points)",
    }
    columns = {Column("participant", "Participant"): choice.participants} | {
        Column(key, head): [q[f"profiles.choice.{name}.{key}"] for name in choice.participants]
        for key, head in distances.items()
    }
    low, high = results.study.schedule.stiffness_percent
    caption = (
        f"Schedules that each participant would give, in points of stiffness percent ({low:g} to {high:g} %): root "
        f"mean square over specimens and forces. The medoid is {choice.medoid}"
    )
    if choice.left_out:
        caption += f"; {listed(choice.left_out)} did not press every specimen"
    return table_of("exemplary", caption, columns)


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    if (profiles := results.recorded.profiles) is not None:
        yield _cocontraction(results, profiles)
        if profiles.new is not None:
            yield _interpolation(results, profiles, profiles.new)


_BOX = {
    "whisker_low_v": "b: lower whisker", "q1_v": "lower quartile", "median_v": "median", "q3_v": "upper quartile",
    "whisker_high_v": "upper whisker",
}  # fmt: skip


def _cocontraction(results: StudyResults, exported: Profiles) -> Drawing:
    tested, scale, whose = results.recorded.hypotheses, results.scale, exported.participant
    profiles = _shown(exported, tested)
    names = [profile.specimen for profile in profiles]
    slopes = [_slopes(results, name, whose) for name in names]
    bars = _bars(tested, names, whose)
    test = "Fisher's LSD, uncorrected" + ("" if whose else "; largest p of all participants")
    look = looks(results.specimens)
    figure = draw_cocontraction(profiles, slopes, bars, [look[name] for name in names], scale, test if bars else "")
    pairs = "; ".join(f"{names[bar.first]} and {names[bar.second]}: {p_text(bar.p)}" for bar in bars)
    caption = (
        f"Fig. 4. Co-contraction of {_whose(exported)}. (a) Mean fitted trend of each specimen; the band is one "
        f"standard deviation {'between trials' if whose else 'between participants'}. (b) Slopes b, one mark a trial: "
        "boxes are Hazen's quartiles, whiskers reach the furthest value within 1.5 interquartile ranges."
    ) + (f" {test}: {STARS}." if bars else "")
    told = [
        f"{p.specimen}: {activity(p.v[0], scale)} to {activity(p.v[-1], scale)}, median b "
        f"{activity(float(np.median(b)), scale) if b.size else 'not known'} in {count(b.size, 'trial')}"
        for p, b in zip(profiles, slopes, strict=True)
    ]
    boxes = [hazen_box(b) if b.size else [None] * 5 for b in slopes]
    columns: Columns = {
        Column("specimen", "Specimen"): names,
        Column("n", "Trials"): [b.size for b in slopes],
        activity_column("v_low_v", "Trend, lowest force", scale): [float(p.v[0]) for p in profiles],
        activity_column("v_high_v", "Trend, highest force", scale): [float(p.v[-1]) for p in profiles],
        **{activity_column(key, head, scale): [box[i] for box in boxes] for i, (key, head) in enumerate(_BOX.items())},
    }
    description = "; ".join(told) + (f". {test}: {pairs}" if pairs else "") + "."
    title = "Co-contraction against force, and slopes b by specimen"
    table = table_of("fig04", "Numbers of figure 4", columns)
    return Drawing("fig04_cocontraction", title, caption, description, figure, table)


def _shown(profiles: Profiles, hypotheses: Hypotheses | None) -> Sequence[Profile]:
    """The exported specimens among which the worst p was taken; all exported where that leaves none."""
    kept = hypotheses.kept if hypotheses else ()
    return [p for p in profiles.profiles if p.specimen in kept] or profiles.profiles


def _slopes(results: StudyResults, specimen: str, whose: str) -> Floats:
    fits = results.recorded.fits
    entering = results.used & (fits.specimen == specimen)
    if whose:
        entering &= fits.participant == whose
    return np.asarray(fits.b_v[entering])


def _bars(hypotheses: Hypotheses | None, names: Sequence[str], whose: str) -> list[PairBar]:
    """All pairs of a few specimens, neighbours of many."""
    if hypotheses is None:
        return []
    lsd, places = hypotheses.tests.pairs.lsd, range(len(names))
    own = np.isin(hypotheses.participants, whose) if whose else np.ones(hypotheses.participants.size, dtype=np.bool_)
    bars = []
    for first, second in combinations(places, 2) if len(names) <= _ALL_PAIRS_UP_TO else pairwise(places):
        ends = np.isin(hypotheses.specimens, [names[first], names[second]])
        these = lsd.p[own[: len(lsd.p)]][:, ends[lsd.first] & ends[lsd.second]]
        if np.isfinite(these).any():
            bars.append(PairBar(first, second, float(np.nanmax(these))))
    return bars


def _interpolation(results: StudyResults, profiles: Profiles, new: Profile) -> Drawing:
    scale, error = results.scale, profiles.new_error
    measured = [*profiles.profiles]
    if profiles.new_measured and profiles.new_measured.specimen not in {p.specimen for p in measured}:
        measured.append(profiles.new_measured)
        measured.sort(key=lambda profile: results.specimens.index(profile.specimen))
    rmse = error.rmse_v if error else float("nan")
    half_v = profiles.half_width_v(new)
    figure = draw_interpolation(measured, new, half_v, looks(results.specimens), scale, rmse)
    beside = (
        f"RMSE to the measured {error.specimen}: {activity(rmse, scale)}, "
        f"{percent(error.relative)} of its root mean square."
        if error
        else "Nobody palpated a specimen of this stiffness, so there is no measured profile to compare with."
    )
    caption = (
        f"Fig. 11. Profile of {new.specimen} ({number(new.stiffness_n_per_mm)} N/mm), interpolated from "
        f"{listed(profiles.bracket or ())}, with the measured profiles. {beside}"
    )
    if np.isfinite(half_v).all():
        caption += f" The band is its interval at each force; {_interval_of(profiles)}."
    every = slice(None, None, max(1, new.force_n.size // 10))
    # of two profiles of one name the new one counts
    drawn = {f"{p.specimen}_v": p for p in [*measured, new]}
    columns = {Column("force_n", "Force (N)"): new.force_n[every]} | {
        activity_column(key, p.specimen, scale): p.v[every] for key, p in drawn.items()
    }
    for end, sign in (("low", -1), ("high", 1)):
        key = f"{new.specimen}_{end}_v"
        columns[activity_column(key, f"{new.specimen} {end}", scale)] = (new.v + sign * half_v)[every]
    title = f"Interpolated profile of {new.specimen} beside measured profiles"
    table = table_of("fig11", "Numbers of figure 11", columns)
    return Drawing("fig11_interpolation", title, caption, caption, figure, table)


_TEXT = """
{% if not people.profiles %}
<p>{{ why_absent("profiles") }}</p>
{% else %}
{{ folded("fig04_cocontraction", "Figure 4: co-contraction against force") }}
{{ folded("profiles", "Coefficients of the profiles") }}
{% if people.profiles.new %}
{{ folded("fig11_interpolation", "Figure 11: interpolated profile of " ~ people.profiles.new.specimen) }}
{% else %}
<p>The study names no new specimen, so nothing is interpolated.</p>
{% endif %}
{% if has("leave_one_out") and people.profiles.leave_one_out %}
{{ folded("leave_one_out", "Each measured profile interpolated from its neighbours") }}
{% else %}
<p>Too few specimens of known stiffness to leave one out.</p>
{% endif %}
{{ folded("exemplary", "Choice of the participant: how far the schedules would differ") }}
<details><summary>Notes on the profiles</summary>{{ people.profiles.notes | bullets }}</details>
{% endif %}
"""

PROFILES = Section("profiles", "Profiles", _TEXT, of_people, _quantities, _tables, _drawings)
