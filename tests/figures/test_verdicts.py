"""The picture of all verdicts: every claim has its words, its line and its verdict."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.claims.claim import UNKNOWN, Asserts, Claim, Found, Judged
from emg2vsa.figures.canvas import style
from emg2vsa.figures.verdicts import draw_verdicts


def judged(
    asserts: Asserts, low: float, value: float, high: float, question: str = "areas", margin: float = 2.0
) -> Judged:
    found = UNKNOWN if np.isnan(value) else Found(value, lambda confidence: (low, high))
    claim = Claim("key", question, f"says {value:g}", "size, %", asserts, found, margin, "mounting", "area")
    return Judged(claim, low, high, 0.95)


def drawn(*claims: Judged):
    with style():
        (axes,) = draw_verdicts(claims).axes
    return axes


def lines(axes) -> list[np.ndarray]:
    """Intervals: lines of two different ends on one height."""
    return [line.get_xdata() for line in axes.lines if len(line.get_xdata()) == 2]


def test_each_claim_has_its_verdict_and_questions_have_their_heading() -> None:
    claims = (judged("more", 1, 2, 3), judged("more", -1, 0, 1), judged("within", -1, 4, 9, "κ"))
    axes = drawn(*claims)
    texts = [text.get_text() for text in axes.texts]
    assert [text for text in texts if text in ("holds", "refuted", "not determined")] == [c.verdict for c in claims]
    assert [text for text in texts if text in ("Areas", "Κ")] == ["Areas", "Κ"]
    np.testing.assert_allclose(lines(axes), [[0.5, 1.5], [-0.5, 0.5], [-0.5, 4.5]])


@pytest.mark.parametrize(("low", "high", "arrows"), [(-1e9, 1.0, "<"), (1.0, np.inf, ">"), (-np.inf, np.inf, "<>")])
def test_what_goes_on_beyond_the_axis_ends_in_an_arrow(low: float, high: float, arrows: str) -> None:
    axes = drawn(judged("more", low, 1.0, high))
    assert "".join(line.get_marker() for line in axes.lines if line.get_marker() in "<>") == arrows
    assert all(np.isfinite(ends).all() for ends in lines(axes))


def test_a_claim_without_an_estimate_has_words_and_no_line() -> None:
    axes = drawn(judged("more", np.nan, np.nan, np.nan))
    assert not axes.lines
    assert [text.get_text() for text in axes.texts] == ["Areas", "says nan", "not determined"]
