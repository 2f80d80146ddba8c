from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from casr.overlays.frames import hexagons
from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.results import LawResult
from emg2vsa.figures.algorithm_1 import draw_steps
from emg2vsa.figures.canvas import PairBar, panel_grid, style, svg_text
from emg2vsa.figures.casr import (
    ConditionBoxes,
    Estimate,
    RateSeries,
    draw_areas,
    draw_conditions,
    draw_contacts,
    draw_estimates,
    draw_rates,
    law_curve,
)
from emg2vsa.figures.palette import looks
from emg2vsa.settings import CalibrationSettings

LOOKS = looks(["S1", "S3"], "S_new")
VALUES = np.linspace(9.0, 11.0, 10)


def test_panels_lie_row_by_row_inside_the_page_and_apart():
    with style():
        figure, rows = panel_grid(2, (2, 1), 40, (12, 2, 10, 8), (15, 12))
    boxes = [axes.get_position() for row in rows for axes in row]
    assert [axes.get_title(loc="left") for row in rows for axes in row] == ["(a)", "(b)", "(c)", "(d)"]
    assert boxes[0].width == pytest.approx(2 * boxes[1].width)
    assert boxes[0].x1 < boxes[1].x0
    assert boxes[2].y1 < boxes[0].y0
    assert min(box.x0 for box in boxes) > 0
    assert max(box.x1 for box in boxes) < 1
    assert figure.get_figwidth() * 25.4 == pytest.approx(181)


def draw(function, *arguments):
    """The figure, drawn in the style of all figures."""
    with style():
        return function(*arguments)


def marked(axes):
    return [line for line in axes.lines if line.get_marker() not in (None, "None", "")]


def test_differences_of_areas_share_one_scale_and_show_every_value():
    def boxes(first, second, names=("S1", "S3")):
        return [(names[0], first, LOOKS["S1"]), (names[1], second, LOOKS["S3"])]

    panels = [(f"{angle}°", boxes(VALUES - 10, 4 * VALUES - 40)) for angle in (0, 30)]
    pooled = "beside 0°", boxes(VALUES - 10, VALUES - 30, ("0°", "30°"))
    figure = draw(draw_areas, [*panels, pooled], [PairBar(0, 1, 0.2)])
    ((low, high),) = {axes.get_ylim() for axes in figure.axes}
    assert low < -21 < 4 < high
    assert [text.get_text() for text in figure.axes[-1].texts] == ["ns"]
    assert np.allclose(np.sort(marked(figure.axes[0])[1].get_ydata()), 4 * VALUES - 40)
    assert figure.axes[0].get_ylabel() == "Difference of area (%)"
    # a box without values leaves its place empty
    axes = draw(draw_areas, [("0°", boxes(VALUES, np.array([np.nan])))], []).axes[0]
    assert len(marked(axes)) == 1
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["S1", "S3"]


@pytest.mark.parametrize("turn", [0.0, 0.2, 0.9])
def test_hexagons_tile_the_lattice_of_the_pins(turn):
    grid = np.stack(np.meshgrid(np.arange(5), np.arange(5)), axis=-1).reshape(-1, 2).astype(float)
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    pins = 20 * grid @ np.array([[1.0, 0.0], [0.5, np.sqrt(0.75)]]) @ rotation
    tiles = hexagons(pins, pins)
    x, y = tiles[:, :, 0], tiles[:, :, 1]
    areas = np.abs(np.sum(x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1), axis=1)) / 2
    assert areas == pytest.approx(np.full(25, np.sqrt(0.75) * 20**2))  # one pin's share of the lattice
    # neighbours share two corners
    first, second = tiles[0], tiles[1]
    shared = np.linalg.norm(first[:, None] - second, axis=2) < 1e-6
    assert shared.sum() == 2


def test_the_picture_is_in_the_drawing_with_its_force_area_and_outline(run_of):
    picture = run_of("S5", 0.0, "modular").picture
    with style():
        figure = draw_contacts([("0°", picture)], "mm²")
        svg = svg_text(figure)
    title = figure.axes[0].get_title(loc="center")
    assert title == f"0°, {picture.force_n:.2f} N\n{picture.area_mm2:.3g} mm²"
    outline = figure.axes[0].patches[-1].get_xy()[:-1]
    np.testing.assert_allclose(outline, picture.outline_px)
    assert "data:image/png;base64" in svg


