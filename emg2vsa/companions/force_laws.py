"""Is the logarithm the right law of co-contraction over force? Power and straight line, by what they did not see.

v = a + b ln F (equation 6), v = a F^c and v = a + b F have two parameters each, and are compared by their errors of
prediction: of a press from the other presses of its cell (participant and specimen), and of a force bin from the other
bins of its press. The first error holds how presses differ, the second is about the shape of the law alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.curves.exponential import fit_exponential
from emg2vsa.curves.line import fit_line
from emg2vsa.curves.logarithmic import fit_log
from emg2vsa.fits import Fits, usable
from emg2vsa.shown import shown
from emg2vsa.statistics.clusters import Names, in_order

LAWS = ("logarithm", "power", "linear")
LEFT_OUT = ("press", "bin")
_MIN_POINTS = 3


@dataclass(frozen=True, eq=False)
class ForceLaws:
    """C cells of P participants; the first axis of errors is that of ``LEFT_OUT``.

    participant, specimen : (C,). error : (2, L, C) root mean square error of prediction over the cell's mean activity,
    laws in the order of ``LAWS``; NaN where it cannot be had. ratio : (2, L) geometric mean over participants of a
    law's error over that of the logarithm; ratio_low, ratio_high : its interval, p : of no difference, Student's t over
    participants, NaN below two. better : (2, L) cells in which the law's error is the smaller one, compared : (2,)
    cells.
    """

    participant: Names
    specimen: Names
    error: Floats
    ratio: Floats = field(metadata=shown("Over the logarithm's"))
    ratio_low: Floats = field(metadata=shown("Low"))
    ratio_high: Floats = field(metadata=shown("High"))
    p: Floats = field(metadata=shown("p"))
    better: Ints
    compared: Ints


@dataclass(frozen=True, eq=False)
class CellErrors:
    """Errors of one cell: error (2, L) as in ``ForceLaws``."""

    participant: str
    specimen: str
    error: Floats


def force_laws(fits: Fits, use: str, confidence: float = 0.95) -> ForceLaws:
    """Compare the laws on the force bins of the trials that ``use`` admits; all bins count alike."""
    return compare_laws(cell_errors(fits, use), confidence)


def cell_errors(fits: Fits, use: str) -> list[CellErrors]:
    """Errors of prediction of every cell of ``fits``: of recordings of different cells, one recording at a time will
    do."""
    found = []
    for (participant, specimen), own in rows_of_cells(fits, use).items():
        kinds = [_errors(fits.bin_force_n[own], fits.bin_v[own], split) for split in (_without_a_press, _without_a_bin)]
        found.append(CellErrors(participant, specimen, np.array(kinds)))
    return found


def rows_of_cells(fits: Fits, use: str) -> dict[tuple[str, str], list[int]]:
    """(participant, specimen) to the rows of the trials that ``use`` admits."""
    at = np.flatnonzero(usable(fits, use))
    rows: dict[tuple[str, str], list[int]] = {}
    for i, *names in zip(at.tolist(), fits.participant[at].tolist(), fits.specimen[at].tolist(), strict=True):
        rows.setdefault((names[0], names[1]), []).append(i)
    return rows


def bin_errors(fits: Fits, rows: NDArray[np.bool_]) -> CellErrors:
    """Errors of prediction of bins alone, of the presses ``rows`` (n,) of one cell; NaN for those of presses."""
    errors = _errors(fits.bin_force_n[rows], fits.bin_v[rows], _without_a_bin)
    return CellErrors(str(fits.participant[0]), str(fits.specimen[0]), np.array([np.full(len(LAWS), np.nan), errors]))


def compare_laws(cells: Iterable[CellErrors], confidence: float = 0.95) -> ForceLaws:
    """The laws over all cells, which are taken in natural order of their names."""
    cells = list(cells)
    people, specimens = (
        {name: place for place, name in enumerate(in_order(np.array(each, dtype=np.str_)).tolist())}
        for each in ([cell.participant for cell in cells], [cell.specimen for cell in cells])
    )
    cells.sort(key=lambda cell: (people[cell.participant], specimens[cell.specimen]))
    error = np.stack([cell.error for cell in cells], axis=-1) if cells else np.empty((2, len(LAWS), 0))
    participant = np.array([cell.participant for cell in cells], dtype=np.str_)
    specimen = np.array([cell.specimen for cell in cells], dtype=np.str_)
    return _compared(participant, specimen, error, confidence)


_Split = Callable[[Floats, Floats], tuple[Floats, Floats, Floats, Floats]]


def _without_a_press(force_n: Floats, v: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Forces and activities that are seen, and those to predict, of R presses (R, B): each press in turn."""
    r = len(v)
    others = np.array([np.delete(np.arange(r), i) for i in range(r)], dtype=np.int64).reshape(r, -1)
    return force_n[others].reshape(r, -1), v[others].reshape(r, -1), force_n, v


