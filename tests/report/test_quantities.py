from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.fits import usable
from emg2vsa.report.study_report import numbers_and_tables


@pytest.fixture(scope="module")
def found(results):
    return numbers_and_tables(results).quantities


def test_names_are_sorted_and_values_plain(found):
    assert list(found) == sorted(found)
    assert {type(value) for value in found.values()} <= {str, int, float, bool}


def test_the_papers_sample_size_is_reproduced(found):
    assert found["power.n14"] == pytest.approx(0.819421399316, abs=1e-12)


def test_numbers_are_those_of_the_stages(found, results):
    hypotheses, error = results.people.hypotheses, results.people.profiles.new_error
    assert found["hypotheses.worst_p"] == hypotheses.worst_p
    first = hypotheses.participants.tolist().index("P01")
    assert found["hypotheses.between_specimens.P01.f"] == hypotheses.tests.between_groups.anova.f[first]
    assert found["hypotheses.worst_p.holm"] == hypotheses.tests.pairs.p_holm[hypotheses.worst]
    assert found["hypotheses.over_people.friedman.p"] == hypotheses.tests.blocks.friedman.p[0]
    assert found["profiles.S_new.rmse_v"] == error.rmse_v
    assert found["profiles.S_new.measured_as"] == "S2"
    modular = next(s for s in results.people.schedules if (s.specimen, s.condition) == ("S1", "modular"))
    assert found["schedules.S1.modular.max_percent"] == modular.stiffness_percent.max() == pytest.approx(80)


def test_rejected_trials_are_counted_but_do_not_enter(found, results):
    assert found["trials.total"] == 3 * 4 * 6
    assert (found["trials.ok"], found["trials.warned"], found["trials.rejected"]) == (70, 1, 1)
    assert found["fit.used"] == 71
    worst = np.argmin(results.people.fits.adj_r2_bins)
    verdict = results.people.fits.verdict.copy()
    verdict[worst] = "rejected"
    without = numbers_and_tables(
        replace(results, people=replace(results.people, fits=replace(results.people.fits, verdict=verdict)))
    ).quantities
    assert without["fit.adj_r2_bins.min"] > found["fit.adj_r2_bins.min"] == results.people.fits.adj_r2_bins[worst]


def test_the_worst_pair_is_the_largest_p_among_the_kept(found):
    pairs = [
        value
        for key, value in found.items()
        if key.startswith("hypotheses.pairs.") and key.endswith(("S1-S3.p", "S1-S5.p", "S3-S5.p"))
    ]
    assert len(pairs) == 3 * 3
    assert max(pairs) == found["hypotheses.worst_p"]


def test_failed_stages_leave_their_numbers_out(broken):
    found = numbers_and_tables(broken).quantities
    assert not [key for key in found if key.startswith(("hypotheses.", "profiles.", "schedules.", "recovery."))]
    assert found["study.failures"] == 3
    assert found["fit.used"] == 71
    assert "power.study" not in found


def test_nothing_usable_is_not_an_exception(results):
    fits = replace(results.people.fits, verdict=np.full(results.people.fits.verdict.shape, "rejected"))
    assert not usable(fits, "ok+warned").any()
    found = numbers_and_tables(replace(results, people=replace(results.people, fits=fits))).quantities
    assert found["fit.used"] == 0
    assert math.isnan(found["fit.adj_r2_bins.min"])
    assert found["recovery.n"] == 0
