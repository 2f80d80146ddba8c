"""The page of many presses: a table, every curve on the same axes, and what could not be scored."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from casr import html
from casr.page.press import whole_page
from casr.page.wording import UNDEFINED, number, verdict
from casr.palette import BLUE
from casr.spread import readable

if TYPE_CHECKING:
    from casr.scoring import Score

_WIDTH, _HEIGHT, _LEFT, _BOTTOM, _TOP = 240, 170, 44, 30, 10


def index_page(title: str, scores: Mapping[str, Score], failures: Mapping[str, str], folder: str) -> str:
    """The page as HTML; each press links to ``folder/<name>.html``. failures : press to the reason in words."""
    links = {name: f"{folder}/{name}.html" for name in scores}
    body = _summary(scores, failures) + html.section("presses", "Presses", _table(scores, links))
    drawn = {name: score for name, score in scores.items() if score.force_n is not None and score.first is not None}
    if drawn:
        body += html.section("curves", "Contact area against force, all on the same axes", _curves(drawn, links))
    return whole_page(title, "Contact area spread rate (CASR) of every press", body)


def _summary(scores: Mapping[str, Score], failures: Mapping[str, str]) -> str:
    kinds = [verdict(score)[0] for score in scores.values()]
    kind = "bad" if failures or "bad" in kinds else "usable" if "usable" in kinds else "good"
    pixels = sum(score.area_unit == "px2" for score in scores.values())
    counts = f"{kinds.count('good')} good, {kinds.count('usable')} with notes, {kinds.count('bad')} to check"
    in_px2 = f" No camera file for {pixels}: their areas are in px², not mm²." if pixels else ""
    said = html.statement(kind, f"{len(scores)} presses scored.", f"{counts}, {len(failures)} not scored.{in_px2}")
    checked = [f"Check {name}: {doubt}" for name, score in scores.items() for doubt in score.doubts]
    undetermined = [
        f"Not determined: {name}: {score.front_doubt}" for name, score in scores.items() if score.first is None
    ]
    return said + html.bullets(
        [*(f"Not scored: {name}: {reason}" for name, reason in failures.items()), *undetermined, *checked]
    )


def _table(scores: Mapping[str, Score], links: Mapping[str, str]) -> str:
    heads = (
        "Press", "Quantity", "CASR", "low", "high", "unit", "Frames from", "to (N)", "Determined from (N)",
        "Skin / front growth", "low", "high", "The other CASR", "Frames", "Notes",
    )  # fmt: skip
    rows = []
    for name, score in scores.items():
        rate, total, other = score.rate, score.interval, score.other.rate
        ends = (UNDEFINED, UNDEFINED) if score.force_n is None else (f"{score.force_n[k]:.2f}" for k in (0, -1))
        front = score.front_spread
        since, ratio = (front.first_n, front.skin_over_front) if front else (None, (None, None, None))
        rows.append((
            name, score.settings.quantity, number(rate.value if rate else None), number(total.low if total else None),
            number(total.high if total else None), readable(rate.unit if rate else score.area_unit), *ends,
            number(since, 3), *(number(each, 3) for each in ratio), number(other.value if other else None),
            str(len(score.frames)), str(len(score.notes)),
        ))  # fmt: skip
    caption = (
        "Low and high: total 95 % interval. Front: the contact area, its edge followed; skin: growth of the first "
        "contact's skin. A dash: not determined, or without a force log."
    )
    return html.table(caption, heads, rows, [links[name] for name in scores])


def _curves(scores: Mapping[str, Score], links: Mapping[str, str]) -> str:
    high_n = max(float(np.nanmax(score.force_n)) for score in scores.values() if score.force_n is not None)
    units = {score.area_unit for score in scores.values()}
    high = {unit: max(float(np.nanmax(s.area)) for s in scores.values() if s.area_unit == unit) for unit in units}
    figures = "".join(
        f'<figure><a href="{escape(links[name])}">{_curve(score, high_n, high[score.area_unit])}</a>'
        f"<figcaption>{escape(name)}</figcaption></figure>"
        for name, score in scores.items()
    )
    return f'<div class="pictures small-ones">{figures}</div>\n'


def _curve(score: Score, high_n: float, high: float) -> str:
    """Dots on axes from zero to the highest force and area of all presses."""
    assert score.force_n is not None
    floor, right = _HEIGHT - _BOTTOM, _WIDTH - 8
    known = np.isfinite(score.force_n) & np.isfinite(score.area)
    x = np.rint(_LEFT + score.force_n[known] / high_n * (right - _LEFT)).astype(int)
    y = np.rint(floor - score.area[known] / high * (floor - _TOP)).astype(int)
    dots = "".join(f"M{px} {py}h0" for px, py in zip(x.tolist(), y.tolist(), strict=True))
    unit = readable(score.area_unit)
    words = (
        f'<text x="{_LEFT}" y="{_HEIGHT - 10}">0</text><text x="{right}" y="{_HEIGHT - 10}" text-anchor="end">'
        f'{high_n:.2g} N</text><text x="{_LEFT - 4}" y="{_TOP + 10}" text-anchor="end">{number(high, 3)}</text>'
        f'<text x="{_LEFT - 4}" y="{_TOP + 24}" text-anchor="end">{unit}</text>'
    )
    label = f"contact area against force, {escape(score.name)}"
    return (
        f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{label}" '
        f'fill="#1a1a1a" font-size="12"><path d="M{_LEFT} {_TOP}V{floor}H{right}" fill="none" stroke="#555"/>'
        f'<path d="{dots}" stroke="{BLUE}" stroke-width="4" stroke-linecap="round"/>{words}</svg>'
    )
