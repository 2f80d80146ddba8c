"""The page of one press: its numbers, what they mean, the pictures they come from, every frame."""

from __future__ import annotations

import base64
import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import casr
from casr import html
from casr.page.wording import (
    MEANING,
    camera_lag,
    error_parts,
    force_zero,
    headline,
    left_out,
    number,
    scatter_only,
    verdict,
)
from casr.press_tables import frame_rows
from casr.spread import readable

if TYPE_CHECKING:
    from casr.camera import Camera
    from casr.scoring import Score


@dataclass(frozen=True)
class Embedded:
    """A picture that travels inside the page. media : ``image/png`` or ``image/svg+xml``."""

    title: str
    caption: str
    media: str
    data: bytes


def press_page(
    score: Score, pictures: Sequence[Embedded], *, camera: Camera | None, n_frames: int, shape: tuple[int, int]
) -> str:
    """The page as HTML.

    n_frames, shape : number of frames in the sequence and their (height, width), px.
    """
    notes = html.section("notes", "Notes", html.bullets(score.notes)) if score.notes else ""
    body = (
        html.statement(*verdict(score))
        + html.tiles(headline(score))
        + notes
        + html.section("pictures", "Pictures", _pictures(pictures))
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


def _pictures(pictures: Iterable[Embedded]) -> str:
    drawn = "".join(
        f"<figure><h3>{escape(p.title)}</h3>"
        f'<img alt="{escape(p.caption)}" src="data:{p.media};base64,{base64.b64encode(p.data).decode()}">'
        f"<figcaption>{escape(p.caption)}</figcaption></figure>\n"
        for p in pictures
    )
    return f'<div class="pictures">{drawn}</div>\n'


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
