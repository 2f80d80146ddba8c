from __future__ import annotations

import re

import pytest

from emg2vsa.figures.palette import INK, MUTED
from emg2vsa.report.stylesheet import CSS

VARIABLES = dict(re.findall(r"--(\w+):(#[0-9a-f]+)", CSS))


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


@pytest.mark.parametrize("colour", [VARIABLES["ink"], VARIABLES["muted"], VARIABLES["link"], INK, MUTED])
@pytest.mark.parametrize("paper", ["#ffffff", VARIABLES["soft"]])
def test_all_text_can_be_read(colour, paper):
    assert contrast(colour, paper) >= 4.5
