"""Co-contraction profiles to stiffness presets by equation (7), over all exported specimens together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.curves.force_bins import bin_edges
from emg2vsa.devices.joints import export_of
from emg2vsa.errors import ScheduleError
from emg2vsa.profiles import MeanErrors, Profile, Profiles
from emg2vsa.schedules.checks import check
from emg2vsa.schedules.intervals import Activities, joined, rivals, share_interval
from emg2vsa.schedules.schedule import Limits, Ramp, Schedule, step_tolerance_n
from emg2vsa.settings import ScheduleSettings

_FLAT = 1e-9
"""Activity that varies by less than this share of its level cannot be mapped: rounding would decide the stiffness."""


def build_schedules(
    profiles: Profiles, settings: ScheduleSettings, provenance: Mapping[str, str]
) -> tuple[Schedule, ...]:
    """Schedules of every exported specimen and the new one, under every condition asked for; each passes ``check``.

    Activity is averaged over force steps. The smallest and the largest step mean of all specimens go to the two ends of
    ``settings.stiffness_percent``. A measured specimen with the name of the new one gives way to it. ScheduleError
    where activity does not vary, or a limit cannot be kept.
    """
    exported = _exported(profiles)
    edges = bin_edges(exported[0].force_n[0], exported[0].force_n[-1], settings.step_n)
    log_force = mean_over_steps(0.0, 1.0, edges)
    means = [_step_means(profile, edges) for profile in exported]
    span = _span(means)
    steps = [Activities(v, profile.weights_at(log_force)) for profile, v in zip(exported, means, strict=True)]
    share = _shares(steps, edges, profiles)
    common = dict(provenance) | {
        "participant": profiles.participant or "mean over all",
        "activity_unit": profiles.unit,
        "mapping": _mapping_text(span, settings),
    }
    return tuple(
        _schedule(
            profile.specimen, condition, edges, _levels(condition, own.v, edges), span, share(condition, own),
            settings, common | _origin(profile, profiles),
        )
        for profile, own in zip(exported, steps, strict=True)
        for condition in dict.fromkeys(settings.conditions)
    )  # fmt: skip


def _step_means(profile: Profile, edges_n: Floats) -> Floats:
    if profile.curve == "spline" and profile.spline is not None:
        return profile.spline.mean_over_steps(edges_n)
    return mean_over_steps(profile.a_v, profile.b_v, edges_n)


def mean_over_steps(a_v: float, b_v: float, edges_n: Floats) -> Floats:
    """Mean (K,), V, of a + b ln F over each step between ``edges_n`` (K + 1,), N, in closed form (of paper, eq. 6).

    The mean of ln F from F1 to F2 is (F2 ln F2 - F1 ln F1)/(F2 - F1) - 1, written here so that it does not cancel.
    """
    low, high = edges_n[:-1], edges_n[1:]
    rise = (high - low) / low
    return a_v + b_v * (np.log(low) + (1 + rise) / rise * np.log1p(rise) - 1)


def _exported(profiles: Profiles) -> tuple[Profile, ...]:
    if profiles.new is None:
        return profiles.profiles
    return (*(p for p in profiles.profiles if p.specimen != profiles.new.specimen), profiles.new)


def _span(means: Sequence[Floats]) -> tuple[float, float]:
    low, high = float(np.min(means)), float(np.max(means))
    if not high - low > _FLAT * max(abs(low), abs(high)):
        raise ScheduleError(
            "mapping of co-contraction to stiffness", wanted="co-contraction that varies with force or specimen",
            found=f"{low:.6g} in every step", do="Check the slopes b of the fits, and the force step.",
        )  # fmt: skip
    return low, high


def _levels(condition: str, v: Floats, edges: Floats) -> Floats:
    if condition == "modular":
        return v
    # the last step may be shorter, so the mean of the curve weighs each step by its width
    level = {"constant-min": v.min(), "constant-mean": np.average(v, weights=np.diff(edges)), "constant-max": v.max()}
    return np.full(v.size, level[condition])


def _shares(
    steps: Sequence[Activities], edges: Floats, profiles: Profiles
) -> Callable[[str, Activities], tuple[Floats, str] | None]:
    """By condition and activities of a specimen: the interval (2, K) of the share of the mapped range, and what it is
    of; None where it is not known."""
    errors = profiles.errors
    ends = joined([own.only(place) for own in steps for place in (0, -1)])
    if errors is None or not np.isfinite(errors.half_width(ends.weights)).all():
        return lambda condition, own: None
    told = _interval_text(profiles, errors)
    lowest, highest = (rivals(ends, sign, errors) for sign in (-1, 1))

    def share(condition: str, own: Activities) -> tuple[Floats, str]:
        of = [own]
        if condition == "constant-mean":
            widths = np.diff(edges) / (edges[-1] - edges[0])
            of = [Activities(np.array([widths @ own.v]), np.einsum("k,ksc->sc", widths, own.weights)[None])]
        elif condition != "modular":
            own_ends = joined([own.only(0), own.only(-1)])
            of = rivals(own_ends, -1 if condition == "constant-min" else 1, errors)
        found = share_interval(of, lowest, highest, errors)
        return np.repeat(found, own.v.size // found.shape[1], axis=1), told

    return share


def _interval_text(profiles: Profiles, errors: MeanErrors) -> str:
    alike = f" (successive ones correlate by {errors.rho:.2g})" if errors.rho else ""
    not_in = " The interval does not hold the choice of the person." if errors.unit == "press" else ""
    return (
        f"{100 * errors.confidence:g} % by Student's t, from the scatter between {profiles.drawn}{alike}. The interval "
        f"holds the error of both ends of the mapping.{not_in}"
    )


def _schedule(
    specimen: str,
    condition: str,
    edges: Floats,
    v: Floats,
    span: tuple[float, float],
    share: tuple[Floats, str] | None,
    settings: ScheduleSettings,
    provenance: dict[str, str],
) -> Schedule:
    limits = Limits(settings.stiffness_percent, _full_preset(settings), settings.actuator, settings.scale)
    percent = limits.preset_percent(stiffness_percent(v, span, settings.stiffness_percent))
    preset = limits.joint.rounded(percent / 100)
    widths = np.diff(edges)
    interval = None
    if share is not None:
        low, high = limits.preset_percent(stiffness_percent(share[0], (0.0, 1.0), settings.stiffness_percent))
        # rounding may put the estimate beside an interval of no width
        interval = np.stack([np.minimum(low, percent), np.maximum(high, percent)])
        provenance = provenance | {"interval": share[1]}
    schedule = Schedule(
        specimen=specimen,
        condition=condition,
        step_force_n=edges,
        stiffness_percent=percent,
        preset=preset,
        stiffness_nm_per_rad=limits.joint.stiffness_nm_per_rad(preset),
        activity_v=v,
        last_step_short=bool(settings.step_n - widths[-1] > step_tolerance_n(settings.step_n)),
        ramp=_ramp(settings),
        limits=limits,
        provenance=provenance,
        interval_percent=interval,
    )
    check(schedule)
    return schedule


def _full_preset(settings: ScheduleSettings) -> float:
    """Full preset in the joint's own unit. ScheduleError where the study does not say it."""
    export = export_of(settings.actuator)
    value = getattr(settings, export.limit, None)
    if value is None:
        do = f"Write it into the table [schedule] of the study for actuator = {settings.actuator!r}."
        raise ScheduleError(
            f"schedule.{export.limit}", wanted=f"the full preset, {export.unit}", found="nothing", do=do
        )
    return float(value) / export.per_preset


