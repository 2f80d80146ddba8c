"""Presses that say the same are named once."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.extraction.reasons import grouped, most_frequent


def test_equal_reasons_are_one_line_with_the_range_of_their_numbers():
    said = [
        (1, "rejected", "lasted 0.33 s, shorter than 0.5 s; EDC is -0.6 dB over rest"),
        (2, "rejected", "lasted 0.28 s, shorter than 0.5 s; EDC is -2.8 dB over rest"),
        (3, "ok", ""),
        (4, "rejected", "lasted 2e-05 s, shorter than 0.5 s; EDC is 0.1 dB over rest"),
        (5, "warned", "mains is 38 % of the power of EDC"),
    ]
    assert grouped(said) == [
        "presses 1-2, 4 rejected: lasted 2e-05 to 0.33 s, shorter than 0.5 s; EDC is -2.8 to 0.1 dB over rest",
        "press 5 warned: mains is 38 % of the power of EDC",
    ]


def test_names_with_numbers_and_verdicts_stay_apart():
    said = [(1, "rejected", "EMG 1 is flat"), (2, "rejected", "EMG 2 is flat"), (3, "warned", "EMG 2 is flat")]
    assert len(grouped(said)) == 3
    assert grouped([(1, "rejected", "EMG 2 misses 3 samples"), (2, "rejected", "EMG 2 misses 40 samples")]) == [
        "presses 1-2 rejected: EMG 2 misses 3 to 40 samples"
    ]


@given(st.lists(st.tuples(st.sampled_from(["warned", "rejected"]), st.integers(-99, 99)), max_size=12))
def test_every_press_is_named_once(said):
    lines = grouped([(i, verdict, f"EDC is {n} dB over rest") for i, (verdict, n) in enumerate(said, 1)])
    named = []
    for line in lines:
        for part in line.split(maxsplit=1)[1].split(" warned")[0].split(" rejected")[0].split(", "):
            first, _, last = part.partition("-")
            named += range(int(first), int(last or first) + 1)
    assert sorted(named) == list(range(1, len(said) + 1))


def test_the_most_frequent_kinds_are_counted_with_the_range_of_their_numbers():
    said = ["EDC is flat", "force falls on 3.4 % of its path", "FDS is flat", "force falls on 3.6 % of its path"]
    assert most_frequent(said, 2) == ["force falls on 3.4 to 3.6 % of its path (2)", "EDC is flat (1)"]
    assert most_frequent([], 5) == []
