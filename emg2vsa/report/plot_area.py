"""A small hand-drawn plot: whole-number coordinates, so that a page of ten plots is light and always the same."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.figures.palette import GRID, INK, MUTED

_TEXT = 24
_SHOWN = 0.56
"Pixels a unit, at most: drawings are made fine and shown at about half their size."


@dataclass(frozen=True)
class PlotArea:
    """Data ranges x (lowest, highest) and y on a drawing of ``width`` by ``height`` units."""

    x_range: tuple[float, float]
    y_range: tuple[float, float]
    width: int
    height: int
    left: int = 80
    right: int = 20
    top: int = 40
    bottom: int = 70

    def x(self, values: Floats | float) -> Floats:
        """Data to horizontal position, whole units."""
        low, high = self.x_range
        inner = self.width - self.left - self.right
        return np.rint(self.left + (np.asarray(values) - low) / (high - low) * inner)

    def y(self, values: Floats | float) -> Floats:
        """Data to vertical position, whole units from the top."""
        low, high = self.y_range
        inner = self.height - self.top - self.bottom
        return np.rint(self.height - self.bottom - (np.asarray(values) - low) / (high - low) * inner)

    def line(self, x: Floats, y: Floats) -> str:
        """Path data of a polyline, in relative steps; points that are not numbers are left out."""
        known = np.isfinite(x) & np.isfinite(y)
        if not known.any():
            return ""
        points = np.column_stack([self.x(x[known]), self.y(y[known])]).astype(np.int64)
        first, steps = points[0], np.diff(points, axis=0)
        steps = steps[np.any(steps != 0, axis=1)]
        return f"M{first[0]} {first[1]}l{_joined(steps.ravel().tolist())}" if steps.size else ""

    def dots(self, x: Floats, y: Floats) -> str:
        """Path data of points without length, to be stroked with round caps."""
        known = np.isfinite(x) & np.isfinite(y)
        points = np.column_stack([self.x(x[known]), self.y(y[known])]).astype(np.int64)
        return "".join(f"M{px} {py}h0" for px, py in points.tolist())

    def axes(self, x_label: str, y_label: str) -> str:
        """Grid, ticks and labels."""
        bottom, right = self.height - self.bottom, self.width - self.right
        x_ticks, y_ticks = ticks(*self.x_range, most=9), ticks(*self.y_range, most=6)
        xs, ys = self.x(np.array(x_ticks)).astype(int), self.y(np.array(y_ticks)).astype(int)
        grid = "".join(f"M{self.left} {y}H{right}" for y in ys)
        marks = "".join(f"M{x} {bottom}v8" for x in xs)
        return (
            f'<path d="{grid}" stroke="{GRID}"/><path d="M{self.left} {bottom}H{right}{marks}" stroke="{INK}"/>'
            + "".join(text(x, bottom + 30, tick, "middle") for x, tick in zip(xs, map(_tick, x_ticks), strict=True))
            + "".join(text(self.left - 8, y + 8, tick, "end") for y, tick in zip(ys, map(_tick, y_ticks), strict=True))
            + text((self.left + right) // 2, self.height - 8, x_label, "middle")
            + text(self.left - 60, 22, y_label, "start")
        )

    def svg(self, body: str, name: str, title: str, description: str) -> str:
        """The drawing, with a name and words for those who do not see it."""
        return (
            f'<svg viewBox="0 0 {self.width} {self.height}" style="max-width:{self.width * _SHOWN:.0f}px;'
            f'min-width:{self.width * _SHOWN * 0.7:.0f}px" role="img" '
            f'aria-labelledby="{name}-t {name}-d" fill="none" '
            f'stroke-width="2" font-size="{_TEXT}"><title id="{name}-t">{escape(title)}</title>'
            f'<desc id="{name}-d">{escape(description)}</desc>{body}</svg>'
        )


def text(x: int, y: int, words: str, anchor: str, colour: str = MUTED) -> str:
    return f'<text x="{x}" y="{y}" text-anchor="{anchor}" fill="{colour}">{escape(words)}</text>'


def ticks(low: float, high: float, *, most: int) -> list[float]:
    """Round numbers within the range, in steps of 1, 2 or 5, at most ``most``."""
    least_step = (high - low) / most
    power = 10.0 ** math.floor(math.log10(least_step))
    step = next(power * m for m in (1, 2, 5, 10, 20) if power * m >= least_step)
    return [step * i for i in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def thinned(x: Floats, y: Floats, most: int) -> tuple[Floats, Floats]:
    """At most ``most`` points that keep every peak: the lowest and the highest of equal stretches."""
    if x.size <= most:
        return x, y
    edges = np.linspace(0, x.size, most // 2 + 1).astype(int)[:-1]
    position = np.repeat(np.arange(edges.size), np.diff(np.append(edges, x.size)))
    order = np.lexsort((y, position))
    keep = np.sort(np.concatenate([order[edges], order[np.append(edges[1:], x.size) - 1]]))
    return x[keep], y[keep]


def _tick(value: float) -> str:
    return f"{value:.6g}"


def _joined(numbers: Iterable[int]) -> str:
    """Numbers of path data: a minus sign separates as well as a blank."""
    return " ".join(map(str, numbers)).replace(" -", "-")
