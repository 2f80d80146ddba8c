"""Stiffness of one press over a stated range of force: the secant kappa over [F0, F1], the tangent kappa(F), how far
kappa changes, where contact lies, and whether the press can say so.

Force over depth between F0 and F1 is a polynomial of degree 1 to 5, where the plate has yet to lie flat with a term
that decays over depth: a mean over these curves by Akaike weights. Standard errors hold how the curves differ, and the
autocorrelation of what is left (AR 1).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.first_contact import LEAST, first_contact, force_at_start, left_over
from emg2vsa.curves.range_doubts import (
    STARTS,
    Stretch,
    doubts_of_course,
    doubts_of_depth,
    doubts_of_rest,
    doubts_of_start,
)  # fmt: skip
from emg2vsa.errors import SettingError
from emg2vsa.shown import shown

_CHANGE = 0.1
"""Share by which kappa changes over the range, from which on a specimen is called nonlinear."""
_DECAYS = (0.04, 0.06, 0.09, 0.13, 0.18, 0.25)
"""Depths over which the term of first contact decays, as shares of the depth between F0 and F1."""
_UPPER = 0.4
"""Share of the range of force, from F0 on, in which first contact may still bend the curve."""
_STEPS = 9
_AGAIN = 0.3
"""Share of its travel by which the plate goes back before a further press counts as one of its own."""


@dataclass(frozen=True, eq=False)
class RangeFit:
    """One press. NaN, and no points, where it cannot be said.

    from_n, to_n : range of force past that of rest. secant, secant_se : F1 - F0 over the depth between, N/mm.
    force_n, tangent, tangent_se : (g,) kappa(F), N/mm. bend, bend_se : by how much it grows from F0 to F1, a share of
    the secant. change, change_se : the same by the course of the upper part, where first contact is over. closing :
    share by which kappa at F0 lies below that course. of_rubber : change of a Neo-Hookean cylinder of the stated
    height. depth_to : at F1, mm.
    contact, contact_low, contact_high : depth of first touch and its 95 % interval, mm. level_n : force at rest, 0
    where ``rests`` says that there is none.
    rating : good, doubtful or unusable, and reasons why. told : what was done to the press.
    """

    from_n: float = field(metadata=shown("From (N)"))
    to_n: float = field(metadata=shown("To (N)"))
    secant: float = field(default=np.nan, metadata=shown("κ over it (N/mm)", digits=4))
    secant_se: float = field(default=np.nan, metadata=shown("Error within the press (N/mm)", digits=2))
    force_n: Floats = field(default_factory=lambda: np.empty(0))
    tangent: Floats = field(default_factory=lambda: np.empty(0))
    tangent_se: Floats = field(default_factory=lambda: np.empty(0))
    dof: float = np.nan
    bend: float = np.nan
    bend_se: float = np.nan
    change: float = field(default=np.nan, metadata=shown("Change of κ (%)", 100))
    change_se: float = np.nan
    closing: float = np.nan
    of_rubber: float = np.nan
    depth_to: float = np.nan
    contact: float = field(default=np.nan, metadata=shown("Contact (mm)"))
    contact_low: float = field(default=np.nan, metadata=shown("from (mm)"))
    contact_high: float = field(default=np.nan, metadata=shown("to (mm)"))
    level_n: float = np.nan
    rests: bool = False
    rating: str = field(default="unusable", metadata=shown("Rating"))
    reasons: tuple[str, ...] = ()
    told: tuple[str, ...] = ()

    def half_width(self, error: Floats | float) -> Floats:
        """Half width of the 95 % interval of numbers with this standard error, a scalar or (g,)."""
        return np.asarray(t_975(self.dof) * error)

    @property
    def nonlinear(self) -> bool:
        """Whether kappa changes by more than a tenth and a standard error, and by three of these. Where the height is
        stated: if the press exceeds a tenth by three, or if a Neo-Hookean cylinder of this kappa does and the press
        lies no four below; repeats of one specimen differ by more than the error of one.
        """
        change, error = abs(self.change), self.change_se
        if np.isnan(self.of_rubber):
            return bool(change > max(_CHANGE + error, 3 * error))
        as_rubber = self.of_rubber > _CHANGE and self.change + 4 * error > _CHANGE
        return bool(change - 3 * error > _CHANGE or as_rubber)

    def notes(self) -> Iterator[str]:
        yield from self.told
        yield from (f"{self.rating}: {reason}" for reason in self.reasons)
        if self.nonlinear:
            ends = f"{self.tangent[0]:.3g} N/mm at {self.from_n:.3g} N, {self.tangent[-1]:.3g} at {self.to_n:.3g} N"
            by_law = self.of_rubber > _CHANGE and abs(self.bend) < _CHANGE
            law = f"rubber of this height changes by {100 * self.of_rubber:.0f} % over it; here "
            yield f"nonlinear: {law if by_law else ''}kappa is {ends}"
        if self.closing > _CHANGE:
            yield f"contact still closes at {self.from_n:.3g} N: kappa is {100 * self.closing:.0f} % lower there"


def fit_range(
    depth_mm: Floats, force_n: Floats, range_n: tuple[float, float], height_mm: float | None = None, *,
    whole: bool = False,
) -> RangeFit:  # fmt: skip
    """depth_mm, force_n : (n,) of one press as measured, unloading included; NaN is left out. range_n : F0 and F1.
    height_mm : of the specimen, a cylinder, where it is known.

    F1 is what the press reaches where that is less, unless ``whole``: then it is unusable. A machine that counts depth
    and force of compression as negative is turned. SettingError : no range.
    The mean over curves has Akaike weights (Burnham and Anderson 2002, 4.3).
    Why a secant over stated forces: decision 49.
    """
    from_n, to_n = range_n
    if not 0 < from_n < to_n < np.inf:
        found, do = f"{from_n:g} to {to_n:g}", "Give the smaller force first."
        raise SettingError("range of force", wanted="0 < F0 < F1, newtons", found=found, do=do)
    x, y, told = loading(depth_mm, force_n)
    if x.size < LEAST:
        reason = f"{x.size} points up to the deepest; {LEAST} are needed"
        return RangeFit(from_n, to_n, reasons=(reason,), told=told)
    if told and told[-1].endswith("?"):
        return RangeFit(from_n, to_n, reasons=told[-1:], told=told[:-1])
    part = _stretch(x, y, from_n, to_n, whole)
    if isinstance(part, str):
        return RangeFit(from_n, to_n, reasons=(part,), told=told)
    to_n, span, between = part.to_n, part.last - part.first, part.places[1] - part.places[0]
    if not span > 0 or between < LEAST:
        reason = f"{between} points between {from_n:g} and {to_n:.3g} N; {LEAST} are needed"
        return RangeFit(from_n, to_n, reasons=(reason,), told=told)
    u, forces = (x[part.inside] - part.first) / span, np.linspace(from_n, to_n, _STEPS)
    course = _course(u, part.y[part.inside], forces, (1, 2, 3, 4, 5), _DECAYS)
    if course is None:
        reason = f"the force falls again between {from_n:g} and {to_n:.3g} N"
        return RangeFit(from_n, to_n, reasons=(reason,), told=told)
    return _fitted(part, course, u, forces, height_mm, told)


def _stretch(x: Floats, y: Floats, from_n: float, to_n: float, whole: bool) -> Stretch | str:
    """The press (n,), mm and N, and its part over the range of force; or why it has none."""
    contact, level, rest_n = first_contact(x, y, from_n)
    y = y - level
    start, start_se = force_at_start(x, y)
    smooth = np.convolve(y, np.full(5, 0.2), mode="same")
    smooth[:2], smooth[-2:] = smooth[2], smooth[-3]
    highest = float(smooth.max())
    if highest < (to_n if whole else 2 * from_n):
        return f"the force reaches {highest:.3g} N of {from_n:g} to {to_n:g} N"
    if not rest_n and abs(start) > STARTS[1] * from_n:
        return f"it begins at {start:.3g} N, with no rest before contact"
    to_n = to_n if to_n < highest else 0.98 * highest
    begins, ends = (int(np.argmax(smooth > force)) for force in (from_n, to_n))
    first, last = x[[begins, ends]].tolist()
    span = last - first
    inside = (x >= first - 0.03 * span) & (x <= last + 0.03 * span)
    inside[max(begins - 4, 0) : ends + 4] = True  # the noise of one sample may carry it past F0
    return Stretch(x, y, smooth, contact, level, rest_n, start, start_se, from_n, to_n, (begins, ends), inside)


def _fitted(
    part: Stretch, course: _Course, u: Floats, forces: Floats, height_mm: float | None, told: tuple[str, ...]
) -> RangeFit:
    """u : depth of the points inside, 0 at F0 and 1 at F1. forces : (g,) of the course, N."""
    from_n, to_n, span = part.from_n, part.to_n, part.last - part.first
    secant = (to_n - from_n) / course.between
    secant_se = secant * course.between_se / course.between
    upper = u >= np.interp(from_n + _UPPER * (to_n - from_n), forces, course.at)
    change, change_se, below = _change(u[upper], part.y[part.inside][upper], secant, course.slope[0])
    if course.bend + 3 * course.bend_se < -_CHANGE * secant:  # it softens: that is no contact that closes
        change, change_se = course.bend / secant, course.bend_se / secant
    # F = E A / 3 (1 / s^2 - s) with s = 1 - depth / height: kappa grows by 2 F / height, to first order of the strain
    of_rubber = 2 * (to_n - from_n) / height_mm / (secant / span) if height_mm else np.nan
    at_first = doubts_of_rest(part, secant) if part.rest else doubts_of_start(part, course.slope[0])
    doubts = [*doubts_of_depth(part, height_mm), *at_first, *doubts_of_course(part, below, course.noise_n)]
    rating = "unusable" if any(bad for bad, _ in doubts) else "doubtful" if doubts else "good"
    return RangeFit(
        from_n, to_n, secant / span, secant_se / span, forces, course.slope / span, course.slope_se / span, course.dof,
        course.bend / secant, course.bend_se / secant, change, change_se, below, of_rubber, part.last,
        *part.contact, part.level_n, part.rest > 0, rating, tuple(reason for _, reason in doubts), told,
    )  # fmt: skip


def t_975(dof: float) -> float:
    """Upper 2.5 % point of Student's t."""
    from scipy.special import stdtrit  # noqa: PLC0415  (0.1 s that other commands do not need)

    return float(stdtrit(dof, 0.975))


