"""The initial area A_c0.

Figure 8: by specimen at each angle, and by angle. Figure 9: the frame of first contact at each angle, with the pins in
contact and the area that follows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from casr.overlays.area import hexagons
from emg2vsa.arrays import Floats
from emg2vsa.figures.boxes import PairBar, draw_bars, draw_box
from emg2vsa.figures.canvas import panel_grid
from emg2vsa.figures.palette import GREY, SKY, Look
from emg2vsa.runs import ContactPicture

POOLED = Look(GREY, "o", "-")
"""All specimens of an angle together."""


@dataclass(frozen=True)
class AreaPanel:
    """One panel: ``values`` (n,) of each group, their names and looks, and bars between them."""

    title: str
    names: Sequence[str]
    values: Sequence[Floats]
    looks: Sequence[Look]
    bars: Sequence[PairBar]


def draw_areas(by_specimen: Sequence[AreaPanel], by_angle: AreaPanel | None, unit: str) -> Figure:
    """The panels of the angles share one scale, from zero, with that of all angles; ``unit`` of the area."""
    panels = [*by_specimen, *([by_angle] if by_angle else [])]
    figure, (row,) = panel_grid(1, [1] * len(panels), 50, (13, 2, 11, 6), (11, 0))
    top = max((float(np.nanmax(v)) for panel in panels for v in panel.values if np.isfinite(v).any()), default=1.0)
    for axes, panel in zip(row, panels, strict=True):
        for place, (values, look) in enumerate(zip(panel.values, panel.looks, strict=True)):
            draw_box(axes, place, values, look)
        axes.set_ylim(0, 1.05 * top)
        draw_bars(axes, panel.bars, "")
        _named(axes, panel)
    row[0].set_ylabel(f"Initial area A$_{{c0}}$ ({unit})")
    highest = max(axes.get_ylim()[1] for axes in row)
    for axes in row:
        axes.set_ylim(0, highest)
    return figure


def _named(axes: Axes, panel: AreaPanel) -> None:
    axes.set_xticks(range(len(panel.names)), list(panel.names))
    axes.set_xlim(-0.6, len(panel.names) - 0.4)
    axes.set_title(panel.title, loc="center")
    axes.grid(axis="x", visible=False)


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
