"""A contact that keeps its whole history, as independent elements: the reference that the recursion is held to.

Dimensionality reduction (Popov and Hess 2015): an axisymmetric contact is a row of springs at x >= 0 under a profile
g(x); spring x is deformed by u = h - g(x) where that is above 0, and F = 2 times the integral of their forces. With a
Maxwell arm each spring has f = E_long u + q, q' = E_arm u' - q / tau, exact over a step on which u is straight.
`ElementRow` shares nothing with emg2vsa.worlds.contact: moduli in place of compliances, depth in place of force.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from emg2vsa.worlds.contact import ConvolvedForce, Relaxation

Floats = NDArray[np.float64]


def maxwell(long_mpa: float, arm_mpa: float, tau_s: float) -> tuple[Relaxation, float]:
    """The body of the modulus long + arm exp(-t / tau), and its modulus after 1 s, MPa."""
    instant, creep = 1 / (long_mpa + arm_mpa), 1 / long_mpa - 1 / (long_mpa + arm_mpa)
    creep_s = tau_s * (long_mpa + arm_mpa) / long_mpa
    after_1_s = instant - creep * math.expm1(-1 / creep_s)
    return Relaxation(instant / after_1_s, (creep / after_1_s,), (creep_s,)), 1 / after_1_s


def convolved_force_n(relaxation: Relaxation, time_s: Floats, force_n: Floats) -> Floats:
    """The convolved force of one that goes straight from sample to sample; before the first it was 0."""
    state, steps = ConvolvedForce([relaxation]), np.diff(time_s, prepend=time_s[0]).tolist()
    return np.concatenate([state.advance(step, force) for step, force in zip(steps, force_n[:, None], strict=True)])


class ElementRow:
    """Reduced modulus E_long + E_arm exp(-t / tau), MPa; a profile of the power law a = R (..F)^n."""

    def __init__(
        self, long_mpa: float, arm_mpa: float, tau_s: float, *, exponent: float, widest_mm: float, count: int = 1500
    ) -> None:
        self.long_mpa, self.arm_mpa, self.tau_s = long_mpa, arm_mpa, tau_s
        self._dx = widest_mm / count
        self.x_mm = (np.arange(count) + 0.5) * self._dx
        self._coefficient = 40 / 3 / (1 - exponent) / 20 ** (1 / exponent - 1)
        self._power = 1 / exponent - 1
        self.profile_mm = self._coefficient * self.x_mm**self._power
        self.depth_mm, self._u, self._arm, self._touching = 0.0, np.zeros(count), np.zeros(count), np.zeros(count, bool)

    def radius_mm(self, depth_mm: float) -> float:
        """During first loading the edge is where the profile is as deep."""
        return float((depth_mm / self._coefficient) ** (1 / self._power))

    def after(self, step_s: float, depth_mm: float) -> tuple[float, Floats, Floats, NDArray[np.bool_]]:
        """Force on the row, N, with deformations, arms and contact of its elements, ``step_s`` later."""
        u = np.maximum(depth_mm - self.profile_mm, 0.0)
        left = math.exp(-step_s / self.tau_s)
        # an element that comes into contact within the step is deformed for the last part of it only
        rate = (u - self._u) / step_s
        fresh = (self._u == 0) & (u > 0)
        since = np.where(fresh, u / max((depth_mm - self.depth_mm) / step_s, 1e-300), step_s)
        rate = np.where(fresh, (depth_mm - self.depth_mm) / step_s, rate)
        grown = self.arm_mpa * rate * self.tau_s * -np.expm1(-since / self.tau_s)
        arm = np.where(fresh, 0.0, left * self._arm) + grown
        force = self.long_mpa * u + arm
        touching = (u > 0) & (force > 0)
        return 2 * self._dx * float(force[touching].sum()), u, arm, touching

    def advance(self, step_s: float, depth_mm: float) -> float:
        force_n, self._u, self._arm, self._touching = self.after(step_s, depth_mm)
        self.depth_mm = depth_mm
        return force_n

    def edge_mm(self) -> float:
        """Outermost element in contact."""
        return float(self.x_mm[self._touching].max(initial=0.0))

    def depth_for(self, step_s: float, force_n: float, guess_mm: float) -> float:
        """Depth at which the row will carry that force, by secants."""
        before, now = self.depth_mm, guess_mm
        at_before, at_now = (self.after(step_s, each)[0] - force_n for each in (before, now))
        for _ in range(50):
            if at_now == at_before:
                break
            before, now, at_before = now, now - at_now * (now - before) / (at_now - at_before), at_now
            at_now = self.after(step_s, now)[0] - force_n
            if abs(now - before) < 1e-12:
                break
        return now
