"""Where points of the skin go: pins lever outward at first contact, then the contact stretches the skin along rays."""

from __future__ import annotations

import numpy as np

from emg2vsa.worlds.tactile.region import ContactEllipse, Points, Rim, rim_distance


def lever(rest_px: Points, contact: ContactEllipse, rim: Rim, ratio: float) -> Points:
    """Pin tips where the dome is flattened over ``contact``.

    A pin of length ``ratio`` R stands square on the skin, so its tip goes outward by ``ratio`` R times the change of
    slope of the surface: r/R inside the contact, (2/(pi R)) (r asin(a/r) - a sqrt(1 - a^2/r^2)) outside (Hertz; Johnson
    1985, section 3.4), with r on the skin. At rest tips lean inward and show r (1 - ratio); inside the contact they are
    parallel and show r itself. Outside the displacement also fades, to nothing at the rim.

    Parameters
    ----------
    rest_px : (N, 2) tips at rest.

    Returns
    -------
    (N, 2) tips in contact.
    """
    from_centre = np.asarray(rest_px) - contact.centre_px
    depth = contact.depth(rest_px) / (1 - ratio)
    outside = depth > 1
    inverse = 1 / np.where(outside, depth, 1.0)
    levelled = (2 / np.pi) * (np.arcsin(inverse) - inverse * np.sqrt(1 - inverse**2))
    distance = np.hypot(from_centre[..., 0], from_centre[..., 1])
    rim_px = rim_distance(from_centre, contact, rim)
    fade = np.clip((rim_px - distance) / (rim_px - distance * inverse), 0.0, 1.0)
    gain = np.where(outside, levelled * fade, 1.0) * ratio / (1 - ratio)
    return np.asarray(rest_px + from_centre * gain[..., None])


def spread(points_px: Points, before: ContactEllipse, after: ContactEllipse, rim: Rim) -> Points:
    """Points of the skin after the contact, a piece of skin, grew from ``before`` to ``after``.

    Along each ray from the centre, with b the edge before, s b the edge after and m the rim, a distance rho becomes
    s rho inside. Outside, the skin between edge and rim is squeezed evenly, m - rho' = (m - rho) (m - s b) / (m - b),
    and the rim rests. Maps compose exactly, and the inverse is the map with the contacts exchanged. (A squeeze of equal
    areas, m^2 - rho^2 in place of m - rho, crowds pins just outside the edge until they merge.)

    Parameters
    ----------
    points_px : (..., 2) points; those at or beyond the rim stay.
    before, after : contacts of one centre and one shape, inside the rim.
    """
    stretch = after.semi_axes_px[0] / before.semi_axes_px[0]
    from_centre = np.asarray(points_px, dtype=np.float64) - before.centre_px
    depth = before.depth(points_px)
    outside = depth > 1
    distance = np.where(outside, np.hypot(from_centre[..., 0], from_centre[..., 1]), 1.0)
    edge = distance / np.where(outside, depth, 1.0)
    rim_px = rim_distance(from_centre, before, rim)
    moved = rim_px - (rim_px - distance) * (rim_px - stretch * edge) / (rim_px - edge)
    gain = np.where(outside, np.where(distance < rim_px, moved / distance, 1.0), stretch)
    return np.asarray(before.centre_px + from_centre * gain[..., None])


def sheared(depth: Points, left: Points) -> Points:
    """Share of a contact's sideways way that the skin at a distance from its middle goes along.

    Skin that sticks goes along from when it touched, and by (2/pi) asin(a/r) before, as an elastic half-space about a
    sheared disc of radius a (Johnson 1985, section 3.7). The way grows like a^3, as the depth does where a grows like
    the force^(1/4); integrated over the growth that is 1 - 4 x^3 / (3 pi) inside, with x the distance over the radius.

    Parameters
    ----------
    depth : (N,) x. left : (N,) what is left of the way from the contact's edge to where the skin is clamped; the skin
        goes along by so much less.
    """
    inside, x = np.minimum(depth, 1.0), np.maximum(depth, 1.0)
    missed = (2 * x**3 - (2 * x**2 + 1) * np.sqrt(x**2 - 1)) / 3
    outside = (2 / np.pi) * (np.arcsin(1 / x) - missed) * np.clip(left, 0.0, 1.0)
    return np.asarray(np.where(depth > 1, outside, 1 - 4 * inside**3 / (3 * np.pi)))


def true_divergence(before: ContactEllipse, after: ContactEllipse) -> float:
    """Divergence of ``spread`` less identity everywhere inside ``before``: 2 (s - 1), per frame pair."""
    return 2 * (after.semi_axes_px[0] / before.semi_axes_px[0] - 1)
