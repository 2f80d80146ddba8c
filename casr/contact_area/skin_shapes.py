"""How pins move where a contact bends a skin and stretches it: two shapes of unit strength."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Points = NDArray[np.complex128]

NEAREST_RIM = 1.02  # edges; the contact stays inside the rim


def edges_away(from_centre: Points, log_size: Array, ellipse: Points) -> Array:
    """Distance from the centre over that of the contact's edge in the same direction, 1 on the edge.

    Parameters
    ----------
    from_centre : points x + iy.
    log_size : logarithm of the geometric mean of the semi-axes.
    ellipse : its size is the logarithm of that mean over the smaller semi-axis, which lies along half its angle.
    """
    oblong = np.abs(ellipse)
    turned = np.sinh(oblong) / np.maximum(oblong, 1e-12) * ellipse
    return np.asarray(np.abs(np.cosh(oblong) * from_centre + turned * from_centre.conj()) / np.exp(log_size))


def skin_shapes(from_centre: Points, edges: Array, rim_centre: Points, rim_radius: Array) -> tuple[Points, Points]:
    """Displacements of unit growth inside the contact: of a skin that bends, and of one that stretches.

    *Bending.* A pin is a lever on the skin, its tip moves by pin length times the change of slope under it. Inside the
    contact the dome is flattened, which is linear in the distance from the centre; outside, a half-space leaves
    (2/pi) (asin(1/q) - sqrt(1 - 1/q^2)/q) of the linear growth, q being the distance in edges (Hertz; Johnson 1985,
    section 3.4).

    *Stretching.* A contact that sticks and spreads takes its skin along; the skin outside is held at its rim and gives
    way evenly, so that the displacement falls from the edge to nothing at the rim along a straight line.

    Parameters
    ----------
    from_centre : pins x + iy at rest, from the contact's centre. edges : of ``edges_away``.
    rim_centre, rim_radius : circle that holds the skin; the centre from the contact's centre.
    """
    inward = 1 / np.maximum(edges, 1.0)
    bending = (2 / np.pi) * (np.arcsin(inward) - inward * np.sqrt(1 - inward**2))
    distance = np.maximum(np.abs(from_centre), 1e-9)
    along = (rim_centre.conj() * from_centre).real / distance
    rim = np.sqrt(np.maximum(along**2 + rim_radius**2 - np.abs(rim_centre) ** 2, 0.0)) + along
    rim = np.maximum(rim, NEAREST_RIM * distance * inward)
    stretching = inward * np.clip((rim - distance) / (rim - distance * inward), 0.0, 1.0)
    return from_centre * bending, from_centre * np.where(edges > 1, stretching, 1.0)
