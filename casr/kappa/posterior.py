"""Kappa of every specimen of a sensor's presses, with an interval: labels by pins, forces, and known specimens.

The unknowns are those of ``KnownSensor``, the dome's stiffness kappa0, kappa of each specimen, and how the labels of
this sensor differ from the truth (Kennedy and O'Hagan 2001, Journal of the Royal Statistical Society B 63, 425): a line
in z and, about it, a smooth curve of which only the size is known. Everything is Gaussian but z(kappa), which is
linearised where the estimate is. The statements are

    z by the pins            = kappa0 / (kappa0 + kappa) + line in z + curve + mounting of the specimen + scatter
    ln force / reduced force = ln kappa0 + curve + mounting of the specimen + scatter
    ln kappa of a known specimen, with its standard error
    3/2 ln travel per newton = level of it + ln(1/k_t + 1/kappa) + curve + mounting of the specimen + scatter,

the last where presses have it: dome and specimen in series after Hertz, the level free, k_t drawn to kappa0. How far
the others contradict each other widens all intervals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.kappa.discrepancy import EXACT, Discrepancy
from casr.kappa.known import CUES, TRAVEL, KnownSensor
from casr.kappa.labels import Labels
from casr.spread.intervals import CONFIDENCE, student_quantile

Array = NDArray[np.float64]
_Statement = tuple[Array, Array, NDArray[np.floating]]
"What is left of r statements (r,), its derivatives by the K parameters (r, K), and their weight (r, r)."

FREE_SD = 10.0
"SD of ln kappa of an unknown specimen about ``_USUAL_KAPPA``: as good as free."
KNOWN_SD = 0.002
"Least standard error of ln kappa of a known specimen."
_USUAL_KAPPA, _MIDDLE_Z = 4.0, 0.4
RIGID = 1e5
"N/mm, of a specimen that is called rigid."
LOG_KT, LOG_KT_SD = 0.5, 0.3
"""ln k_t - ln kappa0: .35 to .75 on the domes that come with casr, 0.5 to 4.5 N, as the tables' depth has it."""
_ROUNDS, _FOUND = 12, 1e-5


@dataclass(frozen=True, kw_only=True, eq=False)
class Kappa:
    """Kappa of one specimen.

    value, low, high : N/mm and its total interval; high is inf where the specimen may be rigid.
    log_sd : standard error of ln kappa, of so many degrees of ``freedom``. kappa0 : stiffness of the dome, N/mm.
    expected : half width of the interval that the design promises, relative.
    contradicted : factor by which statements that contradict each other widen the interval, 1 where they do not.
    determined : whether ``expected`` is ``DETERMINED`` or less, and ``contradicted`` ``CONTRADICTED`` or less.
    bound_sd : of ln kappa, by Cramer and Rao's bound, were white noise of pins and the errors of the known stiffnesses
    all that is unknown. efficiency : bound_sd / log_sd; NaN where the bound, which knows no force, is the larger one.
    by_cue : value and standard error of ln kappa by each cue alone; absent where it says nothing.
    stick : share of friction, mean of the presses.
    """

    specimen: str
    known: float | None
    value: float
    low: float
    high: float
    log_sd: float
    freedom: float
    kappa0: float
    expected: float
    contradicted: float
    determined: bool
    bound_sd: float
    efficiency: float
    by_cue: dict[str, tuple[float, float]]
    stick: float
    n_presses: int

    def interval(self, confidence: float) -> tuple[float, float]:
        """Low and high end, N/mm, of another confidence."""
        return ends(self.value, self.kappa0, student_quantile(confidence, self.freedom) * self.log_sd)


DETERMINED = 0.25
"Largest half width of an interval, relative, that a design may promise for kappa to be called determined."
CONTRADICTED = 2.0
"""Times by which contradictions may widen an interval so that the design's promise still counts: presses of one sensor
stay below 1.6, those of specimens that are mixed up come to 3 to 30."""


