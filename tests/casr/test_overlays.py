"""Pictures: what is drawn is what was computed."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.frames import FrameSequence, force_per_frame
from casr.overlays import press_pictures
from casr.overlays.area import hexagons
from casr.overlays.canvas import view_of
from casr.overlays.curves import area_curve, growth_curve
from casr.overlays.motion import flow_picture, growth_between
from casr.score import Score, score
from casr.spread import SpreadRate, spread_rate
from casr.synthetic import TACTIP_127, PressSettings, TimelineSettings, simulate_press

PINS_PX = TACTIP_127.pins_px((149.5, 149.5))


@pytest.fixture(scope="module")
def pressed() -> tuple[FrameSequence, Score]:
    press = simulate_press(PressSettings(stiffness_n_per_mm=1.11, timeline=TimelineSettings(loading_s=0.5)))
    log = press.timeline
    force_n = force_per_frame(log.log_force_n, log.log_frame_index, len(press.frames))
    sequence = FrameSequence(press.frames, press.settings.camera, force_n)
    return sequence, score(sequence)


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


def test_the_line_of_the_rate_has_its_slope_and_runs_through_the_curve() -> None:
    force_n = np.linspace(0.5, 7, 40)
    area = 100 + 12 * force_n
    axes = area_curve(force_n, area, "mm2", spread_rate(area, force_n, rule="slope")).figure.axes[0]
    line = axes.get_lines()[1].get_xydata()
    assert line[:, 1] == pytest.approx(100 + 12 * line[:, 0], rel=1e-6)
    assert "mm²/N" in axes.get_legend_handles_labels()[1][1]


def test_the_line_of_a_power_law_joins_two_forces_on_it() -> None:
    force_n = np.linspace(0.6, 6.5, 20)
    rate = spread_rate(30 * force_n**0.6, force_n)
    _, curve, line = (
        each.get_xydata() for each in area_curve(force_n, force_n, "mm2", rate).figure.axes[0].get_lines()
    )
    assert curve[:, 1] == pytest.approx(30 * curve[:, 0] ** 0.6)
    assert line[:, 0] == pytest.approx([0.5, 7.0])
    assert line[:, 1] == pytest.approx(30 * line[:, 0] ** 0.6)


def test_the_paper_rate_has_no_line() -> None:
    rate = SpreadRate(5.0, None, None, "mm2/N summed over frames", "paper", 3, ())
    picture = area_curve(np.arange(3.0), np.arange(3.0), "mm2", rate)
    assert len(picture.figure.axes[0].get_lines()) == 1


def test_growth_curve_ends_at_the_sum() -> None:
    picture = growth_curve(np.arange(5, 9), np.array([0.1, 0.2, -0.05]))
    assert picture.figure.axes[0].get_lines()[0].get_ydata()[-1] == pytest.approx(0.25)
    assert "0.250" in picture.caption
    assert f"{np.exp(0.25):.2f} times" in picture.caption


def test_flow_picture_says_the_divergence() -> None:
    y, x = np.mgrid[0:100, 0:100].astype(np.float32)
    flow = np.stack([0.01 * x, 0.02 * y], axis=-1)
    square = np.array([[20.0, 20.0], [80.0, 20.0], [80.0, 80.0], [20.0, 80.0]])
    assert "+0.0300" in flow_picture(np.zeros((100, 100), np.uint8), flow, square, "frames 0 to 1").caption
    still = flow_picture(np.zeros((100, 100), np.uint8), 0 * flow, square, "frames 0 to 1")
    assert "+0.0000" in still.caption
    assert still.png()[:4] == b"\x89PNG"


def test_every_picture_of_a_press(pressed: tuple[FrameSequence, Score]) -> None:
    pictures = press_pictures(*pressed)
    assert [p.name for p in pictures] == ["area_over_force", "growth", "pins", "area", "region", "spreading"]
    assert all(p.title and p.caption.endswith(".") for p in pictures)


def test_counted_pins_are_the_selected_ones(pressed: tuple[FrameSequence, Score]) -> None:
    sequence, scored = pressed
    picture = next(p for p in press_pictures(sequence, scored) if p.name == "pins")
    words = picture.figure.axes[0].get_legend_handles_labels()[1]
    assert any(f"counted ({len(scored.initial.selected)})" in word for word in words)


def test_no_force_no_curve_over_force(pressed: tuple[FrameSequence, Score]) -> None:
    sequence, scored = pressed
    names = [p.name for p in press_pictures(sequence, dataclasses.replace(scored, force_n=None, front_spread=None))]
    assert "area_over_force" not in names


@pytest.mark.parametrize("draw", [lambda p: p.png(60), lambda p: p.svg()], ids=["png", "svg"])
def test_the_same_bytes_every_time(pressed: tuple[FrameSequence, Score], draw: Callable[..., bytes]) -> None:
    one, two = (next(p for p in press_pictures(*pressed) if p.name == "area") for _ in range(2))
    assert draw(one) == draw(two)
