"""Linear viscoelastic bodies in contact, as a recursion over time that is exact while the force grows evenly.

A contact that has not shrunk yet follows the convolved force alone (Lee and Radok 1960, Journal of Applied Mechanics
27, 438; Graham 1965, International Journal of Engineering Science 3, 27; Ting 1966, Journal of Applied Mechanics 33,
845)

    F_c(t) = integral of J(t - s) dF(s),      J(t) = J0 + sum of J_k (1 - exp(-t / tau_k)),      J(1 s) = 1

J is the creep compliance of both bodies over its value after 1 s, so radius, area and depth at F_c are those of elastic
bodies with the moduli after 1 s. Over one step dt in which F is a straight line, z_k of each branch obeys

    e = exp(-dt / tau);   w1 = 1 - (tau / dt)(1 - e);   w0 = (tau / dt)(1 - e) - e;   z <- e z + J (w0 F_old + w1 F_new)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError

TAUS_S = tuple(10.0 ** (-1.75 + k / 2) for k in range(8))
"Half a decade apart, 0.018 to 56 s."
SHARE_FROM_S, SHARE_TO_S = 0.1, 10.0
"Between these times after a step of depth the share of the force relaxes."
MOST_SHARE = 0.8
_HALVINGS = 60


@dataclass(frozen=True)
class Relaxation:
    """Creep compliance over its value after 1 s: ``instant`` + sum of ``branches``[k] (1 - exp(-t / ``taus_s``[k]))."""

    instant: float
    branches: tuple[float, ...] = ()
    taus_s: tuple[float, ...] = ()

    @classmethod
    def of_share(cls, share: float) -> Relaxation:
        """A body whose force relaxes by ``share`` between 0.1 and 10 s after a step of its depth.

        Its compliance grows like a power of time, t^n with n = log10(1 / (1 - share)) / 2; 0 is exactly elastic.
        SettingError outside 0 to 0.8.
        """
        if not 0 <= share <= MOST_SHARE:
            raise SettingError(
                "relaxation", wanted=f"a share of the force, 0 to {MOST_SHARE:g}", found=repr(share),
                do="Give the share that relaxes between 0.1 and 10 s; 0 is elastic.",
            )  # fmt: skip
        return _of_share(share)

    def modulus(self, time_s: ArrayLike) -> Floats:
        """Share of the modulus after a step of depth, the inverse of J by convolution, at times, s, of any shape (Lee
        and Radok 1960)."""
        taus, branches = np.array(self.taus_s), np.array(self.branches)
        # a step of depth: 1 = J0 F + sum z, tau z' = J F - z; a linear system in z, symmetric after scaling
        root = np.sqrt(branches / taus / self.instant)
        rates, across = np.linalg.eigh(np.diag(1 / taus) + np.outer(root, root))
        load = across.T @ root
        gone = -np.expm1(-np.asarray(time_s, dtype=np.float64)[..., None] * rates) / rates
        return np.asarray((1 - gone @ load**2) / self.instant, dtype=np.float64)


ELASTIC = Relaxation(1.0)


@cache
def _of_share(share: float) -> Relaxation:
    if share == 0:
        return ELASTIC
    n = -math.log10(1 - share) / 2
    spectrum = np.array(TAUS_S) ** n
    after_1_s = float(spectrum @ -np.expm1(-1 / np.array(TAUS_S)))

    def body(strength: float) -> Relaxation:
        return Relaxation(1 - strength * after_1_s, tuple((strength * spectrum).tolist()), TAUS_S)

    low, high = 0.0, 1 / after_1_s
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        early, late = body(middle).modulus([SHARE_FROM_S, SHARE_TO_S])
        low, high = (middle, high) if 1 - late / early < share else (low, middle)
    return body(low)


def in_series(bodies: Sequence[tuple[float, Relaxation]]) -> Relaxation:
    """Bodies that carry the same force: (compliance after 1 s, relaxation) of each; compliances, in any unit, add."""
    total = math.fsum(compliance for compliance, _ in bodies)
    branches: dict[float, float] = {}
    for compliance, body in bodies:
        for branch, tau_s in zip(body.branches, body.taus_s, strict=True):
            branches[tau_s] = branches.get(tau_s, 0.0) + compliance / total * branch
    if not branches:
        return ELASTIC
    instant = math.fsum(compliance / total * body.instant for compliance, body in bodies)
    return Relaxation(instant, tuple(branches.values()), tuple(branches))


def specimen_share(stiffness_mpa: float, sensor_mpa: float) -> float:
    """Share of a specimen in the compliance of both: reduced moduli after 1 s, MPa."""
    return sensor_mpa / (sensor_mpa + stiffness_mpa)


class ConvolvedForce:
    """F_c of P contacts, each between bodies of its own, while their forces (P,) go on.

    A step is: ``alpha_beta(dt)``, from which F_c = alpha + beta F for any force F at its end; solve for F; ``advance``.
    Elastic bodies have alpha 0 and beta 1, so F_c is F to the last bit.
    """

    def __init__(self, bodies: Sequence[Relaxation]) -> None:
        self._taus_s = sorted({tau for body in bodies for tau in body.taus_s})
        by_tau = [dict(zip(body.taus_s, body.branches, strict=True)) for body in bodies]
        self._instant = np.array([body.instant for body in bodies])
        self._branches = [np.array([each.get(tau, 0.0) for each in by_tau]) for tau in self._taus_s]
        self._step_s, self._weights = -1.0, list[tuple[float, Floats, Floats]]()
        self.force_n = np.zeros(len(bodies))
        self._states = [self.force_n] * len(self._branches)

    def alpha_beta(self, step_s: float) -> tuple[Floats, Floats]:
        """F_c = alpha + beta F, (P,) both, ``step_s``, s, from now, where F grows evenly from the present force to F
        (Lee and Radok 1960)."""
        self._weigh(step_s)
        alpha, beta = np.zeros(self.force_n.size), self._instant
        for z, (left, from_old, from_new) in zip(self._states, self._weights, strict=True):
            alpha = alpha + (left * z + from_old * self.force_n)
            beta = beta + from_new
        return alpha, beta

    def advance(self, step_s: float, force_n: Floats) -> Floats:
        """Go on to ``force_n`` (P,), N, ``step_s``, s, from now; F_c (P,) there (Lee and Radok 1960)."""
        self._weigh(step_s)
        total = self._instant * force_n
        for k, (left, from_old, from_new) in enumerate(self._weights):
            self._states[k] = left * self._states[k] + from_old * self.force_n + from_new * force_n
            total = total + self._states[k]
        self.force_n = force_n
        return total

    def _weigh(self, step_s: float) -> None:
        if step_s != self._step_s:
            self._step_s = step_s
            parts = [shares_of_step(step_s / tau_s) for tau_s in self._taus_s]
            self._weights = [
                (left, branch * old, branch * new)
                for (left, old, new), branch in zip(parts, self._branches, strict=True)
            ]


def shares_of_step(share: float) -> tuple[float, float, float]:
    """Shares of a branch's state and of the force at start and end of a step of ``share`` of its time: e, w0 and w1
    above.
    """
    gone = -math.expm1(-share)
    mean = gone / share if share > 0 else 1.0
    return 1 - gone, mean - (1 - gone), 1 - mean
