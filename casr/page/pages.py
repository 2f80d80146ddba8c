"""The page of one press, and that of many: numbers, what they mean, the pictures they come from."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

import casr
from casr import html
from casr.camera import Camera
from casr.page.wording import (
    MEANING,
    UNDEFINED,
    camera_lag,
    error_parts,
    force_zero,
    headline,
    left_out,
    number,
    scatter_only,
    verdict,
)
from casr.palette import BLUE
from casr.press_tables import frame_rows
from casr.scored import Score
from casr.spread import readable
from casr.svg import Axes, Picture


def press_page(
    score: Score, pictures: Sequence[Picture], *, camera: Camera | None, n_frames: int, shape: tuple[int, int]
) -> str:
    """The page as HTML.

    n_frames, shape : number of frames in the sequence and their (height, width), px.
    """
    notes = html.section("notes", "Notes", html.bullets(score.notes)) if score.notes else ""
    body = (
        html.statement(*verdict(score))
        + html.tiles(headline(score))
        + notes
        + html.section("pictures", "Pictures", html.pictures(map(picture_figure, pictures)))
        + html.section(
            "numbers",
            "Numbers and settings",
            html.details("What the interval is made of", _intervals(score)),
            html.details("Every frame", _frames(score)),
            html.details("Settings", html.pairs(_settings(score.settings))),
            html.details("Where the numbers come from", html.pairs(_origin(score, camera, n_frames, shape))),
        )
    )
    return whole_page(score.name, "Contact area spread rate (CASR) of one press", body)


def whole_page(title: str, sub: str, body: str) -> str:
    """Title, subtitle and program around a body of HTML."""
    header = f'<h1>{escape(title)}</h1><p class="sub">{escape(sub)}</p>'
    return html.page(title, header, (), body, f'<p class="small">casr {casr.__version__}</p>')


def picture_figure(picture: Picture) -> str:
    """A drawing with its title and caption, as HTML."""
    drawn, caption = picture.inline(), escape(picture.caption)
    return f"<figure><h3>{escape(picture.title)}</h3>{drawn}<figcaption>{caption}</figcaption></figure>\n"


def _intervals(score: Score) -> str:
    """Parts of the total interval of each rate."""
    said = "Standard errors in per cent of the CASR; the total is the root of the sum of their squares."
    body = html.paragraph(said)
    for spread in (score.chosen, score.other):
        narrow = scatter_only(spread) or "no interval for the scatter"
        body += html.heading(f"{spread.quantity.capitalize()}: {MEANING[spread.quantity]}")
        body += html.pairs([*error_parts(spread), ("left out", left_out(spread)), ("beside it", narrow)])
    return body


def _frames(score: Score) -> str:
    """Divergence and growth are those of the step that leads to a frame."""
    unit = readable(score.area_unit)
    heads = (
        "Frame", "Force (N)", f"Front ({unit})", "low", "high", f"Skin ({unit})", "Pins inside", "Shear x (px)",
        "Shear y (px)", "Torsion (°)", "Divergence", "Log growth",
    )  # fmt: skip
    rows = []
    for i, (frame, force, area, low, high, skin, x, y, turn, inside, counts) in enumerate(frame_rows(score)):
        front = map(number, (area, low, high)) if counts else ("–", "–", "–")
        steps = (score.divergence[i - 1], score.log_growth[i - 1]) if i else (None, None)
        rows.append((
            str(frame), number(force), *front, number(skin), str(inside), *(number(each, 3) for each in (x, y, turn)),
            *map(number, steps),
        ))  # fmt: skip
    caption = (
        "Low and high: 95 % of the front's area. Front with a dash: not determined. Shear and torsion: of the pins "
        "inside, since rest. Divergence and log growth: of the skin, in the step that leads to the frame."
    )
    return html.table(caption, heads, rows)


def _settings(settings: object, prefix: str = "") -> list[tuple[str, str]]:
    """Names and values of a settings dataclass and those inside it."""
    found: list[tuple[str, str]] = []
    for field in dataclasses.fields(settings):  # type: ignore[arg-type]
        value = getattr(settings, field.name)
        name = f"{prefix}{field.name}"
        if dataclasses.is_dataclass(value) and not hasattr(value, "polygon_px"):
            found += _settings(value, f"{name}.")
        elif value is None or isinstance(value, (str, int, float, tuple)):
            found.append((name, "not set" if value is None else str(value)))
        else:
            found.append((name, f"polygon of {len(value.polygon_px)} corners"))
    return found


def _origin(score: Score, camera: Camera | None, n_frames: int, shape: tuple[int, int]) -> list[tuple[str, str]]:
    facts = [("program", f"casr {casr.__version__}"), ("frames", f"{n_frames} of {shape[1]} x {shape[0]} px")]
    if camera is None:
        facts.append(("camera", "none given: areas are in px²"))
    else:
        facts.append(("pixel size at the pins", " x ".join(f"{size:.5g}" for size in camera.mm_per_px) + " mm"))
        facts += _settings(camera, "camera ")
    if score.force_n is None:
        facts.append(("force", "none"))
    else:
        facts += [("force at rest", force_zero(score)), ("camera lag", camera_lag(score))]
    front = score.front
    model = front.model + (f", best {front.dome} on {front.stiffness_n_per_mm:g} N/mm" if front.dome else "")
    left = f"{front.misfit:.1%} of the motion of the pins is left over"
    return [
        *facts,
        ("front", f"{MEANING['front']}; by {model}; {left}"),
        ("skin", f"{MEANING['skin']}; initial area: Algorithm 1; growth: eq. (1); CASR: eq. (2), as the settings say"),
    ]


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
    figures = (
        f'<figure><a href="{escape(links[name])}">{_curve(score, high_n, high[score.area_unit], f"curve{place}")}</a>'
        f"<figcaption>{escape(name)}</figcaption></figure>"
        for place, (name, score) in enumerate(scores.items())
    )
    return html.pictures(figures, small=True)


def _curve(score: Score, high_n: float, high: float, name: str) -> str:
    """Dots on axes from zero to the highest force and area of all presses."""
    assert score.force_n is not None
    unit = readable(score.area_unit)
    axes = Axes((0.0, 1.05 * high, 1.03 * high_n, 0.0), ("force (N)", f"area ({unit})"), width=360, height=240)
    axes.dots(np.column_stack([score.force_n, score.area]), BLUE, size=8)
    title = f"Contact area against force, {score.name}"
    return axes.svg(name, title, f"The area grows to {number(float(np.nanmax(score.area)), 3)} {unit}.")
