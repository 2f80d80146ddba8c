"""One level for a whole session: the largest envelope of each muscle in its trials that were not rejected."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.fits import in_session
from emg2vsa.settings import CocontractionSettings

SESSION_MAX = CocontractionSettings(normalise="session-max")


def test_the_largest_envelope_of_each_muscle_counts_as_one(by_hand):
    alone = in_session(by_hand, [by_hand], SESSION_MAX)
    assert alone.activity == pytest.approx([1 / 4 + 10 / 20, 2 / 4 + 1, 90 / 4 + 90 / 20, 99 / 4 + 99 / 20, 1.5, 1.25])
    assert alone.activity_unit == "1"
    assert alone.notes[0] == "a note"
    assert alone.notes[1].endswith("EDC 4 uV, FDS 20 uV")
    assert alone.envelopes_v is by_hand.envelopes_v


def test_recordings_of_a_session_share_their_level(by_hand):
    louder = replace(by_hand, specimen="S2", envelopes_v=2 * by_hand.envelopes_v)
    first, second = (in_session(part, [by_hand, louder], SESSION_MAX) for part in (by_hand, louder))
    assert second.activity == pytest.approx(2 * first.activity)
    assert second.activity == pytest.approx(in_session(by_hand, [by_hand], SESSION_MAX).activity)


def test_order_of_muscles_and_recordings_does_not_matter(by_hand):
    turned = replace(by_hand, muscles=("FDS", "EDC"), envelopes_v=3 * by_hand.envelopes_v[::-1])
    expected = in_session(by_hand, [by_hand, turned], SESSION_MAX).activity
    assert np.array_equal(in_session(by_hand, [turned, by_hand], SESSION_MAX).activity, expected)
    assert in_session(turned, [by_hand, turned], SESSION_MAX).activity == pytest.approx(3 * expected)


def test_a_recording_without_the_muscle_or_without_presses_sets_no_level(by_hand):
    alone = in_session(by_hand, [by_hand], SESSION_MAX).activity
    other = replace(by_hand, muscles=("EDC", "FCR"), envelopes_v=by_hand.envelopes_v * [[0.5], [100]])
    empty = replace(by_hand, verdict=by_hand.verdict[:0], offsets=np.zeros(1, np.int64), envelopes_v=np.empty((2, 0)))
    assert np.array_equal(in_session(by_hand, [by_hand, other, empty], SESSION_MAX).activity, alone)


def test_a_session_of_rejected_trials_only_gives_zero_not_infinity(by_hand):
    rejected = replace(by_hand, verdict=np.full(3, "rejected"))
    assert not in_session(rejected, [rejected], SESSION_MAX).activity.any()


def test_volts_stay_volts_where_nothing_is_normalised(by_hand):
    same = in_session(by_hand, [by_hand], CocontractionSettings())
    assert np.array_equal(same.activity, by_hand.activity)
    assert same.activity_unit == "V"