def loading(depth_mm: Floats, force_n: Floats) -> tuple[Floats, Floats, tuple[str, ...]]:
    """(n,) depth, mm, and force, N, of the first press up to its deepest point, turned where both fall, and what was
    done; that ends with a question where only one of both falls."""
    known = np.isfinite(depth_mm) & np.isfinite(force_n)
    x, y = depth_mm[known], force_n[known]
    told: tuple[str, ...] = ()
    if not x.size:
        return x, y, ()
    pressed = int(np.argmax(np.abs(y - np.median(y[:5]))))
    falls = x[pressed] < x[0], y[pressed] < np.median(y[:5])
    if all(falls):
        x, y, told = -x, -y, ("depth and force of compression are negative: both were turned",)
    elif any(falls):
        asked = "the force does not rise with depth: is the sign of either right?"
        return x, y, (asked,)
    end = int(np.argmax(x)) + 1
    while True:
        back = np.maximum.accumulate(x[:end]) - x[:end] > _AGAIN * np.ptp(x)
        if not back.any():
            return x[:end], y[:end], told
        turn = int(np.argmax(back))
        peak = int(np.argmax(x[:turn])) + 1
        if x[peak - 1] - x[:peak].min() > _AGAIN * np.ptp(x):
            return x[:peak], y[:peak], (*told, "it presses more than once: the first press was used")
        x, y, end = x[turn:], y[turn:], end - turn


