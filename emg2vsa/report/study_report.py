"""The report of a study: one page, its numbers, tables and figures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

from emg2vsa.atomic import write_bytes_atomic, write_text_atomic
from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.report import data_sections, html
from emg2vsa.report.drawing import Drawing, shown
from emg2vsa.report.figure_tex import figure_tex
from emg2vsa.report.hypothesis_section import hypotheses
from emg2vsa.report.inputs import Failure, RunsResults, StudyResults, why_absent, with_short_paths
from emg2vsa.report.latex import latex_table
from emg2vsa.report.methods import methods_paragraph
from emg2vsa.report.numbers_files import numbers_tex, results_json
from emg2vsa.report.paper_comparison import paper_comparison
from emg2vsa.report.quantities import quantities
from emg2vsa.report.quantity import Quantity
from emg2vsa.report.runs_methods import runs_methods
from emg2vsa.report.runs_section import RunsReport, runs_sections
from emg2vsa.report.statements import statements_tex
from emg2vsa.report.study_figures import study_figures
from emg2vsa.report.study_tables import study_tables
from emg2vsa.report.table import Column, Table
from emg2vsa.report.wording import listed

_CONTENTS = (
    ("#paper", "Beside the paper"), ("#participants", "Participants"), ("#fits", "Fits"), ("#hypotheses", "Hypotheses"),
    ("#profiles", "Profiles"), ("#schedules", "Schedules"),
)  # fmt: skip
_LAST_CONTENTS = (("#methods", "Methods"), ("#provenance", "Provenance"))
_TOO_LONG_FOR_PRINT = {"fits", "statements"}


def write_study_report(results: StudyResults, folder: Path) -> list[Path]:
    """Write the page, results.json, numbers.tex, statements.tex, tables/ and figures/ into ``folder``; its files.

    The bytes depend on ``results`` alone. Participants' pages are written by ``write_session_page``.
    """
    results = replace(results, failures=with_short_paths(results.failures, results.study))
    runs = _runs(results, results.failures)
    found = dict(sorted((quantities(results) | runs.quantities).items()))
    tables = study_tables(results)
    comparison = paper_comparison(results, found)
    drawings = study_figures(results)
    texts = {
        "index.html": _page(results, found, tables, comparison, drawings, runs),
        "results.json": results_json(found),
        "numbers.tex": numbers_tex(found),
        "methods.txt": _methods(results) + "\n",
    }
    if "statements" in tables:
        texts["statements.tex"] = statements_tex(tables["statements"])
    return _written(folder, texts, [*tables.values(), comparison, *runs.tables.values()], drawings | runs.drawings)


def write_runs_report(results: RunsResults, folder: Path) -> list[Path]:
    """The same for a study of measured runs alone: section VI, and nothing on people."""
    study = results.study
    failures = with_short_paths(results.failures, study)
    runs = _runs(results, failures)
    found = {
        "study.name": study.name, "study.mode": study.mode, "study.truth_found": False,
        "study.specimens": len(study.specimens), "study.failures": len(failures), **runs.quantities,
    }  # fmt: skip
    found = dict(sorted(found.items()))
    methods = _runs_methods(results)
    texts = {
        "index.html": _runs_page(results, failures, runs, methods),
        "results.json": results_json(found),
        "numbers.tex": numbers_tex(found),
        "methods.txt": methods + "\n",
    }
    return _written(folder, texts, runs.tables.values(), runs.drawings)


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
    for drawing in drawings.values():
        write_bytes_atomic(folder / f"figures/{drawing.name}.pdf", drawing.pdf)
    return [folder / name for name in (*texts, *(f"figures/{name}.pdf" for name in drawings))]


def _page(
    results: StudyResults,
    found: Mapping[str, Quantity],
    tables: Mapping[str, Table],
    comparison: Table,
    drawings: Mapping[str, Drawing],
    runs: RunsReport,
) -> str:
    study = results.study
    rig = " Section VI: from the rig's presses to the stiffness of objects." if runs.body else ""
    header = (
        f"<h1>{escape(study.title)}</h1>"
        f'<p class="sub">Study {escape(study.name)}, settings: {escape(study.mode)} mode. Section IV.B: from palpation '
        f"EMG and force to stiffness schedules.{rig}</p>"
    )
    body = (
        data_sections.glance(results, found),
        html.section("paper", "Beside the paper", comparison.html()),
        data_sections.participants(results),
        data_sections.fits(results, found, tables),
        hypotheses(results, found, tables),
        _profiles(results, tables, drawings),
        _schedules(results, tables, drawings),
        runs.body,
        html.section("methods", "Methods", html.paragraph(_methods(results))),
        _provenance(results.provenance),
    )
    contents = (*_CONTENTS, *runs.contents, *_LAST_CONTENTS)
    return html.page(study.title, header, contents, "".join(body), _FOOTER)


def _runs_page(results: RunsResults, failures: Sequence[Failure], runs: RunsReport, methods: str) -> str:
    study = results.study
    header = (
        f"<h1>{escape(study.title)}</h1>"
        f'<p class="sub">Study {escape(study.name)}, settings: {escape(study.mode)} mode. Section VI: from presses of '
        "a tactile sensor to the stiffness of objects. The study has no recordings of people.</p>"
    )
    body = (
        _runs_failures(failures),
        runs.body,
        html.section("methods", "Methods", html.paragraph(methods)),
        _provenance(results.provenance),
    )
    failed = (("#failures", "What failed"),) if failures else ()
    return html.page(study.title, header, (*failed, *runs.contents, *_LAST_CONTENTS), "".join(body), _FOOTER)


def _runs_failures(failures: Sequence[Failure]) -> str:
    if not failures:
        return ""
    columns = (Column("key", "For"), Column("stage", "Step"), Column("message", "Why"))
    rows = tuple((failure.key, failure.stage, failure.message) for failure in failures)
    table = Table("failed_steps", "Steps that could not be done", columns, rows)
    return html.section("failures", "What failed", table.html())


def _runs_methods(results: RunsResults) -> str:
    versions = [f"{name} {value}" for name, value in _versions(results.provenance).items()]
    return " ".join([*runs_methods(results.study, results.runs), f"Software: {listed(versions)}."])


def _runs(results: StudyResults | RunsResults, failures: Sequence[Failure]) -> RunsReport:
    specimens = [specimen.name for specimen in results.study.specimens]
    why = why_absent(failures, "discrimination")
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


def _methods(results: StudyResults) -> str:
    versions = _versions(results.provenance)
    return methods_paragraph(results.study, results.trials, versions, results.truth is not None, results.runs)


def _versions(provenance: Mapping[str, str]) -> dict[str, str]:
    return {name: value for name, value in provenance.items() if " key" not in name}


def _provenance(provenance: Mapping[str, str]) -> str:
    entries = "".join(
        f"<dt>{escape(name)}</dt><dd><code>{escape(value)}</code></dd>" for name, value in sorted(provenance.items())
    )
    body = f"<dl>{entries}</dl>" if entries else html.paragraph("No versions were handed over.")
    return html.section("provenance", "Provenance", body)