FORCE_N = np.linspace(0.5, 7, 20)


def series(name, rate):
    """Ten presses whose areas rise by ``rate`` mm2 a newton."""
    presses = [(FORCE_N, 20 + rate * FORCE_N)] * 10
    return RateSeries(name, LOOKS[name], presses, np.full(10, rate) + np.linspace(-0.1, 0.1, 10))


def of_areas(area_of, exponential=False):
    return RateSeries("S1", LOOKS["S1"], [(FORCE_N, area_of(FORCE_N))] * 3, VALUES, exponential)


def test_the_fit_is_the_derivative_of_the_law_through_the_areas():
    at, rate = of_areas(lambda force_n: 20 * force_n**0.6).fit
    assert (at[0], at[-1]) == pytest.approx((0.5, 7.0))
    assert rate == pytest.approx(12 * at**-0.4)
    at, rate = of_areas(lambda force_n: 9 * np.exp(0.3 * force_n), exponential=True).fit
    assert rate == pytest.approx(2.7 * np.exp(0.3 * at))
    at, rate = RateSeries("S1", LOOKS["S1"], [(np.full(9, 2.0), np.full(9, 30.0))], VALUES).fit
    assert at.size == rate.size == 0  # frames at one force


def test_raw_quotients_are_those_of_neighbouring_frames_of_one_press():
    force_n, rate = series("S1", 8.0).quotients
    assert rate == pytest.approx(np.full(190, 8.0))  # 10 presses of 19 steps: none from one press to the next
    assert np.unique(np.round(force_n, 9)).size == 19
    still = RateSeries("S1", LOOKS["S1"], [(np.array([1.0, 1.001, 2.0]), np.array([10.0, 90.0, 100.0]))], VALUES)
    assert still.quotients[1].size == 1  # a step of 1 mN is no divisor


def test_every_press_is_among_the_frames_that_are_drawn_and_those_without_a_rate_too():
    raw = draw(draw_rates, [("modular, 0°", [series("S1", 8.0)])], "mm²").axes[0]
    shown = raw.lines[0].get_xdata()
    assert 50 < shown.size < 200
    assert np.unique(np.round(shown, 6)).size == 19
    lost = series("S1", 8.0)
    lost.casr[:] = np.nan
    assert len(draw(draw_rates, [("0°", [lost])], "mm²").axes[0].lines[1].get_xdata()) == 50


def test_quotients_beyond_the_scale_are_counted():
    area = np.where(np.arange(20) == 10, 500.0, 20 + 8 * FORCE_N)
    wild = RateSeries("S1", LOOKS["S1"], [(FORCE_N, area)] + [(FORCE_N, 20 + 8 * FORCE_N)] * 19, VALUES)
    raw = draw(draw_rates, [("0°", [wild])], "mm²").axes[0]
    assert raw.get_title(loc="right") == "2 off the scale"  # up to the wild frame, and down again
    assert raw.get_ylim()[1] < 100


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_steps_of_algorithm_1_show_the_selected_pins_and_a_hexagon_for_each(turn, run_of):
    seen = run_of("S1", 0.0, "modular").first_contact
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    turned = {name: 150 + (getattr(seen, name) - 150) @ rotation for name in ("rest_px", "contact_px")}
    seen = replace(seen, **turned)
    with style():
        figure = draw_steps(seen, np.zeros((300, 300, 2)))
        svg = svg_text(figure)
    selected, hexagons_of = figure.axes[4], figure.axes[5]
    np.testing.assert_allclose(selected.lines[0].get_xydata(), seen.contact_px[seen.selected])
    (tiles,) = hexagons_of.collections
    assert len(tiles.get_paths()) == seen.selected.size > 3
    corners = tiles.get_paths()[0].vertices[:6] - seen.rest_px[seen.selected[0]]
    neighbour = seen.rest_px[1] - seen.rest_px[0]
    towards = corners @ neighbour / np.hypot(*neighbour) ** 2
    assert towards.max() == pytest.approx(0.5)  # half of the way: an edge, not a corner, between two pins
    assert svg.count("data:image/png;base64") == 8