class Posterior:
    """Posterior of kappa of all specimens. left_out : whose stiffness is taken as unknown. confidence : of its
    intervals. start : where they are looked for, as ``mean`` of a posterior of the same presses, with fewer frames
    perhaps.

    mean, covariance : of the n_label parameters of the sensor, ln kappa0, level, slope, ln kappa of each
    specimen, and where there is travel its level and ln k_t.
    """

    def __init__(
        self,
        sensor: KnownSensor,
        discrepancy: Discrepancy,
        left_out: str | None = None,
        *,
        confidence: float = CONFIDENCE,
        start: Array | None = None,
    ) -> None:
        self._sensor, self._d, self._confidence, presses = sensor, discrepancy, confidence, sensor.presses
        self.specimens = sorted({press.specimen for press in presses})
        self._of = np.array([self.specimens.index(press.specimen) for press in presses])
        self._same = np.array(
            [[(a.specimen, a.mounting) == (b.specimen, b.mounting) for b in presses] for a in presses]
        )
        known = {press.specimen: press for press in presses if press.stiffness_n_per_mm is not None}
        self.known = {
            name: min(press.stiffness_n_per_mm, RIGID) for name, press in known.items()
            if press.stiffness_n_per_mm and name != left_out
        }  # fmt: skip
        self._known_sd = {name: max(press.stiffness_sd, KNOWN_SD) for name, press in known.items()}
        self._travelled = sensor.with_travel
        self._log_travel = 1.5 * np.log([presses[k].travel_mm_per_n or np.nan for k in self._travelled])
        self.n_label, self._variance = sensor.mean.size, {"force": 1.0, TRAVEL: 1.0}
        begun = self._begun()  # forces may come with later frames
        self._solve(begun if start is None or start.size != begun.size else start)
        said = {cue: part for cue, part in self._parts(self.mean).items() if cue in self._variance}
        for cue, (left, _, weight) in said.items():
            # what contradicts itself by more than is usual counts less, and does not widen what the pins say
            chi2 = float(left @ weight @ left)
            self._variance[cue] = max((chi2 + discrepancy.freedom) / (left.size + discrepancy.freedom), 1.0)
        if said:
            self._solve(self.mean)

    def _begun(self) -> Array:
        n, sensor = self.n_label, self._sensor
        at = np.concatenate([sensor.mean, [sensor.log_kappa0, 0.0, 0.0],
                             [np.log(self.known.get(name, _USUAL_KAPPA)) for name in self.specimens]])  # fmt: skip
        if self._travelled.size:
            log_kt = at[n] + LOG_KT
            series = np.logaddexp(-log_kt, -at[n + 3 + self._of[self._travelled]])
            at = np.append(at, [float((self._log_travel - series).mean()), log_kt])
        return np.asarray(at)

    def _solve(self, at: Array) -> None:
        n, d, sensor = self.n_label, self._d, self._sensor
        for _ in range(_ROUNDS):
            residual, by, weight = self._statements(at)
            precision = by.T @ weight @ by
            gradient = by.T @ weight @ residual
            precision[:n, :n] += sensor.precision
            gradient[:n] += sensor.precision @ (sensor.mean - at[:n])
            step = np.clip(np.linalg.solve(precision, gradient), -1.0, 1.0)
            at = at + step
            if np.abs(step).max() < _FOUND:
                break
        residual, self._by, self._weight = self._statements(at)
        away = sensor.mean - at[:n]
        told = slice(residual.size - (self._travelled.size + 1 if self._travelled.size else 0))
        # travel that is as it should be says nothing of how well the tables are of this sensor
        left = residual[told]
        self.chi2 = float(left @ self._weight[told, told] @ left + away @ sensor.precision @ away)
        self.mean, self.covariance = at, np.linalg.inv(precision)
        self.freedom = max(left.size - 3 - len(self.specimens), 0) + d.freedom
        self.widened = float(np.sqrt(max((self.chi2 + d.freedom) / self.freedom, 1.0)))
        self.reach = student_quantile(self._confidence, self.freedom)

    def _statements(self, at: Array) -> tuple[Array, Array, Array]:
        """(M,) residuals of all statements but the labels, (M, P) derivatives, (M, M) weights."""
        parts = list(self._parts(at).values())
        sizes = np.cumsum([0, *[len(left) for left, _, _ in parts]])
        weight = np.zeros((sizes[-1], sizes[-1]))
        for first, last, (_, _, own) in zip(sizes[:-1], sizes[1:], parts, strict=True):
            weight[first:last, first:last] = own
        return np.concatenate([left for left, _, _ in parts]), np.vstack([by for _, by, _ in parts]), weight

    def _parts(self, at: Array) -> dict[str, _Statement]:
        """The statements by pins, of what is known, and by each other cue."""
        n = self.n_label
        log_kappa = at[n + 3 : n + 3 + len(self.specimens)]
        true_z = 1 / (1 + np.exp(log_kappa[self._of] - at[n]))
        alike = self._alike(true_z, true_z)
        parts = {"pins": self._by_pins(at, true_z, alike), "known": self._by_known(at)}
        if self._sensor.with_force.size:
            parts["force"] = self._by_force(at, alike)
        if self._travelled.size:
            parts["k_t"], parts[TRAVEL] = self._by_travel(at, log_kappa, alike)
        return parts

    def _by_pins(self, at: Array, true_z: Array, alike: Array) -> _Statement:
        """Labels of the pins beside the line through the true ones (P,)."""
        n, d, z_at, n_press = self.n_label, self._d, self._sensor.z_at, len(self._of)
        level, slope = at[n + 1 : n + 3]
        soft = true_z * (1 - true_z)
        rows, of = np.arange(n_press), n + 3 + self._of
        by_z = np.zeros((n_press, at.size))
        by_z[rows, z_at] = -1
        by_z[:, n], by_z[rows, of] = soft * (1 + slope), -soft * (1 + slope)
        by_z[:, n + 1], by_z[:, n + 2] = 1, true_z - _MIDDLE_Z
        z_left = at[z_at] - true_z - level - slope * (true_z - _MIDDLE_Z)
        z_covariance = d.curve**2 * alike + d.scatter**2 * np.eye(n_press)
        z_covariance += self._same * d.stiffness**2 * np.outer(soft, soft)
        return z_left, by_z, np.linalg.inv(z_covariance)

    def _by_known(self, at: Array) -> _Statement:
        """What is known before a press: the dome, the discrepancy, and the specimens."""
        n, d = self.n_label, self._d
        prior = [(n, self._sensor.log_kappa0, d.log_kappa0), (n + 1, 0, d.level), (n + 2, 0, d.slope)]
        prior += [
            (
                n + 3 + k,
                np.log(self.known.get(name, _USUAL_KAPPA)),
                self._known_sd[name] if name in self.known else FREE_SD,
            )
            for k, name in enumerate(self.specimens)
        ]
        left = np.array([mean - at[row] for row, mean, _ in prior])
        return left, np.eye(at.size)[[row for row, _, _ in prior]], np.diag([sd**-2.0 for _, _, sd in prior])

    def _by_force(self, at: Array, alike: Array) -> _Statement:
        """Stiffness of the dome by the presses that have forces."""
        n, d, forces = self.n_label, self._d, self._sensor.with_force
        first = n - forces.size
        by_force = np.zeros((forces.size, at.size))
        by_force[np.arange(forces.size), first + np.arange(forces.size)], by_force[:, n] = -1, 1
        among = np.ix_(forces, forces)
        covariance = np.diag([self._sensor.presses[k].force_variance + d.force_scatter**2 for k in forces])
        covariance += d.log_force**2 + d.force_curve**2 * alike[among]
        covariance += d.force_mounting**2 * self._same[among]
        return at[first:n] - at[n], by_force, np.linalg.inv(self._variance["force"] * covariance)

    def _by_travel(self, at: Array, log_kappa: Array, alike: Array) -> tuple[_Statement, _Statement]:
        """Stiffness of the dome under travel beside that under the pins, and dome and specimen in series."""
        n, d, travelled = self.n_label, self._d, self._travelled
        travel_level, log_kt = at[-2:]
        log_soft = -log_kappa[self._of[travelled]]
        series = np.logaddexp(-log_kt, log_soft)
        by_travel, by_kt = np.zeros((travelled.size, at.size)), np.zeros((1, at.size))
        of = n + 3 + self._of[travelled]
        by_travel[np.arange(travelled.size), of] = -np.exp(log_soft - series)
        by_travel[:, -2], by_travel[:, -1] = 1, -np.exp(-log_kt - series)
        by_kt[0, [n, -1]] = -1, 1
        among = np.ix_(travelled, travelled)
        covariance = d.travel_curve**2 * alike[among] + d.travel_scatter**2 * np.eye(travelled.size)
        covariance += d.travel_mounting**2 * self._same[among]
        left, weight = self._log_travel - travel_level - series, np.linalg.inv(self._variance[TRAVEL] * covariance)
        return (np.array([at[n] + LOG_KT - log_kt]), by_kt, np.array([[LOG_KT_SD**-2]])), (left, by_travel, weight)

    def log_kappa(self, specimen: str) -> tuple[float, float]:
        """ln kappa and its standard error, not widened."""
        k = self.n_label + 3 + self.specimens.index(specimen)
        return float(self.mean[k]), float(np.sqrt(self.covariance[k, k]))

    def label(self, log_kappa: Array) -> Array:
        """(K,) label z that pins of this sensor show at K values of ln kappa: by the line, and the curve about it
        (Kennedy and O'Hagan 2001)."""
        level, slope = self.mean[self.n_label + 1 : self.n_label + 3]
        at, seen = self.z(np.exp(log_kappa)), self.z(np.exp(self.mean[self.n_label + 3 :][self._of]))
        residual, _, weight = self._statements(self.mean)
        curve = self._d.curve**2 * self._alike(at, seen) @ weight[: seen.size, : seen.size] @ residual[: seen.size]
        return np.asarray(at + level + slope * (at - _MIDDLE_Z) + curve)

    def _alike(self, z: Array, other_z: Array) -> Array:
        """Correlation of the curve there."""
        return np.asarray(np.exp(-((z[:, None] - other_z) ** 2) / (2 * self._d.curve_z**2)))

    def expected_log_sd(self, kappa: Array, presses: int, mountings: int) -> Array:
        """(K,) standard error of ln kappa, widened, of specimens that are not among these, by so many presses in so
        many mountings, told as well as the press of a known specimen whose label is next."""
        n, d, sensor = self.n_label, self._d, self._sensor
        slope, log_kappa = self.mean[n + 2], self.mean[n + 3 + self._of]
        old_z, new_z = self.z(np.exp(log_kappa)), self.z(kappa)
        soft, near = new_z * (1 - new_z), np.abs(new_z[:, None] - old_z).argmin(axis=1)
        by_shared, own = (each[near] for each in sensor.by_shared)
        by = np.zeros((new_z.size, self.mean.size))
        by[:, : by_shared.shape[1]] = by_shared
        by[:, n : n + 3] = -np.stack([soft * (1 + slope), np.ones_like(soft), new_z - _MIDDLE_Z], axis=1)
        curve = np.zeros((new_z.size, len(self._weight)))
        curve[:, : old_z.size] = d.curve**2 * self._alike(new_z, old_z)
        told = curve @ self._weight
        by += told @ self._by
        variance = ((by @ self.covariance) * by).sum(axis=1) + d.curve**2 - (told * curve).sum(axis=1)
        variance += (d.stiffness * soft) ** 2 / min(mountings, presses) + (d.scatter**2 + own) / presses
        return np.asarray(self.widened * np.sqrt(variance) / (soft * (1 + slope)))

    def interval(self, specimen: str) -> tuple[float, float, float]:
        """Low end, kappa and high end, N/mm, of the total interval."""
        log_kappa, sd = self.log_kappa(specimen)
        kappa = float(np.exp(log_kappa))
        low, high = ends(kappa, self.kappa0, self.reach * self.widened * sd)
        return low, kappa, high

    def z(self, kappa: Array | float) -> Array:
        """z that kappa, N/mm, has on this dome: scalar or array, of the shape of ``kappa``."""
        return np.asarray(1 / (1 + kappa / self.kappa0))

    @property
    def kappa0(self) -> float:
        """Stiffness of the dome, N/mm."""
        return float(np.exp(self.mean[self.n_label]))


