"""A program presses over real bytes, and something breaks: the probe is taken away, and the exit status tells it."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.way_out import FREE_N, break_it

pytestmark = pytest.mark.realtime


@pytest.mark.parametrize(
    ("state", "actuator", "cause"),
    [("line dead for 3 s", "qbmove", "lost device"), ("program stopped for 5 s", "rigid", "overrun")],
)
def test_the_probe_is_taken_away(state: str, actuator: str, cause: str, tmp_path: Path) -> None:
    left = break_it(state, actuator, tmp_path)
    assert (left.status, left.told["how"], left.told["cause"]) == (1, "guard", cause)
    assert left.told["retracted"]
    assert left.left_n < FREE_N
    assert left.most_n < 13
    assert not left.on
