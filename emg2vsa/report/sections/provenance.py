"""Where the numbers come from, and what the words mean."""

from __future__ import annotations

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section


def _quantities(results: StudyResults) -> Items:
    study = results.study
    yield "study.name", study.name
    yield "study.mode", study.mode
    yield "study.truth_found", results.people is not None and results.people.truth is not None
    yield "study.specimens", len(study.specimens)
    yield "study.failures", len(results.failures)


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    return {"provenance": sorted(results.provenance.items())}


_TEXT = """
<p>Every number of this page: <a href="results.json">results.json</a>. Tables and figures: tables/ and figures/ beside
this page. LaTeX macros: <a href="numbers.tex">numbers.tex</a>.</p>
{% if provenance %}
<details><summary>Versions and digests</summary>
<dl>{% for name, value in provenance %}<dt>{{ name }}</dt><dd><code>{{ value }}</code></dd>{% endfor %}</dl>
</details>
{% endif %}
"""

PROVENANCE = Section("provenance", "Provenance", _TEXT, quantities=_quantities, words=_words)
