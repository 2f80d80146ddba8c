"""The initial contact area over the frames it comes from: pins and how they moved, hexagons and outline."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from casr.contact_area.algorithm_1 import lattice_cell
from casr.overlays.canvas import Picture, photo, view_of
from casr.palette import GREEN, RED, SKY, YELLOW
from casr.pins import pin_pitch_px
from casr.pins.lattice import nearest_pins
from casr.pins.sites import lattice_kind

if TYPE_CHECKING:
    from casr.contact_area import InitialArea

_HEXAGON_RULES = ("hexagon", "paper")
_ARROW_PX = 12.0
"Length at which the longest displacement is drawn when it is shorter."


def pins_picture(
    rest_image: NDArray[Any], rest_px: NDArray[np.float64], contact_px: NDArray[np.float64], initial: InitialArea
) -> Picture:
    """Every pin at rest, and arrows to where it is at first contact. rest_px, contact_px : (N, 2), NaN where lost."""
    pitch_px = pin_pitch_px(rest_px)
    axes = photo(rest_image, view_of(rest_px, rest_image, 1.5 * pitch_px))
    moved_px = contact_px - rest_px
    longest_px = float(np.nanmax(np.hypot(*moved_px.T), initial=0.0))
    times = max(1.0, round(_ARROW_PX / longest_px)) if longest_px > 0 else 1.0
    chosen = np.zeros(len(rest_px), dtype=bool)
    chosen[initial.selected] = True
    known = np.isfinite(moved_px).all(axis=1)
    for which, colour, words in ((chosen, YELLOW, "counted in A_c0 (skin)"), (~chosen & known, SKY, "not counted")):
        axes.rings(rest_px[which], colour, label=f"{words} ({which.sum()})")
        axes.arrows(rest_px[which], times * moved_px[which], colour)
    if not known.all():
        axes.crosses(rest_px[~known], RED, label=f"lost ({np.sum(~known)})")
    drawn = f"Arrows are drawn {times:.0f} times as long as they are." if times > 1 else "Arrows are to scale."
    return Picture(
        "pins",
        "Which pins moved at first contact",
        f"Pins at rest and their way to the first-contact frame, {longest_px:.1f} px at most. {drawn}",
        axes,
    )


def area_picture(
    contact_image: NDArray[Any],
    rest_px: NDArray[np.float64],
    contact_px: NDArray[np.float64],
    initial: InitialArea,
    region_px: NDArray[np.float64] | None = None,
) -> Picture:
    """The initial area of the skin on the first-contact frame: a hexagon about each counted pin, and its outline.

    region_px : (K, 2) outline that growth is measured in, where there is one.
    """
    axes = photo(contact_image, view_of(rest_px, contact_image, 1.5 * pin_pitch_px(rest_px)))
    if initial.rule in _HEXAGON_RULES:
        cells = hexagons(rest_px[initial.selected], rest_px)
        axes.areas(cells, YELLOW, opacity=0.45, label=f"hexagon of each counted pin ({len(cells)})")
    axes.dots(contact_px, SKY, size=3, label="pin at first contact")
    axes.outline(initial.polygon_px, RED, width=2.4, label="outline of the area")
    if region_px is not None:
        axes.outline(region_px, GREEN, width=2, dash="6 4", label="region that is followed")
    mm2 = f", {initial.area_mm2:.4g} mm²" if initial.area_mm2 is not None else ""
    caption = f"First-contact frame. Rule {initial.rule}: {initial.area_px2:.5g} px²{mm2}. {_about(initial.rule)}"
    return Picture("area", "Initial area of the skin", caption, axes)


def _about(rule: str) -> str:
    return "Hexagons are drawn where the pins are at rest." if rule in _HEXAGON_RULES else "The area is the outline's."


def hexagons(at_px: NDArray[np.float64], pins_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """(M, 6, 2) corners of regular hexagons around ``at_px`` (M, 2) that tile the lattice of ``pins_px`` (N >= 2, 2).

    Their flat sides are half a pitch from their centres and face the nearest neighbours; of a square lattice they are
    squares, (M, 4, 2). Drawing only.
    """
    kind = lattice_kind(pins_px)
    fold = 4 if kind == "square" else 6
    steps = pins_px[nearest_pins(pins_px, 1)[1][:, 0]] - pins_px
    # the direction of the lattice's rows, folded into the turn from one neighbour to the next
    direction = float(np.angle(np.exp(fold * 1j * np.arctan2(steps[:, 1], steps[:, 0])).mean())) / fold
    return np.asarray(at_px[:, None, :] + lattice_cell(pin_pitch_px(pins_px), kind, direction))
