"""Pictures over a frame: pins and the initial area; front, skin, the ways of pins, dense flow and its divergence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.contact_area import InitialArea
from casr.contact_area.rules import lattice_cell
from casr.flow.dense_engine import divergence, mean_divergence, region_mask
from casr.palette import GREEN, RED, SKY, YELLOW
from casr.pins import pin_pitch_px
from casr.pins.lattice import lattice_kind, nearest_pins
from casr.scored import Score
from casr.svg import Axes, Picture, View

_WIDE, _BAR = 812, 148
"Width of a picture, and of the room beside one for a bar of colours and its numbers."
_DIMMED = 420.0
"Grey level shown as white: a bright pin is mid-grey, and marks on it stay visible."
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

    contact_image : (H, W) or (H, W, 3). rest_px, contact_px : (N, 2), px.
    region_px : (K, 2) outline, px, that growth is measured in, where there is one.
    """
    axes = photo(contact_image, view_of(rest_px, contact_image, 1.5 * pin_pitch_px(rest_px)))
    by_hexagons = initial.rule in ("hexagon", "paper")
    if by_hexagons:
        cells = hexagons(rest_px[initial.selected], rest_px)
        axes.areas(cells, YELLOW, opacity=0.45, label=f"hexagon of each counted pin ({len(cells)})")
    axes.dots(contact_px, SKY, size=6, label="pin at first contact")
    axes.outline(initial.polygon_px, RED, width=4.8, label="outline of the area")
    if region_px is not None:
        axes.outline(region_px, GREEN, width=4, dash="12 8", label="region that is followed")
    mm2 = f", {initial.area_mm2:.4g} mm²" if initial.area_mm2 is not None else ""
    drawn = "Hexagons are drawn where the pins are at rest." if by_hexagons else "The area is the outline's."
    caption = f"First-contact frame. Rule {initial.rule}: {initial.area_px2:.5g} px²{mm2}. {drawn}"
    return Picture("area", "Initial area of the skin", caption, axes)


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


_EARLY_TO_LATE = ("#7e03a8", "#b12a90", "#d6556d", "#f2844b", "#feba2c", "#f7e425")
"Dark to bright."
_LONGEST_EDGE = 1.7
"In pitches: longer edges of a triangulation bridge missing pins or the rim."
_DIVERGING = ("#2d004b", "#5f3a91", "#9990bf", "#cfcfe5", "#f7f7f6", "#fed59f", "#ee9b39", "#bd6109", "#7f3b08")
"Both ends dark, the middle white, and told apart without red against green."


def edges_picture(last_image: NDArray[Any], score: Score) -> Picture:
    """Over the last frame (H, W) or (H, W, 3) the front in a few frames, early ones dark and thin, and the first
    contact's skin."""
    front, skin_px = score.front, (score.regions[0], score.regions[-1])
    determined = np.flatnonzero(front.determined & (score.front_doubt == ""))
    n_shown = min(len(_EARLY_TO_LATE), determined.size)
    shown = determined[np.linspace(0, determined.size - 1, n_shown).round().astype(np.intp)] if n_shown else determined
    pins_px = score.rest.centroids_px
    everything = np.concatenate([pins_px, *skin_px, *front.edge_px[shown]])
    axes = photo(last_image, view_of(everything, last_image, pin_pitch_px(pins_px)))
    for place, i in enumerate(shown.tolist()):
        share = place / max(n_shown - 1, 1)
        colour = _EARLY_TO_LATE[round(share * (len(_EARLY_TO_LATE) - 1))]
        axes.outline(front.edge_px[i], colour, width=2.8 + 2.8 * share, label=f"front, {_moment(score, i)}")
    for outline_px, dash, i in zip(skin_px, ("4 6", "14 8"), (0, -1), strict=True):
        axes.outline(outline_px, GREEN, width=4, dash=dash, label=f"skin, {_moment(score, i)}")
    caption = "Over the last frame the front, from dark and thin to bright and thick, and the first contact's skin."
    if not n_shown:
        caption = "The first contact's skin over the last frame. The front is not determined and not drawn."
    return Picture("edges", "Front and skin", caption, axes)