@dataclass(frozen=True, eq=False)
class _Course:
    """Course of force over depth u: depth at stated forces (g,), slope there with its error, by how much it grows
    from the first to the last and depth between these, each with its error, degrees of freedom, and SD of what the
    best curve leaves, N.
    """

    at: Floats
    slope: Floats
    slope_se: Floats
    bend: float
    bend_se: float
    between: float
    between_se: float
    dof: float
    noise_n: float


def _course(u: Floats, y: Floats, forces: Floats, degrees: Sequence[int], decays: Sequence[float]) -> _Course | None:
    """Mean over the curves that may be, each by its Akaike weight; errors hold how they differ (Burnham and Anderson
    2002, 4.3). None where none rises all the way."""
    grid = np.linspace(u.min(), u.max(), 401)
    made = []
    for decay in (0.0, *decays):
        for degree in degrees:
            rows, p = _basis(u, degree, decay), degree + 1 + (decay > 0)
            c, *_ = np.linalg.lstsq(rows, y, rcond=None)
            if (decay and c[-1] < 0) or np.any(_slopes(grid, degree, decay) @ c <= 0):
                continue  # contact that closes lets the force rise ever faster
            left = y - rows @ c
            made.append((rows, c, degree, decay, p, *left_over(left, y, p)))
    if not made:
        return None
    alike = min(each[-1] for each in made)  # what the best curve leaves is noise
    values, variances, worth, dofs = [], [], [], []
    for rows, c, degree, decay, p, square, longer in made:
        dof = max(u.size / longer - p, 1.0)
        covariance = square / max(u.size - p, 1) * longer * np.linalg.pinv(rows.T @ rows)
        where = np.interp(forces, _basis(grid, degree, decay) @ c, grid)
        of_slope, of_force = _slopes(where, degree, decay), _basis(where, degree, decay)
        slope = of_slope @ c
        bend = (_slopes(where + 1e-5, degree, decay) @ c - _slopes(where - 1e-5, degree, decay) @ c) / 2e-5
        deeper = of_force / slope[:, None]
        slopes = of_slope - bend[:, None] * deeper
        parts = np.vstack([slopes, slopes[-1] - slopes[0], deeper[-1] - deeper[0]])
        values.append(np.r_[where, slope, slope[-1] - slope[0], where[-1] - where[0]])
        variances.append(np.einsum("ij,jk,ik->i", parts, covariance, parts))
        n, k = u.size / alike, p + 1 + (decay > 0)
        worth.append(n * np.log(square) + 2 * k * n / max(n - k - 1, 0.1))
        dofs.append(dof)
    weight = np.exp(-0.5 * (np.array(worth) - min(worth)))
    weight /= weight.sum()
    mean = weight @ np.array(values)
    g = forces.size
    spread = weight @ (np.array(variances) + (np.array(values)[:, g:] - mean[g:]) ** 2)
    error = np.sqrt(spread)
    return _Course(
        mean[:g], mean[g:-2], error[:-2], float(mean[-2]), float(error[-2]), float(mean[-1]), float(error[-1]),
        float(weight @ np.array(dofs)), float(np.sqrt(min(each[5] for each in made) / u.size)),
    )  # fmt: skip


