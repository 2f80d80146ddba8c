"""Paths of analysis of people's presses: from the envelopes to the claims.

A law v = a + b g(F) is that of equation (6) over the force exp(g(F)): presses are fitted, and their curves read at the
ends of the force range, on that axis, by the same bins. g is a power of F over the highest force, which changes the
unit of b alone; what claims estimate is relative.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.arrays import Floats
from emg2vsa.claims.claim import Claim
from emg2vsa.claims.people import claims_of_study
from emg2vsa.companions.force_laws import CellErrors, bin_errors, compare_laws
from emg2vsa.curves.force_bins import fit_edges
from emg2vsa.errors import SettingError
from emg2vsa.extraction import Trials
from emg2vsa.fits import Fits, concatenate, fit_trials, usable
from emg2vsa.multiverse.index import by_index
from emg2vsa.multiverse.path import (
    BINS,
    EXCLUSIONS,
    INDEX,
    INTERPOLATION,
    LAW,
    PERSON,
    REPETITION,
    WEIGHTS,
    Choice,
    Tried,
    tried,
)  # fmt: skip
from emg2vsa.settings import FitSettings, Interpolation, Weights
from emg2vsa.study import Study

Rows = NDArray[np.bool_]
Places = Mapping[tuple[str, str], float]
LEAST_R2, FAR_MADS, FEWEST = 0.5, 3.0, 5
"""A press fits badly, a slope b lies far from the median of its recording, and so many presses tell it."""
_SD_PER_MAD = 1.4826
_LAWS, _INTERPOLATED = "log_fit_r2", "interpolation_rmse"
"""Claims that one choice is about."""


@dataclass(frozen=True)
class Law:
    """v = a + b ln F, or with a power of the force in place of its logarithm."""

    says: str
    power: float | None = None

    def axis(self, force_n: ArrayLike, top_n: float) -> Floats:
        """The force, N, whose logarithm the law is linear in, at forces of any shape, N; top_n : highest force of the
        window, N."""
        force = np.asarray(force_n, dtype=np.float64)
        return force if self.power is None else np.exp(np.maximum(force / top_n, 0.0) ** self.power)


LAWS = (Law("a + b ln F"), Law("a + b √F", 0.5), Law("a + b F", 1.0))


@dataclass(frozen=True, eq=False)
class _Fitted:
    """The fits of all recordings by one index, law and fit. by_recording : with their force bins."""

    study: Study
    law: Law
    by_recording: list[Fits]
    fits: Fits

    def claims(self, rows: Rows, place: Places, **changed: object) -> Iterator[Claim]:
        """Claims by the presses ``rows``. changed : settings of the study."""
        verdict = np.where(rows, "ok", "rejected")
        laws = None
        if self.law.power is None:
            laws = compare_laws(self._errors(rows), 1 - self.study.hypotheses.alpha)
        study = replace(self.study, **changed)  # type: ignore[arg-type]
        yield from claims_of_study(study, replace(self.fits, verdict=verdict), place, laws)

    def _errors(self, rows: Rows) -> Iterator[CellErrors]:
        first = 0
        for fits in self.by_recording:
            own = rows[first : first + fits.verdict.size]
            first += own.size
            if own.any():
                yield bin_errors(fits, own)


def people_paths(study: Study, trials: Sequence[Trials], place: Places) -> Iterator[Tried]:
    """The study's own path first; then index, law, bins and exclusions crossed, and the other choices one at a time."""
    for name, recordings in by_index(study, trials):
        index = Choice(INDEX, f"index {name}") if name != study.cocontraction.index else None
        for law in LAWS:
            for bins, fit in _bins(study):
                chosen = (index, None if law.power is None else Choice(LAW, law.says), bins)
                fitted = _fitted(study, recordings, law, fit)
                not_on = () if law.power is None else (_LAWS,)
                for exclusion, rows in _exclusions(study, fitted.fits):
                    yield tried((*chosen, exclusion), fitted.claims(rows, place), not_on)
                if not any(chosen):
                    yield from _one_at_a_time(fitted, place)
                    yield from _weights(study, recordings, place)


