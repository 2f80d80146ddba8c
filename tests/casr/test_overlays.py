"""Pictures: what is drawn is what was computed."""

from __future__ import annotations

import base64
import dataclasses
import re
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from casr.frames import FrameSequence
from casr.overlays import press_pictures
from casr.overlays.curves import area_curve, growth_curve
from casr.overlays.frames import colours_of, flow_picture, growth_between, hexagons, photo, view_of
from casr.palette import RED
from casr.scoring import Score, ScoreSettings, score
from casr.svg import Picture
from emg2vsa.worlds.tactile import TACTIP_127

PINS_PX = TACTIP_127.pins_px((149.5, 149.5))


@given(angle_deg=st.floats(-30, 30), x=st.floats(-50, 50))
def test_hexagons_tile_a_turned_lattice(angle_deg: float, x: float) -> None:
    c, s = np.cos(np.deg2rad(angle_deg)), np.sin(np.deg2rad(angle_deg))
    centres = (PINS_PX - 149.5) @ np.array([[c, s], [-s, c]]) + x
    corners = hexagons(centres, centres)
    # every inner corner belongs to three cells: two triangles' worth of neighbours meet there
    _, counts = np.unique(np.round(corners.reshape(-1, 2), 3), axis=0, return_counts=True)
    apart = np.hypot(*(corners.reshape(-1, 1, 2) - corners[63].reshape(1, 6, 2)).transpose(2, 0, 1))
    assert ((apart < 1e-6).sum(axis=0) == 3).all()
    assert counts.max() <= 3


@given(stretch=st.floats(0.8, 1.6), shear=st.floats(-0.3, 0.3))
def test_growth_between_pins_is_that_of_an_affine_map(stretch: float, shear: float) -> None:
    matrix = np.array([[stretch, shear], [0.1, 1.1]])
    corners, growth = growth_between(PINS_PX, PINS_PX @ matrix.T + 3.0, 20.0)
    assert len(corners) == 216  # 6 rings: 6 n^2 triangles
    assert growth == pytest.approx(np.full(216, np.log(np.linalg.det(matrix))), abs=1e-9)


def test_a_lost_neighbourhood_is_not_bridged() -> None:
    kept = np.delete(PINS_PX, 63, axis=0)
    corners, _ = growth_between(kept, kept, 20.0)
    assert len(corners) == 216 - 6


def test_view_stays_inside_the_frame() -> None:
    image = np.zeros((300, 300), np.uint8)
    assert view_of(PINS_PX, image, 1000.0) == (-0.5, -0.5, 299.5, 299.5)


def marks(picture: Picture, label: str) -> NDArray[np.float64]:
    """Points drawn under a label that begins so."""
    return next(mark.at for mark in picture.axes.marks if mark.label.startswith(label))


def test_the_front_the_skin_and_the_interval_are_those_of_the_score(soft: tuple[FrameSequence, Score]) -> None:
    _, scored = soft
    picture = area_curve(scored)
    counts = scored.front.determined
    assert counts.sum() > 0
    assert scored.force_n is not None
    assert marks(picture, "front") == pytest.approx(np.column_stack([scored.force_n, scored.front.area])[counts])
    assert marks(picture, "skin")[:, 1] == pytest.approx(scored.skin.area)
    band = next(mark.at for mark in picture.axes.marks if mark.kind == "band")
    half = np.exp(1.959964 * scored.front.relative_sd[counts])
    assert np.sort(band[:, 1]) == pytest.approx(
        np.sort(np.append(scored.front.area[counts] * half, scored.front.area[counts] / half)), rel=1e-5
    )


def test_the_line_of_the_rate_joins_two_forces_on_the_power_law(soft: tuple[FrameSequence, Score]) -> None:
    _, scored = soft
    curve, line = (marks(area_curve(scored), label) for label in ("power law", "CASR (front)"))
    assert curve[:, 1] == pytest.approx(scored.rate.law.area(curve[:, 0]))
    assert line[:, 0] == pytest.approx([0.5, 7.0])
    assert np.diff(line[:, 1]) / np.diff(line[:, 0]) == pytest.approx([scored.rate.value])


@pytest.mark.parametrize("quantity", ["front", "skin"])
def test_the_line_of_a_slope_runs_through_the_curve(soft: tuple[FrameSequence, Score], quantity: str) -> None:
    sequence, _ = soft
    scored = score(sequence, ScoreSettings(rate_rule="slope", quantity=quantity))
    line = marks(area_curve(scored), f"CASR ({quantity})")
    assert np.diff(line[:, 1]) / np.diff(line[:, 0]) == pytest.approx([scored.rate.value])
    assert np.nanmin(scored.area) < line[:, 1].mean() < np.nanmax(scored.area)


def test_the_paper_rate_has_no_line(soft: tuple[FrameSequence, Score]) -> None:
    sequence, _ = soft
    picture = area_curve(score(sequence, ScoreSettings(rate_rule="paper")))
    assert not any(mark.kind == "line" for mark in picture.axes.marks)


def test_frames_that_are_not_determined_are_grey(soft: tuple[FrameSequence, Score]) -> None:
    _, scored = soft
    doubtful = dataclasses.replace(scored, front_doubt="too small", front_spread=None)
    picture = area_curve(doubtful)
    assert len(marks(picture, "front, not determined")) == len(scored.frames)
    assert not any(mark.label == "front" for mark in picture.axes.marks)
    assert "Grey" in picture.caption


