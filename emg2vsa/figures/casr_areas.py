"""The initial area A_c0.

Figure 8: by specimen at each angle, and by angle, as differences. Figure 9: the contact at each angle at one force,
with the outline of its area.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from emg2vsa.arrays import Floats
from emg2vsa.figures.boxes import PairBar, draw_bars, draw_box
from emg2vsa.figures.canvas import panel_grid
from emg2vsa.figures.palette import GREY, INK, YELLOW, Look
from emg2vsa.run_scores import ContactPicture

POOLED = Look(GREY, "o", "-")
"""All specimens of an angle together."""


@dataclass(frozen=True)
class AreaPanel:
    """One panel: ``percent`` (n,) of each group, their names and looks, and bars between them."""

    title: str
    names: Sequence[str]
    percent: Sequence[Floats]
    looks: Sequence[Look]
    bars: Sequence[PairBar]


def draw_areas(by_specimen: Sequence[AreaPanel], by_angle: AreaPanel | None) -> Figure:
    """Differences of areas in percent. All panels share one scale, which the levels, from zero, would not leave."""
    panels = [*by_specimen, *([by_angle] if by_angle else [])]
    figure, (row,) = panel_grid(1, [1] * len(panels), 50, (15, 2, 11, 10), (11, 0))
    values = [v[np.isfinite(v)] for panel in panels for v in panel.percent]
    together = np.concatenate([np.zeros(1), *values])
    room = 0.05 * (np.ptp(together) or 1.0)
    for axes, panel in zip(row, panels, strict=True):
        axes.axhline(0, color=INK, linewidth=0.6)
        for place, (percent, look) in enumerate(zip(panel.percent, panel.looks, strict=True)):
            draw_box(axes, place, percent, look)
        axes.set_ylim(together.min() - room, together.max() + room)
        draw_bars(axes, panel.bars, "")
        axes.set_xticks(range(len(panel.names)), list(panel.names))
        axes.set_xlim(-0.6, len(panel.names) - 0.4)
        axes.set_title(panel.title, loc="center")
        axes.grid(axis="x", visible=False)
    row[0].set_ylabel("Difference of area (%)")
    highest = max(axes.get_ylim()[1] for axes in row)
    for axes in row:
        axes.set_ylim(top=highest)
    return figure


_BRIGHTEST = 255


def draw_contacts(pictures: Sequence[tuple[str, ContactPicture]], unit: str) -> Figure:
    """pictures : title and picture of each panel, whose force and area are added to the title."""
    figure, (row,) = panel_grid(1, [1] * len(pictures), 52, (2, 2, 2, 10), (4, 0))
    for axes, (title, picture) in zip(row, pictures, strict=True):
        axes.imshow(picture.image, cmap="gray", vmin=0, vmax=_BRIGHTEST, interpolation="nearest")
        axes.add_patch(Polygon(picture.outline_px, facecolor=YELLOW, alpha=0.25, linewidth=0))
        axes.add_patch(Polygon(picture.outline_px, fill=False, edgecolor=YELLOW, linewidth=1.4))
        axes.set_axis_off()
        axes.set_title(f"{title}, {picture.force_n:.2f} N\n{picture.area_mm2:.3g} {unit}", loc="center")
    return figure
