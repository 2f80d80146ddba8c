from __future__ import annotations

import pytest

from emg2vsa.report.numbers import is_p, unit_of


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("fit.S1.b_v.mean", "V"),
        ("fit.S1.b.mean", ""),
        ("fit.S1.n", ""),
        ("profiles.S_new.rmse_v", "V"),
        ("profiles.S_new.rmse_relative", ""),
        ("trials.largest_delay_mismatch_s", "s"),
        ("schedules.S1.modular.max_percent", "%"),
        ("schedules.S1.constant-min.percent", "%"),
        ("schedules.S1.constant-min.nm_per_rad", "N·m/rad"),
        ("calibration.kappa_n_per_mm", "N/mm"),
        ("runs.modular.30.S1.casr_mm2_per_n.mean", "mm²/N"),
        ("runs.modular.30.S1.a_c0_px2.sd", "px²"),
        ("calibration.decay_per_n", ""),
        ("hypotheses.between_participants.S1.f", ""),
        ("mean", ""),
    ],
)
def test_units_are_those_of_the_names(key, unit):
    assert unit_of(key) == unit


@pytest.mark.parametrize(
    "key", ["hypotheses.worst_p", "hypotheses.worst_p.holm", "a.p", "a.p_gg", "a.mauchly_p", "a.largest_p"]
)
def test_a_p_is_known_by_its_name(key):
    assert is_p(key)


@pytest.mark.parametrize(
    "key", ["hypotheses.worst_pair", "power.n14", "hypotheses.between_specimens.P01.f", "hypotheses.pairs.tested"]
)
def test_other_numbers_are_no_p(key):
    assert not is_p(key)
