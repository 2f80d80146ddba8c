"""Where points of the skin go: pins lever outward at first contact, then the contact stretches the skin along rays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.synthetic.region import ContactEllipse, Points, Rim, rim_distance_sq


def lever(rest_px: Points, contact: ContactEllipse, rim: Rim, ratio: float) -> Points:
    """Pin tips where the dome is flattened over ``contact``.

    A pin of length ``ratio`` R stands square on the skin, so its tip is displaced outward by ``ratio`` R times the change
    of slope of the surface: r/R inside the contact, (2/(pi R)) (r asin(a/r) - a sqrt(1 - a^2/r^2)) outside (Hertz; Johnson
    1985, section 3.4), with r on the skin. At rest tips lean inward and show r (1 - ratio); inside the contact they are
    parallel and show r itself. Outside the displacement fades to nothing at the rim.

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
    distance_sq = (from_centre**2).sum(axis=-1)
    edge_sq = distance_sq * inverse**2
    rim_sq = rim_distance_sq(from_centre, contact, rim)
    fade = np.clip((rim_sq - distance_sq) / (rim_sq - edge_sq), 0.0, 1.0)
    gain = np.where(outside, levelled * fade, 1.0) * ratio / (1 - ratio)
    return np.asarray(rest_px + from_centre * gain[..., None])


def spread(points_px: Points, before: ContactEllipse, after: ContactEllipse, rim: Rim) -> Points:
    """Points of the skin after the contact, a piece of skin, grew from ``before`` to ``after``.

    Along each ray from the centre the distance rho becomes s rho inside, with s the ratio of the semi-axes, and
    rho'^2 = m^2 - (m^2 - rho^2) (m^2 - b'^2) / (m^2 - b^2) outside, with b, b' the edge before and after and m the rim,
    which rests. Maps compose exactly and the inverse is the map with the contacts exchanged.

    Parameters
    ----------
    points_px : (..., 2) points; those at or beyond the rim stay.
    before, after : contacts of one centre and one shape.
    """
    stretch = after.semi_axes_px[0] / before.semi_axes_px[0]
    from_centre = np.asarray(points_px, dtype=np.float64) - before.centre_px
    depth = before.depth(points_px)
    outside = depth > 1
    distance_sq = np.where(outside, (from_centre**2).sum(axis=-1), 1.0)
    edge_sq = distance_sq / np.where(outside, depth, 1.0) ** 2
    rim_sq = rim_distance_sq(from_centre, before, rim)
    room = (rim_sq - stretch**2 * edge_sq) / (rim_sq - edge_sq)
    moved_sq = rim_sq - np.maximum(rim_sq - distance_sq, 0.0) * room
    gain = np.where(outside, np.sqrt(np.maximum(moved_sq / distance_sq, 0.0)), stretch)
    gain = np.where(outside & (distance_sq >= rim_sq), 1.0, gain)
    return np.asarray(before.centre_px + from_centre * gain[..., None])


def true_flow(before: ContactEllipse, after: ContactEllipse, rim: Rim, shape: tuple[int, int]) -> NDArray[np.float32]:
    """(H, W, 2) displacement of the skin seen in each pixel of the first frame, px; 0 beyond the rim."""
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    grid = np.stack([columns, rows], axis=-1).astype(np.float64)
    return (spread(grid, before, after, rim) - grid).astype(np.float32)


def true_divergence(before: ContactEllipse, after: ContactEllipse) -> float:
    """Divergence of ``true_flow`` everywhere inside ``before``: 2 (s - 1), per frame pair."""
    return 2 * (after.semi_axes_px[0] / before.semi_axes_px[0] - 1)
