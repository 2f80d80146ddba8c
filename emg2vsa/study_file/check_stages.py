"""Checks within and across the stages' tables: ranges that run backwards, levels that are missing.

A check takes the tables that it looks at, by their names. ``of_runs_alone``: whether the study has no people.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from emg2vsa.devices.joints import joint_names, kind_with
from emg2vsa.devices.registry import own_kinds
from emg2vsa.settings import (
    MOST_BINS,
    RECIPES,
    ChannelSettings,
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ProfileSettings,
    ScheduleSettings,
    SimulationSettings,
    WindowSettings,
)
from emg2vsa.study_file.problems import KeyPath, Problem, nearest, shown
from emg2vsa.study_file.tables import MvcTable, RecordingsTable, RunsTable, SpecimenTable, overlaid

LARGEST_CROSSTALK = 0.99
"Product of what two muscles hear of each other, up to which they can be told apart."


def _rising(pair: Sequence[float], path: KeyPath, equal: bool = False) -> Iterator[Problem]:
    if pair[0] > pair[1] or (pair[0] == pair[1] and not equal):
        yield Problem(path, "the smaller number first", shown(list(pair)))


def _band_and_order(filters: FilterSettings, at: KeyPath) -> Iterator[Problem]:
    yield from _rising(filters.band_hz, (*at, "band_hz"))
    if filters.fir_order % 2:
        do = f"Take {filters.fir_order + 1}: the delay is then a whole number of samples."
        yield Problem((*at, "fir_order"), "an even order", str(filters.fir_order), do)


def _limits(window: WindowSettings, at: KeyPath) -> Iterator[Problem]:
    yield from _rising(window.force_n, (*at, "force_n"))
    if window.min_duration_s >= window.max_duration_s:
        found = f"{window.max_duration_s:g}"
        yield Problem((*at, "max_duration_s"), f"more than min_duration_s = {window.min_duration_s:g}", found)
    if window.warn_falling_share > window.max_falling_share:
        wanted = f"at most max_falling_share = {window.max_falling_share:g}"
        yield Problem((*at, "warn_falling_share"), wanted, f"{window.warn_falling_share:g}")


def _filters(filters: FilterSettings) -> Iterator[Problem]:
    yield from _band_and_order(filters, ("filters",))


def _window(window: WindowSettings) -> Iterator[Problem]:
    yield from _limits(window, ("window",))


def _own_filters(recordings: RecordingsTable, filters: FilterSettings, raw: Mapping[str, Any]) -> Iterator[Problem]:
    for index, file in enumerate(recordings.files):
        if file.filters:
            given = raw["recordings"]["files"][index]["filters"]
            at = ("recordings", "files", index, "filters")
            yield from _band_and_order(overlaid(filters, file.filters, given), at)


def _own_window(recordings: RecordingsTable, window: WindowSettings, raw: Mapping[str, Any]) -> Iterator[Problem]:
    for index, file in enumerate(recordings.files):
        if file.window:
            given = raw["recordings"]["files"][index]["window"]
            yield from _limits(overlaid(window, file.window, given), ("recordings", "files", index, "window"))


def _muscles(
    cocontraction: CocontractionSettings,
    ids: tuple[str, ...],
    mvc: tuple[MvcTable, ...],
    channels: ChannelSettings | None = None,
    recordings: RecordingsTable | None = None,
) -> Iterator[Problem]:
    sets, index, mvc_v = _muscle_sets(channels, recordings), cocontraction.index, cocontraction.mvc_v
    for muscles in sets:
        pairwise = index in ("rudolph", "falconer-winter")
        if (pairwise and len(muscles) != 2) or (index == "minimum" and len(muscles) < 2):
            wanted = f"{'two' if pairwise else 'two or more'} muscles in every recording for {index!r}"
            yield Problem(("cocontraction", "index"), wanted, ", ".join(muscles))
    every = tuple(dict.fromkeys(muscle for muscles in sets for muscle in muscles))
    for muscle in mvc_v:
        if every and muscle not in every:
            do = nearest(muscle, every, f"The muscles are {', '.join(every)}.")
            yield Problem(("cocontraction", "mvc_v", muscle), "a muscle of [channels.emg]", repr(muscle), do)
    for muscle in (name for into, of in cocontraction.crosstalk.items() for name in (into, *of)):
        if every and muscle not in every:
            do = nearest(muscle, every, f"The muscles are {', '.join(every)}.")
            yield Problem(("cocontraction", "crosstalk", muscle), "a muscle of [channels.emg]", repr(muscle), do)
    for into, heard in cocontraction.crosstalk.items():
        for other, share in heard.items():
            back = cocontraction.crosstalk.get(other, {}).get(into, 0.0)
            if other == into or share * back > LARGEST_CROSSTALK:
                found = f"{into} sees {share:g} of {other}" + (f", and back {back:g}" if other != into else "")
                do = "Measure the shares again, each with one muscle tensed alone."
                where = ("cocontraction", "crosstalk", into)
                yield Problem(where, "shares by which two muscles can be told apart", found, do)
    unrecorded = [name for name in ids if name not in {table.participant for table in mvc}]
    for muscle in every if unrecorded or not ids else ():
        if cocontraction.normalise == "mvc" and muscle not in mvc_v:
            of = ", ".join(unrecorded[:5]) + (" and others" if len(unrecorded) > 5 else "")
            do = f"Measure it, or record it of {of} ([[mvc]]), or set normalise to another value."
            yield Problem(("cocontraction", "mvc_v", muscle), "the level of every muscle", f"none for {muscle!r}", do)


def _muscle_sets(channels: ChannelSettings | None, recordings: RecordingsTable | None) -> tuple[tuple[str, ...], ...]:
    """The muscles of the study's channels and of every recording that has its own."""
    tables = [channels.emg] if channels else []
    own = [file.channels for file in recordings.files] if recordings else []
    tables += [table.emg for table in own if table and table.emg]
    return tuple(dict.fromkeys(tuple(table) for table in tables))