def ends(kappa: float, kappa0: float, reach: float) -> tuple[float, float]:
    """Low and high end, N/mm, of an interval that reaches so far in ln kappa: even in z, in which a rigid specimen is
    not far."""
    z = 1 / (1 + kappa / kappa0)
    half = reach * z * (1 - z)
    low, high = (kappa0 * (1 / each - 1) if each > 0 else np.inf for each in (min(z + half, 1.0), z - half))
    return low, high


def kappas(labels: Labels, discrepancy: Discrepancy | None = None, confidence: float = CONFIDENCE) -> dict[str, Kappa]:
    """Kappa of every specimen; of a known one as the others tell it, where two or more are known beside it."""
    d = discrepancy or Discrepancy()
    sensor, white = KnownSensor.of(labels), KnownSensor.of(labels, ("pins",), white=True)
    whole, bound = Posterior(sensor, d, confidence=confidence), Posterior(white, EXACT)
    cues = (*CUES, *[TRAVEL] * bool(sensor.with_travel.size))
    alone = {cue: Posterior(KnownSensor.of(labels, (cue,)), d) for cue in cues}
    found = {}
    for name in whole.specimens:
        posteriors, of_bound = {"": whole, **alone}, bound
        if name in whole.known:
            if len(whole.known) < 3 or whole.known[name] == RIGID:
                continue
            of_bound, posteriors = (
                Posterior(white, EXACT, name),
                {"": Posterior(sensor, d, name, confidence=confidence)},
            )
        found[name] = _kappa(name, labels, posteriors, whole.known.get(name), of_bound)
    return found


