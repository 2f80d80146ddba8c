"""Does v(F) follow the logarithm, a power or a straight line at all? Lack of fit, person by person and of all together.

``force_laws`` says which of the three predicts best; of a curve that none of them follows it says nothing. Here each
press has three numbers: how much it holds of the three smoothest shapes that the law cannot take, as shares of the
level of its cell (participant and specimen). Shapes are polynomials of fourth degree in ln F without what the law
takes, orthonormal over the force bins: the length of the vector is the root mean square distance from the law over
the range of force. Neighbouring bins of a press have common errors, presses have not: a press counts once, and
Hotelling's T squared says whether the mean over presses is zero. The largest distance is that of a monotone spline.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.companions.force_laws import LAWS, rows_of_cells
from emg2vsa.curves.exponential import fit_exponential
from emg2vsa.curves.line import fit_line
from emg2vsa.curves.logarithmic import fit_log, level_weights
from emg2vsa.curves.monotone_spline import fit_monotone
from emg2vsa.fits import Fits
from emg2vsa.shown import shown
from emg2vsa.statistics.clusters import Names, in_order
from emg2vsa.statistics.mean_vector import MeanVector, mean_vector

MATTERS = 0.01
"Least distance from the law that is told: root mean square over the force range, as a share of the level."
_SMALL_P = 0.001
_DEGREE, _LAW_TAKES = 4, 2
_REACHED = 0.75
"Share of the force bins that a press must have. It must also have one bin more than the law has coefficients."


@dataclass(frozen=True, eq=False)
class CellMisfit:
    """Misfit of a person's R presses on a specimen: shapes (L, R, 3), shares of ``level_v``, by law in the order of
    ``LAWS``.

    beside (B,) : monotone spline less logarithm in each force bin, share of the level; NaN where there are no data
    or it was not asked for.
    force_n (B,) : of the bins.
    """

    participant: str
    specimen: str
    level_v: float
    shapes: Floats
    beside: Floats
    force_n: Floats


@dataclass(frozen=True)
class Misfit:
    """Distance from a law, root mean square over the force range: share of the level, interval, p of none."""

    share: float
    low: float
    high: float
    p: float

    @property
    def told(self) -> bool:
        """The law does not hold: its interval lies above what matters."""
        return self.low > MATTERS


_NAMES = {"logarithm": "logarithm", "power": "power law", "linear": "straight line"}
_UNKNOWN = Misfit(np.nan, np.nan, np.nan, np.nan)


@dataclass(frozen=True, eq=False)
class LawMisfits:
    """P people by L laws, in the order of ``LAWS``.

    presses, level_v (P,) : that count, and the mean activity over their cells. share, low, high, p (L, P) : see
    ``Misfit``; NaN where a person has too few presses. largest, at_n (P,) : largest distance of the monotone spline
    from the logarithm, share of the level, signed, and its force. together : by law, of the mean over people; its error
    is that of presses.
    """

    participant: Names
    presses: Ints
    level_v: Floats = field(metadata=shown("Level"))
    share: Floats = field(metadata=shown("Distance (% of level)", 100.0))
    low: Floats = field(metadata=shown("Low", 100.0))
    high: Floats = field(metadata=shown("High", 100.0))
    p: Floats = field(metadata=shown("p"))
    largest: Floats
    at_n: Floats
    together: tuple[Misfit, ...]

    def of(self, law: int, person: int) -> Misfit:
        """Misfit of one person."""
        return Misfit(*(float(each[law, person]) for each in (self.share, self.low, self.high, self.p)))

    def nearest(self, person: int | None = None) -> str:
        """The law of the smallest distance, of a person or of all together; "" where no distance is known."""
        shares = self.share[:, person] if person is not None else np.array([each.share for each in self.together])
        return LAWS[int(np.argmin(shares))] if np.all(np.isfinite(shares)) else ""

    def said(self, activity_unit: str, person: int | None = None) -> str:
        """In one sentence, of a person or of all together; "" where there are too few presses to say anything."""
        if not (name := self.nearest(person)):
            return ""
        of = self.together if person is None else tuple(self.of(law, person) for law in range(len(LAWS)))
        level = float(np.mean(self.level_v)) if person is None else float(self.level_v[person])
        factor, unit = (1e6, "uV") if activity_unit == "V" else (1.0, activity_unit)
        log = of[0]
        p = f"p = {log.p:.2g}" if log.p >= _SMALL_P else f"p < {_SMALL_P:g}"
        away = f"{100 * log.share:.1f} % of the level [{100 * log.low:.1f}, {100 * log.high:.1f}]"
        away += f", {factor * log.share * level:.2g} {unit}".rstrip()
        if not log.told:
            verdict = "fits" if log.high < MATTERS else f"is not shown to be off by {100 * MATTERS:g} %"
            return f"The logarithm v = a + b ln F {verdict}: presses are {away} from it ({p})."
        nearest = of[LAWS.index(name)]
        near = f"the {_NAMES[name]} is nearest, {100 * nearest.share:.1f} % away"
        if all(each.told for each in of):
            near = f"neither does a power law nor a straight line; {near}"
        return f"The logarithm v = a + b ln F does not fit: presses are {away} from it ({p}); {near}."


def cell_misfits(fits: Fits, use: str, spline: bool = False) -> list[CellMisfit]:
    """Shapes of every cell of the trials that ``use`` admits; one without enough bins or presses of full range is left
    out. spline : whether to fit the monotone spline too."""
    found = []
    for (participant, specimen), own in rows_of_cells(fits, use).items():
        cell = _cell(participant, specimen, fits.bin_force_n[own], fits.bin_v[own], fits.bin_edges_n, spline)
        if cell is not None:
            found.append(cell)
    return found


def compare_misfits(cells: Iterable[CellMisfit], confidence: float = 0.95) -> LawMisfits:
    """Over all cells; every press of a person counts alike, and every person in what is said of all together."""
    cells = list(cells)
    people = in_order(np.array([cell.participant for cell in cells], dtype=np.str_))
    own = [[cell for cell in cells if cell.participant == who] for who in people.tolist()]
    shapes = [np.concatenate([cell.shapes for cell in each], axis=1) for each in own]
    table = np.full((4, len(LAWS), people.size), np.nan)
    for i, each in enumerate(shapes):
        for law, vectors in enumerate(each):
            found = _misfit(mean_vector(vectors, np.zeros(len(vectors), dtype=np.int64)), confidence)
            table[:, law, i] = found.share, found.low, found.high, found.p
    largest, at_n = np.array([_largest(each) for each in own]).reshape(-1, 2).T
    presses = np.array([each.shape[1] for each in shapes], dtype=np.int64)
    groups = np.repeat(np.arange(people.size), presses)
    of_all = np.concatenate(shapes, axis=1) if cells else np.empty((0, 0, 0))
    return LawMisfits(
        participant=people,
        presses=presses,
        level_v=np.array([np.mean([cell.level_v for cell in each]) for each in own]),
        share=table[0],
        low=table[1],
        high=table[2],
        p=table[3],
        largest=largest,
        at_n=at_n,
        together=tuple(_misfit(mean_vector(each, groups), confidence) for each in of_all) or (_UNKNOWN,) * len(LAWS),
    )


def _misfit(found: MeanVector, confidence: float) -> Misfit:
    low, high = found.interval(confidence)
    return Misfit(found.length if found.p == found.p else np.nan, low, high, found.p)


def _largest(cells: list[CellMisfit]) -> tuple[float, float]:
    beside = np.array([cell.beside for cell in cells])
    there = np.isfinite(beside)
    if not there.any():
        return np.nan, np.nan
    mean = np.sum(beside, axis=0, where=there) / np.maximum(np.count_nonzero(there, axis=0), 1)
    at = int(np.argmax(np.abs(mean)))
    return float(mean[at]), float(cells[0].force_n[at])


def _cell(
    participant: str, specimen: str, force_n: Floats, v: Floats, edges_n: Floats, spline: bool
) -> CellMisfit | None:
    """Misfit of presses (R, B)."""
    there = np.isfinite(v) & (force_n > 0)
    whole = np.count_nonzero(there, axis=1) >= max(_REACHED * v.shape[1], _DEGREE + 2)
    there = there[whole]
    n = np.count_nonzero(there, axis=0)
    bins = n > 0
    n, there = n[bins], there[:, bins]
    force_n, v = (np.where(there, of[whole][:, bins], filler) for of, filler in ((force_n, 1.0), (v, 0.0)))
    middle_n, mean_v = np.exp(np.sum(np.log(force_n), axis=0) / n), np.sum(v, axis=0) / n
    level = float(np.mean(mean_v)) if n.size else 0.0
    if not level > 0:
        return None
    line = fit_log(middle_n, mean_v)
    weights = np.where(there, level_weights(line.at(force_n.reshape(1, -1))).reshape(v.shape), 0.0)
    laws = (_logarithm, _power(middle_n, mean_v), _straight)
    shapes = np.stack([_in_shapes(force_n, v / level, np.sqrt(weights), middle_n, law) for law in laws])
    beside = np.full(bins.size, np.nan)
    if spline:
        f, y, w = (each[there] for each in (force_n, v, weights))
        curve = fit_monotone(f, y, w, (max(float(edges_n[0]), float(f.min())), float(edges_n[-1])))
        weighted = fit_line(np.log(f)[None], y[None], w[None])
        beside[bins] = (curve.at(middle_n) - weighted.at(np.log(middle_n))[0]) / level
    return CellMisfit(participant, specimen, level, shapes, beside, (edges_n[1:] + edges_n[:-1]) / 2)


_Law = Callable[[Floats], Floats]
"""Forces of any shape to what the law is made of: one more axis, of two."""


def _logarithm(force_n: Floats) -> Floats:
    return np.stack([np.ones_like(force_n), np.log(force_n)], axis=-1)


def _straight(force_n: Floats) -> Floats:
    return np.stack([np.ones_like(force_n), force_n], axis=-1)


def _power(middle_n: Floats, mean_v: Floats) -> _Law:
    """a F^c near the cell's own c: F^c and its derivative F^c ln F; without a nearest power that of c = 0."""
    c = float(fit_exponential(np.log(middle_n), mean_v).q[0])
    c = c if np.isfinite(c) else 0.0
    return lambda force_n: force_n[..., None] ** c * _logarithm(force_n)


