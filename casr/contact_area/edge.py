"""The contact edge as the fold in the field of pin displacements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

START_PITCHES = (1.2, 1.6, 2.0, 2.6, 3.4)
STEPS = np.array([0.02, 0.02, 1e-3, 1e-3, 1e-3, 1e-3])  # of the numerical derivatives, px or 1
REACH = np.array([10.0, 10.0, 0.3, 0.2, 0.2, 0.4])  # of one iteration
MAX_ITERATIONS = 30
TRIAL_DAMPINGS = 5.0 ** np.arange(4)
HUBER_LIMIT = 3.0  # median distances
NEAR_EDGES = 2.0  # from there on outward pins count less: far from the contact the skin follows its rim


@dataclass(frozen=True)
class ContactEdge:
    """Elliptic contact edge in the rest frame.

    Parameters
    ----------
    centre_px : (2,) centre.
    a_px, b_px, turn_deg : semi-axis along the direction ``turn_deg`` (from x towards y), and across it.
    stretch : displacement over distance from the centre inside the edge.
    area_error : relative standard error of the area.
    explained : share of the squared displacement the model explains.
    """

    centre_px: Array
    a_px: float
    b_px: float
    turn_deg: float
    stretch: float
    area_error: float
    explained: float


def fit_edge(rest_px: Array, displacement_px: Array, pitch_px: float) -> ContactEdge:
    """Least-squares edge of the contact.

    A pin is a lever on the skin: its tip moves by pin length times the change of slope under it. Inside the contact the
    dome is flattened, so the displacement grows linearly with the distance from the centre; outside it falls. For a
    half-space the outside is (2/pi) (asin(1/q) - sqrt(1 - 1/q^2)/q) of the linear growth, q the distance in edges
    (Hertz; Johnson 1985, section 3.4); a shell filled with gel falls off more slowly, so that factor carries a free
    exponent. Six shape parameters (centre, size, ellipse, exponent) by Levenberg-Marquardt; the amplitude is linear
    and eliminated. Several sizes start, as the cost has a dent wherever the edge crosses a pin.

    Parameters
    ----------
    rest_px, displacement_px : (N, 2) of all pins, moved or not.
    pitch_px : pin pitch.
    """
    moved = (displacement_px**2).sum(axis=1)
    centre = moved**1.5 @ rest_px / (moved**1.5).sum()
    field = _Field(rest_px, displacement_px, np.ones(len(rest_px)))
    starts = [np.array([*centre, np.log(pitches * pitch_px), 0.0, 0.0, 0.0]) for pitches in START_PITCHES]
    best = min((field.minimised(start) for start in starts), key=field.cost)
    for _ in range(2):
        field = field.trusting(best)
        best = field.minimised(best)
    return field.edge(best)


class _Field:
    """Displacements and their model; parameters p = (x, y, log size, two of the ellipse, log exponent)."""

    def __init__(self, rest_px: Array, displacement_px: Array, trust: Array) -> None:
        self.rest, self.displacement, self.trust = rest_px, displacement_px, trust

    def residuals(self, p: Array) -> tuple[Array, Array]:
        """(P, N, 2) residuals times the root of the trust, and (P,) amplitudes, of (P, 6) parameters."""
        x, y = (self.rest - p[:, None, :2]).transpose(2, 0, 1)
        s = np.hypot(p[:, 3], p[:, 4])
        grow = np.where(s > 1e-9, np.sinh(s) / np.maximum(s, 1e-9), 1.0)
        diagonal, skew, across = (v[:, None] for v in (np.cosh(s), grow * p[:, 3], grow * p[:, 4]))
        edges = np.hypot((diagonal + skew) * x + across * y, across * x + (diagonal - skew) * y) / np.exp(p[:, 2:3])
        inverse = 1 / np.maximum(edges, 1.0)
        fall = (2 / np.pi) * (np.arcsin(inverse) - inverse * np.sqrt(1 - inverse**2))
        shape = np.stack([x, y], axis=-1) * (fall ** np.exp(p[:, 5:6]))[..., None]
        weighted = shape * self.trust[:, None]
        amplitude = (weighted * self.displacement).sum(axis=(1, 2)) / (weighted * shape).sum(axis=(1, 2))
        error = self.displacement - amplitude[:, None, None] * shape
        return error * np.sqrt(self.trust)[:, None], amplitude

    def trusting(self, p: Array) -> _Field:
        """The same field with less trust in pins far from the contact or far off the model."""
        off = np.hypot(*(self.residuals(p[None])[0][0] / np.sqrt(self.trust)[:, None]).T)
        limit = HUBER_LIMIT * max(float(np.median(off)), 1e-9)
        edges = np.hypot(*(self.rest - p[:2]).T) / np.exp(p[2])
        trust = np.minimum(1.0, limit / np.maximum(off, 1e-12)) / (1 + (edges / NEAR_EDGES) ** 6)
        return _Field(self.rest, self.displacement, trust)

    def cost(self, p: Array) -> float:
        return float((self.residuals(p[None])[0] ** 2).sum())

    def derivatives(self, p: Array) -> Array:
        """(2N, 6) Jacobian of the residuals."""
        ahead, behind = self.residuals(np.concatenate([p + np.diag(STEPS), p - np.diag(STEPS)]))[0].reshape(2, 6, -1)
        return np.asarray(((ahead - behind) / (2 * STEPS[:, None])).T)

    def minimised(self, p: Array) -> Array:
        damping, cost = 1e-2, self.cost(p)
        for _ in range(MAX_ITERATIONS):
            jacobian = self.derivatives(p)
            normal, gradient = jacobian.T @ jacobian, jacobian.T @ self.residuals(p[None])[0].ravel()
            dampings = damping * TRIAL_DAMPINGS
            ridge = (np.diag(normal) + 1e-9) * np.eye(6) * dampings[:, None, None]
            steps = np.linalg.solve(normal + ridge, np.broadcast_to(gradient[:, None], (dampings.size, 6, 1)))[..., 0]
            trials = p - np.clip(steps, -REACH, REACH)
            costs = (self.residuals(trials)[0] ** 2).sum(axis=(1, 2))
            chosen = int(np.argmin(costs))
            gain = cost - float(costs[chosen])
            if gain <= 0:
                break
            p, cost, damping = trials[chosen], float(costs[chosen]), max(dampings[chosen] / 10, 1e-9)
            if gain < 1e-5 * cost:
                break
        return p

    def edge(self, p: Array) -> ContactEdge:
        jacobian = self.derivatives(p)
        errors, amplitude = self.residuals(p[None])
        cost = float((errors**2).sum())
        covariance = np.linalg.pinv(jacobian.T @ jacobian) * cost / (errors.size - 7)
        size, s = float(np.exp(p[2])), float(np.hypot(p[3], p[4]))
        return ContactEdge(
            centre_px=p[:2],
            a_px=size * float(np.exp(-s)),
            b_px=size * float(np.exp(s)),
            turn_deg=float(np.rad2deg(np.arctan2(p[4], p[3]) / 2)),
            stretch=float(amplitude[0]),
            area_error=2 * float(np.sqrt(covariance[2, 2])),
            explained=1 - cost / float((self.trust[:, None] * self.displacement**2).sum()),
        )
