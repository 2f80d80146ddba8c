"""Colours that anyone can tell apart, on paper and on a page at night."""

from __future__ import annotations

from itertools import combinations

import matplotlib.colors
import numpy as np
import pytest
from skimage.color import deltaE_ciede2000, rgb2lab

from casr import palette
from emg2vsa.figures.canvas import inline_svg, new_figure, style, svg_text
from emg2vsa.figures.palette import looks

NAMES = ("ink", "blue", "purple", "green", "sky", "yellow", "red", "grey")
DAY, NIGHT = ({name: both[k] for name, *both in palette.ON_PAGES} for k in (0, 1))
LEAST = {"as it is": 22, "deuteranope": 22, "protanope": 19}, {"as it is": 22, "deuteranope": 21, "protanope": 18}
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
@pytest.mark.parametrize(("colours", "least"), [(DAY, LEAST[0]), (NIGHT, LEAST[1])], ids=["day", "night"])
def test_every_pair_of_colours_is_told_apart(colours, least, who):
    near = {
        (a, b): deltaE_ciede2000(*(lab(colours[name], np.array(SEEN[who])) for name in (a, b)))
        for a, b in combinations(NAMES, 2)
    }
    assert min(near.values()) > least[who], min(near, key=near.get)


@pytest.mark.parametrize(("colours", "least"), [(DAY, 2.2), (NIGHT, 2.9)], ids=["day", "night"])
def test_every_colour_holds_on_the_page(colours, least):
    luminance = {name: linear(colour) @ (0.2126, 0.7152, 0.0722) for name, colour in colours.items()}
    for name in NAMES:
        dark, light = sorted((luminance[name], luminance["page"]))
        assert (light + 0.05) / (dark + 0.05) > least, name


def test_a_figure_is_a_light_card_in_its_file_and_in_the_colours_of_the_page_in_it():
    with style():
        figure, _ = new_figure(80, 60, (10, 2, 10, 5))
        drawn = svg_text(figure)
    assert "fill: #ffffff" in drawn.partition("<path")[2].partition(">")[0]
    shown = inline_svg(drawn, "f", "t", "d")
    assert "fill: var(--page)" in shown
    assert "#1a1a1a" not in shown
    assert "var(--ink)" in shown


def test_twelve_specimens_are_told_apart_by_colour_marker_and_dash():
    found = looks([f"S{i}" for i in range(1, 13)])
    assert len(set(found.values())) == len({(look.colour, look.marker) for look in found.values()}) == 12
    assert len({(look.colour, look.dash) for look in found.values()}) == 12
