"""Kappa of every specimen of a sensor's presses, with an interval: labels by pins, forces, and known specimens.

The unknowns are those of ``Labels``, the dome's stiffness kappa0, kappa of each specimen, and how the labels of this
sensor differ from the truth (Kennedy and O'Hagan 2001, Journal of the Royal Statistical Society B 63, 425): a line in z
and, about it, a smooth curve of which only the size is known. Everything is Gaussian but z(kappa) and the force law,
which are linearised where the estimate is. The statements are

    z by the pins            = kappa0 / (kappa0 + kappa) + line in z + curve + mounting of the specimen + scatter
    ln force / reduced force = ln kappa0 + curve + mounting of the specimen + scatter
    ln kappa of a known specimen, with its standard error.

How far they contradict each other widens all intervals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from casr.kappa.field import OF_VIEW
from casr.kappa.labels import Labels
from casr.spread.intervals import CONFIDENCE, student_quantile

Array = NDArray[np.float64]

CUES = ("pins", "force")
FREE_SD = 10.0
"Of ln kappa of a specimen that is not known, about ``_USUAL_KAPPA``: as good as free."
KNOWN_SD = 0.002
"Least standard error of ln kappa of a known specimen."
_USUAL_KAPPA, _MIDDLE_Z = 4.0, 0.4
RIGID = 1e5
"N/mm, of a specimen that is called rigid."
_ROUNDS, _FOUND = 12, 1e-5


@dataclass(frozen=True, kw_only=True)
class Discrepancy:
    """Standard deviations by which a real sensor differs from the family and presses from each other.

    level, slope : of the line by which labels z differ from the truth. curve : about the line, alike over ``curve_z``.
    scatter : of the label of a press. stiffness : relative, of a specimen from mounting to mounting.
    log_kappa0 : of a sensor's modulus, relative to that of the tables. log_force : of the tables' forces, all alike;
    force_curve : from specimen to specimen. force_mounting : of the force at a radius, from mounting to mounting of a
    specimen; force_scatter : from press to press; force_frame : from frame to frame. force_bend : of ln force from one
    e-fold to the next.
    freedom : degrees of freedom that these were found with.
    """

    level: float = 0.03
    slope: float = 0.10
    curve: float = 0.0075
    curve_z: float = 0.15
    scatter: float = 0.002
    stiffness: float = 0.035
    log_kappa0: float = 1.0
    log_force: float = 0.05
    force_curve: float = 0.02
    force_mounting: float = 0.03
    force_scatter: float = 0.03
    force_frame: float = 0.01
    force_bend: float = 0.03
    force_sd_n: float = 0.01
    freedom: float = 10.0

    def scaled(self, factor: float) -> Discrepancy:
        """Of a sensor that the tables fit less well."""
        names = ("level", "slope", "curve", "log_force", "force_curve")
        return replace(self, **{name: factor * getattr(self, name) for name in names})


EXACT = Discrepancy(level=1e-6, slope=1e-6, curve=1e-6, scatter=1e-6, stiffness=0.0)
"A sensor that is one of the family, and presses that differ by noise alone."


@dataclass(frozen=True, kw_only=True, eq=False)
class Kappa:
    """Kappa of one specimen.

    value, low, high : N/mm and its total 95 % interval; high is inf where the specimen may be rigid.
    log_sd : standard error of ln kappa. expected : half width of the interval that the design promises, relative.
    determined : whether that is ``DETERMINED`` or less. bound_sd : of ln kappa, by Cramer and Rao's bound,
    for white noise of pins, of all presses of the specimen by themselves. efficiency : bound_sd / log_sd.
    by_cue : value and standard error of ln kappa by each cue alone; absent where it says nothing.
    stick : share of friction, mean of the presses.
    """

    specimen: str
    known: float | None
    value: float
    low: float
    high: float
    log_sd: float
    expected: float
    determined: bool
    bound_sd: float
    efficiency: float
    by_cue: dict[str, tuple[float, float]]
    stick: float
    n_presses: int


DETERMINED = 0.25
"Largest half width of an interval, relative, that a design may promise for kappa to be called determined."


@dataclass(frozen=True, eq=False)
class _Forces:
    """(F,) presses that have forces: ln force over reduced force, its variance, (F, G) derivative by the parameters."""

    press: NDArray[np.intp]
    level: Array
    variance: Array
    by: Array


class Posterior:
    """Of all specimens. cues : which are used. mean, covariance : of the n_label parameters of ``Labels``, ln kappa0,
    level, slope and ln kappa of each specimen."""

    def __init__(
        self, labels: Labels, discrepancy: Discrepancy, cues: Sequence[str] = CUES, left_out: str | None = None
    ) -> None:
        self._labels, self._d, self._family = labels, discrepancy, labels.family
        presses = [field.press for field in labels.fields]
        self.specimens = sorted({press.specimen for press in presses})
        self._of = np.array([self.specimens.index(press.specimen) for press in presses])
        self._same = np.array(
            [[a.specimen == b.specimen and a.mounting == b.mounting for b in presses] for a in presses]
        )
        known = {press.specimen: press for press in presses if press.stiffness_n_per_mm is not None}
        self.known = {
            name: min(press.stiffness_n_per_mm, RIGID) for name, press in known.items()
            if press.stiffness_n_per_mm and name != left_out
        }  # fmt: skip
        self._known_sd = {name: max(press.stiffness_sd, KNOWN_SD) for name, press in known.items()}
        self._cues = cues
        self.n_label, self._force_variance = labels.mean.size, 1.0
        self._solve()
        if "force" in cues and self._forces.press.size:
            # forces that contradict each other by more than is usual count less, and do not widen what the pins say
            count = self._forces.press.size + discrepancy.freedom
            self._force_variance = max((self._force_chi2() + discrepancy.freedom) / count, 1.0)
            self._solve()

    def _solve(self) -> None:
        n, d, labels = self.n_label, self._d, self._labels
        self._forces = _forces(labels, d)
        covariance = np.linalg.inv(labels.precision)
        if "pins" not in self._cues:
            covariance = covariance + np.diag(np.isin(np.arange(n), labels.own_at) * 1.0)
        of_labels = np.linalg.inv(covariance)
        at = np.concatenate([labels.mean, [self._family.log_kappa0_at(float(labels.mean[0])), 0.0, 0.0],
                             [np.log(self.known.get(name, _USUAL_KAPPA)) for name in self.specimens]])  # fmt: skip
        for _ in range(_ROUNDS):
            residual, by, weight = self._statements(at)
            precision = by.T @ weight @ by
            gradient = by.T @ weight @ residual
            precision[:n, :n] += of_labels
            gradient[:n] += of_labels @ (labels.mean - at[:n])
            step = np.clip(np.linalg.solve(precision, gradient), -1.0, 1.0)
            at = at + step
            if np.abs(step).max() < _FOUND:
                break
        residual, by, weight = self._statements(at)
        away = labels.mean - at[:n]
        self.chi2 = float(residual @ weight @ residual + away @ of_labels @ away)
        self.freedom = residual.size - 3 - len(self.specimens)
        self.mean, self.covariance = at, np.linalg.inv(precision)
        freedom = max(self.freedom, 0) + d.freedom
        self.widened = float(np.sqrt(max((self.chi2 + d.freedom) / freedom, 1.0)))
        self.reach = student_quantile(CONFIDENCE, freedom)

    def _force_chi2(self) -> float:
        """How far the forces are from what the whole says of them."""
        residual, _, weight = self._statements(self.mean)
        count = self._forces.press.size
        return float(residual[-count:] @ weight[-count:, -count:] @ residual[-count:])

    def _statements(self, at: Array) -> tuple[Array, Array, Array]:
        """(M,) residuals of all statements but the labels, (M, P) derivatives, (M, M) weights."""
        n, d, labels = self.n_label, self._d, self._labels
        size, n_press = at.size, len(self._of)
        log_kappa0, level, slope = at[n : n + 3]
        log_kappa = at[n + 3 :]
        true_z = 1 / (1 + np.exp(log_kappa[self._of] - log_kappa0))
        soft = true_z * (1 - true_z)
        rows, of = np.arange(n_press), n + 3 + self._of
        by_z = np.zeros((n_press, size))
        by_z[rows, labels.own_at] = -1
        by_z[:, n], by_z[rows, of] = soft * (1 + slope), -soft * (1 + slope)
        by_z[:, n + 1], by_z[:, n + 2] = 1, true_z - _MIDDLE_Z
        z_left = at[labels.own_at] - true_z - level - slope * (true_z - _MIDDLE_Z)
        alike = self._alike(true_z, true_z)
        z_covariance = d.curve**2 * alike + d.scatter**2 * np.eye(n_press)
        z_covariance += self._same * d.stiffness**2 * np.outer(soft, soft)
        prior = [(n, self._family.log_kappa0_at(float(at[0])), d.log_kappa0), (n + 1, 0, d.level), (n + 2, 0, d.slope)]
        prior += [
            (
                n + 3 + k,
                np.log(self.known.get(name, _USUAL_KAPPA)),
                self._known_sd[name] if name in self.known else FREE_SD,
            )
            for k, name in enumerate(self.specimens)
        ]
        by_prior = np.eye(size)[[row for row, _, _ in prior]]
        parts = [
            (z_left, by_z, np.linalg.inv(z_covariance)),
            (np.array([mean - at[row] for row, mean, _ in prior]), by_prior, np.diag([sd**-2.0 for _, _, sd in prior])),
        ]
        if "force" in self._cues and self._forces.press.size:
            f = self._forces
            by_force = np.zeros((f.press.size, size))
            by_force[:, :n], by_force[:, n] = -f.by, 1
            left = f.level + f.by @ (at[:n] - labels.mean) - log_kappa0
            among = np.ix_(f.press, f.press)
            covariance = np.diag(f.variance + d.force_scatter**2) + d.log_force**2 + d.force_curve**2 * alike[among]
            covariance += d.force_mounting**2 * self._same[among]
            parts.append((left, by_force, np.linalg.inv(self._force_variance * covariance)))
        sizes = np.cumsum([0, *[len(left) for left, _, _ in parts]])
        weight = np.zeros((sizes[-1], sizes[-1]))
        for first, last, (_, _, own) in zip(sizes[:-1], sizes[1:], parts, strict=True):
            weight[first:last, first:last] = own
        return np.concatenate([left for left, _, _ in parts]), np.vstack([by for _, by, _ in parts]), weight

    def log_kappa(self, specimen: str) -> tuple[float, float]:
        """ln kappa and its standard error, not widened."""
        k = self.n_label + 3 + self.specimens.index(specimen)
        return float(self.mean[k]), float(np.sqrt(self.covariance[k, k]))

    def label(self, log_kappa: Array) -> Array:
        """(K,) label z that pins of this sensor show at K values of ln kappa: by the line, and the curve about it."""
        log_kappa0, level, slope = self.mean[self.n_label : self.n_label + 3]
        at, seen = (
            1 / (1 + np.exp(each - log_kappa0)) for each in (log_kappa, self.mean[self.n_label + 3 :][self._of])
        )
        residual, _, weight = self._statements(self.mean)
        curve = self._d.curve**2 * self._alike(at, seen) @ weight[: seen.size, : seen.size] @ residual[: seen.size]
        return np.asarray(at + level + slope * (at - _MIDDLE_Z) + curve)

    def _alike(self, z: Array, other_z: Array) -> Array:
        """Correlation of the curve there."""
        return np.asarray(np.exp(-((z[:, None] - other_z) ** 2) / (2 * self._d.curve_z**2)))

    @property
    def kappa0(self) -> float:
        """Of the dome, N/mm."""
        return float(np.exp(self.mean[self.n_label]))


def kappas(labels: Labels, discrepancy: Discrepancy | None = None) -> dict[str, Kappa]:
    """Kappa of every specimen; of a known one as the others tell it, where two or more are known beside it."""
    d = discrepancy or Discrepancy()
    whole, bound = Posterior(labels, d), Posterior(replace(labels, precision=labels.white_precision), EXACT, ("pins",))
    alone = {cue: Posterior(labels, d, (cue,)) for cue in CUES}
    found = {}
    for name in whole.specimens:
        posteriors, of_bound = {"": whole, **alone}, bound
        if name in whole.known:
            if len(whole.known) < 3 or whole.known[name] == RIGID:
                continue
            of_bound = Posterior(replace(labels, precision=labels.white_precision), EXACT, ("pins",), name)
            posteriors = {"": Posterior(labels, d, left_out=name)}
        found[name] = _kappa(name, labels, posteriors, whole.known.get(name), of_bound)
    return found


def _kappa(name: str, labels: Labels, posteriors: dict[str, Posterior], known: float | None, bound: Posterior) -> Kappa:
    of = posteriors[""]
    log_kappa, sd = of.log_kappa(name)
    low, value, high = _ends(log_kappa, of.reach * of.widened * sd, of.kappa0)
    promised_low, _, promised_high = _ends(log_kappa, of.reach * sd, of.kappa0)
    expected = (promised_high - promised_low) / (2 * value)
    rows = [k for k, field in enumerate(labels.fields) if field.press.specimen == name]
    bound_sd = bound.log_kappa(name)[1]
    by_cue = {
        cue: (one.log_kappa(name)[0], one.widened * one.log_kappa(name)[1]) for cue, one in posteriors.items() if cue
    }
    return Kappa(
        specimen=name, known=known, value=value, low=low, high=high, log_sd=of.widened * sd, expected=expected,
        determined=expected <= DETERMINED, bound_sd=bound_sd, efficiency=bound_sd / (of.widened * sd),
        by_cue={cue: (float(np.exp(each)), error) for cue, (each, error) in by_cue.items() if error < 1.0},
        stick=float(np.mean([labels.states[k].own[1] for k in rows])), n_presses=len(rows),
    )  # fmt: skip


def _ends(log_kappa: float, reach: float, kappa0: float) -> tuple[float, float, float]:
    """Ends of an interval and kappa between them, N/mm: even in z, in which a rigid specimen is not far away."""
    z = 1 / (1 + np.exp(log_kappa) / kappa0)
    half = reach * z * (1 - z)
    ends = [kappa0 * (1 / each - 1) if each > 0 else np.inf for each in (min(z + half, 1.0), z - half)]
    return float(ends[0]), float(np.exp(log_kappa)), float(ends[1])


def _forces(labels: Labels, d: Discrepancy) -> _Forces:
    press, level, variance, by = [], [], [], []
    for k, field in enumerate(labels.fields):
        if field.press.force_n is None:
            continue
        force_n = field.press.force_n[field.frames]
        there = force_n > 0.1
        if there.sum() < 3:
            continue
        log_force = np.log(np.where(there, force_n, 1.0))
        covariance = np.diag((d.force_frame**2 + (d.force_sd_n / force_n) ** 2)[there])
        for shape, sd in (
            (1 / force_n[there], field.press.force_zero_sd_n),
            (log_force[there] - log_force[there].mean(), d.force_bend),
        ):
            covariance += sd**2 * np.outer(shape, shape)
        weight = np.linalg.solve(covariance, np.ones(int(there.sum())))
        total = float(weight.sum())
        weight = weight / total
        reduced, change = _reduced_force(labels, k)
        press.append(k)
        level.append(float(weight @ (log_force - reduced)[there]))
        variance.append(1 / total)
        by.append(-weight @ change[there])
    size = labels.mean.size
    return _Forces(np.array(press, dtype=np.intp), np.array(level), np.array(variance), np.array(by).reshape(-1, size))


def _reduced_force(labels: Labels, k: int) -> tuple[Array, Array]:
    """(T,) ln of force over kappa0 at the radii of a press, and (T, G) its derivative by all parameters."""
    family, state, own = labels.family, labels.states[k], int(labels.own_at[k])
    bends = len(family.bends)
    first = len(OF_VIEW)
    names = [0, *range(first, first + bends), own, own + 1]
    values = np.array([state.shared[0], *state.shared[first : first + bends], *state.own[:2]])

    def at(values: Array, radius_mm: Array) -> Array:
        world = family.world(values[0], values[-2], values[-1], 0.0, values[1 : 1 + bends])
        return np.interp(np.log(radius_mm), np.log(family.radius_mm), family.log_force(world))

    here, step = at(values, state.radius_mm), 1e-3
    change = (at(values, state.radius_mm + step) - here)[:, None] / step * labels.radius_by[k]
    for row, name in enumerate(names):
        moved = values.copy()
        moved[row] += step
        change[:, name] += (at(moved, state.radius_mm) - here) / step
    return here, change
