from __future__ import annotations

import re

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.figures.canvas import PairBar, hazen_box, inline_svg, new_figure, pdf_bytes, stars, style, svg_text
from emg2vsa.figures.cocontraction import draw_cocontraction, draw_interpolation
from emg2vsa.figures.palette import BLUE, GREEN, RED, YELLOW, activity_scale, looks
from emg2vsa.profiles import Profile

PAPER = ["S1", "S2", "S3", "S4", "S5"]


def profile(name: str, b_v: float, sd: float = 1e-6, source: str = "measured") -> Profile:
    force = np.linspace(0.5, 7, 50)
    return Profile(name, 1.0, 4e-5, b_v, force, 4e-5 + b_v * np.log(force), source, 10, np.full(50, sd))


def test_specimens_wear_the_papers_colours_and_are_told_apart_without_colour():
    look = looks(PAPER, "S_new")
    assert [look[name].colour for name in ("S1", "S3", "S5", "S_new")] == [BLUE, GREEN, YELLOW, RED]
    assert len({one.marker for one in look.values()}) == len({one.dash for one in look.values()}) == 6
    assert len(looks([f"S{i}" for i in range(20)])) == 20  # more specimens than looks


def test_hazen_quartiles_as_matlab_draws_them():
    # prctile(1:10, [25 50 75]) in MATLAB is 3, 5.5, 8
    assert hazen_box(np.arange(1.0, 11.0)) == (1.0, 3.0, 5.5, 8.0, 10.0)
    # whiskers stop at one and a half ranges
    assert hazen_box(np.array([1.0, 2, 3, 4, 5, 6, 7, 8, 9, 100]))[4] == 9.0


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=30))
def test_a_box_is_in_order(values):
    low, q1, median, q3, high = hazen_box(np.array(values))
    assert q1 <= median <= q3
    assert min(values) <= low
    assert high <= max(values)


@pytest.mark.parametrize(
    ("p", "mark"),
    [(0.05, "ns"), (0.049, "*"), (0.01, "*"), (0.0099, "**"), (0.001, "**"), (1e-3 - 1e-9, "***"), (1e-4, "****"),
     (0.0, "****"), (float("nan"), "")],
)  # fmt: skip
def test_stars(p, mark):
    assert stars(p) == mark


@pytest.mark.parametrize(
    ("unit", "largest", "shown"),
    [("V", 4e-5, "µV"), ("V", 2e-3, "mV"), ("V", 3.0, "V"), ("1", 0.4, ""), ("V", np.nan, "µV")],
)
def test_activity_is_shown_in_a_readable_unit(unit, largest, shown):
    scale = activity_scale(unit, [np.nan, largest])
    assert scale.unit == shown
    assert scale.label("b") == (f"b ({shown})" if shown else "b")


ONE_BAR = (PairBar(0, 1, 0.0391),)


def drawn(bars=ONE_BAR, slopes=None, sd=1e-6):
    profiles = [profile("S1", 2e-5, sd), profile("S5", 7e-6, sd)]
    b = slopes or [np.linspace(1.8e-5, 2.2e-5, 10), np.linspace(6e-6, 8e-6, 10)]
    look = looks(["S1", "S5"])
    scale = activity_scale("V", profiles[0].v)
    return draw_cocontraction(profiles, b, bars, [look["S1"], look["S5"]], scale, "Fisher's LSD, uncorrected")


def test_every_slope_is_a_mark_in_shown_units_and_bars_carry_their_stars():
    with style():
        boxes = drawn().axes[1]
    marks = next(line for line in boxes.lines if len(line.get_ydata()) == 10)
    assert np.allclose(np.sort(marks.get_ydata()), np.linspace(18, 22, 10))
    assert np.allclose(np.round(marks.get_xdata()), 0)
    assert [text.get_text() for text in boxes.texts] == ["*"]
    assert boxes.get_title(loc="right") == "Fisher's LSD, uncorrected"


def test_a_single_trial_without_spread_is_drawn():
    with style():
        svg = svg_text(drawn(bars=(), slopes=[np.array([2e-5]), np.empty(0)], sd=float("nan")))
    assert "nan" not in svg.lower()


def test_interpolated_and_measured_of_the_same_name_look_different():
    measured, new = profile("S2", 1.7e-5), profile("S2", 1.6e-5, source="interpolated")
    with style():
        half_v = np.full(new.v.size, 1e-6)
        axes = draw_interpolation([measured], new, half_v, looks(["S2"]), activity_scale("V", new.v)).axes[0]
    (band,) = axes.collections
    low, high = np.array([new.v.min(), new.v.max()]) * 1e6 + [-1, 1]
    extent = band.get_paths()[0].get_extents()
    assert (extent.ymin, extent.ymax) == (pytest.approx(low), pytest.approx(high))
    first, second = axes.lines
    assert first.get_color() != second.get_color()
    assert first.get_marker() != second.get_marker()
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names == ["S2", "S2 (interpolated)"]


def test_drawing_twice_gives_the_same_bytes():
    with style():
        first, second = ((svg_text(figure), pdf_bytes(figure)) for figure in (drawn(), drawn()))
    assert first == second


def test_two_figures_on_a_page_share_no_id():
    with style():
        figure, _ = new_figure(80, 40, (10, 2, 10, 2))
        svg = svg_text(figure)
    pages = [inline_svg(svg, prefix, "Title &amp; more", "Words") for prefix in ("one", "two")]
    ids = [set(re.findall(r'\bid="([^"]+)"', page)) for page in pages]
    assert ids[0]
    assert not ids[0] & ids[1]
    for page, own in zip(pages, ids, strict=True):
        assert set(re.findall(r'href="#([^"]+)"', page)) | set(re.findall(r"url\(#([^)]+)\)", page)) <= own
        assert "<title" in page
        assert "xlink" not in page


def test_settings_of_the_user_for_matplotlib_change_no_figure():
    def svg() -> str:
        with style():
            return svg_text(drawn())

    own = svg()
    with mpl.rc_context({"font.size": 20, "lines.linewidth": 5, "axes.facecolor": "red"}):
        assert svg() == own
        assert mpl.rcParams["font.size"] == 20
