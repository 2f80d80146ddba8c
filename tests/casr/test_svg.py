"""Drawings of pages: marks lie where their values are, in words and colours that everybody can read."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from casr.palette import BLUE, INK, RED
from casr.svg import Axes, Picture, in_colours_of_page, plot, thinned, ticks

VIEW = (0.0, 1.0, 10.0, -1.0)


def axes(**more):
    return Axes(VIEW, ("x", "y"), 1000, 400, **more)


def ends_of(path):
    """Places of a path of relative steps."""
    numbers = np.array(re.findall(r"-?\d+", path), dtype=int).reshape(-1, 2)
    return np.cumsum(numbers, axis=0)


def paths(svg, colour):
    return re.findall(rf'<path d="([^"]+)"[^>]* stroke="{re.escape(colour)}"', svg)


@given(low=st.floats(-1e4, 1e4), span=st.floats(1e-3, 1e5), most=st.integers(2, 12))
def test_ticks_are_round_few_and_inside(low, span, most):
    found = ticks(low, low + span, most)
    assert len(found) <= most + 1
    rounding = 1e-9 * span + 4 * np.spacing(abs(low) + span)
    assert all(low - rounding <= tick <= low + span + rounding for tick in found)
    if len(found) > 1:
        assert np.allclose(np.diff(found), found[1] - found[0])


def test_a_line_is_drawn_where_its_points_are_with_a_gap_where_one_is_not_known():
    drawn = axes()
    drawn.line([(0.0, -1.0), (2.5, 0.0), (np.nan, 0.0), (5.0, 0.5), (10.0, 1.0)], RED)
    (path,) = paths(drawn.svg("n", "t", "d", page=False), RED)
    left, right = (ends_of(part) for part in path[1:].split("M"))
    assert left.tolist() == [[120, 456], [370, 256]]
    assert right.tolist() == [[620, 156], [1120, 56]]


def test_ticks_of_a_logarithmic_axis_tell_the_quantity():
    drawn = Axes((0.0, 1.0, 1.0, 0.0), ("kappa", "y"), 1000, 400, logarithmic=True)
    places = re.findall(r'<text x="(\d+)" y="492" text-anchor="middle">(\d+)<', drawn.svg("n", "t", "d"))
    assert [(int(x), value) for x, value in places][:2] == [(421, "2"), (722, "4")]
    assert places[-1] == ("1120", "10")


def test_a_line_of_nothing_is_nothing_and_lost_points_leave_no_mark():
    drawn = axes()
    drawn.line([(np.nan, 1.0)], RED)
    drawn.dots([(1.0, 1.0), (np.nan, np.nan)], RED)
    svg = drawn.svg("n", "t", "d")
    assert "nan" not in svg
    assert svg.count("h0") == 1


def test_words_at_the_ends_do_not_cover_each_other():
    drawn = axes(beside=40)
    drawn.ends(np.array([0.5, 0.5, np.nan, -3.0]), ["a", "b", "lost", "low"], [INK] * 4)
    heights = {word: int(y) for y, word in re.findall(r'y="(\d+)" fill="[^"]+">(\w+)<', drawn.svg("n", "t", "d"))}
    assert heights["b"] - heights["a"] >= 24
    assert heights["low"] <= 56 + 400 + 8
    assert "lost" not in heights


def test_a_drawing_tells_what_it_shows_and_shares_no_id():
    drawn = axes()
    drawn.colour_bar(1.0, ("#000000", "#ffffff"), "growth")
    drawn.shade(1.0, 2.0, "url(#warned)", "press <3>")
    one, two = (drawn.svg(name, "A & B", "from <1> to 2") for name in ("one", "two"))
    ids = [set(re.findall(r'\bid="([^"]+)"', svg)) for svg in (one, two)]
    assert ids[0].isdisjoint(ids[1])
    for name, svg in (("one", one), ("two", two)):
        ElementTree.fromstring(svg)
        assert f'aria-labelledby="{name}-title {name}-desc"' in svg
        assert f'<desc id="{name}-desc">from &lt;1&gt; to 2</desc>' in svg
        asked = set(re.findall(r"url\(#([^)]+)", svg)) - {"warned"}
        assert asked <= set(re.findall(r'\bid="([^"]+)"', svg))
    assert "<title>press &lt;3&gt;</title>" in one


def test_a_page_gives_the_colours_and_a_file_is_white():
    picture = Picture("p", "title", "caption", plot(("x", "y"), (0, 1), (0, 1)))
    picture.axes.dots([(0.5, 0.5)], BLUE)
    assert "var(--blue)" in picture.inline()
    assert not re.search(r"#[0-9A-Fa-f]{6}", picture.inline())
    file = picture.file().decode()
    assert "var(" not in file
    assert 'fill="#fff"' in file
    assert in_colours_of_page(f'fill="{INK.lower()}" stroke="#123456"') == 'fill="var(--ink)" stroke="#123456"'


def test_a_legend_goes_on_in_a_new_line_and_the_drawing_grows():
    few, many = axes(), axes()
    few.line([(0, 0), (1, 1)], RED, label="one")
    for i in range(12):
        many.line([(0, 0), (1, 1)], RED, label=f"a rather long label {i}")
    heights = [float(re.search(r'viewBox="0 0 \d+ (\d+)"', each.svg("n", "t", "d"))[1]) for each in (axes(), few, many)]
    assert heights[0] < heights[1] < heights[2]


@given(st.integers(1, 5000), st.integers(0, 2**32 - 1))
def test_thinning_keeps_order_and_extremes(n, seed):
    y = np.random.default_rng(seed).standard_normal(n)
    x = np.arange(n, dtype=float)
    few_x, few_y = thinned(x, y, 300)
    assert few_x.size <= 300
    assert np.all(np.diff(few_x) >= 0)
    assert np.array_equal(y[few_x.astype(int)], few_y)
    assert few_y.max() == y.max()
    assert few_y.min() == y.min()