def _moment(score: Score, i: int) -> str:
    return f"frame {score.frames[i]}" if score.force_n is None else f"{score.force_n[i]:.1f} N"


def spreading_picture(
    first_image: NDArray[Any],
    first_px: NDArray[np.float64],
    last_px: NDArray[np.float64],
    outline_px: NDArray[np.float64],
    span: str,
) -> Picture:
    """Pins and their way over the press; between them how much each triangle of pins grew.

    first_px, last_px : (N, 2) the same pins, NaN where lost. span : the frames in words.
    """
    known = np.isfinite(first_px).all(axis=1) & np.isfinite(last_px).all(axis=1)
    first_px, last_px = first_px[known], last_px[known]
    pitch_px = pin_pitch_px(first_px)
    axes = photo(first_image, view_of(first_px, first_image, 1.5 * pitch_px), bar=True)
    corners, growth = growth_between(first_px, last_px, pitch_px)
    if growth.size:
        half = max(float(np.abs(growth).max()), 1e-6)
        colours = ["#" + bytes(colour).hex() for colour in colours_of(growth, half, _DIVERGING)]
        axes.areas(first_px[corners], colours, opacity=0.8)
        axes.colour_bar(half, _DIVERGING, "log growth of the area between pins")
    axes.arrows(first_px, last_px - first_px, "#fff", label="pin, first to last frame")
    axes.outline(outline_px, RED, width=4.4, label="first contact's skin")
    longest_px = float(np.hypot(*(last_px - first_px).T).max(initial=0.0))
    return Picture(
        "spreading",
        "Where the skin spread in the image",
        f"Ways of the pins, {span}, {longest_px:.1f} px at most, to scale. Orange: spread; purple: drew together.",
        axes,
    )


def flow_picture(image: NDArray[Any], flow: NDArray[np.float32], region_px: NDArray[np.float64], span: str) -> Picture:
    """Dense flow (H, W, 2), px, as arrows, and its divergence inside the region, a (K, 2) polygon."""
    inside = region_mask(region_px, (image.shape[0], image.shape[1])) > 0.5
    low, high = region_px.min(axis=0), region_px.max(axis=0)
    margin_px = 0.35 * float((high - low).max())
    axes = photo(image, view_of(region_px, image, margin_px), bar=True)
    found = divergence(flow).astype(np.float64)
    half = max(float(np.percentile(np.abs(found[inside]), 95)), 1e-6) if inside.any() else 1.0
    red_green_blue = colours_of(found.ravel(), half, _DIVERGING).reshape(*found.shape, 3)
    alpha = (190 * inside).astype(np.uint8)
    _lay(axes, np.dstack([red_green_blue[..., ::-1], alpha]), (-0.5, -0.5))
    axes.colour_bar(half, _DIVERGING, "divergence (1 per frame pair)")
    step = max(round(float((high - low + 2 * margin_px).max()) / 22), 1)
    ys, xs = np.mgrid[0 : image.shape[0] : step, 0 : image.shape[1] : step]
    at = np.column_stack([xs.ravel(), ys.ravel()]).astype(np.float64)
    near = ((at >= low - margin_px) & (at <= high + margin_px)).all(axis=1)
    vectors = flow[ys.ravel()[near], xs.ravel()[near]].astype(np.float64)
    longest_px = float(np.hypot(*vectors.T).max(initial=0.0))
    times = step / longest_px if longest_px > 0 else 1.0
    axes.arrows(at[near], times * vectors, "#fff", label="flow")
    axes.outline(region_px, RED, width=4.4, label="contact region")
    mean = mean_divergence(flow, region_px)
    return Picture(
        "flow",
        f"Flow and divergence, {span}",
        f"Mean divergence in the region {mean:+.4f}. The longest arrow is {longest_px:.2f} px.",
        axes,
    )


