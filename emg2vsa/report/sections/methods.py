"""Methods as a journal prints them, from the settings that ran."""

from __future__ import annotations

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.methods import methods_paragraph
from emg2vsa.report.section import Quantities, Section


def methods_text(results: StudyResults) -> str:
    """Plain text."""
    people, runs = results.people, results.runs
    versions = {name: value for name, value in results.provenance.items() if "digest of " not in name}
    return methods_paragraph(
        results.study,
        people.trials if people else (),
        versions,
        people is not None and people.truth is not None,
        runs.scores if runs else (),
    )


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    return {"methods": methods_text(results)}


METHODS = Section("methods", "Methods", "<p>{{ methods }}</p>", words=_words)
