from __future__ import annotations

import csv
import io
import math
import re

from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.report.table import Column, Table, latex_text

NAMES = st.text(st.characters(exclude_categories=("C",)), max_size=8)


def table(*rows: tuple, factor: float = 1.0) -> Table:
    return Table("t", "A & B", (Column("name", "Na_me"), Column("v_v", "v (µV)", factor)), rows)


@given(st.lists(st.tuples(NAMES, st.floats(allow_nan=False)), max_size=5))
def test_csv_reads_back_exactly(rows):
    read = list(csv.reader(io.StringIO(table(*rows).csv(), newline="")))
    assert read[0] == ["name", "v_v"]
    assert [float(row[1]) for row in read[1:]] == [value for _, value in rows]


def test_csv_holds_stored_units_and_people_see_theirs():
    made = table(("S1", 2e-5), factor=1e6)
    assert made.csv().splitlines()[1] == "S1,2e-05"
    assert "20.0" in made.html()
    assert "20.0" in made.latex()


def test_missing_values_are_empty_in_csv_and_a_dash_for_people():
    made = table(("S1", math.nan), ("S2", None))
    assert made.csv().splitlines()[1:] == ["S1,", "S2,"]
    assert made.html().count("–") == 2
    assert "nan" not in (made.html() + made.latex()).lower()


def test_html_escapes_what_a_study_may_call_its_specimens():
    made = table(("<script>alert(1)</script>", 1.0)).html()
    assert "<script" not in made
    assert "A &amp; B" in made


def test_latex_is_booktabs_with_every_special_character_escaped():
    made = table(("50 % of A_1 & ~", 1.0)).latex()
    assert r"50 \% of A\_1 \& \textasciitilde{}" in made
    assert made.index(r"\toprule") < made.index(r"\midrule") < made.index(r"\bottomrule")
    assert r"\caption{A \& B}" in made
    assert r"\begin{tabular}{lr}" in made


@given(st.text(alphabet="ab&%$#_{}~^\\<>µ²ηκα–·±−≤", max_size=20))
def test_latex_text_leaves_no_bare_special_character(text):
    made = re.sub(r"\\(?:[&%$#_{}]|[a-zA-Z]+(?:\{\})?)", "", latex_text(text))
    made = re.sub(r"[{}]|\^2", "", made)  # braces and powers of the symbols' own commands
    assert not set(made) & set("&%$#_~^\\µηκα·±−≤")
