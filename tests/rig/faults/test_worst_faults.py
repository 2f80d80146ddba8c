"""The worst that `benchmarks.fault_search` has found, of one and of two faults: what a specimen may feel of them, and
that a line or an encoder that comes to its senses leaves nothing on it."""

from __future__ import annotations

import pytest

from benchmarks.fault_search import COMPLETED_N, LEFT_N, MOST_N, carry_out

LEAVES = [
    ("rigid", "jumped-motor-1 -20000 at 3.4 s"),  # on the way out: 26 N before its encoder was watched there
    ("rigid", "jumped-motor-1 -2000 at 3.2 s"),
    ("rigid", "gain 0.015 at 0.28 s"),  # before contact: 19 N before the motor's current was a witness
    ("rigid", "dead at 0.23 N for 0.59 s; frozen-shaft at 1.56 s for 1.28 s"),
    ("rigid", "deaf at 6.28 N for 1.5 s"),  # left pressed before a line that heals was waited for
    ("rigid", "lag 119 at 0.67 s"),
    ("qbmove", "jumped-shaft -60 at 3 N"),
    ("qbmove", "late 12.2 at 2.38 N for 1.38 s"),
    ("qbmove", "overflow at 0.16 s; jumped-motor-2 10400 at 0.17 s for 0.06 s"),
    ("dynamixel", "ignore at 1.99 s for 0.52 s; reset 99 at 2.81 s"),
    ("dynamixel", "silent at 1.59 s"),
    ("dynamixel", "late 9.19 at 3.55 N; trash at 3.78 N"),
]
STAYS = [
    ("rigid", "jumped-motor-1 -20000 at 7.4 N"),  # beyond position_deg the device takes no command; 26 N before
    ("rigid", "dead at 1.80 s for 1.11 s; jumped-motor-1 -20000 at 7.4 N"),
    ("qbmove", "replayed at 6.88 N for 0.05 s; jumped-motor-1 -3300 at 2.13 s"),
    ("qbmove", "jumped-motor-2 -19900 at 6.88 N"),
    ("qbmove", "replayed at 3.69 N; jumped-motor-2 -20000 at 4.40 N"),  # one of two motors: 67 N before
    ("dynamixel", "frozen-shaft at 1.92 s; lose at 4.21 N"),
]
"""Nothing takes these away: the motors are off, and that is told."""


@pytest.mark.parametrize(("actuator", "lines"), [*LEAVES, *STAYS])
def test_the_worst_faults(actuator: str, lines: str) -> None:
    found = carry_out(tuple(lines.split("; ")), actuator)
    assert found.how in ("guard", "rejected", "completed"), found
    assert found.true_n <= MOST_N
    assert found.completed_n <= COMPLETED_N
    if (actuator, lines) in LEAVES:
        assert found.left_n <= LEFT_N
