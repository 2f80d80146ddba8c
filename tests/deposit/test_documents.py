from __future__ import annotations

from emg2vsa.deposit.documents import packages, proof, readme

FILES = {
    "numbers.tex": b"% Written\n\\newcommand{\\emgFitUsed}{700} % fit.used\n",
    "figures/f.tex": b"% takes the package graphicx\n\\begin{figure}\\end{figure}\n",
    "figures/f.pdf": b"%PDF",
    "tables/t.tex": b"% takes the packages booktabs, tabularx\n",
    "tables/long.tex": b"% takes the packages booktabs and longtable, and text in one column\n",
}


def test_packages_are_those_the_files_name():
    assert packages(FILES) == ["amsmath", "booktabs", "graphicx", "longtable", "tabularx"]


def test_the_readme_shows_inputs_that_exist_and_lists_every_file():
    text = readme("small", "A small study", "Simulated.", FILES)
    assert r"\usepackage{amsmath,booktabs,graphicx,longtable,tabularx}" in text
    assert r"\input{paper/numbers}" in text
    assert r"\input{paper/statements}" not in text
    assert r"\input{paper/tables/long}" in text
    assert r"\input{paper/figures/f}" in text
    for name in ("numbers.tex", "tables/ (.tex)", "figures/ (.pdf, .tex)", "long, t"):
        assert name in text


def test_the_readme_shows_macros_that_exist():
    one = b"\\newcommand{\\emgRunsPresses}{90} % runs.presses\n"
    both = one + b"\\newcommand{\\emgRunsCount}{9} % runs.count\n"
    text = readme("rig", "A rig", "Measured.", {"numbers.tex": both})
    assert r"The probe pressed \emgRunsPresses{} times in \emgRunsCount{} runs" in text
    assert r"\emgFitUsed" not in text
    assert "The probe pressed" not in readme("rig", "A rig", "Measured.", {"numbers.tex": one})


def test_the_proof_holds_each_float_once_and_each_macro_beside_its_key():
    text = proof("A & B", FILES)
    for name in ("numbers.tex", "figures/f.tex", "tables/t.tex", "tables/long.tex"):
        assert text.count(rf"\input{{{name}}}") == 1
    assert text.index(r"\input{tables/t.tex}") < text.index(r"\onecolumn") < text.index(r"\input{tables/long.tex}")
    assert r"\texttt{fit.used}\hfill \emgFitUsed\par" in text
    assert r"\title{A \& B}" in text


def test_the_first_page_of_the_proof_has_text_and_no_character_that_latex_lacks():
    methods = "Presses and fits\nAreas grew as F², p = 3 × 10⁻⁵, κ ≥ 1 “so”.\n\nTests\nNone.\n"
    text = proof("A study", FILES | {"methods.txt": methods.encode()})
    title, heading, figure = (
        text.index(part) for part in (r"\maketitle", r"\subsection*{Presses and fits}", r"\input{figures")
    )
    assert title < heading < figure
    assert text.isascii()
    assert text.count(r"\subsection*") == 2
