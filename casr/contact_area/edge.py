"""The contact edge as the fold in the field of pin displacements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.contact_area.skin_shapes import edges_away, skin_shapes

Array = NDArray[np.float64]
Points = NDArray[np.complex128]

START_PITCHES = (1.2, 1.7, 2.4, 3.4)
STEPS = np.array([0.02, 0.02, 1e-3, 1e-3, 1e-3, 1e-3])  # of the numerical derivatives, px or 1
REACH = np.array([10.0, 10.0, 0.3, 0.2, 0.2, 0.4])  # of one iteration
MAX_ITERATIONS = 30
ENOUGH, ENOUGH_TO_CHOOSE = 1e-5, 1e-2  # relative gain of an iteration, below which it was the last
TRIAL_DAMPINGS = 5.0 ** np.arange(4)
HUBER_LIMIT = 3.0  # median distances
NEAR_EDGES = 2.0  # from there on outward pins count less: what the skin does there says little of the edge


@dataclass(frozen=True)
class ContactEdge:
    """Elliptic contact edge in the rest frame.

    Parameters
    ----------
    centre_px : (2,) centre.
    a_px, b_px, turn_deg : semi-axis along the direction ``turn_deg`` (from x towards y), and across it.
    stretch : displacement over distance from the centre inside the edge.
    shift_px : (2,) by which all pins moved alike, those at the rim too; the displacement of the centre.
    area_error : relative standard error of the area.
    explained : share of the squared displacement, without the shift, that the model explains.
    """

    centre_px: Array
    a_px: float
    b_px: float
    turn_deg: float
    stretch: float
    shift_px: Array
    area_error: float
    explained: float


def fit_edge(rest_px: Array, displacement_px: Array, pitch_px: float) -> ContactEdge:
    """Least-squares edge of the contact.

    The displacement is a common shift, a bending and a stretching of the skin around an ellipse (``skin_shapes``), none
    of the two negative. Those strengths are linear and eliminated. Left are six parameters, by Levenberg-Marquardt:
    centre, size and ellipse of the contact, and the radius of the rim that holds the skin; the rim lies around the
    middle of the pins, and the search begins with one row beyond the outermost. Several sizes start, as the cost has a
    dent wherever the edge crosses a pin.

    Parameters
    ----------
    rest_px, displacement_px : (N, 2) of all pins, moved or not.
    pitch_px : pin pitch.
    """
    rest, displacement = (points[:, 0] + 1j * points[:, 1] for points in (rest_px, displacement_px))
    middle = rest.mean()
    rim = np.log(np.abs(rest - middle).max() + pitch_px)
    moved = np.abs(displacement) ** 3
    centre = moved @ rest / moved.sum()
    field = _Field(rest, displacement, middle, np.ones(rest.size))
    starts = [np.array([centre.real, centre.imag, np.log(n * pitch_px), 0.0, 0.0, rim]) for n in START_PITCHES]
    best = min((field.minimised(start, ENOUGH_TO_CHOOSE) for start in starts), key=field.cost)
    for _ in range(2):
        field = field.trusting(best)
        best = field.minimised(best)
    return field.edge(best)


class _Field:
    """Displacements and their model; parameters p = (x, y, log size, two of the ellipse, log rim radius)."""

    def __init__(self, rest: Points, displacement: Points, middle: complex, trust: Array) -> None:
        self.rest, self.displacement, self.middle, self.trust = rest, displacement, middle, trust
        self._root, self._share = np.sqrt(trust), trust / trust.sum()
        self._target = self._unshifted(displacement)

    def _unshifted(self, points: Points) -> Array:
        """(..., 2N) what no common shift explains, times the root of the trust."""
        left = (points - (points @ self._share)[..., None]) * self._root
        return np.asarray(left.view(np.float64))

    def _shapes(self, p: Array) -> tuple[Points, Points]:
        centre, ellipse = p[:, :1] + 1j * p[:, 1:2], p[:, 3:4] + 1j * p[:, 4:5]
        away = self.rest - centre
        return skin_shapes(away, edges_away(away, p[:, 2:3], ellipse), self.middle - centre, np.exp(p[:, 5:6]))

    def residuals(self, p: Array) -> tuple[Array, Array]:
        """(P, 2N) residuals and (P, 2) strengths of bending and stretching, of (P, 6) parameters."""
        bent, stretched = shapes = [self._unshifted(shape) for shape in self._shapes(p)]
        bb, bs, ss = ((a * b).sum(axis=-1) for a, b in ((bent, bent), (bent, stretched), (stretched, stretched)))
        bd, sd = (shape @ self._target for shape in shapes)
        spread = np.maximum(bb * ss - bs**2, 1e-12 * bb * ss)
        bending, stretching = (ss * bd - bs * sd) / spread, (bb * sd - bs * bd) / spread
        # where one comes out negative the other does without it
        bending, stretching = np.where(stretching < 0, bd / bb, bending), np.where(bending < 0, sd / ss, stretching)
        strengths = np.maximum(np.stack([bending, stretching], axis=-1), 0.0)
        return self._target - strengths[:, :1] * bent - strengths[:, 1:] * stretched, strengths

    def trusting(self, p: Array) -> _Field:
        """The same field with less trust in pins far from the contact or far off the model."""
        off = np.abs(self.residuals(p[None])[0][0].view(np.complex128)) / self._root
        limit = HUBER_LIMIT * max(float(np.median(off)), 1e-9)
        edges = np.abs(self.rest - (p[0] + 1j * p[1])) / np.exp(p[2])
        trust = np.minimum(1.0, limit / np.maximum(off, 1e-12)) / (1 + (edges / NEAR_EDGES) ** 6)
        return _Field(self.rest, self.displacement, self.middle, trust)

    def cost(self, p: Array) -> float:
        return float((self.residuals(p[None])[0] ** 2).sum())

    def derivatives(self, p: Array) -> Array:
        """(2N, 6) Jacobian of the residuals."""
        ahead, behind = self.residuals(np.concatenate([p + np.diag(STEPS), p - np.diag(STEPS)]))[0].reshape(2, 6, -1)
        return np.asarray(((ahead - behind) / (2 * STEPS[:, None])).T)

    def minimised(self, p: Array, enough: float = ENOUGH) -> Array:
        damping, errors = 1e-2, self.residuals(p[None])[0][0]
        cost = float(errors @ errors)
        for _ in range(MAX_ITERATIONS):
            jacobian = self.derivatives(p)
            normal, gradient = jacobian.T @ jacobian, jacobian.T @ errors
            dampings = damping * TRIAL_DAMPINGS
            ridge = (np.diag(normal) + 1e-9) * np.eye(6) * dampings[:, None, None]
            steps = np.linalg.solve(normal + ridge, np.broadcast_to(gradient[:, None], (dampings.size, 6, 1)))[..., 0]
            trials = p - np.clip(steps, -REACH, REACH)
            trial_errors = self.residuals(trials)[0]
            costs = (trial_errors**2).sum(axis=-1)
            chosen = int(np.argmin(costs))
            gain = cost - float(costs[chosen])
            if gain <= 0:
                break
            p, errors, cost, damping = trials[chosen], trial_errors[chosen], float(costs[chosen]), dampings[chosen] / 10
            damping = max(damping, 1e-9)
            if gain < enough * cost:
                break
        return p

    def edge(self, p: Array) -> ContactEdge:
        jacobian = self.derivatives(p)
        errors, strengths = self.residuals(p[None])
        cost = float((errors**2).sum())
        covariance = np.linalg.pinv(jacobian.T @ jacobian) * cost / (errors.size - 10)
        size, oblong = float(np.exp(p[2])), float(np.hypot(p[3], p[4]))
        bent, stretched = (shape[0] for shape in self._shapes(p[None]))
        shift = (self.displacement - strengths[0, 0] * bent - strengths[0, 1] * stretched) @ self._share
        return ContactEdge(
            centre_px=p[:2],
            a_px=size * float(np.exp(-oblong)),
            b_px=size * float(np.exp(oblong)),
            turn_deg=float(np.rad2deg(np.arctan2(p[4], p[3]) / 2)),
            stretch=float(strengths.sum()),
            shift_px=np.array([shift.real, shift.imag]),
            area_error=2 * float(np.sqrt(covariance[2, 2])),
            explained=1 - cost / float((self._target**2).sum()),
        )