def photo(image: NDArray[Any], view: View, *, bar: bool = False) -> Axes:
    """Axes over a dimmed frame (H, W) or (H, W, 3); pixel centres at whole numbers, y down.

    bar : there is to be one beside them.
    """
    left, top, right, bottom = view
    beside = _BAR if bar else 0
    width = _WIDE - beside
    height = width * (bottom - top) / (right - left)
    axes = Axes(view, ("x (px)", "y (px)"), width, height, grid=False, beside=beside)
    x0, y0 = max(int(np.floor(left)), 0), max(int(np.floor(top)), 0)
    shown = np.asarray(image)[y0 : int(np.ceil(bottom)) + 1, x0 : int(np.ceil(right)) + 1]
    grey = shown if shown.ndim == 2 else shown.mean(axis=-1)
    dimmed = np.clip(grey.astype(np.float32) * (255 / _DIMMED), 0, 255).astype(np.uint8)
    _lay(axes, dimmed, (x0 - 0.5, y0 - 0.5))
    return axes


def _lay(axes: Axes, picture: NDArray[np.uint8], left_top: tuple[float, float]) -> None:
    """A picture (H, W), or (H, W, 4) in blue, green, red and alpha, under what is drawn from now on."""
    axes.image(cv2.imencode(".png", picture)[1].tobytes(), left_top, (picture.shape[0], picture.shape[1]))


def view_of(points_px: NDArray[np.float64], image: NDArray[Any], margin_px: float) -> View:
    """Left, top, right, bottom of the part of a frame (H, W) that holds the points (n, 2) and a margin, px."""
    low = np.maximum(np.nanmin(points_px, axis=0) - margin_px, -0.5)
    high = np.minimum(np.nanmax(points_px, axis=0) + margin_px, (image.shape[1] - 0.5, image.shape[0] - 0.5))
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def colours_of(values: NDArray[np.float64], half: float, colours: Sequence[str]) -> NDArray[np.uint8]:
    """(N, 3) red, green and blue of values from ``-half`` to ``half``, between evenly spaced colours."""
    stops = np.array([[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour in colours], dtype=np.float64)
    place = (np.clip(values / half, -1, 1) + 1) / 2 * (len(colours) - 1)
    found = np.column_stack([np.interp(place, np.arange(len(colours)), stop) for stop in stops.T])
    return np.asarray(np.rint(found), dtype=np.uint8)


def growth_between(
    first_px: NDArray[np.float64], last_px: NDArray[np.float64], pitch_px: float
) -> tuple[NDArray[np.int_], NDArray[np.float64]]:
    """Corners (M, 3) of triangles of neighbouring pins, rows of ``first_px`` (N, 2), and the log growth (M,) of each.

    Triangles that turned over, where pins were mistaken for each other, are left out.
    """
    corners = _triangles(first_px, pitch_px)
    ratio = _doubled_area(last_px[corners]) / _doubled_area(first_px[corners])
    return corners[ratio > 0], np.log(ratio[ratio > 0])


def _triangles(points_px: NDArray[np.float64], pitch_px: float) -> NDArray[np.int_]:
    """(M, 3) corners of the triangles between neighbouring pins (Delaunay)."""
    if len(points_px) < 3:
        return np.empty((0, 3), dtype=np.int_)
    left, top = np.floor(points_px.min(axis=0)).astype(int).tolist()
    right, bottom = np.ceil(points_px.max(axis=0)).astype(int).tolist()
    mesh = cv2.Subdiv2D((left - 1, top - 1, right - left + 3, bottom - top + 3))
    # a point's number in the mesh, which has numbers of its own for corners far outside, to its row
    row = {mesh.insert((float(x), float(y))): i for i, (x, y) in enumerate(points_px)}
    found = [
        tuple(row.get(mesh.locate((float(x), float(y)))[2], -1) for x, y in triangle)
        for triangle in np.asarray(mesh.getTriangleList()).reshape(-1, 3, 2)
    ]
    corners = np.array([each for each in found if min(each) >= 0], dtype=np.int_).reshape(-1, 3)
    edges = points_px[corners] - points_px[np.roll(corners, 1, axis=1)]
    return np.asarray(
        corners[np.hypot(edges[..., 0], edges[..., 1]).max(axis=1, initial=0.0) < _LONGEST_EDGE * pitch_px]
    )


def _doubled_area(corners_px: NDArray[np.float64]) -> NDArray[np.float64]:
    (ax, ay), (bx, by) = (corners_px[:, k].T - corners_px[:, 0].T for k in (1, 2))
    return np.asarray(ax * by - ay * bx)
