"""Figure 9: the frame of first contact at each angle, with the pins in contact and the area that follows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from emg2vsa.arrays import Floats
from emg2vsa.figures.grid import panel_grid
from emg2vsa.figures.palette import SKY
from emg2vsa.runs import ContactPicture

_BRIGHTEST = 255


def draw_contacts(pictures: Sequence[tuple[str, ContactPicture]], unit: str) -> Figure:
    """pictures : title and picture of each panel. Every pin in contact wears the hexagon that it stands for."""
    figure, (row,) = panel_grid(1, [1] * len(pictures), 52, (2, 2, 2, 6), (4, 0))
    for axes, (title, picture) in zip(row, pictures, strict=True):
        axes.imshow(picture.image, cmap="gray", vmin=0, vmax=_BRIGHTEST, interpolation="nearest")
        tiles = PolyCollection(
            list(hexagons(picture.contact_px, picture.pins_px)), facecolors=SKY, alpha=0.45, edgecolors=SKY,
            linewidths=0.8,
        )  # fmt: skip
        axes.add_collection(tiles)
        axes.set_axis_off()
        axes.set_title(f"{title}: {picture.area_mm2:.3g} {unit}", loc="center")
    return figure


def hexagons(at_px: Floats, pins_px: Floats) -> Floats:
    """(M, 6, 2) corners of regular hexagons around ``at_px`` (M, 2) that tile a lattice as wide as ``pins_px`` (N, 2).

    A hexagon's width across is the distance of neighbouring pins (paper, Algorithm 1: r_h cos 30 = half of it).
    """
    if len(pins_px) < 2:
        return np.empty((0, 6, 2))
    distances = np.linalg.norm(pins_px[:, None] - pins_px, axis=2)
    np.fill_diagonal(distances, np.inf)
    step = pins_px[np.argmin(distances, axis=1)] - pins_px
    # the lattice's own direction, folded into one sixth of a turn
    direction = np.angle(np.mean(np.exp(6j * np.arctan2(step[:, 1], step[:, 0])))) / 6
    turn = direction + np.pi / 6 + np.arange(6) * np.pi / 3
    radius = float(np.median(np.min(distances, axis=1))) / np.sqrt(3)
    return np.asarray(at_px[:, None] + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1))
