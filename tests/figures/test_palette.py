"""Colours that anyone can tell apart, on paper and on a page at night."""

from __future__ import annotations

from itertools import combinations

import matplotlib.colors
import numpy as np
import pytest
from skimage.color import deltaE_ciede2000, rgb2lab

from casr import palette
from emg2vsa.figures.canvas import new_figure, style, svg_text

COLOURS = {name: getattr(palette, name) for name in ("INK", "BLUE", "PURPLE", "GREEN", "SKY", "YELLOW", "RED", "GREY")}
SEEN = {
    "as it is": np.eye(3),
    "deuteranope": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "protanope": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
}
"""Machado, Oliveira and Fernandes (2009), severity 1, on linear RGB."""


def linear(colour):
    rgb = np.array(matplotlib.colors.to_rgb(colour))
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def lab(colour, matrix):
    seen = np.clip(matrix @ linear(colour), 0, 1)
    return rgb2lab(np.where(seen <= 0.0031308, 12.92 * seen, 1.055 * seen ** (1 / 2.4) - 0.055))


def test_the_simulation_makes_red_and_green_alike():
    matrix = np.array(SEEN["deuteranope"])
    pair = "#d62728", "#6b7a00"
    assert deltaE_ciede2000(*(lab(c, matrix) for c in pair)) < 0.6 * deltaE_ciede2000(
        *(lab(c, np.eye(3)) for c in pair)
    )


@pytest.mark.parametrize("who", SEEN)
def test_every_pair_of_colours_is_told_apart(who):
    least = {"as it is": 22, "deuteranope": 22, "protanope": 19}[who]
    near = {
        (a, b): deltaE_ciede2000(*(lab(COLOURS[name], np.array(SEEN[who])) for name in (a, b)))
        for a, b in combinations(COLOURS, 2)
    }
    assert min(near.values()) > least, min(near, key=near.get)


def test_every_colour_holds_on_white_paper():
    luminance = [linear(colour) @ (0.2126, 0.7152, 0.0722) for colour in COLOURS.values()]
    assert min(1.05 / (np.array(luminance) + 0.05)) > 2.2


def test_a_figure_is_a_light_card_by_day_and_by_night():
    with style():
        figure, _ = new_figure(80, 60, (10, 2, 10, 5))
        background = svg_text(figure).partition("<path")[2].partition(">")[0]
    assert "fill: #ffffff" in background
