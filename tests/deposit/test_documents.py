from __future__ import annotations

import io
import zipfile

from emg2vsa.deposit.documents import packages, proof, readme
from emg2vsa.deposit.package import zip_bytes

FILES = {
    "numbers.tex": b"% Written\n\\newcommand{\\emgFitUsed}{700} % fit.used\n",
    "figures/f.tex": b"% takes the package graphicx\n\\begin{figure}\\end{figure}\n",
    "figures/f.pdf": b"%PDF",
    "tables/t.tex": b"% takes the packages booktabs, tabularx\n",
    "tables/long.tex": b"% takes the packages booktabs and longtable, and text in one column\n",
}


def test_packages_are_those_the_files_name_and_the_readme_lists_every_file():
    assert packages(FILES) == ["amsmath", "booktabs", "graphicx", "longtable", "tabularx"]
    text = readme("small", "A small study", "Simulated.", FILES)
    assert r"\usepackage{amsmath,booktabs,graphicx,longtable,tabularx}" in text
    for name in ("numbers", "tables/long", "figures/f"):
        assert rf"\input{{paper/{name}}}" in text
    assert r"\input{paper/statements}" not in text
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


def test_an_archive_reads_back_sorted_without_times_and_depends_on_names_and_contents_alone():
    made = zip_bytes({"b/c.txt": b"two", "a.txt": b"one"})
    assert made == zip_bytes({"a.txt": b"one", "b/c.txt": b"two"})
    assert made != zip_bytes({"a.txt": b"two", "b/c.txt": b"two"})
    archive = zipfile.ZipFile(io.BytesIO(made))
    assert archive.testzip() is None
    times = [(entry.filename, entry.date_time) for entry in archive.infolist()]
    assert times == [("a.txt", (1980, 1, 1, 0, 0, 0)), ("b/c.txt", (1980, 1, 1, 0, 0, 0))]
    assert archive.read("b/c.txt") == b"two"
