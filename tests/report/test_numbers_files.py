from __future__ import annotations

import json
import math
import re

from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.report.numbers import macro_names, numbers_tex, results_json

KEYS = st.text(alphabet="abcXYZ019._-", min_size=1, max_size=12).filter(lambda key: any(c.isalnum() for c in key))


def test_json_is_flat_sorted_exact_and_strict():
    text = results_json({"b": 0.1 + 0.2, "a": math.nan, "c": "S1, S3", "d": True, "e": 3})
    read = json.loads(text)
    assert list(read) == sorted(read)
    assert read == {"a": None, "b": 0.30000000000000004, "c": "S1, S3", "d": True, "e": 3}
    assert "NaN" not in text


def test_an_interval_without_an_end_says_so():
    found = {"kappa.high": math.inf, "kappa.low": -math.inf}
    assert json.loads(results_json(found)) == {"kappa.high": "inf", "kappa.low": "-inf"}
    assert r"\newcommand{\emgKappaHigh}{\ensuremath{\infty}}" in numbers_tex(found)


def test_macros_spell_digits():
    assert macro_names(["fit.adj_r2_bins.min"]) == {"fit.adj_r2_bins.min": "emgFitAdjRTwoBinsMin"}
    assert macro_names(["power.n14"], "emgTest") == {"power.n14": "emgTestPowerNOneFour"}


@given(st.lists(KEYS, unique=True, max_size=20))
def test_macros_are_letters_only_and_never_twice_the_same(keys):
    names = list(macro_names(keys).values())
    assert all(re.fullmatch("[A-Za-z]+", name) for name in names)
    assert len(set(names)) == len(keys)


def test_numbers_as_latex_sets_them():
    text = numbers_tex({"a.b": 1.23456e-5, "c.d": 0.039123, "e.f": 700, "g.h": "P07 S_1", "i.j": math.nan, "k.l": True})
    assert r"\newcommand{\emgAB}{\ensuremath{1.235\times10^{-5}}} % a.b" in text
    assert r"\newcommand{\emgCD}{0.03912}" in text
    assert r"\newcommand{\emgEF}{700}" in text
    assert r"\newcommand{\emgGH}{P07 S\_1}" in text
    assert r"\newcommand{\emgIJ}{--}" in text
    assert r"\newcommand{\emgKL}{yes}" in text


def test_units_stand_beside_numbers_and_volts_are_read_in_their_own_size():
    found = {"b_v": 19.98e-6, "c_v": -2.5e-3, "d_v": 1.5, "e_v": 0.0, "t_s": 3, "u.percent": 34.6321, "w_v": math.nan}
    text = numbers_tex(found)
    assert r"{\emgBV}{\emgquantity{19.98}{\ensuremath{\mu}V}}" in text
    assert r"{\emgCV}{\emgquantity{\ensuremath{-2.5}}{mV}}" in text
    assert r"{\emgDV}{\emgquantity{1.5}{V}}" in text
    assert r"{\emgEV}{\emgquantity{0}{V}}" in text
    assert r"{\emgTS}{\emgquantity{3}{s}}" in text
    assert r"{\emgUPercent}{\emgquantity{34.63}{\%}}" in text
    assert r"{\emgWV}{--}" in text


def test_a_p_says_its_bound():
    text = numbers_tex({"a.p": 0.0391, "b.p": 1e-9, "c.p": 0.99999, "worst_p.holm": 0.5, "d.p": math.nan})
    assert r"{\emgAP}{\emgp{=}{.039}}" in text
    assert r"{\emgBP}{\emgp{<}{.001}}" in text
    assert r"{\emgCP}{\emgp{>}{.999}}" in text
    assert r"{\emgWorstPHolm}{\emgp{=}{.500}}" in text
    assert r"{\emgDP}{--}" in text
