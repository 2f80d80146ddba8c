"""What counts as a path of a claim, and the shares that keep its verdict."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.claims.claim import UNKNOWN, Claim, Found, student
from emg2vsa.multiverse.path import BINS, INDEX, KINDS, SEVERAL, Choice, tried
from emg2vsa.multiverse.paths import gathered

ALPHA = 0.1


def claim(found: Found, key: str = "one") -> Claim:
    return Claim(key, "question", f"{key} is so", "difference", "more", found, 0.1, "person", "fits")


HOLDS, REFUTED, OPEN = student(1.0, 0.01, 10.0), student(-1.0, 0.01, 10.0), student(0.1, 1.0, 10.0)


def paths(others, own=HOLDS):
    """others : pairs of choices and what is found."""
    found = [tried([Choice(kind, kind) for kind in kinds], [claim(of)]) for kinds, of in others]
    return gathered([tried([], [claim(own)])], found, ALPHA)


def test_shares_are_those_of_the_paths_that_bear():
    found = paths([([INDEX], student(0.9, 0.01, 10.0)), ([INDEX], REFUTED), ([BINS], OPEN), ([INDEX, BINS], HOLDS)])
    assert found.own.tolist() == ["holds"]
    assert found.verdict[0].tolist() == ["holds", "refuted", "not determined", ""]  # the last leaves all as it was
    assert found.kept("one") == (1, 3)
    assert found.kept("one", INDEX) == (1, 2)
    assert found.kept("one", SEVERAL) == (0, 0)
    assert found.worst_kind("one") == BINS


def test_nothing_overturns_a_verdict_that_all_paths_keep_or_several_choices_alone_overturn():
    assert paths([([INDEX], student(0.9, 0.01, 10.0))]).worst_kind("one") == ""
    assert paths([([INDEX, BINS], REFUTED)]).worst_kind("one") == ""
    assert paths([]).kept("one") == (0, 0)


def test_a_path_without_the_data_says_so_and_one_that_is_not_about_the_claim_does_not_count():
    lacking = paths([([INDEX], UNKNOWN)])
    assert lacking.verdict[0].tolist() == ["not determined"]
    assert lacking.kept("one") == (0, 1)
    assert np.isnan(lacking.estimate[0, 0])
    unknown_before_and_after = paths([([INDEX], UNKNOWN)], UNKNOWN)
    assert unknown_before_and_after.kept("one") == (1, 1)
    own, other = tried([], [claim(HOLDS), claim(HOLDS, "two")]), [Choice(INDEX, "other")]
    found = gathered([own], [tried(other, [claim(REFUTED), claim(REFUTED, "two")], ["two"])], ALPHA)
    assert found.kept("one") == (0, 1)
    assert found.kept("two") == (0, 0)


def test_a_claim_of_which_a_path_says_nothing_is_not_one_of_its_claims():
    own = tried([], [claim(HOLDS), claim(HOLDS, "two")])
    found = gathered([own], [tried([Choice(INDEX, "other")], [claim(REFUTED)])], ALPHA)
    assert found.verdict[:, 0].tolist() == ["refuted", ""]


@pytest.mark.parametrize("kinds", [[], [INDEX], [INDEX, BINS], [BINS, None]])
def test_a_path_is_named_by_its_choices(kinds):
    of = tried([kind and Choice(kind, f"other {kind}") for kind in kinds], [])
    assert of.kind == ("", kinds[0] if kinds else "", SEVERAL)[sum(map(bool, kinds))]
    assert of.name == ", ".join(f"other {kind}" for kind in kinds if kind)
    assert of.kind in ("", *KINDS)
