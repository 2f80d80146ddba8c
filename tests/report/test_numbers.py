"""The quantities of a report: where they come from, their units, and their files."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.fits import usable
from emg2vsa.report.numbers import is_p, macro_names, numbers_tex, results_json, unit_of
from emg2vsa.report.study_report import numbers_and_tables

KEYS = st.text(alphabet="abcXYZ019._-", min_size=1, max_size=12).filter(lambda key: any(c.isalnum() for c in key))
NAN = math.nan


@pytest.fixture(scope="module")
def found(results):
    return numbers_and_tables(results).quantities


def test_names_are_sorted_and_values_plain(found):
    assert list(found) == sorted(found)
    assert {type(value) for value in found.values()} <= {str, int, float, bool}


def test_numbers_are_those_of_the_stages(found, results):
    hypotheses, error = results.people.hypotheses, results.people.profiles.new_error
    assert found["power.n14"] == pytest.approx(0.819421399316, abs=1e-12)  # the paper's sample size
    assert found["hypotheses.worst_p"] == hypotheses.worst_p
    first = hypotheses.participants.tolist().index("P01")
    assert found["hypotheses.between_specimens.P01.f"] == hypotheses.tests.between_groups.anova.f[first]
    assert found["hypotheses.worst_p.holm"] == hypotheses.tests.pairs.p_holm[hypotheses.worst]
    assert found["hypotheses.over_people.friedman.p"] == hypotheses.tests.blocks.friedman.p[0]
    assert (found["profiles.S_new.rmse_v"], found["profiles.S_new.measured_as"]) == (error.rmse_v, "S2")
    modular = next(s for s in results.people.schedules if (s.specimen, s.condition) == ("S1", "modular"))
    assert found["schedules.S1.modular.max_percent"] == modular.stiffness_percent.max() == pytest.approx(80)
    ends = ("S1-S3.p", "S1-S5.p", "S3-S5.p")
    pairs = [value for key, value in found.items() if key.startswith("hypotheses.pairs.") and key.endswith(ends)]
    assert len(pairs) == 3 * 3
    assert max(pairs) == found["hypotheses.worst_p"]


def test_rejected_trials_are_counted_but_do_not_enter(found, results):
    assert found["trials.total"] == 3 * 4 * 6
    assert (found["trials.ok"], found["trials.doubtful"], found["trials.rejected"]) == (70, 1, 1)
    assert found["fit.used"] == 70
    fits = results.people.fits
    worst, verdict = np.argmin(fits.adj_r2_bins), fits.verdict.copy()
    verdict[worst] = "rejected"
    people = replace(results.people, fits=replace(fits, verdict=verdict))
    without = numbers_and_tables(replace(results, people=people)).quantities
    assert without["fit.adj_r2_bins.min"] > found["fit.adj_r2_bins.min"] == fits.adj_r2_bins[worst]


def test_failed_stages_leave_their_numbers_out_and_nothing_usable_is_no_exception(broken, results):
    found = numbers_and_tables(broken).quantities
    assert not [key for key in found if key.startswith(("hypotheses.", "profiles.", "schedules.", "recovery."))]
    assert (found["study.failures"], found["fit.used"]) == (3, 70)
    assert "power.study" not in found
    fits = replace(results.people.fits, verdict=np.full(results.people.fits.verdict.shape, "rejected"))
    assert not usable(fits, "ok+doubtful").any()
    found = numbers_and_tables(replace(results, people=replace(results.people, fits=fits))).quantities
    assert found["fit.used"] == found["recovery.n"] == 0
    assert math.isnan(found["fit.adj_r2_bins.min"])


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("fit.S1.b_v.mean", "V"), ("fit.S1.b.mean", ""), ("fit.S1.n", ""), ("profiles.S_new.rmse_v", "V"),
        ("profiles.S_new.rmse_relative", ""), ("trials.largest_delay_mismatch_s", "s"),
        ("schedules.S1.modular.max_percent", "%"), ("schedules.S1.constant-min.percent", "%"),
        ("schedules.S1.constant-min.nm_per_rad", "N·m/rad"), ("calibration.kappa_n_per_mm", "N/mm"),
        ("runs.modular.30.S1.casr_mm2_per_n.mean", "mm²/N"), ("runs.modular.30.S1.a_c0_px2.sd", "px²"),
        ("calibration.decay_per_n", ""), ("hypotheses.between_participants.S1.f", ""), ("mean", ""),
    ],
)  # fmt: skip
def test_units_are_those_of_the_names(key, unit):
    assert unit_of(key) == unit


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ("hypotheses.worst_p hypotheses.worst_p.holm a.p a.p_gg a.mauchly_p a.largest_p", True),
        ("hypotheses.worst_pair power.n14 hypotheses.between_specimens.P01.f hypotheses.pairs.tested", False),
    ],
)
def test_a_p_is_known_by_its_name(keys, expected):
    assert {is_p(key) for key in keys.split()} == {expected}


def test_json_is_flat_sorted_exact_and_strict():
    text = results_json({"b": 0.1 + 0.2, "a": NAN, "c": "S1, S3", "d": True, "e": 3, "high": math.inf})
    assert list(json.loads(text)) == ["a", "b", "c", "d", "e", "high"]
    expected = {"a": None, "b": 0.30000000000000004, "c": "S1, S3", "d": True, "e": 3, "high": "inf"}
    assert json.loads(text) == expected
    assert json.loads(results_json({"low": -math.inf})) == {"low": "-inf"}
    assert "NaN" not in text


@given(st.lists(KEYS, unique=True, max_size=20))
def test_macros_are_letters_only_and_never_twice_the_same(keys):
    names = list(macro_names(keys).values())
    assert all(re.fullmatch("[A-Za-z]+", name) for name in names)
    assert len(set(names)) == len(keys)
    assert macro_names(["fit.adj_r2_bins.min"]) == {"fit.adj_r2_bins.min": "emgFitAdjRTwoBinsMin"}
    assert macro_names(["power.n14"], "emgTest") == {"power.n14": "emgTestPowerNOneFour"}


@pytest.mark.parametrize(
    ("key", "value", "made"),
    [
        ("a.b", 1.23456e-5, r"{\emgAB}{\ensuremath{1.235\times10^{-5}}} % a.b"),
        ("c.d", 0.039123, r"{\emgCD}{0.03912}"), ("e.f", 700, r"{\emgEF}{700}"),
        ("g.h", "P07 S_1", r"{\emgGH}{P07 S\_1}"), ("i.j", NAN, r"{\emgIJ}{--}"),
        ("k.l", True, r"{\emgKL}{yes}"), ("kappa.high", math.inf, r"{\emgKappaHigh}{\ensuremath{\infty}}"),
        # units stand beside numbers, and volts are read in their own size
        ("b_v", 19.98e-6, r"{\emgBV}{\emgquantity{19.98}{\ensuremath{\mu}V}}"),
        ("c_v", -2.5e-3, r"{\emgCV}{\emgquantity{\ensuremath{-2.5}}{mV}}"),
        ("d_v", 1.5, r"{\emgDV}{\emgquantity{1.5}{V}}"),
        ("e_v", 0.0, r"{\emgEV}{\emgquantity{0}{V}}"), ("t_s", 3, r"{\emgTS}{\emgquantity{3}{s}}"),
        ("u.percent", 34.6321, r"{\emgUPercent}{\emgquantity{34.63}{\%}}"), ("w_v", NAN, r"{\emgWV}{--}"),
        # a p says its bound
        ("a.p", 0.0391, r"{\emgAP}{\emgp{=}{.039}}"), ("b.p", 1e-9, r"{\emgBP}{\emgp{<}{.001}}"),
        ("c.p", 0.99999, r"{\emgCP}{\emgp{>}{.999}}"), ("worst_p.holm", 0.5, r"{\emgWorstPHolm}{\emgp{=}{.500}}"),
        ("d.p", NAN, r"{\emgDP}{--}"),
    ],
)  # fmt: skip
def test_numbers_as_latex_sets_them(key, value, made):
    assert rf"\newcommand{made}" in numbers_tex({key: value})
