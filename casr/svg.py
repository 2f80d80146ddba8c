"""Drawings of pages: axes with marks and a legend as SVG, in the colours of the page, told to those who do not see."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.palette import GRID, INK, MUTED, ON_PAGES

Array = NDArray[np.float64]
View = tuple[float, float, float, float]
"Left, top, right and bottom of what the axes show; pictures have y down, so their top is the smaller number."

_LEFT, _RIGHT, _TOP, _UNDER, _LINE = 120, 28, 56, 88, 38
"Room beside, above and under the axes, and of a line of the legend."
_SIZE, _LETTER = 24, 13.2
"Size of letters, and their mean width."
_SHOWN = 0.5
"Px per unit: whole units are fine enough for lines, and short."
_FONT = "DejaVu Sans,Verdana,Arial,sans-serif"
_EDGE = "#000"
"Around arrows, which lie on photographs, by day and by night."


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
    """One drawing: ``name`` for its file, ``title`` and ``caption`` for people."""

    name: str
    title: str
    caption: str
    axes: Axes

    def file(self) -> bytes:
        """A whole SVG file, on white; the same bytes whenever it is drawn."""
        return self.axes.svg(self.name, self.title, self.caption, page=False).encode()

    def inline(self) -> str:
        """Part of a page."""
        return self.axes.svg(self.name, self.title, self.caption)


@dataclass
class Axes:
    """Axes over ``view``, ``width`` by ``height`` units of half a px.

    labels : of x and y. beside : more room at the right. whole : x is counted, not measured. logarithmic : x is the
    common logarithm of what its ticks tell. marks : what was drawn, in order.
    """

    view: View
    labels: tuple[str, str]
    width: float = 812
    height: float = 560
    grid: bool = True
    beside: float = 0
    whole: bool = False
    logarithmic: bool = False
    marks: list[Mark] = field(default_factory=list)
    _body: list[str] = field(default_factory=list)
    _over: list[str] = field(default_factory=list)
    "Outside the axes."
    _legend: list[tuple[str, str]] = field(default_factory=list)

    def line(
        self, at: ArrayLike, colour: str, *, width: float = 3.2, dash: str = "", label: str = "", title: str = ""
    ) -> None:
        """Through (N, 2) points; a gap where one is not known. title : shown by the pointer."""
        look = f'fill="none" stroke="{colour}" stroke-width="{width:.3g}"'
        look += f' stroke-dasharray="{dash}"' if dash else ""
        self._draw(f'd="{self._path(self._keep("line", at, label))}" {look} stroke-linejoin="round"', title)
        self._add_legend(label, f'<path d="M0 0H40" {look}/>')

    def outline(self, at: Array, colour: str, *, width: float = 3.2, dash: str = "", label: str = "") -> None:
        """Around a polygon (N, 2)."""
        self.line(np.vstack([at, at[:1]]), colour, width=width, dash=dash, label=label)

    def level(self, y: float, colour: str = MUTED, *, dash: str = "8 10") -> None:
        """A line across, in no legend."""
        self.line([(self.view[0], y), (self.view[2], y)], colour, width=2, dash=dash)

    def band(self, x: Array, low: Array, high: Array, colour: str, *, opacity: float = 0.18) -> None:
        """Between two curves over (N,) x."""
        at = np.concatenate([np.column_stack([x, high]), np.column_stack([x, low])[::-1]])
        self._draw(f'd="{self._path(self._keep("band", at, ""))}Z" fill="{colour}" fill-opacity="{opacity}"')

    def shade(self, left: float, right: float, fill: str, title: str = "") -> None:
        """A stripe over the whole height, at least 4 units wide. fill : a colour, or a pattern of the page."""
        x0, x1 = (float(self._page(np.array([[x, 0.0]]))[0, 0]) for x in (left, right))
        self._draw(f'd="M{x0:.1f} {_TOP}H{max(x1, x0 + 4):.1f}v{self.height:g}H{x0:.1f}Z" fill="{fill}"', title)

    def dots(self, at: ArrayLike, colour: str, *, size: float = 10, label: str = "", opacity: float = 1) -> None:
        """Discs of a diameter at (N, 2) points."""
        look = f'stroke="{colour}" stroke-width="{size:.3g}" stroke-linecap="round"'
        look += f' stroke-opacity="{opacity:g}"' if opacity < 1 else ""
        self._spots("dots", at, look, "h0", label)

    def rings(self, at: ArrayLike, colour: str, *, label: str = "") -> None:
        """Circles around (N, 2) points."""
        look = f'fill="none" stroke="{colour}" stroke-width="2.4"'
        self._spots("rings", at, look, "m-7 0a7 7 0 1 0 14 0a7 7 0 1 0-14 0", label)

    def crosses(self, at: ArrayLike, colour: str, *, label: str = "") -> None:
        """At (N, 2) points."""
        look = f'fill="none" stroke="{colour}" stroke-width="3.2"'
        self._spots("crosses", at, look, "m-6-6l12 12m-12 0l12-12", label)

    def arrows(self, at: Array, steps: Array, colour: str, *, label: str = "") -> None:
        """From (N, 2) points along (N, 2) steps, both in units of the axes, edged so as to be seen on anything."""
        kept = self._keep("arrows", np.column_stack([at, steps]), label)
        tail, head = self._page(kept[:, :2]), self._page(kept[:, :2] + kept[:, 2:])
        way = head - tail
        long = np.hypot(*way.T)
        along = way / np.maximum(long, 1e-9)[:, None]
        across = along[:, ::-1] * (-1, 1)
        tip = np.minimum(long, 10.0)[:, None]
        wings = [head - tip * (along + side * 0.5 * across) for side in (1, -1)]
        lines = np.stack([tail, head, wings[0], head, wings[1]], axis=1)
        looks = [(_EDGE, 5.2), (colour, 2.6)]

        def drawn(path: str) -> str:
            look = 'fill="none" stroke-linecap="round" stroke-linejoin="round"'
            return "".join(f'<path d="{path}" {look} stroke="{c}" stroke-width="{w}"/>' for c, w in looks)

        self._body.append(drawn("".join(_path(each) for each in lines[long > 0.6])))
        self._add_legend(label, drawn("M0 0H36l-10-6m10 6l-10 6"))

    def bars(self, x: Array, height: Array, colour: str, *, label: str = "") -> None:
        """Bars from 0 up or down, one unit of x apart."""
        kept = self._keep("bars", np.column_stack([x, height]), label)
        corners = np.array([(-0.45, 0), (-0.45, 1), (0.45, 1), (0.45, 0)])
        boxes = kept[:, None] * (1, 0) + corners * np.stack([np.ones(len(kept)), kept[:, 1]], axis=1)[:, None]
        self._draw(f'd="{"".join(self._path(box) + "Z" for box in boxes)}" fill="{colour}"')
        self._add_legend(label, f'<rect y="-10" width="40" height="20" fill="{colour}"/>')

    def areas(self, corners: Array, colours: str | Sequence[str], *, opacity: float, label: str = "") -> None:
        """Polygons (M, K, 2), all of one colour or each of its own."""
        kept = self._keep("areas", corners, label)
        if isinstance(colours, str):
            look = f'fill="{colours}" fill-opacity="{opacity}"'
            self._draw(f'd="{"".join(self._path(each) + "Z" for each in kept)}" stroke="{colours}" {look}')
            self._add_legend(label, f'<rect y="-10" width="40" height="20" {look}/>')
            return
        cells = (f'<path d="{self._path(c)}Z" fill="{colour}"/>' for c, colour in zip(kept, colours, strict=True))
        self._body.append(f'<g fill-opacity="{opacity}">{"".join(cells)}</g>')

    def image(self, png: bytes, left_top: tuple[float, float], shape: tuple[int, int]) -> None:
        """A picture of (H, W) units; ``left_top`` is its upper left corner in units of the axes."""
        corner = np.array(left_top)
        (x0, y0), (x1, y1) = self._page(np.array([corner, corner + shape[::-1]]))
        self._body.append(
            f'<image x="{x0:.1f}" y="{y0:.1f}" width="{x1 - x0:.1f}" height="{y1 - y0:.1f}" '
            'preserveAspectRatio="none" style="image-rendering:pixelated" '
            f'href="data:image/png;base64,{base64.b64encode(png).decode()}"/>'
        )

    def above(self, x: float, words: str) -> None:
        """Words over the axes."""
        at = float(self._page(np.array([[x, 0.0]]))[0, 0])
        self._over.append(_text(at, _TOP - 8, words, "middle"))

    def ends(self, y: Array, words: Sequence[str], colours: Sequence[str]) -> None:
        """Words right of the axes at (N,) heights, moved down where they would cover each other; NaN: left out."""
        lowest = -np.inf
        places = np.clip(self._page(np.column_stack([np.zeros(len(y)), y]))[:, 1], _TOP, _TOP + self.height)
        for i in np.argsort(places, kind="stable").tolist():
            if y[i] == y[i]:
                lowest = max(float(places[i]), lowest + _SIZE)
                self._over.append(_text(_LEFT + self.width + 10, lowest + 8, words[i], "start", colours[i]))

    def colour_bar(self, half: float, colours: Sequence[str], label: str) -> None:
        """Beside the axes, from ``-half`` to ``half``."""
        x, height = _LEFT + self.width + 24, self.height
        stops = "".join(
            f'<stop offset="{k / (len(colours) - 1):.3f}" stop-color="{c}"/>' for k, c in enumerate(reversed(colours))
        )
        self._over.append(
            f'<linearGradient id="bar" x1="0" y1="0" x2="0" y2="1">{stops}</linearGradient>'
            f'<rect x="{x}" y="{_TOP}" width="24" height="{height:.1f}" fill="url(#bar)"/>'
            f'<text transform="translate({x + 120} {_TOP + height / 2:.0f}) rotate(-90)" text-anchor="middle">'
            f"{escape(label)}</text>"
        )
        for share, value in ((0.02, f"{half:+.2g}"), (0.5, "0"), (0.98, f"{-half:+.2g}")):
            self._over.append(_text(x + 36, _TOP + share * height + 8, value))

    def svg(self, name: str, title: str, description: str, *, page: bool = True) -> str:
        """The drawing; the legend is under the axes, where no mark is.

        page : in the page's colours, with ids that begin with ``name``; else a whole file on white.
        """
        total = _LEFT + self.width + _RIGHT + self.beside
        lines = self._legend_lines(total)
        foot = _TOP + self.height + _UNDER
        height = foot + _LINE * len(lines)
        legend = "".join(
            f'<g transform="translate({x:.0f} {foot + _LINE * row + 12:.0f})">{sample}{_text(52, 8, label)}</g>'
            for row, entries in enumerate(lines)
            for x, sample, label in entries
        )
        frame = f'x="{_LEFT}" y="{_TOP}" width="{self.width:.1f}" height="{self.height:.1f}"'
        least = f";min-width:{0.6 * _SHOWN * total:.0f}px" if total > 1200 else ""
        head = f'style="max-width:{_SHOWN * total:.0f}px{least}"' if page else 'xmlns="http://www.w3.org/2000/svg"'
        ground = "" if page else f'<rect width="{total:.0f}" height="{height:.0f}" fill="#fff"/>'
        drawn = (
            f'<svg {head} viewBox="0 0 {total:.0f} {height:.0f}" role="img" aria-labelledby="title desc" '
            f'font-family="{_FONT}" font-size="{_SIZE}" stroke-width="2" fill="{INK}">'
            f'<title id="title">{escape(title)}</title><desc id="desc">{escape(description)}</desc>{ground}'
            f'<clipPath id="in"><rect {frame}/></clipPath>{self._ticks()}'
            f'<g clip-path="url(#in)">{"".join(self._body)}</g>'
            f'<rect {frame} fill="none" stroke="{MUTED}"/>{"".join(self._over)}{legend}</svg>'
        )
        return in_colours_of_page(_own_ids(drawn, name)) if page else drawn + "\n"

    def _ticks(self) -> str:
        left, top, right, bottom = self.view
        floor, grid = _TOP + self.height, 1.0 if self.grid else 0.0
        most = int(self.height / 90) + 2
        ends = (10**left, 10**right) if self.logarithmic else (left, right)
        across = [x for x in ticks(*ends, int(self.width / 120)) if not self.whole or x == round(x)]
        up = ticks(min(top, bottom), max(top, bottom), most)
        at = np.log10(across) if self.logarithmic else across
        xs = self._page(np.array([[value, bottom] for value in at]))[:, 0].tolist()
        ys = self._page(np.array([[left, value] for value in up]))[:, 1].tolist()
        lines = "".join(f"M{x:.1f} {floor + 8:.1f}v{-8 - grid * self.height:g}" for x in xs)
        lines += "".join(f"M{_LEFT - 8} {y:.1f}h{8 + grid * self.width:g}" for y in ys)
        return (
            f'<path d="{lines}" stroke="{GRID}"/>'
            + "".join(_text(x, floor + 36, f"{value:g}", "middle") for x, value in zip(xs, across, strict=True))
            + "".join(_text(_LEFT - 14, y + 8, f"{value:g}", "end") for y, value in zip(ys, up, strict=True))
            + _text(_LEFT + self.width / 2, floor + 72, self.labels[0], "middle")
            + _text(8, _SIZE, self.labels[1])
        )

    def _legend_lines(self, total: float) -> list[list[tuple[float, str, str]]]:
        """Rows of x, sample and label: as many beside each other as there is room for."""
        lines: list[list[tuple[float, str, str]]] = []
        x = float(total)
        for sample, label in self._legend:
            wide = 52 + _LETTER * len(label) + 32
            if x + wide > total:
                lines.append([])
                x = 32.0
            lines[-1].append((x, sample, label))
            x += wide
        return lines

    def _spots(self, kind: str, at: ArrayLike, look: str, shape: str, label: str) -> None:
        places = self._page(self._keep(kind, at, label))
        path = "".join(f"M{x:.1f} {y:.1f}{shape}" for x, y in places[np.isfinite(places).all(axis=1)].tolist())
        self._draw(f'd="{path}" {look}')
        self._add_legend(label, f'<path d="M20 0{shape}" {look}/>')

    def _draw(self, path: str, title: str = "") -> None:
        self._body.append(f"<path {path}><title>{escape(title)}</title></path>" if title else f"<path {path}/>")

    def _keep(self, kind: str, at: ArrayLike, label: str) -> Array:
        points = np.asarray(at, dtype=np.float64)
        self.marks.append(Mark(kind, points, label))
        return points

    def _add_legend(self, label: str, sample: str) -> None:
        if label:
            self._legend.append((sample, label))

    def _page(self, at: Array) -> Array:
        left, top, right, bottom = self.view
        x, y = np.asarray(at, dtype=np.float64).reshape(-1, 2).T
        across, down = (x - left) / (right - left), (y - top) / (bottom - top)
        return np.column_stack([_LEFT + across * self.width, _TOP + down * self.height])

    def _path(self, at: Array) -> str:
        return _path(self._page(at))


def plot(labels: tuple[str, str], x: Iterable[float], y: Iterable[float], **size: float) -> Axes:
    """Axes for a curve that hold the values x and y, and a margin. size : as of ``Axes``."""
    (left, right), (bottom, top) = (_with_margin(np.array(list(values))) for values in (x, y))
    return Axes((left, top, right, bottom), labels, **size)  # type: ignore[arg-type]


def _with_margin(values: Array) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    margin = 0.04 * (high - low) or 0.5
    return (low - margin if low else low), high + margin


def ticks(low: float, high: float, most: int) -> list[float]:
    """Round numbers within the range, in steps of 1, 2 or 5, at most ``most`` steps."""
    least_step = (high - low) / most
    power = 10.0 ** np.floor(np.log10(least_step))
    step = next(power * k for k in (1, 2, 5, 10) if power * k >= least_step * (1 - 1e-9))
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    return [round(float(k * step), 12) for k in range(first, last + 1)]


def thinned(x: Array, y: Array, most: int) -> tuple[Array, Array]:
    """At most ``most`` points of x, y (n,) that keep every peak: the lowest and the highest of equal stretches."""
    if x.size <= most:
        return x, y
    edges = np.linspace(0, x.size, most // 2 + 1).astype(int)[:-1]
    position = np.repeat(np.arange(edges.size), np.diff(np.append(edges, x.size)))
    order = np.lexsort((y, position))
    keep = np.sort(np.concatenate([order[edges], order[np.append(edges[1:], x.size) - 1]]))
    return x[keep], y[keep]


_OF_PAGE = {day.upper(): f"var(--{name})" for name, day, _ in ON_PAGES}


def in_colours_of_page(svg: str) -> str:
    """The same drawing in the colours of ``casr.html``, which change by night. White in three digits stays white."""
    return re.sub(r"#[0-9A-Fa-f]{6}\b", lambda found: _OF_PAGE.get(found[0].upper(), found[0]), svg)


def _own_ids(svg: str, name: str) -> str:
    """Ids that no other drawing of the page has; patterns are the page's."""
    svg = svg.replace('aria-labelledby="title desc"', f'aria-labelledby="{name}-title {name}-desc"')
    return re.sub(r'(\bid="|url\(#(?=in|bar))', rf"\g<1>{name}-", svg)


def _path(places: Array) -> str:
    """Lines from place to place in whole steps; a gap where a place is not known."""
    known = np.flatnonzero(np.isfinite(places).all(axis=1))
    if not known.size:
        return ""
    whole = np.rint(places[known]).astype(np.int64)
    return "".join(map(_piece, np.split(whole, np.flatnonzero(np.diff(known) > 1) + 1)))


def _piece(places: NDArray[np.int64]) -> str:
    steps = np.diff(places, axis=0)
    numbers = steps[np.any(steps != 0, axis=1)].ravel().tolist()
    # a minus sign separates as well as a blank
    way = "l" + " ".join(map(str, numbers)).replace(" -", "-") if numbers else "h0"
    return f"M{places[0, 0]} {places[0, 1]}{way}"


def _text(x: float, y: float, words: str, anchor: str = "start", colour: str = "") -> str:
    fill = f' fill="{colour}"' if colour else ""
    side = f' text-anchor="{anchor}"' if anchor != "start" else ""
    return f'<text x="{x:.0f}" y="{y:.0f}"{side}{fill}>{escape(words)}</text>'
