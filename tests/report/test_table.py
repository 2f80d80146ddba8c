from __future__ import annotations

import csv
import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.report.table import FEW_ON_PAGE, MOST_ON_PAGE, Column, ColumnRows, Table, from_quantities, table_of

NAMES = st.text(st.characters(exclude_categories=("C",)), max_size=8)


def table(*rows: tuple, factor: float = 1.0) -> Table:
    keyed = tuple({"name": name, "v_v": value} for name, value in rows)
    return Table("t", "A & B", (Column("name", "Na_me"), Column("v_v", "v (µV)", factor)), keyed)


@given(st.lists(st.tuples(NAMES, st.floats(allow_nan=False)), max_size=5))
def test_csv_reads_back_exactly(rows):
    read = list(csv.reader(io.StringIO("".join(table(*rows).csv()), newline="")))
    assert read[0] == ["name", "v_v"]
    assert [float(row[1]) for row in read[1:]] == [value for _, value in rows]


def test_csv_holds_stored_units_and_people_see_theirs_escaped():
    made = table(("S1", 2e-5), factor=1e6)
    assert "".join(made.csv()).splitlines()[1] == "S1,2e-05"
    assert "20.0" in made.html()
    missing = table(("S1", math.nan), ("S2", None))
    assert "".join(missing.csv()).splitlines()[1:] == ["S1,", "S2,"]
    assert missing.html().count("–") == 2
    assert "nan" not in missing.html().lower()
    html = table(("<script>alert(1)</script>", 1.0)).html()
    assert "<script" not in html
    assert "A &amp; B" in html
    assert list(Table("t", "", (Column("b_v", "b", name="b"),), ()).csv()) == ["b\n"]


def test_people_may_see_fewer_rows_than_programs():
    made = Table("t", "", (Column("name", "Name"),), ({"name": "all"}, {"name": "some"}), ({"name": "some"},))
    assert "".join(made.csv()).splitlines() == ["name", "all", "some"]
    assert "some" in made.html()
    assert "all" not in made.html()


def test_people_see_a_p_with_its_bound_and_programs_every_digit():
    made = Table("t", "", (Column("p_holm", "p Holm"),), ColumnRows({"p_holm": [1.2345e-9, 0.0391, 0.99999, math.nan]}))
    assert made.cells() == [["< .001"], [".039"], ["> .999"], ["–"]]
    assert "".join(made.csv()).splitlines()[1:3] == ["1.2345e-09", "0.0391"]


def test_latex_keeps_its_own_minus():
    """A true minus stops pdflatex."""
    made = Table("t", "", (Column("apa", "APA"), Column("latex", "LaTeX")), ({"apa": "-.11", "latex": "$= -.11$"},))
    assert made.cells() == [["−.11", "$= -.11$"]]


@pytest.mark.parametrize("row", [{"name": "S1"}, {"name": "S1", "v_v": 1.0, "w": 2.0}, {"v_v": 1.0, "title": "S1"}])
def test_a_row_has_the_columns_of_its_table_and_no_others(row):
    columns = (Column("name", "Name"), Column("v_v", "v"))
    with pytest.raises(ValueError, match="table t: a row has"):
        Table("t", "", columns, (row,))


def test_the_order_of_keys_in_a_row_does_not_matter():
    columns = (Column("first", "First"), Column("second", "Second"))
    rows = ({"second": 2.0, "first": "a"}, {"first": "b", "second": 4.0})
    made = Table("t", "", columns, rows)
    assert "".join(made.csv()).splitlines() == ["first,second", "a,2.0", "b,4.0"]
    assert made.cells() == [["a", "2.00"], ["b", "4.00"]]
    assert made.numeric() == [False, True]


def test_a_table_on_a_page_has_its_number_links_and_kinds():
    columns = (Column("name", "Name"), Column("verdict", "Verdict"))
    rows = ({"name": "a", "verdict": "holds"}, {"name": "b", "verdict": "does not hold"})
    made = Table("t", "All of -1 at 5%", columns, rows, kinds=("holds", "fails"), links=("#a", "")).html(7)
    assert "<caption><b>Table 7.</b> All of −1 at 5\N{NO-BREAK SPACE}%</caption>" in made
    assert '<tr class="fails"><td>b</td><td class="verdict">does not hold</td></tr>' in made
    assert '<td><a href="#a">a</a></td>' in made


def test_a_long_table_is_cut_on_the_page_and_whole_in_its_file() -> None:
    made = Table(
        "t", "c", (Column("a", "A"), Column("b", "B")), ColumnRows({"a": np.arange(1234.0), "b": ["x"] * 1234})
    )
    page, file = made.html(), list(made.csv())
    assert page.count("<tr>") == 1 + MOST_ON_PAGE
    assert f"The first {MOST_ON_PAGE} of 1234 rows" in page
    assert 'href="tables/t.csv"' in page
    assert len(file) > 2
    assert "".join(file).splitlines()[1:] == [f"{float(i)!r},x" for i in range(1234)]


def test_a_long_table_with_links_has_a_page_of_its_own() -> None:
    names = [f"P{i}" for i in range(MOST_ON_PAGE + 1)]
    made = Table(
        "t", "c", (Column("a", "A"),), ColumnRows({"a": names}), links=tuple(f"p/{name}.html" for name in names)
    )
    assert made.own_page == "t.html"
    assert 'href="t.html"' in made.html()
    assert f'href="p/P{MOST_ON_PAGE}.html"' not in made.html()
    assert f'href="p/P{MOST_ON_PAGE}.html"' in made.html(whole=True)
    assert Table("t", "c", (Column("a", "A"),), ColumnRows({"a": names[:2]}), links=("p", "q")).own_page == ""


def test_rows_of_columns_are_made_when_they_are_asked_for() -> None:
    rows = ColumnRows({"a": np.arange(1234), "b": [str(i) for i in range(1234)]})
    whole = [{"a": i, "b": str(i)} for i in range(1234)]
    assert (len(rows), list(rows), rows[7], rows[-1], rows[3:5]) == (1234, whole, whole[7], whole[-1], whole[3:5])
    assert type(rows[0]["a"]) is int
    with pytest.raises(IndexError):
        rows[1234]
    with pytest.raises(ValueError, match="unequal length"):
        ColumnRows({"a": [1], "b": [1, 2]})


def test_a_table_of_single_persons_shows_its_first_rows_and_its_file_has_them_all() -> None:
    made = table_of("t", "c", {Column("a", "A"): np.arange(70)}, FEW_ON_PAGE)
    assert made.html().count("<tr>") == 1 + FEW_ON_PAGE
    assert f"The first {FEW_ON_PAGE} of 70 rows" in made.html()
    assert made.html(whole=True).count("<tr>") == 71
    assert len("".join(made.csv()).splitlines()) == 71


def test_columns_of_quantities_are_empty_where_there_is_none() -> None:
    q = {"fit.S1.n": 3, "fit.S2.n": 4, "fit.S2.b.mean": 1.5}
    n, mean = Column("used", "Used"), Column("b_mean", "Mean b")
    found = from_quantities(q, ["fit.S1", "fit.S2"], {n: "n", mean: "b.mean"})
    assert found == {n: [3, 4], mean: [None, 1.5]}
    assert "".join(table_of("t", "c", found).csv()).splitlines() == ["used,b_mean", "3,", "4,1.5"]