def _without_a_bin(force_n: Floats, v: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Each bin of each press in turn."""
    r, b = v.shape
    out = np.eye(b, dtype=np.bool_)
    seen_f, seen_v = (np.where(out, np.nan, values[:, None, :]).reshape(r * b, b) for values in (force_n, v))
    return seen_f, seen_v, force_n.reshape(r * b, 1), v.reshape(r * b, 1)


def _errors(force_n: Floats, v: Floats, split: _Split) -> Floats:
    """Relative error (L,) of every law, over the points that every law could predict."""
    seen_f, seen_v, force_n, v = split(force_n, v)
    enough = (np.count_nonzero(np.isfinite(seen_v) & (seen_f > 0), axis=1) >= _MIN_POINTS) if seen_v.size else []
    if not np.any(enough):
        return np.full(len(LAWS), np.nan)
    seen_f, seen_v, force_n, v = (values[enough] for values in (seen_f, seen_v, force_n, v))
    predicted = np.stack([law(seen_f, seen_v, force_n) for law in (_logarithm, _power, _linear)])
    known = np.isfinite(v) & np.isfinite(force_n)
    all_of = known & np.all(np.isfinite(predicted), axis=0)
    if not np.any(all_of):
        return np.full(len(LAWS), np.nan)
    residual = np.where(all_of, predicted - np.where(known, v, 0.0), 0.0)
    level = abs(float(np.mean(v[all_of])))
    found = np.sqrt(np.sum(residual**2, axis=(1, 2)) / np.count_nonzero(all_of))
    return np.asarray(found / (level if level > 0 else np.nan))


def _logarithm(seen_f: Floats, seen_v: Floats, force_n: Floats) -> Floats:
    return fit_log(seen_f, seen_v).at(force_n)


def _power(seen_f: Floats, seen_v: Floats, force_n: Floats) -> Floats:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        fit = fit_exponential(np.log(seen_f), seen_v)
        return np.asarray(fit.y0[:, None] * np.exp(fit.q[:, None] * (np.log(force_n) - fit.x0[:, None])))


def _linear(seen_f: Floats, seen_v: Floats, force_n: Floats) -> Floats:
    there = np.isfinite(seen_f) & np.isfinite(seen_v)
    f, v = (np.where(there, values, 0.0) for values in (seen_f, seen_v))
    return fit_line(f, v, there.astype(np.float64)).at(force_n)


def log_ratios(participant: Names, error: Floats) -> Floats:
    """ln of a law's error over that of the logarithm, (2, L, P): mean over the cells of each of P participants.

    participant : (C,). error : (2, L, C) as in ``ForceLaws``. Participants are in natural order; NaN without a cell.
    """
    log_ratio, people = _by_cell(error), in_order(participant).tolist()
    found = np.full((*error.shape[:2], len(people)), np.nan)
    for i, who in enumerate(people):
        found[..., i] = mean_of(log_ratio[..., participant == who])
    return found


def _by_cell(error: Floats) -> Floats:
    with np.errstate(divide="ignore", invalid="ignore"):
        log_ratio = np.log(error / error[:, :1])
    return np.where(np.isfinite(log_ratio), log_ratio, np.nan)


def _compared(participant: Names, specimen: Names, error: Floats, confidence: float) -> ForceLaws:
    log_ratio = _by_cell(error)
    of_person = log_ratios(participant, error)
    known = np.isfinite(of_person)
    n = np.count_nonzero(known, axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.sum(of_person, axis=2, where=known) / n
        squares = np.sum((of_person - mean[..., None]) ** 2, axis=2, where=known)
        se = np.sqrt(squares / (n * (n - 1.0)))
        se = np.where(se > 0, se, np.nan)
        t, df = mean / se, np.where(np.isnan(se), np.nan, n - 1.0)
        reach = special.stdtrit(df, 0.5 + 0.5 * confidence) * se
    return ForceLaws(
        participant=participant,
        specimen=specimen,
        error=error,
        ratio=np.exp(mean),
        ratio_low=np.exp(mean - reach),
        ratio_high=np.exp(mean + reach),
        p=2 * special.stdtr(df, -np.abs(t)),
        better=np.count_nonzero(log_ratio < 0, axis=2),
        compared=np.count_nonzero(np.isfinite(log_ratio[:, 0]), axis=1),
    )
