"""How the skin moved: the contact region as it grows, pins and their spreading, dense flow and its divergence."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import TwoSlopeNorm
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from casr.flow.divergence import divergence, mean_divergence, region_mask
from casr.overlays.canvas import GREEN, INK, RED, Picture, legend_below, photo, styled, view_of
from casr.pins import pin_pitch_px

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from casr.score import Score

_WITH_BAR_INCH = 3.9
_OUTLINES = 6
_LONGEST_EDGE = 1.7
"In pitches: longer edges of a triangulation bridge missing pins or the rim."
_DIVERGING = "PuOr_r"
"Both ends dark, the middle white, and told apart without red against green."


@styled
def edges_picture(last_image: NDArray[Any], score: Score) -> Picture:
    """Over the last frame the front in a few frames, early ones dark and thin, and the first contact's skin."""
    front, skin_px = score.front, (score.regions[0], score.regions[-1])
    determined = np.flatnonzero(front.determined) if not score.front_doubt else np.zeros(0, dtype=np.intp)
    shown = determined[np.linspace(0, determined.size - 1, min(_OUTLINES, determined.size)).round().astype(np.intp)]
    pins_px = score.rest.centroids_px
    everything = np.concatenate([pins_px, *skin_px, *front.edge_px[shown]])
    figure, axes = photo(last_image, view_of(everything, last_image, pin_pitch_px(pins_px)))
    for place, i in enumerate(shown.tolist()):
        share = place / max(len(shown) - 1, 1)
        words = f"front, {_moment(score, i)}"
        _outline(
            axes,
            front.edge_px[i],
            color=colormaps["plasma"](0.25 + 0.7 * share),
            linewidth=1.2 + 1.4 * share,
            label=words,
        )
    for outline_px, style, i in zip(skin_px, (":", "--"), (0, -1), strict=True):
        _outline(axes, outline_px, color=GREEN, linewidth=1.8, linestyle=style, label=f"skin, {_moment(score, i)}")
    legend_below(axes)
    caption = (
        "The front, from dark and thin to yellow and thick, and the skin of the first contact, over the last frame."
    )
    if not shown.size:
        caption = "The skin of the first contact over the last frame. The front is not determined and not drawn."
    return Picture("edges", "Front and skin", caption, figure)


def _moment(score: Score, i: int) -> str:
    force = f"{score.force_n[i]:.1f} N" if score.force_n is not None else ""
    return force or f"frame {score.frames[i]}"


def _outline(axes: Axes, points_px: NDArray[np.float64], **look: Any) -> None:
    axes.plot(*np.vstack([points_px, points_px[:1]]).T, **look)


@styled
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
    figure, axes = photo(first_image, view_of(first_px, first_image, 1.5 * pitch_px), _WITH_BAR_INCH)
    corners, growth = growth_between(first_px, last_px, pitch_px)
    if growth.size:
        half = max(float(np.abs(growth).max()), 1e-6)
        drawn = axes.tripcolor(
            Triangulation(first_px[:, 0], first_px[:, 1], corners),
            facecolors=growth,
            cmap=_DIVERGING,
            norm=TwoSlopeNorm(0, -half, half),
            alpha=0.8,
        )
        figure.colorbar(drawn, ax=axes, label="log growth of the area between pins")
    _arrows(axes, first_px, last_px - first_px, "pin, first to last frame")
    axes.plot(*np.vstack([outline_px, outline_px[:1]]).T, color=RED, linewidth=2, label="contact region at first")
    legend_below(axes)
    longest_px = float(np.hypot(*(last_px - first_px).T).max(initial=0.0))
    return Picture(
        "spreading",
        "Where the skin spread",
        f"Ways of the pins, {span}, {longest_px:.1f} px at most, to scale. Orange: spread; purple: drew together.",
        figure,
    )


