"""Figures 4, 5 and 11 of a study: drawn once, each saved as SVG and PDF, shown on the page, and told in words."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.figures.boxes import PairBar, hazen_box
from emg2vsa.figures.canvas import style
from emg2vsa.figures.cocontraction import draw_cocontraction, draw_interpolation
from emg2vsa.figures.palette import looks
from emg2vsa.figures.schedule_map import draw_schedules
from emg2vsa.fits import usable
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.report.drawing import STARS, Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.study_tables import scale_of
from emg2vsa.report.table import Column, Table, activity_column
from emg2vsa.report.wording import activity, count, listed, number, p_text, percent

_ALL_PAIRS_UP_TO = 4


def study_figures(results: StudyResults) -> dict[str, Drawing]:
    """Name to drawing; without profiles or schedules their figures are absent."""
    with style():
        drawings = [_cocontraction(results), _schedules(results), _interpolation(results)]
    return {drawing.name: drawing for drawing in drawings if drawing is not None}


def _cocontraction(results: StudyResults) -> Drawing | None:
    if results.profiles is None:
        return None
    scale, whose = scale_of(results), results.profiles.participant
    profiles = _shown(results.profiles, results.hypotheses)
    names = [profile.specimen for profile in profiles]
    slopes = [_slopes(results, name, whose) for name in names]
    bars = _bars(results.hypotheses, names, whose)
    of = whose or "all participants"
    test = "Fisher's LSD, uncorrected" + ("" if whose else "; largest p of all participants")
    look = looks(_specimens(results))
    figure = draw_cocontraction(profiles, slopes, bars, [look[name] for name in names], scale, test if bars else "")
    pairs = "; ".join(f"{names[bar.first]} and {names[bar.second]}: {p_text(bar.p)}" for bar in bars)
    caption = (
        f"Fig. 4. Co-contraction of {of}. (a) Mean fitted trend of each specimen; the band is one standard deviation "
        f"{'between trials' if whose else 'between participants'}. (b) Slopes b, one mark a trial: boxes are Hazen's "
        "quartiles, whiskers reach the furthest value within 1.5 interquartile ranges."
    ) + (f" {test}: {STARS}." if bars else "")
    told = [
        f"{p.specimen}: {activity(p.v[0], scale)} to {activity(p.v[-1], scale)}, median b "
        f"{activity(float(np.median(b)), scale) if b.size else 'not known'} in {count(b.size, 'trial')}"
        for p, b in zip(profiles, slopes, strict=True)
    ]
    columns = (
        Column("specimen", "Specimen"), Column("n", "Trials"),
        *(
            activity_column(key, head, scale)
            for key, head in (
                ("v_low_v", "Trend, lowest force"), ("v_high_v", "Trend, highest force"),
                ("whisker_low_v", "b: lower whisker"), ("q1_v", "lower quartile"), ("median_v", "median"),
                ("q3_v", "upper quartile"), ("whisker_high_v", "upper whisker"),
            )
        ),
    )  # fmt: skip
    rows = tuple(
        (p.specimen, b.size, float(p.v[0]), float(p.v[-1]), *(hazen_box(b) if b.size else [None] * 5))
        for p, b in zip(profiles, slopes, strict=True)
    )
    table = Table("fig04", "Numbers of figure 4", columns, rows)
    title = "Co-contraction against force, and slopes b by specimen"
    description = "; ".join(told) + (f". {test}: {pairs}" if pairs else "") + "."
    return Drawing("fig04_cocontraction", title, caption, description, figure, table)


def _shown(profiles: Profiles, hypotheses: Hypotheses | None) -> Sequence[Profile]:
    """The exported specimens among which the worst p was taken; all exported where that leaves none."""
    kept = hypotheses.kept if hypotheses else ()
    return [p for p in profiles.profiles if p.specimen in kept] or profiles.profiles


def _slopes(results: StudyResults, specimen: str, whose: str) -> Floats:
    fits = results.fitted
    entering = usable(fits, results.study.hypotheses.use) & (fits.specimen == specimen)
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


def _schedules(results: StudyResults) -> Drawing | None:
    if not results.schedules:
        return None
    new = results.profiles.new.specimen if results.profiles and results.profiles.new else None
    figure = draw_schedules(results.schedules, looks(_specimens(results), new))
    low, high, scale = (*results.study.schedule.stiffness_percent, results.study.schedule.scale)
    caption = (
        f"Fig. 5. Co-contraction mapped on the actuator's stiffness, {low:g} to {high:g} % of the maximum {scale} over "
        "all exported specimens. Left: modular stiffness, step by step. Right: constant stiffness, at the "
        "minimum (lower bar), mean (mark) and maximum (upper bar) of each profile."
    )
    told = [
        f"{s.specimen} {s.condition}: {number(s.stiffness_percent.min())}"
        + (f" to {number(s.stiffness_percent.max())} %" if s.condition == "modular" else " %")
        for s in results.schedules
    ]
    title = "Stiffness preset against force"
    return Drawing("fig05_schedules", title, caption, "; ".join(told) + ".", figure, None)


def _interpolation(results: StudyResults) -> Drawing | None:
    profiles = results.profiles
    if profiles is None or profiles.new is None:
        return None
    scale, new, error = scale_of(results), profiles.new, profiles.new_error
    measured = [*profiles.profiles]
    if profiles.new_measured and profiles.new_measured.specimen not in {p.specimen for p in measured}:
        measured.append(profiles.new_measured)
        measured.sort(key=lambda profile: _specimens(results).index(profile.specimen))
    rmse = error.rmse_v if error else float("nan")
    figure = draw_interpolation(measured, new, looks(_specimens(results)), scale, rmse)
    bracket = listed(profiles.bracket or ())
    beside = (
        f"RMSE to the measured {error.specimen}: {activity(rmse, scale)}, "
        f"{percent(error.relative)} of its root mean square."
        if error
        else "Nobody palpated a specimen of this stiffness, so there is no measured profile to compare with."
    )
    caption = (
        f"Fig. 11. Profile of {new.specimen} ({number(new.stiffness_n_per_mm)} N/mm), interpolated from {bracket}, "
        f"with the measured profiles. {beside}"
    )
    columns = (
        Column("force_n", "Force (N)"),
        *(activity_column(f"{p.specimen}_v", p.specimen, scale) for p in [*measured, new]),
    )
    every = slice(None, None, max(1, new.force_n.size // 10))
    rows = tuple(zip(new.force_n[every].tolist(), *(p.v[every].tolist() for p in [*measured, new]), strict=True))
    table = Table("fig11", "Numbers of figure 11", columns, rows)
    title = f"Interpolated profile of {new.specimen} beside measured profiles"
    return Drawing("fig11_interpolation", title, caption, caption, figure, table)


def _specimens(results: StudyResults) -> list[str]:
    return [specimen.name for specimen in results.study.specimens]
