from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from emg2vsa.errors import SettingError
from emg2vsa.study import Study
from emg2vsa.worlds.people.plan import plan_study

Make = Callable[..., Study]


def test_every_cell_once_and_each_participant_in_an_order_of_its_own(study_with: Make) -> None:
    _, plan = plan_study(study_with(participants=6, specimens=5))
    assert [(r.participant, r.specimen) for r in plan[:6]] == [*(("P01", f"S{i}") for i in range(1, 6)), ("P02", "S1")]
    orders = [tuple(r.position for r in plan[i : i + 5]) for i in range(0, 30, 5)]
    assert all(sorted(order) == [1, 2, 3, 4, 5] for order in orders)
    assert len(set(orders)) > 1


def test_acquisition_times_follow_the_order(study_with: Make) -> None:
    _, plan = plan_study(study_with(participants=3, specimens=4))
    for i in range(0, 12, 4):
        in_time = sorted(plan[i : i + 4], key=lambda r: r.acquired)
        assert [r.position for r in in_time] == [1, 2, 3, 4]
        assert len({r.acquired.date() for r in in_time}) == 1
    assert len({r.acquired for r in plan}) == 12


def test_long_recordings_do_not_overlap(study_with: Make) -> None:
    settings, plan = plan_study(study_with(participants=1, specimens=3, repetitions=50))
    begun = sorted(plan, key=lambda r: r.acquired)
    for first, second in pairwise(begun):
        assert first.make(settings).duration_s < (second.acquired - first.acquired).total_seconds()


def test_coefficients_are_the_specimens_own_unless_participants_differ(study_with: Make) -> None:
    _, plan = plan_study(study_with(participants=3))
    assert [r.b_v for r in plan] == pytest.approx([15e-6, 14e-6] * 3)
    _, plan = plan_study(study_with(participants=200, specimens=1, participant_sd=0.1))
    b_v = np.array([r.b_v for r in plan])
    assert np.std(b_v) / 15e-6 == pytest.approx(0.1, rel=0.2)
    assert np.mean(b_v) / 15e-6 == pytest.approx(1.0, abs=0.03)


def test_a_participant_differs_alike_on_all_specimens(study_with: Make) -> None:
    _, plan = plan_study(study_with(participants=4, participant_sd=0.1))
    for first, second in zip(plan[::2], plan[1::2], strict=True):
        assert first.b_v / 15e-6 == pytest.approx(second.b_v / 14e-6)
        assert first.a_v / first.b_v == pytest.approx(2.0)


def test_coefficients_that_do_not_fit_are_refused(study_with: Make) -> None:
    with pytest.raises(SettingError, match="Raise a_v"):
        plan_study(study_with(a_v={"S1": 1e-5, "S2": 1e-5}))


def test_a_study_without_simulation_is_refused(study: Study) -> None:
    with pytest.raises(SettingError, match=r"\[simulation\]"):
        plan_study(replace(study, simulation=None))