@styled
def flow_picture(
    image: NDArray[Any],
    flow: NDArray[np.float32],
    region_px: NDArray[np.float64],
    span: str,
) -> Picture:
    """Dense flow (H, W, 2), px, as arrows, and its divergence inside the region, a (K, 2) polygon."""
    inside = region_mask(region_px, (image.shape[0], image.shape[1])) > 0.5
    low, high = region_px.min(axis=0), region_px.max(axis=0)
    margin_px = 0.35 * float((high - low).max())
    figure, axes = photo(image, view_of(region_px, image, margin_px), _WITH_BAR_INCH)
    shown = np.where(inside, divergence(flow), np.nan)
    half = max(float(np.nanpercentile(np.abs(shown), 95)), 1e-6) if inside.any() else 1.0
    drawn = axes.imshow(shown, cmap=_DIVERGING, norm=TwoSlopeNorm(0, -half, half), alpha=0.75)
    figure.colorbar(drawn, ax=axes, label="divergence (1 per frame pair)", extend="both")
    step = max(round(float((high - low + 2 * margin_px).max()) / 22), 1)
    ys, xs = np.mgrid[0 : image.shape[0] : step, 0 : image.shape[1] : step]
    at = np.column_stack([xs.ravel(), ys.ravel()]).astype(np.float64)
    near = ((at >= low - margin_px) & (at <= high + margin_px)).all(axis=1)
    vectors = flow[ys.ravel()[near], xs.ravel()[near]]
    longest_px = float(np.hypot(*vectors.T).max(initial=0.0))
    times = step / longest_px if longest_px > 0 else 1.0
    _arrows(axes, at[near], times * vectors, "flow")
    axes.plot(*np.vstack([region_px, region_px[:1]]).T, color=RED, linewidth=2, label="contact region")
    legend_below(axes)
    mean = mean_divergence(flow, region_px)
    return Picture(
        "flow",
        f"Flow and divergence, {span}",
        f"Mean divergence in the region {mean:+.4f}. The longest arrow is {longest_px:.2f} px.",
        figure,
    )


def growth_between(
    first_px: NDArray[np.float64], last_px: NDArray[np.float64], pitch_px: float
) -> tuple[NDArray[np.int_], NDArray[np.float64]]:
    """Corners (M, 3) of triangles of neighbouring pins, rows of ``first_px`` (N, 2), and the log growth (M,) of each.

    Triangles that turned over, where pins were mistaken for each other, are left out.
    """
    corners = _triangles(first_px, pitch_px)
    ratio = _doubled_area(last_px[corners]) / _doubled_area(first_px[corners])
    return corners[ratio > 0], np.log(ratio[ratio > 0])


def _arrows(axes: Axes, at_px: NDArray[np.float64], steps_px: NDArray[Any], words: str) -> None:
    axes.quiver(
        *at_px.T, *steps_px.T, color="white", edgecolor=INK, linewidth=0.6, angles="xy", scale_units="xy", scale=1,
        width=0.006,
    )  # fmt: skip
    axes.plot([], [], color=INK, linestyle="none", marker=r"$\rightarrow$", markersize=14, label=words)


def _triangles(points_px: NDArray[np.float64], pitch_px: float) -> NDArray[np.int_]:
    """(M, 3) corners of the triangles between neighbouring pins."""
    if len(points_px) < 3:
        return np.empty((0, 3), dtype=np.int_)
    corners = np.asarray(Triangulation(*points_px.T).triangles, dtype=np.int_)
    edges = points_px[corners] - points_px[np.roll(corners, 1, axis=1)]
    short = np.hypot(edges[..., 0], edges[..., 1]).max(axis=1) < _LONGEST_EDGE * pitch_px
    return np.asarray(corners[short])


def _doubled_area(corners_px: NDArray[np.float64]) -> NDArray[np.float64]:
    (ax, ay), (bx, by) = (corners_px[:, k].T - corners_px[:, 0].T for k in (1, 2))
    return np.asarray(ax * by - ay * bx)