def stiffness_percent(activity_v: ArrayLike, span_v: tuple[float, float], percent: tuple[float, float]) -> Floats:
    """Equation (7), k = p1 v + p2: co-contraction v to percent of the actuator's maximum stiffness (any shape).

    span_v : the activities that go to the two ends of ``percent``; what lies outside goes to the nearer end.
    """
    share = np.clip((np.asarray(activity_v, dtype=np.float64) - span_v[0]) / (span_v[1] - span_v[0]), 0.0, 1.0)
    return (1 - share) * percent[0] + share * percent[1]


def _ramp(settings: ScheduleSettings) -> Ramp:
    speed, gear, travel = settings.probe_speed_mm_per_s, settings.gear_mm_per_degree, settings.travel_mm
    return Ramp(speed, gear, speed / gear, travel, travel / speed)


def _mapping_text(span: tuple[float, float], settings: ScheduleSettings) -> str:
    lowest, highest = settings.stiffness_percent
    p1 = (highest - lowest) / (span[1] - span[0])
    return f"k = p1 v + p2 in percent of maximum {settings.scale}; p1 = {p1!r}, p2 = {lowest - p1 * span[0]!r}"


def _origin(profile: Profile, profiles: Profiles) -> dict[str, str]:
    origin = profile.source
    if profile.source == "interpolated" and profiles.bracket:
        stiffer, softer = profiles.bracket
        origin = f"interpolated at {profile.stiffness_n_per_mm!r} N/mm, nearest neighbours {stiffer} and {softer}"
        if np.isfinite(profiles.weight_alpha):
            origin += f", weight of {softer} {profiles.weight_alpha!r}"
    return {
        "profile": origin,
        "trials": str(profile.n_trials),
        "curve": "v = a + b ln(F / 1 N)" if profile.curve == "log" else "monotone spline",
        "fit": f"v = a + b ln(F / 1 N); a = {profile.a_v!r}, b = {profile.b_v!r}",
    }