def _bins(window: WindowSettings, fit: FitSettings) -> Iterator[Problem]:
    lower, upper = window.force_n
    if fit.points == "bins" and 0 < upper - lower < 3 * fit.bin_n:
        do = "A fit of two parameters needs three bins."
        yield Problem(("fit", "bin_n"), f"at most {(upper - lower) / 3:g}", f"{fit.bin_n:g}", do)
    if (bins := (upper - lower) / fit.bin_n) > MOST_BINS + 1e-6:
        wanted = f"at most {MOST_BINS} bins from {lower:g} to {upper:g} N"
        found, do = f"{math.ceil(bins)} bins of {fit.bin_n:g} N", "Widen the bins: no press has samples for so many."
        yield Problem(("fit", "bin_n"), wanted, found, do)


def _new_specimen(profile: ProfileSettings) -> Iterator[Problem]:
    name, stiffness = profile.new_specimen, profile.new_stiffness_n_per_mm
    if name is not None and stiffness is None:
        yield Problem(("profile", "new_stiffness_n_per_mm"), f"the stiffness of {name!r}", "nothing")
    for value, what in ((stiffness, "stiffness"), (profile.new_height_mm, "height")):
        if value is not None and name is None:
            yield Problem(("profile", "new_specimen"), f"a name for the new {what}", "nothing")


def _bracket(profile: ProfileSettings, specimens: tuple[SpecimenTable, ...], of_runs_alone: bool) -> Iterator[Problem]:
    stiffness = profile.new_stiffness_n_per_mm
    if profile.new_specimen is None or stiffness is None or profile.extrapolate or of_runs_alone:
        return
    used = [s.stiffness_n_per_mm for s in specimens if not profile.specimens or s.name in profile.specimens]
    known = [value for value in used if value is not None]
    if not known or not min(known) <= stiffness <= max(known):
        span = f"between {min(known):g} and {max(known):g}, the specimens used" if known else ""
        do = "Add specimens, or set extrapolate = true."
        wanted = span or "specimens of known stiffness"
        yield Problem(("profile", "new_stiffness_n_per_mm"), wanted, f"{stiffness:g}", do)


def _schedule(schedule: ScheduleSettings) -> Iterator[Problem]:
    yield from _rising(schedule.stiffness_percent, ("schedule", "stiffness_percent"))
    if (kind := kind_with(schedule.actuator)) is None:
        known = joint_names()
        wanted, do = f"one of {', '.join(known)}", nearest(schedule.actuator, known)
        yield Problem(("schedule", "actuator"), wanted, shown(schedule.actuator), do)
    elif getattr(schedule, key := kind.full_key, None) is None:
        wanted = f"a key {key!r} with actuator = {schedule.actuator!r}: its full preset"
        yield Problem(("schedule", key), wanted, "nothing")


