from __future__ import annotations

import json
import math
import re

from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.report.numbers_files import macro_names, numbers_tex, results_json

KEYS = st.text(alphabet="abcXYZ019._-", min_size=1, max_size=12).filter(lambda key: any(c.isalnum() for c in key))


def test_json_is_flat_sorted_exact_and_strict():
    text = results_json({"b": 0.1 + 0.2, "a": math.nan, "c": "S1, S3", "d": True, "e": 3})
    read = json.loads(text)
    assert list(read) == sorted(read)
    assert read == {"a": None, "b": 0.30000000000000004, "c": "S1, S3", "d": True, "e": 3}
    assert "NaN" not in text


def test_macros_spell_digits():
    assert macro_names(["fit.adj_r2_bins.min"]) == {"fit.adj_r2_bins.min": "FitAdjRTwoBinsMin"}
    assert macro_names(["power.n14"]) == {"power.n14": "PowerNOneFour"}


@given(st.lists(KEYS, unique=True, max_size=20))
def test_macros_are_letters_only_and_never_twice_the_same(keys):
    names = list(macro_names(keys).values())
    assert all(re.fullmatch("[A-Za-z]+", name) for name in names)
    assert len(set(names)) == len(keys)


def test_numbers_as_latex_sets_them():
    text = numbers_tex({"a.b": 1.23456e-5, "c.d": 0.039123, "e.f": 700, "g.h": "P07 S_1", "i.j": math.nan})
    assert r"\newcommand{\AB}{\ensuremath{1.235\times10^{-5}}}" in text
    assert r"\newcommand{\CD}{0.03912}" in text
    assert r"\newcommand{\EF}{700}" in text
    assert r"\newcommand{\GH}{P07 S\_1}" in text
    assert r"\newcommand{\IJ}{--}" in text
