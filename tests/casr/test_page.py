"""Pages: one file, right numbers, nothing hidden that a reader must know."""

from __future__ import annotations

import dataclasses
import re
from html.parser import HTMLParser

import pytest

from casr.frames import FrameSequence, force_per_frame
from casr.page import Embedded, index_page, press_page
from casr.page.wording import number, verdict
from casr.score import Score, score
from casr.synthetic import PressSettings, TimelineSettings, simulate_press

PICTURE = Embedded("A title", "What it shows & why.", "image/png", b"\x89PNG")
EMPTY = {"meta", "img", "br", "path"}


@pytest.fixture(scope="module")
def scored() -> Score:
    press = simulate_press(PressSettings(stiffness_n_per_mm=1.11, timeline=TimelineSettings(loading_s=0.5)))
    log = press.timeline
    force_n = force_per_frame(log.log_force_n, log.log_frame_index, len(press.frames))
    found = score(FrameSequence(press.frames, press.settings.camera, force_n))
    return dataclasses.replace(found, name="a <b> press", notes=())


class Balanced(HTMLParser):
    """Fails on a tag that is closed out of turn."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def check(page: str) -> None:
    parser = Balanced()
    parser.feed(re.sub(r"<path[^>]*/>", "", page))
    assert parser.open == []
    assert "<b> press" not in page
    assert not re.search(r"<script|<link|@import|url\(|src=\"(?!data:)", page)


def test_a_press_page_stands_alone(scored: Score) -> None:
    page = press_page(scored, [PICTURE], camera=None, n_frames=30, shape=(300, 300))
    check(page)
    assert "data:image/png;base64,iVBORw==" in page
    assert "What it shows &amp; why." in page
    assert page.count("<tr>") == len(scored.frames) + 1
    assert f"{number(scored.rate.value)} mm²/N" in page  # type: ignore[union-attr]
    assert "prefers-color-scheme:dark" in page


def test_notes_come_before_the_pictures(scored: Score) -> None:
    noted = dataclasses.replace(scored, notes=("The force falls in 3 steps.",))
    page = press_page(noted, [PICTURE], camera=None, n_frames=30, shape=(300, 300))
    assert page.index("The force falls in 3 steps.") < page.index(">Pictures</h2>")


def test_every_setting_is_shown(scored: Score) -> None:
    page = press_page(scored, [], camera=None, n_frames=30, shape=(300, 300))
    assert [f.name for f in dataclasses.fields(scored.settings) if f.name not in page] == []
    assert [f.name for f in dataclasses.fields(scored.settings.flow) if f"flow.{f.name}" not in page] == []


def test_verdicts(scored: Score) -> None:
    assert verdict(scored)[0] == "good"
    assert "Softer specimens" in verdict(scored)[2]
    assert verdict(dataclasses.replace(scored, notes=("x",)))[0] == "usable"
    assert verdict(dataclasses.replace(scored, front_spread=None, force_n=None))[1] == "No spread rate."
    shrinking = dataclasses.replace(scored.front, area=scored.front.area[::-1])
    assert verdict(dataclasses.replace(scored, front=shrinking))[0] == "bad"
    saturated = dataclasses.replace(scored.initial, saturated=True)
    assert verdict(dataclasses.replace(scored, initial=saturated))[0] == "bad"


def test_the_index_links_every_press_and_names_the_failed(scored: Score) -> None:
    page = index_page("presses", {"one": scored, "two": scored}, {"three": "frames: wanted <x>."}, "pages")
    check(page)
    for name in ("one", "two"):
        assert page.count(f'href="pages/{name}.html"') == 2
    assert "three: frames: wanted &lt;x&gt;." in page
    assert page.count("<svg") == 2


def test_an_index_of_nothing() -> None:
    page = index_page("presses", {}, {"three": "bad"}, "pages")
    check(page)
    assert "0 presses scored" in page


@pytest.mark.parametrize(
    ("value", "text"), [(None, "–"), (float("nan"), "–"), (0.123456, "0.1235"), (123456.0, "123456"), (-2.5, "-2.5")]
)
def test_numbers_for_people(value: float | None, text: str) -> None:
    assert number(value) == text
