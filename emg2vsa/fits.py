"""The stage of equation (6): every trial's co-contraction fitted as v = a + b ln F, with errors that can be believed.

The samples of an envelope are far from independent, so the fit reported by default runs on force bins; what the same
trial gives sample by sample, as in the paper, stands beside it.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, median
from emg2vsa.curves.force_bins import fit_edges
from emg2vsa.curves.logarithmic import LogFit, said_of_forces
from emg2vsa.curves.press_fits import PressFits, fit_presses
from emg2vsa.errors import DataError
from emg2vsa.extraction import Trials
from emg2vsa.settings import CocontractionSettings, FitSettings, PressJudgement, WindowSettings
from emg2vsa.signals.bias import BiasBudget
from emg2vsa.signals.cocontraction import cocontraction_index

MIN_POINTS = 3
"""Fewest points a trial is fitted on: two parameters and one degree of freedom for their errors."""
CERTAIN = 0.05
"A slope that is this certain, as a share of itself, is never called uncertain beside others."
WIDE = 0.2
"""Half-width of the interval of b over the fitted level, from which on a slope is not known. To reject a press whose
level hardly changes with force, but is known, would select on the outcome: what is left has too large a b. Of 400 clean
presses 99 % have less than 0.12, with b down to nothing too; presses with spikes or a burst have 0.27 and more.
"""
CLEARLY, LIKE_OTHERS = 4.0, 3.0
"""... unless the presses of its recording together have a slope, by so many standard errors, and its interval is less
than so many times as wide as theirs: then it is one of them, and its low R2 is chance."""
_COMMON = ("bin_edges_n", "activity_unit", "points", "weights", "confidence")


@dataclass(frozen=True)
class Fits:
    """One row per trial, of one recording or of many (``concatenate``); all arrays (n,) unless said.

    Trials that could not be fitted stay, with NaN, verdict "rejected" and the reason.
    """

    participant: NDArray[np.str_]
    specimen: NDArray[np.str_]
    repetition: Ints
    verdict: NDArray[np.str_]
    reason: NDArray[np.str_]
    visit: NDArray[np.str_]
    "Its label; empty where the participant comes once."
    start_s: Floats
    a_v: Floats
    "Intercept of the reported fit: activity at 1 N, in ``activity_unit``."
    b_v: Floats
    "Slope of the reported fit, ``activity_unit`` per unit of ln(F / N)."
    a_se_v: Floats
    b_se_v: Floats
    b_lo_v: Floats
    "Interval of b at ``confidence``: Student's t, wider by the errors of corrections and by the bias that is left."
    b_hi_v: Floats
    n_points: Ints
    "Bins or samples the reported fit rests on."
    adj_r2: Floats
    "Adjusted R² of the reported fit, weighted as the fit was."
    r2_bins: Floats
    "R² of ordinary least squares on the bins, whatever is reported; likewise the next three."
    adj_r2_bins: Floats
    r2_samples: Floats
    adj_r2_samples: Floats
    n_effective: Floats
    "Independent observations that the samples are worth, from the autocorrelation of their residuals over the level."
    lag1: Floats
    "Autocorrelation of the sample residuals at a lag of one sample."
    b_bias: Floats
    "Share by which causes that were found, and not corrected, are expected to change b; signed."
    b_bias_se: Floats
    "Standard error of that, and of what was corrected, as a share of b; the interval holds both."
    b_corrected: Floats
    "Share by which the causes that were corrected had changed b; signed."
    cause: NDArray[np.str_]
    "The largest of these causes, of `emg2vsa.signals.bias.CAUSES`; empty without any."
    v_min_v: Floats
    "Fitted activity at the lower force of the window."
    v_max_v: Floats
    "Fitted activity at the upper force of the window."
    bin_edges_n: Floats
    "(B + 1,) newtons."
    bin_force_n: Floats
    "(n, B) geometric mean force of each bin, NaN where empty."
    bin_v: Floats
    "(n, B) mean activity of each bin, NaN where empty."
    activity_unit: str
    points: str
    weights: str
    confidence: float

    def __repr__(self) -> str:
        usable = self.verdict == "ok"
        told = (
            f", median b {np.nanmedian(self.b_v[usable]):.4g} {self.activity_unit}"
            if np.isfinite(self.b_v[usable]).any()
            else ""
        )
        people, specimens = np.unique(self.participant).size, np.unique(self.specimen).size
        return (
            f"Fits({usable.sum()} of {usable.size} trials usable{told}; {people} participants, {specimens} specimens)"
        )


def fit_trials(
    trials: Trials,
    fit: FitSettings,
    window: WindowSettings,
    judgements: Sequence[PressJudgement] = (),
    edges_n: Floats | None = None,
) -> Fits:
    """Fit every trial of a recording (paper, eq. 6), the rejected ones too, and reject those whose fit is no fit.

    ``judgements`` of people have the last word, that on a press before that on its recording, except that what could
    not be fitted stays rejected, and so does a press of a recording with a fault unless all of it is accepted.
    edges_n : (B + 1,) of the force bins, N, in place of those that ``fit`` and ``window`` make.
    With inverse-variance weights a bin counts as its number of samples over the square of its fitted level
    (``fit_log_by_level``); its errors allow for the envelope's memory (``bin_covariance``). On samples they do not.
    """
    edges = fit_edges(*window.force_n, fit.bin_n) if edges_n is None else edges_n
    curves = fit_presses(trials.force_n, trials.activity, trials.offsets, edges, fit)
    reported, bins = curves.reported, curves.bins
    fitted = (reported.n >= MIN_POINTS) & np.isfinite(reported.b) & np.isfinite(reported.b_se)
    at_ends = reported.at(window.force_n)
    n = fitted.size
    reasons = _reasons(trials.reasons, fitted, reported.n, fit.points, bins.force_n)
    verdicts = np.where(fitted, trials.verdict, "rejected").tolist()
    if not trials.fault:
        no_fit = _no_fit(curves, fitted & (trials.verdict != "rejected"), fit, window)
        for i, reason in no_fit.items():
            verdicts[i] = "rejected"
            reasons[i] = f"{reason}; {reasons[i]}" if reasons[i] else reason
    low_v, high_v = _with_bias(reported, trials.bias)
    if fit.max_bias:
        for i, reason in _doubts(reported, high_v - low_v, trials.bias, fit.max_bias).items():
            if verdicts[i] == "ok":
                verdicts[i] = "rejected" if trials.bias.largest[i] == "lost samples" else "doubtful"
                reasons[i] = f"{reason}; {reasons[i]}" if reasons[i] else reason
    _apply(judgements, trials, fitted, verdicts, reasons)
    shown = {
        "a_v": reported.a, "b_v": reported.b, "a_se_v": reported.a_se, "b_se_v": reported.b_se,
        "b_lo_v": low_v, "b_hi_v": high_v, "b_bias": trials.bias.total, "b_bias_se": trials.bias.total_se,
        "b_corrected": np.sum(trials.bias.corrected, axis=0), "adj_r2": reported.adj_r2,
        "v_min_v": at_ends[:, 0], "v_max_v": at_ends[:, 1],
    }  # fmt: skip
    on_bins, on_samples = curves.on_bins, curves.on_samples
    return Fits(
        participant=np.full(n, trials.participant), specimen=np.full(n, trials.specimen), repetition=trials.repetition,
        verdict=np.array(verdicts, dtype="<U8"), reason=np.array(reasons, dtype=np.str_),
        visit=trials.visit if trials.visit.size else np.full(n, ""), start_s=trials.start_s, n_points=reported.n,
        r2_bins=on_bins.r2, adj_r2_bins=on_bins.adj_r2, r2_samples=on_samples.r2, adj_r2_samples=on_samples.adj_r2,
        n_effective=curves.n_effective, lag1=curves.lag1, cause=np.array(trials.bias.largest, dtype=np.str_),
        bin_edges_n=edges, bin_force_n=bins.force_n, bin_v=bins.v, activity_unit=trials.activity_unit,
        points=fit.points, weights=fit.weights, confidence=fit.confidence,
        **{name: np.where(fitted, values, np.nan) for name, values in shown.items()},
    )  # fmt: skip


def _with_bias(reported: LogFit, bias: BiasBudget) -> tuple[Floats, Floats]:
    """The interval (k,), (k,) of b that also holds the errors of corrections, and the value without the bias left."""
    half = (reported.b_hi - reported.b_lo) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = half * np.hypot(1, bias.total_se * np.abs(reported.b) / reported.b_se)
    reach = np.where(np.isfinite(reach), reach, half)
    without = reported.b / (1 + bias.total)
    return np.fmin(reported.b, without) - reach, np.fmax(reported.b, without) + reach


def _doubts(reported: LogFit, width: Floats, bias: BiasBudget, most: float) -> dict[int, str]:
    """Press to why its b is doubtful: the bias that is expected, and its error, exceed ``most`` or the half width."""
    off = np.abs(reported.b) * np.abs(1 - 1 / (1 + bias.total))
    half = (width - off) / 2
    size = np.hypot(bias.total, bias.total_se)
    largest, told = bias.largest, {}
    for i in np.flatnonzero((size > most) | (np.hypot(off, bias.total_se * np.abs(reported.b)) > half)).tolist():
        way = f"too {'low' if bias.total[i] < 0 else 'high'}" if abs(bias.total[i]) > bias.total_se[i] else "off"
        share = f"{100 * size[i]:.0f}" if size[i] <= 1 else "more than 100"
        told[i] = f"b is expected to be {share} % {way}: {largest[i]}"
    return told


def _no_fit(curves: PressFits, among: NDArray[np.bool_], fit: FitSettings, window: WindowSettings) -> dict[int, str]:
    """Press to why its fit is no fit, of those ``among`` the presses (n,) that could be fitted.

    The median interval is that of these presses; of fewer than three it says nothing.
    """
    reported, adj_r2 = curves.reported, curves.on_bins.adj_r2
    half = (reported.b_hi - reported.b_lo) / 2
    level = reported.at(window.force_n).mean(axis=1)
    typical, sound = np.inf, False
    if np.count_nonzero(among) >= 3:
        typical = median(half[among])
        with np.errstate(divide="ignore", invalid="ignore"):
            sound = bool(np.sum(reported.b[among] / reported.b_se[among]) > CLEARLY * np.count_nonzero(among) ** 0.5)
    found = {}
    for i in np.flatnonzero(among).tolist():
        wide = half[i] > WIDE * abs(level[i]) and not (sound and half[i] < LIKE_OTHERS * typical)
        if wide and adj_r2[i] < fit.min_adj_r2:
            found[i] = f"its fit explains too little (adjusted R2 {adj_r2[i]:.2f})"
        elif fit.max_b_error_ratio and half[i] > max(fit.max_b_error_ratio * typical, CERTAIN * abs(reported.b[i])):
            found[i] = f"its slope is {half[i] / typical:.0f} times less certain than the others of its recording"
        elif wide and fit.max_b_error and half[i] > fit.max_b_error * abs(reported.b[i]):
            found[i] = f"its slope is uncertain by {100 * half[i] / abs(reported.b[i]):.0f} %"
    return found


def _apply(
    judgements: Sequence[PressJudgement],
    trials: Trials,
    fitted: NDArray[np.bool_],
    verdicts: list[str],
    reasons: list[str],
) -> None:
    """Put people's words in the place of the program's, whose reasons stay behind; those on one press come last.

    A fault is the recording's: only who accepts all of the recording overrules it.
    """
    cell = trials.participant, trials.specimen
    own = [judgement for judgement in judgements if (judgement.participant, judgement.specimen) == cell]
    overruled = any(judgement.repetition is None and not judgement.excludes for judgement in own)
    for judgement in sorted(own, key=lambda judgement: judgement.repetition is not None):
        for i, repetition in enumerate(trials.repetition.tolist()):
            if judgement.repetition not in (None, repetition):
                continue
            said = f"{'excluded' if judgement.excludes else 'accepted'} by hand: {judgement.reason}"
            if judgement.excludes:
                verdicts[i] = "rejected"
            elif trials.fault and not overruled:
                said = f"[[accept]] of one press does not overrule a fault of its recording: {judgement.reason}"
            elif fitted[i]:
                verdicts[i] = "ok"
            reasons[i] = f"{said}; {reasons[i]}" if reasons[i] else said


def _reasons(given: Sequence[str], fitted: NDArray[np.bool_], n: Ints, points: str, bin_force_n: Floats) -> list[str]:
    kind = "force bins" if points == "bins" else "samples"
    reasons = list(given)
    for i in np.flatnonzero(~fitted):
        why = f"no fit: {n[i]} {kind}" if n[i] < MIN_POINTS else "no fit: force does not change"
        reasons[i] = f"{reasons[i]}; {why}" if reasons[i] else why
    for row, why in enumerate(said_of_forces(bin_force_n)):
        if why and fitted[row]:
            reasons[row] = f"{reasons[row]}; {why}" if reasons[row] else why
    return reasons


def usable(fits: Fits, use: str) -> NDArray[np.bool_]:
    """Trials (n,) that enter a test or a profile: fitted, and "ok", or with ``use="ok+doubtful"`` also "doubtful"."""
    return np.isin(fits.verdict, use.split("+")) & np.isfinite(fits.b_v)


def by_recording(fits: Fits) -> dict[tuple[str, str], Fits]:
    """(participant, specimen) to the trials of that recording."""
    rows: dict[tuple[str, str], list[int]] = {}
    for i, key in enumerate(zip(fits.participant.tolist(), fits.specimen.tolist(), strict=True)):
        rows.setdefault(key, []).append(i)
    return {key: replace(fits, **{name: getattr(fits, name)[own] for name in _COLUMNS}) for key, own in rows.items()}


def concatenate(parts: Iterable[Fits], bins: bool = True) -> Fits:
    """Fits of several recordings as one table, in the order given. DataError unless made with the same settings.

    parts : taken one at a time, so that few of them need be in memory at once. bins : False leaves out the force bins,
    (n, 0), which take most of the memory and are for laws and pictures of a press alone.
    """
    first: Fits | None = None
    blocks: list[dict[str, Any]] = []
    rest = iter(parts)
    while block := list(itertools.islice(rest, _AT_ONCE)):
        first = first or block[0]
        for part in block:
            _check_alike(part, first)
        blocks.append(_joined([{name: _column(part, name, bins) for name in _COLUMNS} for part in block]))
    if first is None:
        raise DataError("fits", wanted="at least one recording", found="none", do="Fit a recording first.")
    return replace(first, **(blocks[0] if len(blocks) == 1 else _joined(blocks)))


_AT_ONCE = 64
_COLUMNS = tuple(field.name for field in dataclasses.fields(Fits) if field.name not in _COMMON)


def _column(part: Fits, name: str, bins: bool) -> NDArray[Any]:
    values: NDArray[Any] = getattr(part, name)
    if name == "reason":  # as fixed-width text all rows would take the width of the longest
        return values.astype(object)
    return values if bins or not name.startswith("bin_") else values[:, :0]


def _joined(parts: Sequence[dict[str, Any]]) -> dict[str, Any]:
    return {name: np.concatenate([part[name] for part in parts]) for name in _COLUMNS}


def _check_alike(part: Fits, first: Fits) -> None:
    for name in _COMMON:
        if not np.array_equal(getattr(part, name), getattr(first, name)):
            raise DataError(
                f"fits, {name}",
                wanted="the same in all recordings",
                found=f"{getattr(first, name)} and {getattr(part, name)}",
                do="Fit all recordings with the same settings.",
            )


def in_session(
    trials: Trials,
    session: Sequence[Trials],
    settings: CocontractionSettings,
    judgements: Sequence[PressJudgement] = (),
) -> Trials:
    """``trials`` with its activity relative to the largest envelope of each muscle in the whole ``session``.

    One level for all recordings of a participant keeps specimens comparable. Rejected trials do not set the level: an
    artefact would. Nor do trials that people excluded; those they accepted do.
    """
    judged = [_judged(part, judgements) for part in session]
    levels_v = {muscle: max(_largest_v(part, muscle) for part in judged) for muscle in trials.muscles}
    activity, unit, said = cocontraction_index(trials.envelopes_v, trials.muscles, settings, levels_v)
    return replace(trials, activity=activity, activity_unit=unit, notes=(*trials.notes, *said))


def _judged(trials: Trials, judgements: Sequence[PressJudgement]) -> Trials:
    """The trials with the verdicts of people."""
    verdicts, reasons = trials.verdict.tolist(), list(trials.reasons)
    _apply(judgements, trials, np.ones(len(verdicts), dtype=np.bool_), verdicts, reasons)
    return replace(trials, verdict=np.array(verdicts, dtype="<U8"), reasons=tuple(reasons))


def _largest_v(trials: Trials, muscle: str) -> float:
    counted = np.repeat(trials.verdict != "rejected", np.diff(trials.offsets))
    if muscle not in trials.muscles:
        return 0.0
    level_v = trials.envelopes_v[trials.muscles.index(muscle), counted]
    return float(np.fmax.reduce(level_v, initial=0.0))