def _bins(study: Study) -> Iterator[tuple[Choice | None, FitSettings]]:
    """The points of a fit: the study's own, bins of half and of double the width, samples."""
    own = study.fit
    on_bins = [replace(own, points="bins", bin_n=own.bin_n * factor) for factor in (1, 0.5, 2)]
    for fit in (own, *(each for each in (*on_bins, replace(own, points="samples")) if each != own)):
        with suppress(SettingError):  # too many bins
            fit_edges(*study.window.force_n, fit.bin_n)
            says = "samples" if fit.points == "samples" else f"bins of {fit.bin_n:g} N"
            yield Choice(BINS, says) if fit != own else None, fit


def _fitted(study: Study, recordings: Sequence[Trials], law: Law, fit: FitSettings) -> _Fitted:
    top = study.window.force_n[1]
    low, high = law.axis(study.window.force_n, top).tolist()
    window = replace(study.window, force_n=(low, high))
    edges = law.axis(fit_edges(*study.window.force_n, fit.bin_n), top)
    parts = [
        fit_trials(replace(each, force_n=law.axis(each.force_n, top)), fit, window, study.judgements, edges)
        for each in recordings
    ]
    return _Fitted(replace(study, window=window, fit=fit), law, parts, concatenate(parts, bins=False))


def _exclusions(study: Study, fits: Fits) -> Iterator[tuple[Choice | None, Rows]]:
    """Which presses count, (n,): as the study says, and by other rules; of rules that agree the first."""
    own, fitted = usable(fits, study.hypotheses.use), np.isfinite(fits.b_v)
    rules = {
        "": own,
        "presses whose bias is small": usable(fits, "ok"),
        "doubtful presses too": usable(fits, "ok+doubtful"),
        "presses without a remark": usable(fits, "ok") & (fits.reason == ""),
        "all presses with a fit": fitted,
        f"without presses of adj. R² below {LEAST_R2:g}": own & (fits.adj_r2_bins >= LEAST_R2),
        "without outlying b": own & ~_outlying(fits, own),
    }
    seen = set()
    for says, rows in rules.items():
        if rows.tobytes() not in seen:
            seen.add(rows.tobytes())
            yield Choice(EXCLUSIONS, says) if says else None, rows


def _outlying(fits: Fits, own: Rows) -> Rows:
    far = np.zeros_like(own)
    cells = np.char.add(np.char.add(fits.participant, "/"), fits.specimen)
    for cell in np.unique(cells[own]):
        rows = np.flatnonzero(own & (cells == cell))
        away = np.abs(fits.b_v[rows] - np.median(fits.b_v[rows]))
        if rows.size >= FEWEST:
            far[rows] = away > FAR_MADS * _SD_PER_MAD * np.median(away)
    return far


def _one_at_a_time(own: _Fitted, place: Places) -> Iterator[Tried]:
    """Without each person, without each repetition, and by the other rules of interpolation."""
    study, fits = own.study, own.fits
    rows = usable(fits, study.hypotheses.use)
    for kind, of, word in ((PERSON, fits.participant, "without"), (REPETITION, fits.repetition, "without repetition")):
        for each in np.unique(of[rows]) if np.unique(of[rows]).size > 1 else ():
            yield tried([Choice(kind, f"{word} {each}")], own.claims(rows & (of != each), place))
    for rule in get_args(Interpolation) if study.profile.new_specimen else ():
        if rule != study.profile.interpolation:
            found = own.claims(rows, place, profile=replace(study.profile, interpolation=rule))
            only = [claim for claim in found if claim.key == _INTERPOLATED]
            yield tried([Choice(INTERPOLATION, f"rule {rule}")], only)


def _weights(study: Study, recordings: Sequence[Trials], place: Places) -> Iterator[Tried]:
    other: Weights = "none" if study.fit.weights == "inverse-variance" else "inverse-variance"
    settings = {f"weights: {other}": replace(study.fit, weights=other)}
    settings[f"{'no ' if study.fit.robust else ''}Huber weights"] = replace(study.fit, robust=not study.fit.robust)
    for says, fit in settings.items():
        fitted = _fitted(study, recordings, LAWS[0], fit)
        rows = usable(fitted.fits, study.hypotheses.use)
        yield tried([Choice(WEIGHTS, says)], fitted.claims(rows, place), [_LAWS])
