"""The report of a study: one page, its numbers, tables and figures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

from casr import html
from casr.atomic import write_bytes_atomic, write_text_atomic
from emg2vsa.claims.claim import Judged
from emg2vsa.figures.canvas import style
from emg2vsa.report.drawing import Drawing, figure_tex
from emg2vsa.report.failures import ShortPaths
from emg2vsa.report.inputs import StudyResults, origin
from emg2vsa.report.latex import latex_table
from emg2vsa.report.numbers import numbers_tex, results_json, statements_tex
from emg2vsa.report.section import Content, Section, rendered
from emg2vsa.report.sections import SECTIONS
from emg2vsa.report.sections.claims import claim_quantities, claims_tables, judged_claims, summary, verdict_drawings
from emg2vsa.report.sections.provenance import methods_text, references_bib

_TOO_LONG_FOR_PRINT = frozenset({"fits", "statements"})
_MOST_PRINTED = 2000
"""Rows of a table that LaTeX gets; nobody prints a longer one."""


def write_study_report(results: StudyResults, folder: Path) -> list[Path]:
    """Write the page, results.json, numbers.tex, statements.tex, tables/ and figures/ into ``folder``; its files.

    The bytes depend on ``results`` alone. Participants' pages are written by ``write_session_page``, the PDFs of the
    figures by ``write_figure_pdfs``.
    """
    results = replace(results, failures=ShortPaths(results.study).failures(results.failures))
    content = contents(results)
    written = []
    for name, text in _texts(results, content):  # one at a time: those of many people are long
        write_text_atomic(folder / name, text)
        written.append(folder / name)
    return written


def _texts(results: StudyResults, content: Content) -> Iterator[tuple[str, str | Iterator[str]]]:
    """Every file of the report and its text, or the pieces of it."""
    yield "index.html", _page(results, content)
    yield "results.json", results_json(content.quantities)
    yield "numbers.tex", numbers_tex(content.quantities)
    yield "methods.txt", methods_text(results) + "\n"
    if bib := references_bib(results):
        yield "references.bib", bib
    if "statements" in content.tables:
        yield "statements.tex", statements_tex(content.tables["statements"])
    for name, table in content.tables.items():
        yield f"tables/{name}.csv", table.csv()
        if table.own_page:
            heading = f"<h1>{escape(table.caption)}</h1>"
            yield table.own_page, html.page(table.caption, heading, [], table.html(whole=True), "")
        if name not in _TOO_LONG_FOR_PRINT and len(table.rows) <= _MOST_PRINTED:
            yield f"tables/{name}.tex", latex_table(table)
    for name, drawing in content.drawings.items():
        yield f"figures/{name}.svg", drawing.svg
        yield f"figures/{name}.tex", figure_tex(drawing)


def contents(results: StudyResults) -> Content:
    """What the sections that apply give, by name. ValueError : two of them give the same name."""
    content = numbers_and_tables(results)
    content.drawings = _drawn(results, content.judged)
    return content


def numbers_and_tables(results: StudyResults) -> Content:
    """``contents`` without drawings, which take most of its time. ValueError : as there."""
    content = Content()
    sections = _sections(results)
    for section in sections:
        _add(content.quantities, dict(section.quantities(results)), section)
    content.judged = judged = judged_claims(results)
    content.summary = list(summary(results, judged))
    content.quantities = dict(sorted((content.quantities | dict(claim_quantities(judged, results.registered))).items()))
    content.tables |= {table.name: table for table in claims_tables(results, judged, content.quantities) if table.rows}
    for section in sections:
        _add(content.tables, {table.name: table for table in section.tables(results, content.quantities)}, section)
    return content


def _sections(results: StudyResults) -> list[Section]:
    return [section for section in SECTIONS if section.applies(results)]


def _add(into: dict[str, Any], more: dict[str, Any], section: Section) -> None:
    if twice := sorted(into.keys() & more.keys()):
        raise ValueError(f"section {section.name} gives what another one gives: {', '.join(twice)}")
    into |= more


def _drawn(results: StudyResults, judged: Sequence[Judged]) -> dict[str, Drawing]:
    """Those of the verdicts, then those of each section. ValueError : two of them give the same name."""
    with style():
        drawn = {drawing.name: drawing for drawing in verdict_drawings(judged)}
        for section in _sections(results):
            _add(drawn, {drawing.name: drawing for drawing in section.drawings(results)}, section)
    return drawn


def write_figure_pdfs(results: StudyResults, folder: Path) -> list[Path]:
    """Write every figure of the report as ``folder/figures/NAME.pdf``, for a paper; the files."""
    drawn = _drawn(results, judged_claims(results))
    paths = {folder / f"figures/{name}.pdf": drawing for name, drawing in drawn.items()}
    for path, drawing in paths.items():
        write_bytes_atomic(path, drawing.pdf())
    return list(paths)


def _page(results: StudyResults, content: Content) -> str:
    study, sections = results.study, _sections(results)
    header = html.statement(*origin(results)) + (
        f"<h1>{escape(study.title)}</h1>"
        f'<p class="sub">Study {escape(study.name)}, settings: {escape(study.mode)} mode.</p>'
    )
    links = [(f"#{section.name}", section.title) for section in sections]
    body = "".join(rendered(section, results, content) for section in sections)
    return html.page(study.title, header, links, body, "")
