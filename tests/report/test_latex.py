from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from emg2vsa.report.drawing import Drawing, figure_tex
from emg2vsa.report.latex import latex_number, latex_table, latex_text
from emg2vsa.report.table import Column, Table


def table(*rows: tuple, heads: tuple[str, ...] = ("Na_me", "v (µV)")) -> Table:
    columns = tuple(Column(f"c{i}", head) for i, head in enumerate(heads))
    keyed = tuple({column.key: cell for column, cell in zip(columns, row, strict=True)} for row in rows)
    return Table("t", "A & B", columns, keyed)


def test_booktabs_with_every_special_character_escaped():
    made = latex_table(table(("50 % of A_1 & ~", 1.0)))
    assert r"50~\% of A\_1 \& \textasciitilde{} & 1.00 \\" in made
    assert made.index(r"\toprule") < made.index(r"\midrule") < made.index(r"\bottomrule")
    assert r"\caption{A \& B}" in made
    assert r"\begin{tabular}{lr}" in made
    assert "Na\\_me & v (\\ensuremath{\\mu}V)" in made


@given(st.text(alphabet="ab&%$#_{}~^\\<>µ²ηκα–·±−≤", max_size=20))
def test_text_leaves_no_bare_special_character(text):
    made = re.sub(r"\\(?:[&%$#_{}]|[a-zA-Z]+(?:\{\})?)", "", latex_text(text))
    made = re.sub(r"[{}]|\^2|_(?=\{)", "", made)  # braces, powers and indices of the symbols' own commands
    assert not set(made) & set("&%$#_~^\\µηκα·±−≤")


@pytest.mark.parametrize(
    ("shown", "made"),
    [
        ("1.50", "1.50"), ("-0.2", r"\ensuremath{-0.2}"), ("4.4e-25", r"\ensuremath{4.4\times10^{-25}}"),
        ("-1e+07", r"\ensuremath{-1\times10^{7}}"), ("–", "--"),
    ],
)  # fmt: skip
def test_numbers_have_minus_signs_and_powers(shown, made):
    assert latex_number(shown) == made


def test_long_heads_are_broken_so_that_numbers_set_the_width():
    made = latex_table(table(("S1", 1.0), heads=("Name", "Stiffness at zero load (N·m/rad)")))
    assert r"\begin{tabular}[b]{@{}r@{}}Stiffness\\at zero\\load\\" in made


WORDS = "a quantity of so many words that it is a sentence"


def test_a_narrow_table_takes_one_column_a_wide_one_both_and_long_texts_are_broken():
    assert r"\begin{table}" in latex_table(table(("S1", 1.0)))
    wide = latex_table(table(tuple(range(8)), heads=("A head",) * 8))
    assert r"\begin{table*}" in wide
    assert r"\footnotesize" in wide
    broken = latex_table(table((WORDS, 1.0), (WORDS, 2.0)))
    assert broken.startswith("% takes the packages booktabs, tabularx")
    assert r"\begin{tabularx}{\linewidth}{>{\raggedright\arraybackslash}Xr}" in broken
    assert broken.count(r"\addlinespace") == 1  # rows of several lines stand apart
    assert r"\addlinespace" not in latex_table(table(("S1", 1.0), ("S2", 2.0)))


def test_a_long_table_goes_over_pages_with_its_head_on_each_and_across_where_it_is_too_wide():
    made = latex_table(table(*[("S1", float(i)) for i in range(100)]))
    assert r"\begin{longtable}{lr}" in made
    assert "tabularx" not in made
    assert made.count("Na\\_me") == 2
    assert "longtable" not in latex_table(table(*[("S1", float(i)) for i in range(20)]))
    made = latex_table(table(*[tuple(1e-6 * i for i in range(20))] * 50, heads=("A head",) * 20))
    assert made.startswith("% takes the packages booktabs, longtable and lscape")
    assert made.index(r"\begin{landscape}") < made.index(r"\begin{longtable}")
    assert made.rstrip().endswith(r"\end{landscape}")


def test_symbols_have_their_index_below_the_line():
    assert latex_text("η²_G = .99") == r"\ensuremath{\eta}\ensuremath{^2}\ensuremath{_\mathrm{G}} = .99"
    assert latex_text("A_c0 of S_1") == r"A\ensuremath{_\mathrm{c0}} of S\_1"
    assert latex_text("|r_rb|").count(r"r\ensuremath{_\mathrm{rb}}") == 1
    assert latex_text("A_c05, BA_c0, var_rb") == r"A\_c05, BA\_c0, var\_rb"


@pytest.mark.parametrize(("width_pt", "environment"), [(252, "figure"), (513.07, "figure*")])
def test_a_figure_stands_in_the_columns_it_was_drawn_for(width_pt, environment):
    figure = Figure(figsize=(width_pt / 72, 0.5))
    made = figure_tex(Drawing("fig04_x", "T", "Fig. 4. Slopes of S_1, p < .05.", "D", figure))
    assert rf"\begin{{{environment}}}" in made
    assert rf"\end{{{environment}}}" in made
    assert r"\includegraphics[width=\linewidth]{\emgfolder/figures/fig04_x.pdf}" in made
    assert r"\caption{Slopes of S\_1, p \ensuremath{<} .05.}" in made
    assert r"\emgfigure{4}" in made
    assert r"\providecommand{\emgfigure}[1]{\renewcommand{\thefigure}{#1}}" in made
    assert made.index(r"\begin{") < made.index(r"\emgfigure{4}") < made.index(r"\caption")
    without = figure_tex(Drawing("x", "T", "Slopes.", "D", figure))
    assert r"\emgfigure{" not in without
    assert r"\caption{Slopes.}" in without
    assert r"\label{fig:fig04_x}" in made
