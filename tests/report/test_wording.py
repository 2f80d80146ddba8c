from __future__ import annotations

import math

import pytest

from emg2vsa.report.wording import bounded, count, listed, number, p_text, percent, signed, typeset

NAN = math.nan


def plain(text: str) -> str:
    return text.replace("\N{NO-BREAK SPACE}", " ")


@pytest.mark.parametrize(
    ("p", "shown"),
    [(0.0391, "p = .039"), (0.0009999, "p < .001"), (0.001, "p = .001"), (1.0, "p > .999"), (0.9994, "p = .999")],
)
def test_p_has_three_decimals_and_no_leading_zero(p, shown):
    assert plain(p_text(p)) == shown


@pytest.mark.parametrize(
    ("value", "shown"),
    [(23.0, "23.0"), (0.0, "0"), (7, "7"), (123456, "123456"), (123.4, "123"), (4321.6, "4322"), (0.05, "0.0500"),
     (7.2e-10, "7.20e-10"), (-0.474, "−0.474")],
)  # fmt: skip
def test_numbers_keep_their_significant_digits(value, shown):
    assert number(value) == shown


def test_what_is_not_defined_is_never_shown_as_a_number():
    assert number(NAN) == number(None) == bounded(NAN) == percent(NAN) == "–"
    assert plain(p_text(NAN)) == "p not defined"


def test_small_words():
    assert bounded(-0.25, 2) == "−.25"
    assert plain(percent(0.4774)) == "47.7 %"
    assert count(1, "trial") == "1 trial"
    assert count(2, "trial") == "2 trials"
    assert listed(["S1", "S3", "S5"]) == "S1, S3 and S5"
    assert listed(["S1"]) == "S1"
    assert listed([]) == ""


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("95% CI [-0.1, -.3]", "95 % CI [−0.1, −.3]"), ("12 %", "12 %"), ("-3 dB", "−3 dB"), ("S-1", "S-1"),
        ("1e-05", "1e-05"), ("2026-11-23", "2026-11-23"), ("constant-min", "constant-min"), ("x (-1)", "x (−1)"),
    ],
)  # fmt: skip
def test_minus_and_percent_are_set_in_one_way(text, shown):
    assert plain(typeset(text)) == shown
    assert typeset(typeset(text)) == typeset(text)


def test_a_difference_has_its_sign():
    assert signed(3.14) == "+3.1"
    assert plain(signed(-0.44, "%")) == "−0.4 %"
    assert signed(NAN) == "–"