def test_without_forces_areas_are_drawn_frame_by_frame(soft: tuple[FrameSequence, Score]) -> None:
    _, scored = soft
    found = dataclasses.replace(scored.front_spread, rate=None, interval=None)
    picture = area_curve(dataclasses.replace(scored, force_n=None, front_spread=found))
    assert marks(picture, "skin")[:, 0] == pytest.approx(scored.frames)
    assert picture.title == "Area frame by frame"


def test_growth_curve_ends_at_the_sum() -> None:
    picture = growth_curve(np.arange(5, 9), np.array([0.1, 0.2, -0.05]))
    assert marks(picture, "sum")[-1] == pytest.approx([8, 0.25])
    assert marks(picture, "of one step")[:, 1] == pytest.approx([0.1, 0.2, -0.05])
    assert "0.250" in picture.caption
    assert f"{np.exp(0.25):.2f} times" in picture.caption


def test_edges_are_the_fronts_of_a_few_frames_and_the_skin(soft: tuple[FrameSequence, Score]) -> None:
    sequence, scored = soft
    picture = next(p for p in press_pictures(sequence, scored) if p.name == "edges")
    fronts = [mark.at for mark in picture.axes.marks if mark.label.startswith("front")]
    assert len(fronts) == 6
    assert fronts[-1][:-1] == pytest.approx(scored.front.edge_px[-1])
    assert marks(picture, "skin")[:-1] == pytest.approx(scored.regions[0])


def test_flow_picture_says_the_divergence() -> None:
    y, x = np.mgrid[0:100, 0:100].astype(np.float32)
    flow = np.stack([0.01 * x, 0.02 * y], axis=-1)
    square = np.array([[20.0, 20.0], [80.0, 20.0], [80.0, 80.0], [20.0, 80.0]])
    assert "+0.0300" in flow_picture(np.zeros((100, 100), np.uint8), flow, square, "frames 0 to 1").caption
    still = flow_picture(np.zeros((100, 100), np.uint8), 0 * flow, square, "frames 0 to 1")
    assert "+0.0000" in still.caption
    ElementTree.fromstring(still.file())


def test_every_picture_of_a_press(soft: tuple[FrameSequence, Score]) -> None:
    pictures = press_pictures(*soft)
    assert [p.name for p in pictures] == ["area_curve", "edges", "growth", "pins", "area", "spreading"]
    assert all(p.title and p.caption.endswith(".") for p in pictures)
    for picture in pictures:
        ElementTree.fromstring(picture.file())


def test_the_frame_lies_under_its_marks() -> None:
    image = np.zeros((40, 60), np.uint8)
    image[20, 30] = 255
    axes = photo(image, (9.5, 4.5, 49.5, 34.5))
    axes.dots([(30.0, 20.0)], RED)
    svg = axes.svg("x", "x", "")
    found = re.search(r'<image x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="([\d.]+)".*base64,([^"]+)', svg)
    assert found
    x, y, width, height = map(float, found.groups()[:4])
    shown = cv2.imdecode(np.frombuffer(base64.b64decode(found[5]), np.uint8), cv2.IMREAD_GRAYSCALE)
    row, column = np.unravel_index(np.argmax(shown), shown.shape)
    dot = re.search(r"M([\d.]+) ([\d.]+)h0", svg)
    assert dot
    middle = x + (column + 0.5) / shown.shape[1] * width, y + (row + 0.5) / shown.shape[0] * height
    assert middle == pytest.approx((float(dot[1]), float(dot[2])), abs=0.11)


def test_colours_go_through_the_middle() -> None:
    ends = colours_of(np.array([-2.0, -1.0, 0.0, 1.0]), 1.0, ("#000000", "#808080", "#ffffff"))
    assert ends.tolist() == [[0, 0, 0], [0, 0, 0], [128, 128, 128], [255, 255, 255]]


def test_a_lost_pin_leaves_a_gap() -> None:
    axes = photo(np.zeros((10, 10), np.uint8), (0, 0, 9, 9))
    axes.dots([(1.0, 1.0), (np.nan, np.nan)], RED)
    axes.line([(1.0, 1.0), (np.nan, 2.0), (3.0, 3.0)], RED)
    assert "nan" not in axes.svg("x", "x", "")


def test_counted_pins_are_the_selected_ones(soft: tuple[FrameSequence, Score]) -> None:
    sequence, scored = soft
    picture = next(p for p in press_pictures(sequence, scored) if p.name == "pins")
    assert marks(picture, f"counted in A_c0 (skin) ({len(scored.initial.selected)})") == pytest.approx(
        scored.rest.centroids_px[scored.initial.selected]
    )


def test_the_same_bytes_every_time(soft: tuple[FrameSequence, Score]) -> None:
    one, two = (next(p for p in press_pictures(*soft) if p.name == "area") for _ in range(2))
    assert one.file() == two.file()


def test_pictures_decode_three_frames(soft: tuple[FrameSequence, Score]) -> None:
    sequence, scored = soft
    asked: set[int] = set()

    class Counting:
        def __getitem__(self, index: int) -> NDArray[np.generic]:
            asked.add(index)
            return sequence[index]

    press_pictures(Counting(), scored)  # type: ignore[arg-type]
    assert asked == {scored.rest_frame, int(scored.frames[0]), int(scored.frames[-1])}
