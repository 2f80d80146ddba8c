"""Pages: one file, right numbers, nothing hidden that a reader must know."""

from __future__ import annotations

import dataclasses
import re
from html.parser import HTMLParser

import pytest

from casr.frames import FrameSequence, force_per_frame
from casr.page import Embedded, index_page, press_page
from casr.page.wording import error_parts, growths, headline, interval, left_out, number, verdict
from casr.scoring import Score, score
from emg2vsa.worlds.tactile import PressSettings, TimelineSettings, simulate_press

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
    assert scored.front_spread is not None
    no_rate = dataclasses.replace(scored.front_spread, rate=None, interval=None)
    assert verdict(dataclasses.replace(scored, front_spread=no_rate, force_n=None))[1] == "No spread rate."
    back = dataclasses.replace(scored.front, area=scored.front.area[::-1])
    assert verdict(dataclasses.replace(scored, front=back))[0] == "bad"
    assert verdict(dataclasses.replace(scored, doubts=("slip",)))[:2] == ("bad", "Check this press:")
    saturated = dataclasses.replace(scored, initial=dataclasses.replace(scored.initial, saturated=True))
    assert verdict(saturated)[0] == "good"
    assert verdict(by_skin(saturated))[0] == "bad"


def by_skin(scored: Score) -> Score:
    return dataclasses.replace(scored, settings=dataclasses.replace(scored.settings, quantity="skin"))


def undetermined(scored: Score) -> Score:
    return dataclasses.replace(scored, front_doubt="the contact is too small", front_spread=None)


def test_a_front_that_is_not_determined_is_the_headline_and_no_number(scored: Score) -> None:
    doubtful = undetermined(scored)
    kind, word, text = verdict(doubtful)
    assert (kind, word) == ("bad", "Not determined:")
    for way_out in ("the contact is too small", "larger contact", "pin_length_mm", "--quantity skin"):
        assert way_out in text
    facts = {name: value for name, value, _ in headline(doubtful)}
    assert facts["CASR (front)"] == "not determined"
    assert "A_c0 (front)" not in facts
    assert "A_c0 (skin)" in facts
    page = press_page(doubtful, [], camera=None, n_frames=30, shape=(300, 300))
    check(page)
    assert scored.rate is not None
    assert number(scored.rate.value) not in page
    assert verdict(by_skin(doubtful))[0] == "good"


def test_the_headline_names_both_quantities_with_their_total_intervals(scored: Score) -> None:
    for asked, other in (("front", "skin"), ("skin", "front")):
        shown = scored if asked == "front" else by_skin(scored)
        facts = headline(shown)
        names = [name for name, _, _ in facts]
        assert names[:3] == [f"CASR ({asked})", "Forces", f"CASR ({other})"]
        for spread, (_, value, remark) in ((shown.chosen, facts[0]), (shown.other, facts[2])):
            assert spread.rate is not None
            assert spread.interval is not None
            assert value.startswith(number(spread.rate.value))
            assert remark == f"95 %: {number(spread.interval.low)} to {number(spread.interval.high)}"
    assert scored.force_n is not None
    assert scored.front_spread is not None
    forces = {name: (value, remark) for name, value, remark in headline(scored)}["Forces"]
    assert forces[0] == "0.5 to 7 N"
    assert f"{scored.force_n[-1]:.2f} N" in forces[1]
    assert f"determined from {scored.front_spread.first_n:.2f} N" in forces[1]


def test_the_narrow_interval_says_that_it_is_scatter_only(scored: Score) -> None:
    rate = scored.rate
    assert rate is not None
    page = press_page(scored, [], camera=None, n_frames=30, shape=(300, 300))
    assert f"scatter only, 95 %: {number(rate.scatter_low)} to {number(rate.scatter_high)}" in page
    assert page.count(number(rate.scatter_low)) == 1
    assert scored.front_spread is not None
    bare = dataclasses.replace(scored, front_spread=dataclasses.replace(scored.front_spread, interval=None))
    assert interval(bare.chosen).startswith("scatter only")


def test_parts_of_the_interval_add_up(scored: Score) -> None:
    parts = dict(error_parts(scored.chosen))
    shares = {name: float(text.removesuffix(" %")) for name, text in parts.items()}
    total = shares.pop("total")
    assert set(shares) == {
        "scatter", "dome", "misfit", "pin length", "depth", "beyond the frames", "narrow window", "force zero",
    }  # fmt: skip
    assert sum(share**2 for share in shares.values()) ** 0.5 == pytest.approx(total, abs=0.1)
    assert "mounting" in left_out(scored.chosen)


def test_every_frame_has_its_interval_and_dashes_where_it_is_not_determined(scored: Score) -> None:
    page = press_page(scored, [], camera=None, n_frames=30, shape=(300, 300))
    assert number(float(scored.front.area[-1])) in page
    doubtful = press_page(undetermined(scored), [], camera=None, n_frames=30, shape=(300, 300))
    assert doubtful.count('<td class="n">–</td>') >= 3 * len(scored.frames)


def test_the_index_links_every_press_and_names_the_failed(scored: Score) -> None:
    page = index_page("presses", {"one": scored, "two": scored}, {"three": "frames: expected <x>."}, "pages")
    check(page)
    for name in ("one", "two"):
        assert page.count(f'href="pages/{name}.html"') == 2
    assert "three: frames: expected &lt;x&gt;." in page
    assert page.count("<svg") == 2


def test_the_index_names_presses_to_check_and_those_not_determined(scored: Score) -> None:
    doubted = dataclasses.replace(scored, doubts=("slip",))
    page = index_page("presses", {"one": doubted, "two": undetermined(scored)}, {}, "pages")
    check(page)
    assert "Check one: slip" in page
    assert "Not determined: two: the contact is too small" in page
    assert page.count("<svg") == 1, "nothing to draw of the second"


def test_an_index_of_nothing() -> None:
    page = index_page("presses", {}, {"three": "bad"}, "pages")
    check(page)
    assert "0 presses scored" in page


@pytest.mark.parametrize(
    ("value", "text"), [(None, "–"), (float("nan"), "–"), (0.123456, "0.1235"), (123456.0, "123456"), (-2.5, "-2.5")]
)
def test_numbers_for_people(value: float | None, text: str) -> None:
    assert number(value) == text


def test_growth_by_the_printed_law_says_so(scored: Score) -> None:
    assert all(times.endswith(" times") for _, times in growths(scored))
    as_printed = dataclasses.replace(scored, settings=dataclasses.replace(scored.settings, area_law="paper"))
    said = dict(growths(as_printed))
    assert said["skin"].endswith(" times by equation (1) as printed")
    assert said["front"].endswith(" times")