def _kappa(name: str, labels: Labels, posteriors: dict[str, Posterior], known: float | None, bound: Posterior) -> Kappa:
    of = posteriors[""]
    sd, (low, value, high) = of.log_kappa(name)[1], of.interval(name)
    promised_low, promised_high = ends(value, of.kappa0, of.reach * sd)
    expected = (promised_high - promised_low) / (2 * value)
    rows = [k for k, field in enumerate(labels.fields) if field.press.specimen == name]
    bound_sd = bound.log_kappa(name)[1]
    by_cue = {
        cue: (one.log_kappa(name)[0], one.widened * one.log_kappa(name)[1]) for cue, one in posteriors.items() if cue
    }
    return Kappa(
        specimen=name, known=known, value=value, low=low, high=high, log_sd=of.widened * sd, freedom=of.freedom,
        kappa0=of.kappa0, expected=expected,
        contradicted=of.widened, determined=expected <= DETERMINED and of.widened <= CONTRADICTED, bound_sd=bound_sd,
        efficiency=bound_sd / (of.widened * sd) if bound_sd < of.widened * sd else np.nan,
        by_cue={cue: (float(np.exp(each)), error) for cue, (each, error) in by_cue.items() if error < 1.0},
        stick=float(np.mean([labels.states[k].own[1] for k in rows])), n_presses=len(rows),
    )  # fmt: skip
