"""How far skin that sticks goes along with a contact that is pulled along the surface."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.dome.view import OUTER_RADIUS_MM, PinsAroundAxis

Array = NDArray[np.float64]


def share_pulled(from_middle: Any, edge: Any, clamp: Any) -> Array:
    """Share of a contact's sideways way that the skin at a distance from its middle goes along.

    Skin that sticks goes along from when it touched, and by (2/pi) asin(a/r) before, as an elastic half-space about a
    sheared disc of radius a (Johnson 1985, section 3.7). The way grows like a^3, as the depth does where a grows like
    the force^(1/4); integrated over the growth that is 1 - 4 x^3 / (3 pi) inside, with x the distance over the radius.
    Outside it falls off in proportion to what is left of the way to where the skin is clamped.

    from_middle, edge, clamp : distances of one unit, of shapes that broadcast.
    """
    left = np.clip((clamp - from_middle) / np.maximum(clamp - edge, 1e-9), 0.0, 1.0)
    depth = np.asarray(from_middle / np.maximum(edge, 1e-12))
    inside, x = np.minimum(depth, 1.0), np.maximum(depth, 1.0)
    missed = (2 * x**3 - (2 * x**2 + 1) * np.sqrt(x**2 - 1)) / 3
    outside = (2 / np.pi) * (np.arcsin(1 / x) - missed) * left
    return np.asarray(np.where(depth > 1, outside, 1 - 4 * inside**3 / (3 * np.pi)))


def pulled_px(around: PinsAroundAxis, n_pins: int, radius_mm: Array, clamp_mm: float) -> Array:
    """(A, R, 2, N, 2) px by which pins move, without the common shift, where a contact of each radius (R,) about each
    of A axes is pulled along the surface by 1 mm, in either direction.

    around : N pins about one axis after the other. clamp_mm : arc from the middle to where the skin is held.
    The pull of a sheared disc is that of Johnson (1985), section 3.7.
    """
    view = around.view
    axes = np.broadcast_to(around.axis, around.directions.shape)[::n_pins]
    arc_mm = around.arc_mm.reshape(-1, 1, n_pins)
    tips = view.tip_radius_mm * around.directions.reshape(-1, 1, n_pins, 3)
    away = tips[..., 2:] + view.behind_mm
    across = np.linalg.svd(axes[:, None])[2][:, 1:, None]  # (A, 2, 1, 3)
    moves = view.focal_px * (across[..., :2] - tips[..., :2] * across[..., 2:] / away) / away
    edge_mm = view.inner_radius_mm * np.arcsin(np.clip(radius_mm / OUTER_RADIUS_MM, 0.0, 1.0))[:, None]
    share = share_pulled(arc_mm, edge_mm, clamp_mm)
    pulled = share[:, :, None, :, None] * moves[:, None]
    return np.asarray(pulled - pulled.mean(axis=3, keepdims=True))
