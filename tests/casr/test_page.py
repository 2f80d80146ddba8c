"""Pages and tables: right numbers, nothing hidden that a reader must know, and words that can be read."""

from __future__ import annotations

import csv
import dataclasses
import io
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from casr.frames import FrameSequence
from casr.html import CSS, page
from casr.page import index_page, press_page
from casr.page.wording import error_parts, growths, headline, interval, left_out, number, verdict
from casr.press_tables import frame_columns, frame_rows, frames_csv, pins_csv
from casr.scoring import Score, score
from casr.svg import Picture, plot
from emg2vsa.figures.palette import INK, MUTED
from emg2vsa.worlds.tactile import PressSettings, TimelineSettings, simulate_press

PICTURE = Picture("one", "A title", "What it shows & why.", plot(("x", "y"), (0, 1), (0, 1)))
EMPTY = {"meta", "img", "br", "path"}


@pytest.fixture
def scored(soft: tuple[FrameSequence, Score]) -> Score:
    return dataclasses.replace(soft[1], name="a <b> press", notes=())


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
    assert not re.search(r"<script|<link|@import|url\((?!#)|src=\"(?!data:)", page)


def test_a_press_page_stands_alone(scored: Score) -> None:
    page = press_page(scored, [PICTURE], camera=None, n_frames=30, shape=(300, 300))
    check(page)
    assert page.count("<svg") == 1
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
    assert number(scored.rate.value) not in page
    assert verdict(by_skin(doubtful))[0] == "good"


def test_the_headline_names_both_quantities_with_their_total_intervals(scored: Score) -> None:
    for asked, other in (("front", "skin"), ("skin", "front")):
        shown = scored if asked == "front" else by_skin(scored)
        facts = headline(shown)
        names = [name for name, _, _ in facts]
        assert names[:3] == [f"CASR ({asked})", "Forces", f"CASR ({other})"]
        for spread, (_, value, remark) in ((shown.chosen, facts[0]), (shown.other, facts[2])):
            assert value.startswith(number(spread.rate.value))
            assert remark == f"95 %: {number(spread.interval.low)} to {number(spread.interval.high)}"
    forces = {name: (value, remark) for name, value, remark in headline(scored)}["Forces"]
    assert forces[0] == "0.5 to 7 N"
    assert f"{scored.force_n[-1]:.2f} N" in forces[1]
    assert f"determined from {scored.front_spread.first_n:.2f} N" in forces[1]


def test_the_narrow_interval_says_that_it_is_scatter_only(scored: Score) -> None:
    rate = scored.rate
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
        "scatter", "dome", "misfit", "pin length", "depth", "beyond the tables", "beyond the frames",
        "narrow window", "force zero",
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


@pytest.fixture(scope="module")
def hard() -> Score:
    made = simulate_press(PressSettings(stiffness_n_per_mm=7.63, timeline=TimelineSettings(loading_s=1.5)))
    return score(made.sequence())


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_every_pin_of_every_frame(hard: Score) -> None:
    found = rows(pins_csv(hard))
    n_pins = len(hard.rest)
    assert len(found) == n_pins * (1 + len(hard.frames))
    assert [int(row["frame"]) for row in found[::n_pins]] == [hard.rest_frame, *hard.frames]
    last = found[-n_pins:]
    assert [int(row["pin"]) for row in last] == list(range(n_pins))
    places = np.array([(float(row["x_px"]), float(row["y_px"])) for row in last])
    assert places == pytest.approx(hard.pins_px[-1], abs=5e-4)
    assert sum(int(row["inside"]) for row in last) == hard.front.pins_inside[-1]
    assert not any(int(row["inside"]) for row in found[:n_pins])


def test_a_lost_pin_is_empty(hard: Score) -> None:
    places = hard.pins_px.copy()
    places[-1, 7] = np.nan
    row = rows(pins_csv(dataclasses.replace(hard, pins_px=places)))[-len(hard.rest) + 7]
    assert (row["pin"], row["x_px"], row["y_px"]) == ("7", "", "")


def test_every_frame_with_its_interval(hard: Score) -> None:
    found = rows(frames_csv(hard))
    assert tuple(found[0]) == frame_columns("mm2")
    assert len(found) == len(hard.frames)
    area, low, high = (np.array([float(row[f"front_area{end}_mm2"]) for row in found]) for end in ("", "_low", "_high"))
    assert area == pytest.approx(hard.front.area, rel=1e-6)
    assert np.log(high / area) == pytest.approx(np.log(area / low), abs=1e-5)
    assert np.log(high / area) == pytest.approx(1.959964 * hard.front.relative_sd, rel=1e-3)
    assert [float(row["force_n"]) for row in found] == pytest.approx(hard.force_n, abs=1e-6)
    assert [float(row["skin_area_mm2"]) for row in found] == pytest.approx(hard.skin.area, rel=1e-6)
    assert [int(row["determined"]) for row in found] == hard.front.determined.astype(int).tolist()
    assert 0 < sum(int(row["determined"]) for row in found) < len(found), "the press begins too small"
    assert [float(row["shear_x_px"]) for row in found] == pytest.approx(hard.front.shear_px[:, 0], abs=1e-6)
    assert [float(row["torsion_deg"]) for row in found] == pytest.approx(hard.front.torsion_deg, abs=1e-6)


def test_what_is_not_known_is_empty_and_a_doubted_front_is_not_determined(hard: Score) -> None:
    doubted = dataclasses.replace(hard, force_n=None, front_doubt="too small", front_spread=None)
    assert {row[1] for row in frame_rows(doubted)} == {None}
    assert {row[-1] for row in frame_rows(doubted)} == {0}
    assert frames_csv(doubted).splitlines()[1].split(",")[1] == ""


def test_json_leaves_trajectories_to_the_table(hard: Score) -> None:
    found = hard.to_dict()
    assert "pins_px" not in found
    assert "inside" not in found["front"]
    assert len(found["contact_px"]) == len(hard.rest)
    assert found["rate"]["scatter_low"] > found["interval"]["low"], "the narrow interval goes by its name"


BY_DAY, BY_NIGHT = (dict(re.findall(r"--(\w+):(#[0-9A-F]+)", line)) for line in re.findall(r":root{(.*?)}", CSS, re.S))


def luminance(colour: str) -> float:
    digits = colour[1:] if len(colour) == 7 else "".join(2 * c for c in colour[1:])
    channels = [int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(first: str, second: str) -> float:
    light, dark = sorted((luminance(first), luminance(second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_contrast_is_computed_as_wcag_does():
    assert contrast("#000", "#ffffff") == pytest.approx(21)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)


@pytest.mark.parametrize("colours", [BY_DAY, BY_NIGHT], ids=["day", "night"])
@pytest.mark.parametrize("text", ["ink", "muted", "link", "good", "bad"])
@pytest.mark.parametrize("paper", ["page", "soft"])
def test_all_text_can_be_read(colours, text, paper):
    assert contrast(colours[text], colours[paper]) >= 4.5


@pytest.mark.parametrize("colour", [INK, MUTED])
def test_words_of_figures_can_be_read(colour):
    assert contrast(colour, "#ffffff") >= 4.5


def test_a_page_without_contents_has_nothing_to_skip():
    assert "nav" not in page("t", "", (), "", "").split("</style>")[1]
    assert '<a class="skip" href="#main">' in page("t", "", [("#a", "A")], "", "")
