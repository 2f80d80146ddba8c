"""All designs of a study tell together how its mountings differ."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.calibration.mountings import MountingScatter, mounting_scatter, pooled

ASSUMED = 0.043


def of_designs(
    sds, *, mountings=3, presses=3, press=0.02, studies=1, seed=0
) -> tuple[MountingScatter, list[MountingScatter]]:
    """Of designs of four specimens whose mountings have these SDs: all one after the other, and study by study."""
    rng = np.random.default_rng(seed)
    logs = press * rng.standard_normal((studies, len(sds), 4, mountings, presses))
    logs += np.array(sds)[:, None, None, None] * rng.standard_normal((studies, len(sds), 4, mountings, 1))
    labels = np.tile(np.repeat(np.arange(1, mountings + 1), presses), (4, 1))
    scores = 10 * np.exp(logs).reshape(studies, len(sds), 4, -1)
    each = [mounting_scatter(study, labels, ASSUMED) for study in scores]
    return each[0], [pooled(one) for one in each]


def test_designs_together_know_their_mountings_better_than_each_alone():
    _, studies = of_designs([0.03] * 9, studies=400)
    sd, freedom = (np.array([getattr(study, name) for study in studies]) for name in ("sd", "freedom"))
    together = freedom == 72
    assert np.mean(together) > 0.93, "5 % of the designs keep to themselves by chance"
    assert np.mean(sd[together] ** 2) ** 0.5 == pytest.approx(0.03, rel=0.03)
    assert np.std(sd[together]) < 0.004
    assert set(freedom[~together]) == {8}


def test_a_design_whose_mountings_scatter_more_counts_for_itself_and_the_others_are_wide():
    _, studies = of_designs([0.02] * 8 + [0.12], studies=200)
    sd = np.sqrt(np.mean([study.sd**2 for study in studies], axis=0))
    assert sd[-1] == pytest.approx(0.12, rel=0.1)
    assert np.all(sd[:-1] > 0.02)
    assert np.mean([study.freedom[-1] == 8 for study in studies]) > 0.95


def test_a_design_that_was_mounted_once_takes_what_the_others_show():
    several, _ = of_designs([0.02] * 3)
    once, _ = of_designs([0.02], mountings=1, presses=10)
    assert (once.sd[0], once.freedom[0]) == (ASSUMED, 0)
    fields = ("sd", "freedom", "between", "of_presses", "assumed")
    both = MountingScatter(*(np.append(getattr(several, name), getattr(once, name)) for name in fields))
    found = pooled(both)
    assert np.unique(found.freedom) == [24]
    assert np.ptp(found.sd) == 0
    assert 0.005 < found.sd[-1] < 0.04


@pytest.mark.parametrize(("mountings", "presses"), [(1, 10), (1, 1)])
def test_designs_that_were_mounted_once_keep_the_assumed_sd(mountings, presses):
    each, (found,) = of_designs([0.02] * 3, mountings=mountings, presses=presses)
    for name in ("sd", "freedom", "between", "of_presses", "assumed"):
        np.testing.assert_array_equal(getattr(found, name), getattr(each, name))
    assert set(found.sd) == {ASSUMED}


def test_mountings_that_were_pressed_once_do_not_join_those_that_were_pressed_again():
    """Their scatter has that of the presses in it."""
    again, _ = of_designs([0.02] * 2)
    single, _ = of_designs([0.02] * 2, presses=1, seed=1)
    fields = ("sd", "freedom", "between", "of_presses", "assumed")
    both = MountingScatter(*(np.append(getattr(again, name), getattr(single, name)) for name in fields))
    np.testing.assert_array_equal(pooled(both).sd, both.sd)


def test_few_mountings_leave_the_design_to_the_assumed_sd():
    """Chance decides what they show; nine designs of three mountings know it."""
    each, (nine,) = of_designs([0.02] * 9)
    np.testing.assert_array_equal(each.as_assumed().sd, ASSUMED)
    np.testing.assert_array_equal(nine.as_assumed().sd, np.where(nine.freedom == 72, nine.sd, ASSUMED))
    assert np.count_nonzero(nine.freedom == 72) >= 7
    none = MountingScatter(each.sd, each.freedom, each.between, each.of_presses, 0 * each.assumed)
    np.testing.assert_array_equal(none.as_assumed().sd, each.sd)