def _in_shapes(force_n: Floats, v: Floats, root_weights: Floats, middle_n: Floats, law: _Law) -> Floats:
    """Shares (R, 3) of the shapes in presses (R, B), beside the law fitted to each press by weighted least squares."""
    x = np.log(middle_n)
    centre, half = (x[-1] + x[0]) / 2, (x[-1] - x[0]) / 2

    def powers(force_n: Floats) -> Floats:
        return np.stack([((np.log(force_n) - centre) / half) ** i for i in range(_DEGREE + 1)], axis=-1)

    # on the bins' middles: orthonormal polynomials, of which second to fourth are freed of the law, then of each other;
    # their order and signs are those of the powers, so that the shapes of different cells can be averaged
    to_orthonormal = np.linalg.inv(_triangle(powers(middle_n)))[:, _LAW_TAKES:]
    curved = powers(middle_n) @ to_orthonormal
    of_law = np.linalg.lstsq(law(middle_n), curved)[0]
    turn = np.linalg.inv(_triangle(curved - law(middle_n) @ of_law)) * np.sqrt(middle_n.size)
    shapes = (powers(force_n) @ to_orthonormal - law(force_n) @ of_law) @ turn
    design = np.concatenate([law(force_n), shapes], axis=-1) * root_weights[..., None]
    normal = design.swapaxes(1, 2) @ design
    moment = design.swapaxes(1, 2) @ (v * root_weights)[..., None]
    return np.asarray(np.linalg.solve(normal, moment)[:, _LAW_TAKES:, 0])


def _triangle(columns: Floats) -> Floats:
    """R of columns = Q R, with a positive diagonal."""
    found = np.linalg.qr(columns, "r")
    return np.asarray(found * np.where(np.diag(found) < 0, -1.0, 1.0)[:, None])