def _basis(u: Floats, degree: int, decay: float) -> Floats:
    powers = [u**k for k in range(degree + 1)]
    return np.stack(powers + ([np.exp(-u / decay)] if decay else []), axis=-1)


def _slopes(u: Floats, degree: int, decay: float) -> Floats:
    powers = [k * u ** max(k - 1, 0) for k in range(degree + 1)]
    return np.stack(powers + ([-np.exp(-u / decay) / decay] if decay else []), axis=-1)


def _change(u: Floats, y: Floats, secant: float, at_first: float) -> tuple[float, float, float]:
    """Change of kappa over the whole range by the course of its upper part, its error, and how far kappa at F0 lies
    below that course; shares of the secant."""
    c, covariance = np.linalg.lstsq(rows := _basis(u, 2, 0.0), y, rcond=None)[0], np.linalg.pinv(rows.T @ rows)
    left = y - rows @ c
    square, longer = left_over(left, y, 3)
    per_bend = 2 * float(np.ptp(u)) / (1 - _UPPER)
    change, high = per_bend * c[2], c[1] + 2 * c[2] * u.max()
    change_se = per_bend * np.sqrt(square / max(u.size - 3, 1) * longer * covariance[2, 2])
    return float(change / secant), float(change_se / secant), float((high - change - at_first) / secant)
