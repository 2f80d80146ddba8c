"""Algorithm 1, which finds the initial area. Figure 2: its steps in one press, as in the paper, and the flow."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from casr.flow.dense_engine import divergence, region_mask
from casr.flow.region import Region
from casr.overlays.frames import hexagons as cells_of
from casr.pins import PinSettings
from casr.pins.detect import above_surroundings, fit_view
from emg2vsa.figures.canvas import panel_grid
from emg2vsa.figures.palette import BLUE, SKY, YELLOW
from emg2vsa.run_scores import FirstContact

_BRIGHTEST = 255
_ARROWS_PX = 12
"""Between arrows of the flow."""


def draw_steps(seen: FirstContact, flow_px: NDArray[np.floating[Any]]) -> Figure:
    """flow_px : (H, W, 2) from the first frame in contact to the next, NaN where it is not known."""
    figure, rows = panel_grid(2, [1] * 4, 41, (2, 2, 2, 7), (4, 8))
    (frame, mask, at_rest, in_contact), (selected, hexagons, flow, growth) = rows
    rest, contact, _ = seen.frames
    titles = (
        "frame", "mask", "centroids at rest", "centroids in contact", "selected pins", "one hexagon each", "flow",
        "divergence",
    )  # fmt: skip
    for each, title in zip([*rows[0], *rows[1]], titles, strict=True):
        each.set_title(title, loc="center")
        each.set_axis_off()
    _grey(frame, contact)
    _grey(mask, _BRIGHTEST * _mask(contact))
    for where, image, pins in ((at_rest, rest, seen.rest_px), (in_contact, contact, seen.contact_px)):
        _grey(where, image)
        where.plot(*pins.T, linestyle="none", marker="+", markersize=3.5, color=YELLOW, markeredgewidth=0.8)
    _grey(selected, contact)
    start, end = seen.rest_px[seen.selected], seen.contact_px[seen.selected]
    selected.plot(*end.T, linestyle="none", marker="o", markersize=4, markerfacecolor="none", markeredgecolor=YELLOW)
    selected.quiver(*start.T, *(end - start).T, angles="xy", scale_units="xy", scale=0.25, color=SKY, width=0.008)
    _grey(hexagons, rest)
    tiles = list(cells_of(start, seen.rest_px))
    hexagons.add_collection(
        PolyCollection(tiles, facecolors=(*to_rgb(YELLOW), 0.25), edgecolors=YELLOW, linewidths=0.8)
    )
    # flow is not seen outside what the pins enclose
    hull = Region.from_points(seen.contact_px[np.isfinite(seen.contact_px).all(axis=1)])
    of_skin = np.where(region_mask(hull.polygon_px, seen.frames.shape[1:])[..., None] > 0, flow_px, np.nan)
    _flow(flow, contact, of_skin)
    _divergence(growth, of_skin)
    return figure


def _grey(axes: Axes, image: NDArray[np.uint8]) -> None:
    axes.imshow(image, cmap="gray", vmin=0, vmax=_BRIGHTEST, interpolation="nearest")


def _mask(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(H, W) 0 or 1: what the search for pins takes for a bright blob."""
    view, _ = fit_view(image, PinSettings())
    _, mask = above_surroundings(view.grey(image), view.block_px, view.contrast)
    height, width = image.shape
    return np.asarray(cv2.resize((mask > 0).astype(np.uint8), (width, height), interpolation=cv2.INTER_NEAREST))


def _flow(axes: Axes, image: NDArray[np.uint8], flow_px: NDArray[np.floating[Any]]) -> None:
    _grey(axes, (image // 3).astype(np.uint8))
    height, width = image.shape
    y, x = np.mgrid[_ARROWS_PX // 2 : height : _ARROWS_PX, _ARROWS_PX // 2 : width : _ARROWS_PX]
    u, v = (flow_px[y, x, part] for part in (0, 1))
    axes.quiver(x, y, u, v, angles="xy", scale_units="xy", scale=0.1, color=SKY, width=0.008)


def _divergence(axes: Axes, flow_px: NDArray[np.floating[Any]]) -> None:
    """One scale to both sides of zero: blue shrinks, yellow grows, white is still."""
    field = 100 * divergence(flow_px.astype(np.float32))
    most = float(np.nanpercentile(np.abs(field), 99.5)) or 1.0
    shown = np.clip(np.nan_to_num(field) / most, -1, 1)[..., None]
    ends = np.where(shown > 0, to_rgb(YELLOW), to_rgb(BLUE))
    axes.imshow(1 - np.abs(shown) * (1 - ends), interpolation="nearest")
    axes.set_title(f"divergence, ±{most:.2g} %", loc="center")
