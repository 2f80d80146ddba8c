"""Numbers on records: lost, late, repeated."""

from __future__ import annotations

import pytest

from emg2vsa.rig.rdt_sequence import REMEMBERED, SequenceCount, steps

CASES = [
    # numbers as they come, what each says, (lost, late, repeated)
    ([1, 2, 3], [0, 0, 0], (0, 0, 0)),
    ([2, 3], [1, 0], (1, 0, 0)),
    ([1, 5, 6], [0, 3, 0], (3, 0, 0)),
    ([1, 2, 2, 3], [0, 0, None, 0], (0, 0, 1)),
    ([1, 3, 2, 4], [0, 1, None, 0], (0, 1, 0)),
    ([1, 3, 2, 2, 4], [0, 1, None, None, 0], (0, 1, 1)),
    ([1, 4, 2], [0, 2, None], (1, 1, 0)),
]


@pytest.mark.parametrize(("numbers", "said", "counts"), CASES)
def test_counts(numbers, said, counts):
    sequence = SequenceCount()
    assert [sequence.arrived(number) for number in numbers] == said
    assert (sequence.lost, sequence.late, sequence.repeated) == counts


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [(1, 2, 1), (2, 1, -1), (2**32 - 1, 0, 1), (0, 2**32 - 1, -1), (2**32 - 2, 3, 5), (7, 7, 0)],
)
def test_steps_wrap(before, after, expected):
    assert steps(before, after) == expected


def test_counting_goes_on_past_32_bits():
    sequence = SequenceCount()
    for far in (2**31 - 1, 2**32 - 2):
        sequence.arrived(far)
    lost = sequence.lost
    assert [sequence.arrived(number) for number in (2**32 - 1, 0, 2)] == [0, 0, 1]
    assert sequence.lost == lost + 1


def test_a_long_gap_keeps_little_in_mind():
    sequence = SequenceCount()
    assert sequence.arrived(10_000_001) == 10_000_000
    sequence.arrived(10_000_001 - REMEMBERED)
    sequence.arrived(10_000_001 - REMEMBERED - 1)
    assert (sequence.lost, sequence.late, sequence.repeated) == (9_999_999, 1, 1)
