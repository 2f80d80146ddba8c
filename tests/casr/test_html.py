from __future__ import annotations

import re

import pytest

from casr.html import CSS, page
from emg2vsa.figures.palette import INK, MUTED

BY_DAY, BY_NIGHT = (dict(re.findall(r"--(\w+):(#[0-9a-f]+)", line)) for line in re.findall(r":root{(.*?)}", CSS, re.S))


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
