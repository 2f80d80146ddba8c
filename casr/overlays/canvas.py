"""The look of every picture: frames dimmed under bright marks, words outside, colours anyone can tell apart."""

from __future__ import annotations

import functools
import io
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

INK, MUTED, FAINT, GRID = "#1a1a1a", "#555555", "#a0a0a0", "#d9d9d9"
BLUE, GREEN, SKY, ORANGE, RED = "#0072B2", "#009E73", "#56B4E9", "#E69F00", "#D55E00"
"Okabe and Ito (2008)."

_Arguments = ParamSpec("_Arguments")
_Drawn = TypeVar("_Drawn")

View = tuple[float, float, float, float]
"Left, top, right and bottom of the part of a frame that is shown, px."

_WIDTH_INCH = 4.8
_DIMMED = 420.0
"Grey level shown as white: a bright pin is mid-grey, and marks on it stay visible."

_STYLE: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],  # ships with matplotlib: the same text on every machine
    "font.size": 10,
    "axes.titlesize": 10,
    "axes.labelsize": 10,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.4,
    "svg.fonttype": "path",
    "svg.hashsalt": "casr",
}


@dataclass(frozen=True)
class Picture:
    """One picture of a press: ``name`` for its file, ``title`` and ``caption`` for people."""

    name: str
    title: str
    caption: str
    figure: Figure

    def png(self, dpi: int = 160) -> bytes:
        """The same bytes whenever it is drawn."""
        return self._saved("png", dpi=dpi, metadata={"Software": None})

    def svg(self) -> bytes:
        """Vector drawing, text as outlines; the same bytes whenever it is drawn."""
        return self._saved("svg", metadata={"Date": None, "Creator": None})

    def _saved(self, format: str, **how: Any) -> bytes:
        buffer = io.BytesIO()
        styled(self.figure.savefig)(buffer, format=format, **how)
        return buffer.getvalue()


def styled(draw: Callable[_Arguments, _Drawn]) -> Callable[_Arguments, _Drawn]:
    """Draw in the style of these pictures, whatever matplotlib is set to."""

    @functools.wraps(draw)
    def drawn(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Drawn:
        with mpl.rc_context(_STYLE):  # type: ignore[arg-type]
            return draw(*args, **kwargs)

    return drawn


def plot(x_label: str, y_label: str) -> tuple[Figure, Axes]:
    """Axes for a curve."""
    figure = Figure(figsize=(_WIDTH_INCH, 3.6), layout="constrained")
    axes = figure.add_subplot()
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.grid(True)
    return figure, axes


def photo(image: NDArray[Any], view: View, height_inch: float = 4.8) -> tuple[Figure, Axes]:
    """Axes over a dimmed frame; pixel centres at whole numbers, y down. A bar beside them takes a lower figure."""
    figure = Figure(figsize=(_WIDTH_INCH, height_inch), layout="constrained")
    axes = figure.add_subplot()
    axes.imshow(image, cmap="gray", vmin=0, vmax=_DIMMED, interpolation="nearest")
    left, top, right, bottom = view
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_xlabel("x (px)")
    axes.set_ylabel("y (px)")
    return figure, axes


def view_of(points_px: NDArray[np.float64], image: NDArray[Any], margin_px: float) -> View:
    """Left, top, right, bottom of the part of a frame that holds the points and a margin, px."""
    low = np.maximum(np.nanmin(points_px, axis=0) - margin_px, -0.5)
    high = np.minimum(np.nanmax(points_px, axis=0) + margin_px, (image.shape[1] - 0.5, image.shape[0] - 0.5))
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def legend_below(axes: Axes, columns: int = 2) -> None:
    """Under the axes: marks on a frame leave no free corner."""
    axes.figure.legend(loc="outside lower center", ncols=columns)
