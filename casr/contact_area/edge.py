"""The contact edge as the fold in the field of pin displacements: the skin that explains them, and its fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.contact_area.motion import PinMotion
from casr.flow.region import Region
from casr.median import median

Array = NDArray[np.float64]
Points = NDArray[np.complex128]

NEAREST_RIM = 1.02  # edges; the contact stays inside the rim


def _edges_away(from_centre: Points, log_size: Array, ellipse: Points) -> Array:
    """Distance from the centre over that of the contact's edge in the same direction, 1 on the edge.

    from_centre : points x + iy. log_size : logarithm of the geometric mean of the semi-axes.
    ellipse : its size is the logarithm of that mean over the smaller semi-axis, which lies along half its angle.
    """
    oblong = np.abs(ellipse)
    turned = np.sinh(oblong) / np.maximum(oblong, 1e-12) * ellipse
    return np.asarray(np.abs(np.cosh(oblong) * from_centre + turned * from_centre.conj()) / np.exp(log_size))


def _skin_shapes(from_centre: Points, edges: Array, rim_centre: Points, rim_radius: Array) -> Points:
    """Displacements (2, ...) of unit growth inside the contact: of a skin that bends, and of one that stretches.

    *Bending.* A pin is a lever on the skin, its tip moves by pin length times the change of slope under it. Inside the
    contact the dome is flattened, which is linear in the distance from the centre; outside, a half-space leaves
    (2/pi) (asin(1/q) - sqrt(1 - 1/q^2)/q) of the linear growth, q being the distance in edges (Hertz; Johnson 1985,
    section 3.4).

    *Stretching.* A contact that sticks and spreads takes its skin along; the skin outside is held at its rim and gives
    way evenly, so that the displacement falls from the edge to nothing at the rim along a straight line.

    from_centre : pins x + iy at rest, from the contact's centre. edges : of ``edges_away``.
    rim_centre, rim_radius : circle that holds the skin; the centre from the contact's centre.
    """
    inward = 1 / np.maximum(edges, 1.0)
    bending = (2 / np.pi) * (np.arcsin(inward) - inward * np.sqrt(1 - inward**2))
    distance = np.maximum(np.abs(from_centre), 1e-9)
    along = (rim_centre.conj() * from_centre).real / distance
    rim = np.sqrt(np.maximum(along**2 + rim_radius**2 - np.abs(rim_centre) ** 2, 0.0)) + along
    rim = np.maximum(rim, NEAREST_RIM * distance * inward)
    stretching = inward * np.minimum(np.maximum((rim - distance) / (rim - distance * inward), 0.0), 1.0)
    return np.asarray(from_centre * np.stack([bending, np.where(edges > 1, stretching, 1.0)]))


STEPS = np.array([0.02, 0.02, 1e-3, 1e-3, 1e-3, 1e-3])  # of the numerical derivatives, px or 1
_BESIDE = np.concatenate([np.diag(STEPS), -np.diag(STEPS)])
REACH = np.array([10.0, 10.0, 0.3, 0.2, 0.2, 0.4])  # of one iteration
MAX_ITERATIONS = 30
ENOUGH = 1e-5  # relative gain of an iteration, below which it was the last
TRIAL_DAMPINGS = 5.0 ** np.arange(4)
HUBER_LIMIT = 3.0  # median distances
NEAR_EDGES = 2.0  # from there on outward pins count less: what the skin does there says little of the edge
LINEAR = 4  # two strengths and the two of the shift


class DisplacementField:
    """Displacements and their model; parameters p = (x, y, log size, two of the ellipse, log rim radius)."""

    def __init__(self, rest: Points, displacement: Points, middle: complex, trust: Array) -> None:
        self.rest, self.displacement, self.middle, self.trust = rest, displacement, middle, trust
        self._root, self._share = np.sqrt(trust), trust / trust.sum()
        self._target = self._unshifted(displacement)

    def _unshifted(self, points: Points) -> Array:
        """(..., 2N) what no common shift explains, times the root of the trust."""
        left = (points - (points @ self._share)[..., None]) * self._root
        return np.asarray(left.view(np.float64))

    def _shapes(self, p: Array) -> Points:
        centre, ellipse = p[..., :1] + 1j * p[..., 1:2], p[..., 3:4] + 1j * p[..., 4:5]
        away = self.rest - centre
        return _skin_shapes(away, _edges_away(away, p[..., 2:3], ellipse), self.middle - centre, np.exp(p[..., 5:6]))

    def residuals(self, p: Array) -> tuple[Array, Array]:
        """(..., 2N) residuals and (..., 2) strengths of bending and stretching, of (..., 6) parameters. The contact
        bends its skin as in Johnson (1985), section 3.4."""
        bent, stretched = shapes = self._unshifted(self._shapes(p))
        (bb, ss), bs = (shapes * shapes).sum(axis=-1), (bent * stretched).sum(axis=-1)
        bd, sd = shapes @ self._target
        spread = np.maximum(bb * ss - bs**2, 1e-12 * bb * ss)
        bending, stretching = (ss * bd - bs * sd) / spread, (bb * sd - bs * bd) / spread
        # where one comes out negative the other does without it
        bending, stretching = np.where(stretching < 0, bd / bb, bending), np.where(bending < 0, sd / ss, stretching)
        strengths = np.maximum(np.stack([bending, stretching], axis=-1), 0.0)
        return self._target - strengths[..., :1] * bent - strengths[..., 1:] * stretched, strengths

    def trusting(self, p: Array) -> DisplacementField:
        """The same field with less trust in pins far from the contact p (6,) or far off the model (weights of Huber
        1981)."""
        off = np.abs(self.residuals(p[None])[0][0].view(np.complex128)) / self._root
        limit = HUBER_LIMIT * max(float(median(off)), 1e-9)
        edges = np.abs(self.rest - (p[0] + 1j * p[1])) / np.exp(p[2])
        trust = np.minimum(1.0, limit / np.maximum(off, 1e-12)) / (1 + (edges / NEAR_EDGES) ** 6)
        return DisplacementField(self.rest, self.displacement, self.middle, trust)

    def cost(self, p: Array) -> float:
        """Sum of squared residuals at parameters (6,), px2 times trust."""
        return float((self.residuals(p[None])[0] ** 2).sum())

    def derivatives(self, p: Array) -> Array:
        """(K, 6, 2N) of the residuals by the parameters (K, 6)."""
        around = p[:, None] + _BESIDE
        ahead, behind = np.split(self.residuals(around)[0], 2, axis=1)
        return np.asarray((ahead - behind) / (2 * STEPS[:, None]))

    def lowest(self, starts: list[Array], enough: float = ENOUGH) -> Array:
        """The best (6,) of the minima that these starts (6,) lead to."""
        return min(self.minimised(np.array(starts), enough), key=self.cost)

    def minimised(self, p: Array, enough: float) -> Array:
        """(K, 6) where Levenberg-Marquardt (Marquardt 1963) leads to from (K, 6), each for itself but all at once."""
        p, damping, going = p.copy(), np.full(len(p), 1e-2), np.arange(len(p))
        errors = self.residuals(p[:, None])[0][:, 0]
        cost = np.array([float(each @ each) for each in errors])
        for _ in range(MAX_ITERATIONS):
            slopes, dampings = self.derivatives(p[going]), damping[going, None] * TRIAL_DAMPINGS
            normal, gradient = slopes @ slopes.transpose(0, 2, 1), slopes @ errors[going, :, None]
            diagonal = np.diagonal(normal, axis1=1, axis2=2) + 1e-9
            ridge = (diagonal[:, None] * np.eye(6))[:, None] * dampings[..., None, None]
            steps = np.linalg.solve(normal[:, None] + ridge, np.repeat(gradient[:, None], TRIAL_DAMPINGS.size, axis=1))
            trials = p[going, None] - np.clip(steps[..., 0], -REACH, REACH)
            trial_errors = self.residuals(trials)[0]
            costs = (trial_errors**2).sum(axis=-1)
            least = np.arange(going.size), np.argmin(costs, axis=1)
            gain = cost[going] - costs[least]
            better = gain > 0
            going, gain, least = going[better], gain[better], tuple(each[better] for each in least)
            p[going], errors[going], cost[going] = trials[least], trial_errors[least], costs[least]
            damping[going] = np.maximum(dampings[least] / 10, 1e-9)
            going = going[gain >= enough * cost[going]]
            if not going.size:
                break
        return p

    def strengths(self, p: Array) -> tuple[Array, complex]:
        """(2,) of bending and stretching, and the common shift x + iy."""
        strengths = self.residuals(p[None])[1][0]
        bent, stretched = self._shapes(p[None])[:, 0]
        left = self.displacement - strengths[0] * bent - strengths[1] * stretched
        return strengths, complex(left @ self._share)

    def standard_errors(self, p: Array) -> Array:
        """(6,) of the parameters."""
        jacobian = self.derivatives(p[None])[0].T
        freedom = self._target.size - p.size - LINEAR
        return np.sqrt(np.diag(np.linalg.pinv(jacobian.T @ jacobian)) * self.cost(p) / freedom)

    def explained(self, p: Array) -> float:
        """Share of the squared displacement that parameters (6,) explain, without the shift."""
        return 1 - self.cost(p) / max(float((self._target**2).sum()), 1e-300)


START_PITCHES = (1.2, 1.8, 2.8)
NEXT_SIZES = (0.0, -0.1, 0.1)  # in log size; the best there is may lie beyond the next dent
LOG_SIZE = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
ENOUGH_TO_CHOOSE = 1e-2


@dataclass(frozen=True)
class ContactEdge:
    """Elliptic contact edge in the rest frame.

    centre_px : (2,) centre.
    a_px, b_px, turn_deg : semi-axis along the direction ``turn_deg`` (from x towards y), and across it.
    stretch : displacement over distance from the centre inside the edge.
    shift_px : (2,) by which all pins moved alike, those at the rim too; the displacement of the centre.
    area_error : relative standard error of the area.
    explained : share of the squared displacement, without the shift, that the model explains.
    parameters : of the fit, to begin another one with.
    """

    centre_px: Array
    a_px: float
    b_px: float
    turn_deg: float
    stretch: float
    shift_px: Array
    area_error: float
    explained: float
    parameters: Array

    def at_contact(self, motion: PinMotion) -> Region:
        """Where it lies in the contact frame."""
        shift = np.median(motion.contact_px - motion.rest_px - motion.displacement_px, axis=0) + self.shift_px
        # inside the edge the rest frame is stretched about the centre, so this is the same piece of skin
        grow = 1 + self.stretch
        x_px, y_px = (self.centre_px + shift).tolist()
        return Region.ellipse(x_px, y_px, self.a_px * grow, self.b_px * grow, turn_deg=self.turn_deg)


def fit_edge(motion: PinMotion, near: ContactEdge | None = None) -> ContactEdge:
    """Least-squares edge of the contact.

    The displacement is a common shift, a bending and a stretching of the skin around an ellipse (`DisplacementField`),
    none of the two negative. Those strengths are linear and eliminated. Left are six parameters, by
    Levenberg-Marquardt: centre, size and ellipse of the contact, and the radius of the rim that holds the skin; the rim
    lies around the middle of the pins, and the search begins with one row beyond the outermost. Several sizes start,
    and the best is tried on both sides, as the cost has a dent wherever the edge crosses a pin.

    motion : of all pins, moved or not. near : edge of a frame close by, to begin with instead of several sizes.
    """
    rest, displacement = (points[:, 0] + 1j * points[:, 1] for points in (motion.rest_px, motion.displacement_px))
    middle, pitch_px = rest.mean(), motion.pitch_px
    rim = np.log(np.abs(rest - middle).max() + pitch_px)
    moved = np.abs(displacement) ** 3
    centre = moved @ rest / moved.sum() if moved.any() else middle
    field = DisplacementField(rest, displacement, middle, np.ones(rest.size))
    if near is None:
        starts = [np.array([centre.real, centre.imag, np.log(n * pitch_px), 0.0, 0.0, rim]) for n in START_PITCHES]
    else:
        starts = [near.parameters]
    best = field.lowest(starts, ENOUGH_TO_CHOOSE)
    for sizes in (NEXT_SIZES, (0.0,)):
        field = field.trusting(best)
        best = field.lowest([best + size * LOG_SIZE for size in sizes])
    return _edge(field, best)


def _edge(field: DisplacementField, p: Array) -> ContactEdge:
    strengths, shift = field.strengths(p)
    size, oblong = float(np.exp(p[2])), float(np.hypot(p[3], p[4]))
    return ContactEdge(
        centre_px=p[:2].copy(), a_px=size * float(np.exp(-oblong)), b_px=size * float(np.exp(oblong)),
        turn_deg=float(np.rad2deg(np.arctan2(p[4], p[3]) / 2)), stretch=float(strengths.sum()),
        shift_px=np.array([shift.real, shift.imag]), area_error=2 * float(field.standard_errors(p)[2]),
        explained=field.explained(p), parameters=p,
    )  # fmt: skip
