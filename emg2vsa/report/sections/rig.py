"""The rig's runs."""

from __future__ import annotations

from collections.abc import Iterable

from markupsafe import Markup

from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Quantity
from emg2vsa.report.rig_claims import area_claims, filter_claims, kappa_claims, rate_claims, reduction_claims
from emg2vsa.report.runs_section import RunsReport, runs_sections
from emg2vsa.report.section import Claim, Quantities, Section, of_runs
from emg2vsa.report.table import Table


class _Held:
    """The last report, so that its parts are made once."""

    results: StudyResults | None = None
    report: RunsReport | None = None


def _report(results: StudyResults) -> RunsReport:
    if _Held.results is not results or _Held.report is None:
        runs, why = results.pressed, results.why_absent("discrimination")
        _Held.results = results
        _Held.report = runs_sections(runs.scores, runs.discrimination, runs.calibration, results.specimens, why)
    return _Held.report


def _quantities(results: StudyResults) -> Iterable[tuple[str, Quantity]]:
    return _report(results).quantities.items()


def _tables(results: StudyResults, q: Quantities) -> Iterable[Table]:
    return _report(results).tables.values()


def _drawings(results: StudyResults) -> Iterable[Drawing]:
    return _report(results).drawings.values()


def _claims(results: StudyResults, q: Quantities) -> Iterable[Claim]:
    for claims in (filter_claims, area_claims, rate_claims, kappa_claims, reduction_claims):
        yield from claims(results, q)


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    return {"body": Markup(_report(results).body)}


RIG = Section("rig", "Runs of the rig", "{{ body }}", of_runs, _quantities, _tables, _drawings, _claims, _words)
