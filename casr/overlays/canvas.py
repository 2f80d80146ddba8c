"""The look of every picture: SVG, frames dimmed under bright marks, words outside, colours anyone can tell apart."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.palette import GRID, INK, MUTED

Array = NDArray[np.float64]
View = tuple[float, float, float, float]
"Left, top, right and bottom of the part of a frame that is shown, px."

_WIDTH, _LEFT, _RIGHT, _TOP = 480, 68, 14, 12
_PLOT_HEIGHT = 280
_BAR = 74
"Room beside a frame for a bar of colours and its numbers."
_UNDER_AXES, _LINE = 46, 19
_LETTER = 6.6
"Width of a letter, on average."
_DIMMED = 420.0
"Grey level shown as white: a bright pin is mid-grey, and marks on it stay visible."
_FONT = "DejaVu Sans,Verdana,Arial,sans-serif"


@dataclass(frozen=True)
class Mark:
    """What was drawn, in the units of the axes.

    kind : ``line``, ``band``, ``dots``, ``rings``, ``crosses``, ``bars``, ``arrows`` or ``areas``. at : (N, 2), or for
    ``areas`` (M, K, 2) and for ``arrows`` (N, 4), x, y and their steps. label : empty where it is in no legend.
    """

    kind: str
    at: Array
    label: str


@dataclass(frozen=True)
class Picture:
    """One picture of a press: ``name`` for its file, ``title`` and ``caption`` for people."""

    name: str
    title: str
    caption: str
    axes: Axes

    def svg(self) -> bytes:
        """A whole file; the same bytes whenever it is drawn."""
        return self.axes.svg(self.title).encode()


@dataclass
class Axes:
    """Axes from ``left`` to ``right`` and ``bottom`` to ``top``, on a plot of ``width`` by ``height`` units.

    marks : what was drawn, in order.
    """

    view: View
    labels: tuple[str, str]
    width: float
    height: float
    grid: bool = True
    marks: list[Mark] = field(default_factory=list)
    _body: list[str] = field(default_factory=list)
    _legend: list[tuple[str, str]] = field(default_factory=list)
    _beside: str = ""

    def line(self, at: ArrayLike, colour: str, *, width: float = 1.6, dash: str = "", label: str = "") -> None:
        """Through (N, 2) points."""
        points = self._keep("line", at, label)
        look = f'fill="none" stroke="{colour}" stroke-width="{width:.3g}"' + (
            f' stroke-dasharray="{dash}"' * bool(dash)
        )
        self._body.append(f'<path d="{self._path(points)}" {look} stroke-linejoin="round"/>')
        self._add_legend(label, f'<path d="M0 0H20" {look}/>')

    def outline(self, at: Array, colour: str, *, width: float = 1.6, dash: str = "", label: str = "") -> None:
        """Around a polygon (N, 2)."""
        self.line(np.vstack([at, at[:1]]), colour, width=width, dash=dash, label=label)

    def band(self, x: Array, low: Array, high: Array, colour: str) -> None:
        """Between two curves over (N,) x."""
        at = np.concatenate([np.column_stack([x, high]), np.column_stack([x, low])[::-1]])
        points = self._keep("band", at, "")
        self._body.append(f'<path d="{self._path(points)}Z" fill="{colour}" fill-opacity="0.18"/>')

    def dots(self, at: ArrayLike, colour: str, *, size: float = 5, label: str = "") -> None:
        """Discs of a diameter at (N, 2) points."""
        self._spots("dots", at, f'stroke="{colour}" stroke-width="{size:.3g}" stroke-linecap="round"', "h0", label)

    def rings(self, at: ArrayLike, colour: str, *, label: str = "") -> None:
        """Circles around (N, 2) points."""
        look = f'fill="none" stroke="{colour}" stroke-width="1.2"'
        self._spots("rings", at, look, "m-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0-7 0", label)

    def crosses(self, at: ArrayLike, colour: str, *, label: str = "") -> None:
        """At (N, 2) points."""
        look = f'fill="none" stroke="{colour}" stroke-width="1.6"'
        self._spots("crosses", at, look, "m-3-3l6 6m-6 0l6-6", label)

    def arrows(self, at: Array, steps: Array, colour: str, *, label: str = "") -> None:
        """From (N, 2) points along (N, 2) steps, both in units of the axes, edged so as to be seen on anything."""
        kept = self._keep("arrows", np.column_stack([at, steps]), label)
        tail, head = self._page(kept[:, :2]), self._page(kept[:, :2] + kept[:, 2:])
        way = head - tail
        long = np.hypot(*way.T)
        along = way / np.maximum(long, 1e-9)[:, None]
        across = along[:, ::-1] * (-1, 1)
        tip = np.minimum(long, 5.0)[:, None]
        wings = [head - tip * (along + side * 0.5 * across) for side in (1, -1)]
        lines = np.stack([tail, head, wings[0], head, wings[1]], axis=1)
        path = "".join(_path(each) for each in lines[long > 0.3])
        look = 'fill="none" stroke-linecap="round" stroke-linejoin="round"'
        self._body.append(f'<path d="{path}" {look} stroke="{INK}" stroke-width="2.6"/>')
        self._body.append(f'<path d="{path}" {look} stroke="{colour}" stroke-width="1.3"/>')
        arrow = f'd="M0 0H18l-5-3m5 3l-5 3" {look}'
        sample = (
            f'<path {arrow} stroke="{INK}" stroke-width="2.6"/><path {arrow} stroke="{colour}" stroke-width="1.3"/>'
        )
        self._add_legend(label, sample)

    def bars(self, x: Array, height: Array, colour: str, *, label: str = "") -> None:
        """From 0 up or down, one unit of x apart."""
        kept = self._keep("bars", np.column_stack([x, height]), label)
        corners = np.array([(-0.45, 0), (-0.45, 1), (0.45, 1), (0.45, 0)])
        boxes = kept[:, None] * (1, 0) + corners * np.stack([np.ones(len(kept)), kept[:, 1]], axis=1)[:, None]
        self._body.append(f'<path d="{"".join(self._path(box) + "Z" for box in boxes)}" fill="{colour}"/>')
        self._add_legend(label, f'<rect y="-5" width="20" height="10" fill="{colour}"/>')

    def areas(self, corners: Array, colours: str | Sequence[str], *, opacity: float, label: str = "") -> None:
        """Polygons (M, K, 2), all of one colour or each of its own."""
        kept = self._keep("areas", corners, label)
        if isinstance(colours, str):
            path = "".join(self._path(each) + "Z" for each in kept)
            self._body.append(f'<path d="{path}" fill="{colours}" stroke="{colours}" fill-opacity="{opacity}"/>')
            self._add_legend(label, f'<rect y="-5" width="20" height="10" fill="{colours}" fill-opacity="{opacity}"/>')
            return
        cells = (f'<path d="{self._path(c)}Z" fill="{colour}"/>' for c, colour in zip(kept, colours, strict=True))
        self._body.append(f'<g fill-opacity="{opacity}">{"".join(cells)}</g>')

    def image(self, picture: NDArray[np.uint8], left_top: tuple[float, float]) -> None:
        """A picture (H, W), or (H, W, 4) in blue, green, red and alpha; its upper left corner in units of the axes."""
        data = base64.b64encode(cv2.imencode(".png", picture)[1].tobytes()).decode()
        corner = np.array(left_top)
        (x0, y0), (x1, y1) = self._page(np.array([corner, corner + picture.shape[1::-1]]))
        self._body.append(
            f'<image x="{x0:.1f}" y="{y0:.1f}" width="{x1 - x0:.1f}" height="{y1 - y0:.1f}" '
            f'preserveAspectRatio="none" style="image-rendering:pixelated" href="data:image/png;base64,{data}"/>'
        )

    def colour_bar(self, half: float, colours: Sequence[str], label: str) -> None:
        """Beside the axes, from ``-half`` to ``half``."""
        x, height = _LEFT + self.width + 12, self.height
        stops = "".join(
            f'<stop offset="{k / (len(colours) - 1):.3f}" stop-color="{c}"/>' for k, c in enumerate(reversed(colours))
        )
        numbers = "".join(
            f'<text x="{x + 18}" y="{_TOP + share * height + 4:.1f}">{value}</text>'
            for share, value in ((0.02, f"{half:+.2g}"), (0.5, "0"), (0.98, f"{-half:+.2g}"))
        )
        middle = _TOP + height / 2
        self._beside = (
            f'<linearGradient id="bar" x1="0" y1="0" x2="0" y2="1">{stops}</linearGradient>'
            f'<rect x="{x}" y="{_TOP}" width="12" height="{height:.1f}" fill="url(#bar)"/>{numbers}'
            f'<text transform="translate({x + 60} {middle:.0f}) rotate(-90)" text-anchor="middle">'
            f"{escape(label)}</text>"
        )

    def svg(self, title: str) -> str:
        """The drawing; the legend is under the axes, where no mark is."""
        lines = self._legend_lines()
        height = _TOP + self.height + _UNDER_AXES + _LINE * len(lines) + 4
        legend = "".join(
            f'<g transform="translate({x:.0f} {_TOP + self.height + _UNDER_AXES + _LINE * row + 6:.0f})">{sample}'
            f'<text x="26" y="4">{escape(label)}</text></g>'
            for row, entries in enumerate(lines)
            for x, sample, label in entries
        )
        frame = f'x="{_LEFT}" y="{_TOP}" width="{self.width:.1f}" height="{self.height:.1f}"'
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height:.0f}" role="img" '
            f'aria-label="{escape(title)}" font-family="{_FONT}" font-size="12" fill="{INK}">'
            f'<rect width="{_WIDTH}" height="{height:.0f}" fill="#fff"/><clipPath id="in"><rect {frame}/></clipPath>'
            f'{self._ticks()}<g clip-path="url(#in)">{"".join(self._body)}</g>'
            f'<rect {frame} fill="none" stroke="{MUTED}"/>{self._beside}{legend}</svg>\n'
        )

    def _ticks(self) -> str:
        left, top, right, bottom = self.view
        floor = _TOP + self.height
        parts = []
        for value in ticks(left, right):
            x = float(self._page(np.array([[value, bottom]]))[0, 0])
            end = _TOP if self.grid else floor
            parts.append(f'<path d="M{x:.1f} {floor + 4:.1f}V{end:.1f}" stroke="{GRID}"/>')
            parts.append(f'<text x="{x:.1f}" y="{floor + 18:.1f}" text-anchor="middle">{value:g}</text>')
        for value in ticks(min(top, bottom), max(top, bottom)):
            y = float(self._page(np.array([[left, value]]))[0, 1])
            end = _LEFT + self.width if self.grid else _LEFT
            parts.append(f'<path d="M{_LEFT - 4} {y:.1f}H{end:.1f}" stroke="{GRID}"/>')
            parts.append(f'<text x="{_LEFT - 7}" y="{y + 4:.1f}" text-anchor="end">{value:g}</text>')
        middle = _LEFT + self.width / 2, _TOP + self.height / 2
        under = f'<text x="{middle[0]:.0f}" y="{floor + 36:.1f}" text-anchor="middle">'
        parts.append(f"{under}{escape(self.labels[0])}</text>")
        parts.append(
            f'<text transform="translate(14 {middle[1]:.0f}) rotate(-90)" text-anchor="middle">'
            f"{escape(self.labels[1])}</text>"
        )
        return "".join(parts)

    def _legend_lines(self) -> list[list[tuple[float, str, str]]]:
        """Rows of x, sample and label: as many beside each other as there is room for."""
        lines: list[list[tuple[float, str, str]]] = []
        x = float(_WIDTH)
        for sample, label in self._legend:
            wide = 26 + _LETTER * len(label) + 16
            if x + wide > _WIDTH:
                lines.append([])
                x = 16.0
            lines[-1].append((x, sample, label))
            x += wide
        return lines

    def _spots(self, kind: str, at: ArrayLike, look: str, shape: str, label: str) -> None:
        places = self._page(self._keep(kind, at, label))
        path = "".join(f"M{x:.1f} {y:.1f}{shape}" for x, y in places[np.isfinite(places).all(axis=1)].tolist())
        self._body.append(f'<path d="{path}" {look}/>')
        self._add_legend(label, f'<path d="M10 0{shape}" {look}/>')

    def _keep(self, kind: str, at: ArrayLike, label: str) -> Array:
        points = np.asarray(at, dtype=np.float64)
        self.marks.append(Mark(kind, points, label))
        return points

    def _add_legend(self, label: str, sample: str) -> None:
        if label:
            self._legend.append((sample, label))

    def _page(self, at: Array) -> Array:
        left, top, right, bottom = self.view
        return np.column_stack(
            [
                _LEFT + (at[:, 0] - left) / (right - left) * self.width,
                _TOP + (at[:, 1] - top) / (bottom - top) * self.height,
            ]
        )

    def _path(self, at: Array) -> str:
        return _path(self._page(at))


def _path(places: Array) -> str:
    """Lines from place to place; a gap where one is not known."""
    parts, pen = [], "M"
    for x, y in places.tolist():
        if x != x or y != y:
            pen = "M"
            continue
        parts.append(f"{pen}{x:.1f} {y:.1f}")
        pen = "L"
    return "".join(parts)


def plot(x_label: str, y_label: str, x: Iterable[float], y: Iterable[float]) -> Axes:
    """Axes for a curve that hold the values x and y, and a margin."""
    (left, right), (bottom, top) = (_with_margin(np.array(list(values))) for values in (x, y))
    return Axes((left, top, right, bottom), (x_label, y_label), _WIDTH - _LEFT - _RIGHT, _PLOT_HEIGHT)


def _with_margin(values: Array) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    margin = 0.04 * (high - low) or 0.5
    return (low - margin if low else low), high + margin


def photo(image: NDArray[Any], view: View, *, bar: bool = False) -> Axes:
    """Axes over a dimmed frame; pixel centres at whole numbers, y down. bar : there is to be one beside them."""
    left, top, right, bottom = view
    width = _WIDTH - _LEFT - _RIGHT - (_BAR if bar else 0)
    axes = Axes(view, ("x (px)", "y (px)"), width, width * (bottom - top) / (right - left), grid=False)
    x0, y0 = max(int(np.floor(left)), 0), max(int(np.floor(top)), 0)
    shown = np.asarray(image)[y0 : int(np.ceil(bottom)) + 1, x0 : int(np.ceil(right)) + 1]
    grey = shown if shown.ndim == 2 else shown.mean(axis=-1)
    dimmed = np.clip(grey.astype(np.float32) * (255 / _DIMMED), 0, 255).astype(np.uint8)
    axes.image(dimmed, (x0 - 0.5, y0 - 0.5))
    return axes


def view_of(points_px: Array, image: NDArray[Any], margin_px: float) -> View:
    """Left, top, right, bottom of the part of a frame that holds the points and a margin, px."""
    low = np.maximum(np.nanmin(points_px, axis=0) - margin_px, -0.5)
    high = np.minimum(np.nanmax(points_px, axis=0) + margin_px, (image.shape[1] - 0.5, image.shape[0] - 0.5))
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def ticks(low: float, high: float) -> list[float]:
    """Round numbers between two, four to nine of them."""
    power = 10.0 ** np.floor(np.log10((high - low) / 4))
    step = power * max(k for k in (1, 2, 5) if 4 * k * power <= high - low)
    return [round(float(k * step), 12) for k in range(int(np.ceil(low / step)), int(np.floor(high / step)) + 1)]


def colours_of(values: Array, half: float, colours: Sequence[str]) -> NDArray[np.uint8]:
    """(N, 3) red, green and blue of values from ``-half`` to ``half``, between evenly spaced colours."""
    stops = np.array([[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour in colours], dtype=np.float64)
    place = (np.clip(values / half, -1, 1) + 1) / 2 * (len(colours) - 1)
    found = np.column_stack([np.interp(place, np.arange(len(colours)), stop) for stop in stops.T])
    return np.asarray(np.rint(found), dtype=np.uint8)
