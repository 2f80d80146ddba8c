"""The documentation site; ``scripts/docs`` builds it. Every font and script is local."""

from __future__ import annotations

import json
import posixpath
import re
from pathlib import Path

from sphinx.application import Sphinx

import emg2vsa
from benchmarks.bench.plots import write_plots
from benchmarks.bench.record import RESULTS, is_record, markdown
from benchmarks.bench.run import read_area
from benchmarks.bench.tables import tables as area_tables
from benchmarks.mutation.table import tables as mutation_tables
from benchmarks.scale.results import kept as kept_scale
from benchmarks.scale.results import tables as scale_tables
from benchmarks.stress.table import tables as stress_tables

ROOT = Path(__file__).resolve().parent.parent

project = "emg2vsa"
author = "The emg2vsa authors"
copyright = author
version = release = emg2vsa.__version__
language = "en"

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["_build", "style.md", "paper"]
nitpicky = True
nitpick_ignore_regex = [("py:.*", ".*")]  # docstrings name types of NumPy and pandas, whose own sites are elsewhere

myst_heading_anchors = 4
myst_enable_extensions: list[str] = []  # no formulas: MathJax would come from another server
nb_execution_mode = "force"
nb_execution_timeout = 120
nb_execution_raise_on_error = True
nb_execution_show_tb = True

autodoc_typehints = "description"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_google_docstring = False

html_theme = "furo"
html_title = "emg2vsa"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_search_scorer = str(ROOT / "docs" / "search_scorer.js")
html_show_sphinx = False
html_copy_source = False
pygments_style = "a11y-light"  # contrast of 4.5 and more; it comes with the theme
pygments_dark_style = "monokai"

_OUTSIDE = re.compile(r"\[([^\]\n]+)\]\(((?:\.\./)[^)\s#]*)(#[^)\s]*)?\)")


def _offer_files_outside(app: Sphinx, name: str, source: list[str]) -> None:
    """A link to a file of the project that is no page of the site gives the file itself."""
    page = ROOT / "docs" / posixpath.dirname(name)

    def offered(link: re.Match[str]) -> str:
        path = (page / link[2]).resolve()
        docs = ROOT / "docs"
        is_page = path.is_relative_to(docs) and path.relative_to(docs).parts[0] not in exclude_patterns
        if is_page or not path.is_file():
            return link[0]
        return "{download}`" + link[1].replace("`", "") + " <" + link[2] + ">`"

    source[0] = _OUTSIDE.sub(offered, source[0])


MADE = ROOT / "docs" / "benchmarks" / "made"
"""Plots and pages that the site makes of JSON; not kept in git."""
_TABLES = re.compile(r"<!-- tables: (\S+) -->")


def _make_evidence(app: Sphinx) -> None:
    """A page for every record of a benchmark."""
    MADE.mkdir(exist_ok=True)
    for file in sorted(RESULTS.glob("*.json")):
        record = json.loads(file.read_text(encoding="utf-8"))
        if is_record(record):
            (MADE / f"{file.stem}.md").write_text(markdown(record), encoding="utf-8")


def _show_tables(app: Sphinx, name: str, source: list[str]) -> None:
    """Tables and plots of a benchmark in place of the mark that its page ends with."""
    source[0] = _TABLES.sub(lambda mark: _tables(mark[1]), source[0])


def _tables(file: str) -> str:
    if file == "mutation":
        return mutation_tables([json.loads(path.read_text()) for path in sorted(RESULTS.glob("mutation_*.json"))])
    if file == "scale.json":
        return scale_tables(kept_scale())
    path = ROOT / "docs" / "benchmarks" / file
    if file == "stress.json":
        return stress_tables(json.loads(path.read_text(encoding="utf-8")))
    area = read_area(path)
    plots = {of: [f"made/{name}" for name in names] for of, names in write_plots(area, MADE).items()}
    return area_tables(area, plots)


def setup(app: Sphinx) -> None:
    app.connect("builder-inited", _make_evidence)
    app.connect("source-read", _show_tables)
    app.connect("source-read", _offer_files_outside)
