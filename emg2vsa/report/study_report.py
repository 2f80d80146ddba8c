"""The report of a study: one page, its numbers, tables and figures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

from casr import html
from casr.atomic import write_bytes_atomic, write_text_atomic
from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.report import data_sections
from emg2vsa.report.drawing import Drawing, figure_tex, shown
from emg2vsa.report.failures import Failure, ShortPaths
from emg2vsa.report.hypothesis_section import hypotheses
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.latex import latex_table
from emg2vsa.report.methods import methods_paragraph
from emg2vsa.report.numbers_files import numbers_tex, results_json, statements_tex
from emg2vsa.report.paper_comparison import paper_comparison
from emg2vsa.report.quantities import quantities
from emg2vsa.report.quantity import Quantity
from emg2vsa.report.runs_figures import runs_figures
from emg2vsa.report.runs_section import RunsReport, runs_sections
from emg2vsa.report.study_figures import study_figures
from emg2vsa.report.study_tables import study_tables
from emg2vsa.report.table import Table

_CONTENTS = (
    ("#paper", "Beside the paper"), ("#participants", "Participants"), ("#fits", "Fits"), ("#hypotheses", "Hypotheses"),
    ("#profiles", "Profiles"), ("#schedules", "Schedules"),
)  # fmt: skip
_LAST_CONTENTS = (("#methods", "Methods"), ("#provenance", "Provenance"))
_TOO_LONG_FOR_PRINT = {"fits", "statements"}


def write_study_report(results: StudyResults, folder: Path) -> list[Path]:
    """Write the page, results.json, numbers.tex, statements.tex, tables/ and figures/ into ``folder``; its files.

    The bytes depend on ``results`` alone. A study of runs alone has section VI and nothing on people. Participants'
    pages are written by ``write_session_page``, the PDFs of its figures by ``write_figure_pdfs``.
    """
    results = replace(results, failures=ShortPaths(results.study).failures(results.failures))
    runs = _runs(results)
    people = results.fits is not None
    found = dict(sorted((quantities(results) | runs.quantities).items()))
    tables = study_tables(results) if people else {}
    drawings = study_figures(results) if people else {}
    if people:
        tables["paper_comparison"] = paper_comparison(results, found)
    versions = {name: value for name, value in results.provenance.items() if "digest of " not in name}
    methods = methods_paragraph(results.study, results.trials, versions, results.truth is not None, results.runs)
    body = _people(results, found, tables, drawings) if people else _nobody(results.failures)
    texts = {
        "index.html": _page(results, body, runs, methods),
        "results.json": results_json(found),
        "numbers.tex": numbers_tex(found),
        "methods.txt": methods + "\n",
    }
    if "statements" in tables:
        texts["statements.tex"] = statements_tex(tables["statements"])
    return _written(folder, texts, [*tables.values(), *runs.tables.values()], drawings | runs.drawings)


def _written(
    folder: Path, texts: dict[str, str], tables: Iterable[Table], drawings: Mapping[str, Drawing]
) -> list[Path]:
    """Write the files, with those of the tables and drawings."""
    for table in tables:
        texts[f"tables/{table.name}.csv"] = table.csv()
        if table.name not in _TOO_LONG_FOR_PRINT:
            texts[f"tables/{table.name}.tex"] = latex_table(table)
    for drawing in drawings.values():
        texts |= {f"figures/{drawing.name}.svg": drawing.svg, f"figures/{drawing.name}.tex": figure_tex(drawing)}
    for name, text in texts.items():
        write_text_atomic(folder / name, text)
    return [folder / name for name in texts]


def write_figure_pdfs(results: StudyResults, folder: Path) -> list[Path]:
    """Write every figure of the report as ``folder/figures/NAME.pdf``, for a paper; the files."""
    drawings = study_figures(results) if results.fits is not None else {}
    if results.runs and results.discrimination is not None:
        specimens = [specimen.name for specimen in results.study.specimens]
        drawings |= runs_figures(results.runs, results.discrimination, results.calibration, specimens)
    paths = {folder / f"figures/{name}.pdf": drawing for name, drawing in drawings.items()}
    for path, drawing in paths.items():
        write_bytes_atomic(path, drawing.pdf())
    return list(paths)


def _page(results: StudyResults, body: str, runs: RunsReport, methods: str) -> str:
    study = results.study
    contents: tuple[tuple[str, str], ...] = _CONTENTS
    rig = " Section VI: from the rig's presses to the stiffness of objects." if runs.body else ""
    about = f"Section IV.B: from palpation EMG and force to stiffness schedules.{rig}"
    if results.fits is None:
        contents = (("#failures", "What failed"),) if body else ()
        nobody = "No recording of people could be used." if study.recordings else _RUNS_ALONE
        about = f"Section VI: from presses of a tactile sensor to the stiffness of objects. {nobody}"
    header = (
        f"<h1>{escape(study.title)}</h1>"
        f'<p class="sub">Study {escape(study.name)}, settings: {escape(study.mode)} mode. {about}</p>'
    )
    body += runs.body + html.section("methods", "Methods", html.paragraph(methods)) + _provenance(results.provenance)
    return html.page(study.title, header, (*contents, *runs.contents, *_LAST_CONTENTS), body, _FOOTER)


_RUNS_ALONE = "The study has no recordings of people."


def _people(
    results: StudyResults, found: Mapping[str, Quantity], tables: Mapping[str, Table], drawings: Mapping[str, Drawing]
) -> str:
    return "".join(
        (
            data_sections.glance(results, found),
            html.section("paper", "Beside the paper", tables["paper_comparison"].html()),
            data_sections.participants(results),
            data_sections.fits(results, found, tables),
            hypotheses(results, found, tables),
            _profiles(results, tables, drawings),
            _schedules(results, tables, drawings),
        )
    )


def _nobody(failures: Sequence[Failure]) -> str:
    """Without people the failures are all that stands before section VI."""
    return html.section("failures", "What failed", data_sections.failed_steps(failures).html()) if failures else ""


def _runs(results: StudyResults) -> RunsReport:
    specimens = [specimen.name for specimen in results.study.specimens]
    why = results.why_absent("discrimination")
    found = runs_sections(results.runs, results.discrimination, results.calibration, specimens, why)
    return _with_reasons(found, results.calibration)


def _with_reasons(runs: RunsReport, calibration: CalibrationResults | None) -> RunsReport:
    """A calibration that estimated nothing says why."""
    if not runs.body or calibration is None or calibration.conditions:
        return runs
    title = "Stiffness of the new specimen"
    section = html.section("kappa", title, html.bullets(calibration.notes))
    return replace(runs, contents=(*runs.contents, ("#kappa", title)), body=runs.body + section)


_FOOTER = (
    '<p class="small">Numbers in full: <a href="results.json">results.json</a>, <a href="numbers.tex">numbers.tex</a>, '
    "tables/ and figures/ beside this page.</p>"
)


def _profiles(results: StudyResults, tables: Mapping[str, Table], drawings: Mapping[str, Drawing]) -> str:
    title = "Profiles"
    if results.profiles is None:
        return html.section("profiles", title, html.paragraph(results.why_absent("profiles")))
    left_out = tables["leave_one_out"]
    new = (
        shown(drawings["fig11_interpolation"])
        if "fig11_interpolation" in drawings
        else html.paragraph("The study names no new specimen, so nothing is interpolated.")
    )
    return html.section(
        "profiles",
        title,
        shown(drawings["fig04_cocontraction"]),
        tables["profiles"].html(),
        new,
        left_out.html() if left_out.rows else html.paragraph("Too few specimens of known stiffness to leave one out."),
        html.bullets(results.profiles.notes),
    )


def _schedules(results: StudyResults, tables: Mapping[str, Table], drawings: Mapping[str, Drawing]) -> str:
    title = "Stiffness schedules"
    if not results.schedules:
        return html.section("schedules", title, html.paragraph(results.why_absent("schedules")))
    ramp, limits = results.schedules[0].ramp, results.schedules[0].limits
    text = (
        f"The probe moves {ramp.travel_mm:g} mm at {ramp.speed_mm_per_s:g} mm/s ({ramp.duration_s:g} s, "
        f"{ramp.speed_deg_per_s:g} degrees/s of the shaft) while the preset follows the measured force. 100 % is "
        f"{limits.max_preset_ticks} ticks of a {limits.actuator}."
    )
    short = [s.specimen for s in results.schedules if s.last_step_short and s.condition == "modular"]
    remark = html.paragraph("The last force step is shorter than the others; it is kept.", "small") if short else ""
    data = html.details("Every schedule in numbers", tables["schedules"].html())
    return html.section("schedules", title, shown(drawings["fig05_schedules"]), html.paragraph(text), remark, data)


def _provenance(provenance: Mapping[str, str]) -> str:
    entries = "".join(
        f"<dt>{escape(name)}</dt><dd><code>{escape(value)}</code></dd>" for name, value in sorted(provenance.items())
    )
    body = f"<dl>{entries}</dl>" if entries else html.paragraph("No versions were handed over.")
    return html.section("provenance", "Provenance", body)
