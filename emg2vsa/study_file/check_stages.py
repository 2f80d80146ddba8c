"""Checks within and across the stages' tables: ranges that run backwards, levels that are missing."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from emg2vsa.settings import FilterSettings, ProfileSettings, ScheduleSettings, SimulationSettings, WindowSettings
from emg2vsa.study_file.draft import Draft
from emg2vsa.study_file.lines import KeyPath
from emg2vsa.study_file.problems import Problem, nearest, shown


def stage_problems(draft: Draft) -> Iterator[Problem]:
    """Every stage in the order of the chain, and the exceptions that single recordings make."""
    if draft.filters:
        yield from _filters(draft.filters, ("filters",))
    if draft.window:
        yield from _window(draft.window, ("window",))
    for index, file in enumerate(draft.files):
        if file and draft.filters and draft.window:
            at = ("recordings", "files", index)
            yield from _filters(draft.overlaid(draft.filters, index, "filters"), (*at, "filters"))
            yield from _window(draft.overlaid(draft.window, index, "window"), (*at, "window"))
    yield from _cocontraction(draft)
    yield from _bins(draft)
    if draft.profile:
        yield from _new_specimen(draft, draft.profile)
    if draft.schedule:
        yield from _schedule(draft, draft.schedule)
    if draft.runs:
        yield from _rising(draft.runs.force_n, ("runs", "force_n"))
    if draft.simulation:
        yield from _simulation(draft, draft.simulation)


def _rising(pair: Sequence[float], path: KeyPath, equal: bool = False) -> Iterator[Problem]:
    if pair[0] > pair[1] or (pair[0] == pair[1] and not equal):
        yield Problem(path, "the smaller number first", shown(list(pair)))


def _filters(filters: FilterSettings, at: KeyPath) -> Iterator[Problem]:
    yield from _rising(filters.band_hz, (*at, "band_hz"))
    if filters.fir_order % 2:
        do = f"Take {filters.fir_order + 1}: the delay is then a whole number of samples."
        yield Problem((*at, "fir_order"), "an even order", str(filters.fir_order), do)


def _window(window: WindowSettings, at: KeyPath) -> Iterator[Problem]:
    yield from _rising(window.force_n, (*at, "force_n"))
    if window.min_duration_s >= window.max_duration_s:
        found = f"{window.max_duration_s:g}"
        yield Problem((*at, "max_duration_s"), f"more than min_duration_s = {window.min_duration_s:g}", found)
    if window.warn_falling_share > window.max_falling_share:
        wanted = f"at most max_falling_share = {window.max_falling_share:g}"
        yield Problem((*at, "warn_falling_share"), wanted, f"{window.warn_falling_share:g}")


def _cocontraction(draft: Draft) -> Iterator[Problem]:
    table, sets = draft.cocontraction, draft.muscle_sets()
    if table is None or not sets:
        return
    for muscles in sets:
        pairwise = table.index in ("rudolph", "falconer-winter")
        if (pairwise and len(muscles) != 2) or (table.index == "minimum" and len(muscles) < 2):
            wanted = f"{'two' if pairwise else 'two or more'} muscles in every recording for {table.index!r}"
            yield Problem(("cocontraction", "index"), wanted, ", ".join(muscles))
    muscles = _union(sets)
    for muscle in table.mvc_v:
        if muscle not in muscles:
            listed = f"The muscles are {', '.join(muscles)}."
            path = ("cocontraction", "mvc_v", muscle)
            yield Problem(path, "a muscle of [channels.emg]", repr(muscle), nearest(muscle, muscles, listed))
    for muscle in muscles:
        if table.normalise == "mvc" and muscle not in table.mvc_v:
            do = "Measure it, or set normalise to another value."
            yield Problem(("cocontraction", "mvc_v", muscle), "the level of every muscle", f"none for {muscle!r}", do)


def _union(sets: Sequence[Sequence[str]]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(muscle for muscles in sets for muscle in muscles))


def _bins(draft: Draft) -> Iterator[Problem]:
    if draft.window and draft.fit and draft.fit.points == "bins":
        lower, upper = draft.window.force_n
        if 0 < upper - lower < 3 * draft.fit.bin_n:
            do = "A fit of two parameters needs three bins."
            yield Problem(("fit", "bin_n"), f"at most {(upper - lower) / 3:g}", f"{draft.fit.bin_n:g}", do)


def _new_specimen(draft: Draft, profile: ProfileSettings) -> Iterator[Problem]:
    stiffness = profile.new_stiffness_n_per_mm
    if profile.new_specimen is not None and stiffness is None:
        wanted = f"the stiffness of {profile.new_specimen!r}"
        yield Problem(("profile", "new_stiffness_n_per_mm"), wanted, "nothing")
    if stiffness is not None and profile.new_specimen is None:
        yield Problem(("profile", "new_specimen"), "a name for the new stiffness", "nothing")
    names = profile.specimens or draft.specimen_names
    if profile.new_specimen is None or stiffness is None or names is None or profile.extrapolate:
        return
    if draft.is_of_runs_alone:  # no profile is interpolated
        return
    known = [
        s.stiffness_n_per_mm for s in draft.specimens if s and s.name in names and s.stiffness_n_per_mm is not None
    ]
    unread = any(p.path[0] == "specimens" for p in draft.problems)
    if not unread and (not known or not min(known) <= stiffness <= max(known)):
        span = (
            f"between {min(known):g} and {max(known):g}, the specimens used"
            if known
            else "specimens of known stiffness"
        )
        do = "Add specimens, or set extrapolate = true."
        yield Problem(("profile", "new_stiffness_n_per_mm"), span, f"{stiffness:g}", do)


def _schedule(draft: Draft, schedule: ScheduleSettings) -> Iterator[Problem]:
    yield from _rising(schedule.stiffness_percent, ("schedule", "stiffness_percent"))
    if draft.window:
        lower, upper = draft.window.force_n
        if 0 < upper - lower < schedule.step_n:
            wanted = f"at most {upper - lower:g}, the width of the force window"
            yield Problem(("schedule", "step_n"), wanted, f"{schedule.step_n:g}")


def _simulation(draft: Draft, simulation: SimulationSettings) -> Iterator[Problem]:
    for key in ("loading_s", "rest_s"):
        yield from _rising(getattr(simulation, key), ("simulation", key), equal=True)
    share = simulation.muscle_share
    others = [muscles for muscles in draft.muscle_sets() if set(muscles) != set(share)]
    if others:
        wanted = f"a share for each of {', '.join(others[0])}"
        yield Problem(("simulation", "muscle_share"), wanted, ", ".join(share) or "none")
    elif not math.isclose(sum(share.values()), 1.0, abs_tol=1e-9):
        yield Problem(("simulation", "muscle_share"), "shares that sum to 1", f"a sum of {sum(share.values()):g}")
    if draft.window:
        yield from _silent(simulation, draft.window.force_n)


def _silent(simulation: SimulationSettings, force_n: Sequence[float]) -> Iterator[Problem]:
    """Activity is an amplitude: the truth must stay above zero over the whole window."""
    for name in simulation.a_v.keys() & simulation.b_v.keys():
        lowest = min(simulation.a_v[name] + simulation.b_v[name] * math.log(f) for f in force_n)
        if lowest <= 0:
            wanted = f"a + b log F > 0 from {force_n[0]:g} to {force_n[1]:g} N"
            yield Problem(("simulation", "a_v", name), wanted, f"{lowest:.3g} V", "Raise a_v or lower b_v.")
