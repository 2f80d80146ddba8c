"""Order of acquisition and drift: told from the order where it differs, bounded by the recordings where it does not."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.statistics.drift import Slope, drift

PER_PLACE = 0.8
"Of the worlds below, in SDs of a press."


def session(rng, people, orders, *, specimens=5, presses=10, per_place=PER_PLACE, rates=0.3):
    """Columns of ``drift``: people with levels of their own press specimens; ``orders`` : person to places (from 1)."""
    shape = (people, specimens, presses)
    who, what, number = (axis.ravel() for axis in np.indices(shape))
    place = np.array([orders(i) for i in range(people)], dtype=float)[who, what]
    rate = per_place / presses * (1 + rates * rng.standard_normal(people))
    value = rng.standard_normal(shape).ravel() + 3 * rng.standard_normal(people)[who] + what
    value += rate[who] * ((place - 1) * presses + number)
    return np.char.mod("P%d", who), np.char.mod("S%d", what), place, number + 1.0, value


def at_random(rng, specimens=5):
    return lambda person: 1 + rng.permutation(specimens)


def as_listed(person):
    return np.arange(1, 6)


def test_the_order_tells_the_drift_of_people_that_drift_at_rates_of_their_own():
    """An interval of 95 %: fewer than 88 of 100 would hold the drift in less than 0.4 % of samples."""
    rng = np.random.default_rng(1)
    held = 0
    for _ in range(100):
        found = drift(*session(rng, 14, at_random(rng)))
        assert found.order == "differs"
        low, high = found.by_order.interval(0.95)
        held += low <= PER_PLACE <= high
    assert held >= 88


def test_presses_within_recordings_tell_the_drift_whatever_the_order():
    rng = np.random.default_rng(2)
    held = 0
    for _ in range(100):
        low, high = drift(*session(rng, 14, as_listed)).within.interval(0.95)
        held += low <= PER_PLACE <= high
    assert held >= 88


@pytest.mark.parametrize("others", [0, 1])
def test_an_order_that_all_or_all_but_one_share_tells_nothing(others):
    rng = np.random.default_rng(3)
    found = drift(*session(rng, 14, lambda person: as_listed(person)[:: -1 if person < others else 1]))
    assert found.order == "same"
    assert np.isnan(found.by_order.value)
    assert found.session == found.within.times(4)


def reversed_for(people):
    return lambda person: as_listed(person)[:: -1 if person < people else 1]


def of_a_square(person):
    return 1 + (np.arange(5) + person) % 5


@pytest.mark.parametrize(
    ("orders", "told"), [(reversed_for(2), "same"), (reversed_for(7), "same"), (of_a_square, "differs")]
)
def test_few_orders_tell_drift_where_no_group_keeps_its_place(orders, told):
    """Forwards and backwards, the middle specimen has one place: a drift that is not straight would look like it."""
    assert drift(*session(np.random.default_rng(4), 14, orders)).order == told


@pytest.mark.parametrize(("lost", "order"), [(1, "differs"), (2, "unknown"), (4, "unknown")])
def test_the_order_is_unknown_unless_more_than_half_of_the_people_tell_it(lost, order):
    rng = np.random.default_rng(5)
    block, group, place, repetition, values = session(rng, 4, at_random(rng))
    of_lost = np.isin(block, [f"P{i}" for i in range(lost)])
    place[of_lost & (group == "S2")] = np.nan
    found = drift(block, group, place, repetition, values)
    assert (found.order, found.places) == (order, 5)
    assert np.isfinite(found.within.value)
    others = drift(*(each[~of_lost] for each in (block, group, place, repetition, values)))
    assert order == "unknown" or found.by_order == others.by_order


def test_values_that_are_not_there_count_for_nothing():
    rng = np.random.default_rng(6)
    columns = session(rng, 6, at_random(rng))
    gone = (columns[0] == "P2") & (columns[1] == "S3")
    gone[0] = True
    values = np.where(gone, np.nan, columns[4])
    found, expected = drift(*columns[:4], values), drift(*(each[~gone] for each in columns))
    assert found == expected


def test_mountings_of_a_rig_are_recordings_of_one_block():
    """Cells that were mounted three times each, at random places: the slope of a straight drift, without error."""
    rng = np.random.default_rng(7)
    cells, presses = np.repeat(np.arange(8), 3), 5
    place = 1.0 + rng.permutation(24)
    cell, at = np.repeat(cells, presses), np.repeat(place, presses)
    values = cell + 0.1 * at
    columns = np.full(cell.size, "rig"), np.char.mod("%d", cell), at, np.tile(np.arange(1.0, 6), 24), values
    found = drift(*columns, unit=np.char.mod("%g", at))
    assert found.order == "differs"
    assert found.places == 24
    assert found.by_order.value == pytest.approx(0.1)
    assert found.within.value == pytest.approx(0.0, abs=1e-12)


def test_nothing_gives_nothing():
    none = np.empty(0)
    found = drift(none.astype(str), none.astype(str), none, none, none)
    assert (found.order, found.places) == ("unknown", 0)
    assert found.within.most(0.95) == np.inf


def test_one_press_a_recording_leaves_the_drift_unbounded():
    rng = np.random.default_rng(8)
    found = drift(*session(rng, 5, as_listed, presses=1))
    assert found.order == "same"
    assert found.within.most(0.95) == np.inf


def test_the_most_that_a_slope_allows_is_its_farther_end():
    assert Slope(-1.0, 0.5, np.inf).most(0.95) == pytest.approx(1.98, abs=0.001)
    assert Slope(-1.0, 0.5, np.inf).times(-2).interval(0.95) == pytest.approx((0.04, 3.96), abs=0.001)


def test_a_slope_of_exactly_nothing_has_an_error():
    """One unit and t = 0: the error is that of the slope; values that are all alike have none."""
    columns = np.full(4, "P1"), np.full(4, "S1"), np.full(4, np.nan), np.arange(1.0, 5.0)
    found = drift(*columns, np.array([1.0, 0.0, 0.0, 1.0])).within
    assert found.value == 0
    assert 0 < found.error < np.inf
    assert np.isnan(drift(*columns, np.ones(4)).within.error)