def _plates(specimens: tuple[SpecimenTable, ...]) -> Iterator[Problem]:
    """Forces that rise, a change over forces that are stated, and both sizes of a cylinder."""
    for index, of in enumerate(specimens):
        at: KeyPath = ("specimens", index)
        if of.stiffness_range_n:
            yield from _rising(of.stiffness_range_n, (*at, "stiffness_range_n"))
        elif of.stiffness_change:
            wanted = "stiffness_range_n too, the forces over which it changes so"
            yield Problem((*at, "stiffness_change"), wanted, "none")
        if of.diameter_mm and not of.height_mm:
            yield Problem((*at, "height_mm"), "height_mm beside diameter_mm of a cylinder", "nothing")


def _full_preset(schedule: ScheduleSettings, raw: Mapping[str, Any]) -> Iterator[Problem]:
    kind = kind_with(schedule.actuator)
    for other in dict.fromkeys(each.full_key for _, each in own_kinds("actuator")):
        if kind and other != (own := kind.full_key) and other in raw.get("schedule", {}):
            wanted = f"no key of another actuator with actuator = {schedule.actuator!r}"
            yield Problem(("schedule", other), wanted, repr(other), f"Give {own!r}, or correct actuator.")


def _step(schedule: ScheduleSettings, window: WindowSettings) -> Iterator[Problem]:
    lower, upper = window.force_n
    if 0 < upper - lower < schedule.step_n:
        wanted = f"at most {upper - lower:g}, the width of the force window"
        yield Problem(("schedule", "step_n"), wanted, f"{schedule.step_n:g}")


def _runs(runs: RunsTable) -> Iterator[Problem]:
    yield from _rising(runs.force_n, ("runs", "force_n"))
    recipe, own = runs.recipe, RECIPES[runs.algorithm]
    if runs.algorithm == "front":
        for key in ("engine", "area_rule", "law", "rate", "region"):
            if getattr(recipe, key) != getattr(own, key):
                wanted = f"no {key}, or {getattr(own, key)!r}, with algorithm = 'front'"
                do = "The front is followed by the pins; choose another algorithm, or leave the key out."
                yield Problem(("runs", key), wanted, repr(getattr(recipe, key)), do)
        return
    if runs.algorithm != "paper" and recipe.area_rule != own.area_rule:
        wanted = f"no area_rule, or {own.area_rule!r}, with algorithm = {runs.algorithm!r}"
        do = f"Choose algorithm = {recipe.area_rule!r}, or leave area_rule out."
        yield Problem(("runs", "area_rule"), wanted, repr(recipe.area_rule), do)
    if recipe.region == "image" and recipe.engine == "pin-affine":
        wanted, do = "a dense engine with region = 'image'", "Choose horn-schunck or dis, or leave region out."
        yield Problem(("runs", "engine"), wanted, repr(recipe.engine), do)


def _durations(simulation: SimulationSettings) -> Iterator[Problem]:
    yield from _rising(simulation.loading_s, ("simulation", "loading_s"), equal=True)
    yield from _rising(simulation.rest_s, ("simulation", "rest_s"), equal=True)


def _shares(
    simulation: SimulationSettings, channels: ChannelSettings | None = None, recordings: RecordingsTable | None = None
) -> Iterator[Problem]:
    share = simulation.muscle_share
    others = [muscles for muscles in _muscle_sets(channels, recordings) if set(muscles) != set(share)]
    if others:
        wanted = f"a share for each of {', '.join(others[0])}"
        yield Problem(("simulation", "muscle_share"), wanted, ", ".join(share) or "none")
    elif not math.isclose(sum(share.values()), 1.0, abs_tol=1e-9):
        yield Problem(("simulation", "muscle_share"), "shares that sum to 1", f"a sum of {sum(share.values()):g}")


def _silent(simulation: SimulationSettings, window: WindowSettings) -> Iterator[Problem]:
    """Activity is an amplitude: the truth must stay above zero over the whole window."""
    lower, upper = window.force_n
    for name in simulation.a_v.keys() & simulation.b_v.keys():
        lowest = min(simulation.a_v[name] + simulation.b_v[name] * math.log(f) for f in (lower, upper))
        if lowest <= 0:
            wanted = f"a + b log F > 0 from {lower:g} to {upper:g} N"
            yield Problem(("simulation", "a_v", name), wanted, f"{lowest:.3g} V", "Raise a_v or lower b_v.")


CHECKS = (
    _filters, _window, _own_filters, _own_window, _muscles, _bins, _new_specimen, _bracket, _plates, _schedule,
    _full_preset, _step, _runs, _durations, _shares, _silent,
)  # fmt: skip
