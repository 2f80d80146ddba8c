"""Published against recomputed numbers."""

from __future__ import annotations

import math

import pytest

from emg2vsa.deposit.agreement import compared, compared_texts, relative_difference, restated_list, tolerance_of


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        (1.0, 1.0, 0.0), (1, 1.25, 0.2), (-2.0, 2.0, 2.0), (math.inf, math.inf, 0.0), (1.0, math.inf, None),
        (True, 1, None), (None, 1.0, None), ("1", 1.0, None),
    ],
)  # fmt: skip
def test_a_difference_is_relative_to_the_larger_number(one, other, expected):
    assert relative_difference(one, other) == relative_difference(other, one) == expected


@pytest.mark.parametrize(
    ("key", "expected"),
    [("runs.modular.45.new", 1e-2), ("contrast.frame_sum.x", 1e-2), ("contrast.slope", 1e-4), ("fit.S1.b.mean", 1e-9)],
)
def test_the_first_pattern_that_fits_gives_the_tolerance(key, expected):
    assert tolerance_of(key) == expected


def test_numbers_are_equal_within_the_tolerance_of_their_key_or_differ():
    published = {"a": 1.0, "b": 1.0, "runs.c": 1.0, "d": True, "e": None, "f": "12"}
    recomputed = {"a": 1.0, "b": 1 + 1e-10, "runs.c": 1.02, "d": 1, "e": None, "g": 3}
    found = compared(published, recomputed, ["a", "b", "runs.c", "d", "e", "f", "g"])
    assert (found.exact, found.within) == (2, 1)
    assert [str(each) for each in found.differ] == [
        "runs.c: published 1.0, recomputed 1.02, relative difference 0.02, tolerance 0.01",
        "d: published true, recomputed 1",
        'f: published "12", recomputed nothing',
        "g: published nothing, recomputed 3",
    ]


@pytest.mark.parametrize(
    ("published", "recomputed", "exact", "agree"),
    [
        ("slope 0.123 V", "slope 0.124 V", False, True),  # the last digit of a rounded number
        ("slope 0.123 V", "slope 0.124 V", True, False),
        ("slope 0.123 V", "slope 0.125 V", False, False),
        ("slope 0.123 V", "slope 0.123 mV", False, False),
        ("p = 1.0e-12", "p = 1.0000000001e-12", True, True),
        ("n = 3", "n = 3 of 4", False, False),
    ],
)
def test_numbers_in_words_may_round_either_way_unless_they_are_exact(published, recomputed, exact, agree):
    found = compared_texts("a.tex", published, recomputed, 1e-9, exact=exact)
    assert (found.within, len(found.differ)) == ((1, 0) if agree else (0, 1))


def test_cells_of_tables_are_compared_one_by_one():
    found = compared_texts(
        "t.csv", "# sha256: 1\na,b\n1,2\n3,4", "# sha256: 2\na,b\n1,2.0000000001\n3,5", 1e-9, exact=True
    )
    assert (found.exact, found.within) == (2, 1)
    assert [str(each) for each in found.differ] == [
        "t.csv, line 4: published 4.0, recomputed 5.0, relative difference 0.2, tolerance 1e-09"
    ]
    (missing,) = compared_texts("t.csv", "a\n1", "a", 1e-9, exact=True).differ
    assert str(missing).startswith("t.csv, line 2: published 1.0, recomputed nothing")


def test_a_list_that_says_otherwise_than_the_results_is_told():
    text = "key,value\na,1\nb,\nc,true\nmore,2\n"
    assert [str(each) for each in restated_list({"a": 1, "b": None, "c": False, "d": "x"}, text)] == [
        'results.csv: c: published "true", recomputed "false"',
        'results.csv: d: published nothing, recomputed "x"',
        'results.csv: more: published "2", recomputed nothing',
    ]