def test_an_interval_beyond_the_panel_ends_in_an_arrow_and_the_papers_error_is_a_bracket():
    rows = [
        Estimate("front, rigid", 10.0, -20.0, np.inf, True, LOOKS["S1"], printed=7.0),
        Estimate("edge, rigid", np.nan, np.nan, np.nan, False, LOOKS["S1"]),
        Estimate("circle, rigid", 300.0, -500.0, 900.0, False, LOOKS["S1"]),
    ]
    axes = draw(draw_estimates, [("0°", rows)], "Error (%)", 0.0).axes[0]
    assert [line.get_marker() for line in axes.lines if line.get_marker() in "<>"] == [">", "<", ">"]
    bracket = axes.lines[1]
    assert (bracket.get_marker(), bracket.get_xdata().tolist()) == ("|", [-7.0, 7.0])
    assert [text.get_text() for text in axes.texts] == ["not determined"]
    assert [text.get_text() for text in axes.get_yticklabels()] == [row.name for row in rows]
    known = draw(
        draw_estimates, [("", [replace(rows[0], value=5.0, low=4.0, high=6.0)])], "κ", 5.3, {"S1": 7.6, "S5": 1.1}
    )
    assert known.axes[0].get_xscale() == "log"
    assert [text.get_text() for text in known.axes[0].get_xticklabels()] == ["S1\n7.6", "S5\n1.1"]


def test_rates_have_a_row_for_each_design_and_one_legend():
    rows = [("0°", [series("S1", 8.0), series("S3", 9.0)]), ("30°", [series("S1", 7.0)])]
    figure = draw(draw_rates, rows, "mm²")
    assert len(figure.axes) == 4
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["S1", "S3"]
    assert figure.axes[1].get_ylabel() == "CASR (mm²/N)"
    # presses without frames still have their boxes
    figure = draw(draw_rates, [("imported", [RateSeries("S1", LOOKS["S1"], [], VALUES)])], "mm²")
    assert "nan" not in draw(svg_text, figure).lower()
    assert len(figure.axes[1].patches) == 1


def test_both_conditions_stand_side_by_side_and_their_difference_below():
    boxes = [
        ConditionBoxes("S1", LOOKS["S1"], VALUES, VALUES + 5, far=True),
        ConditionBoxes("S3", LOOKS["S3"], VALUES, VALUES),
    ]
    figure = draw(draw_conditions, [("0°", boxes), ("30°", boxes[1:])], "mm²", 4.0)
    above, _, below, _ = figure.axes
    hollow, filled = above.patches[:2]
    assert hollow.get_x() + hollow.get_width() < filled.get_x()
    assert hollow.get_facecolor()[3] == 0 < filled.get_facecolor()[3]
    assert len(above.patches) == 4
    band, difference = below.patches[:2]
    assert (band.get_y(), band.get_height()) == (-4.0, 8.0)
    rings = [line for each in (below, figure.axes[3]) for line in each.lines if line.get_markersize() > 10]
    assert [line.get_ydata()[0] for line in rings] == [pytest.approx(50)]  # of the one that is far
    assert difference.get_y() + difference.get_height() / 2 == pytest.approx(50)  # 15 beside a mean of 10
    assert len({axes.get_ylim() for axes in figure.axes[:2]}) == len({axes.get_ylim() for axes in figure.axes[2:]}) == 1
    # marks tell both apart where boxes are thin
    rigid, human_like = above.lines[:2]
    assert (rigid.get_markerfacecolor(), rigid.get_markeredgecolor()) == ("white", LOOKS["S1"].colour)
    assert human_like.get_markerfacecolor() == LOOKS["S1"].colour
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert [label.split(":")[0] for label in labels] == ["left, hollow", "right, filled"]


@pytest.mark.parametrize("law", ["compliance", "exponential", "power", "linear-log"])
def test_the_curve_is_the_law_that_was_fitted(law):
    casr = np.array([[8.0, 8.1], [10.0, 9.9], [14.0, 14.2]])
    fitted = calibrate([7.6, 3.3, 1.1], casr, CalibrationSettings(law=law), casr_unit="mm2/N")
    parameters = tuple(fitted.fit.parameters[0].tolist())
    nan = float("nan")
    none = np.empty(0)
    result = LawResult(law, "casr", "", parameters, *[nan] * 8, none, nan, ())
    at = np.array([8.5, 11.0])
    assert law_curve(result, at) == pytest.approx(fitted.fit.at(at[None])[0])
