"""The paper's own tests of its claims on people, as it ran them: printed numbers, and what they say here."""

from __future__ import annotations

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.section import PaperTest, Quantities


def people_tests(results: StudyResults, q: Quantities) -> dict[str, PaperTest]:
    return {}
