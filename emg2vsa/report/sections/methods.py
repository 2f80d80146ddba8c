"""Methods as a journal prints them, from the settings that ran, with the works that they cite."""

from __future__ import annotations

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.methods import Paragraph, filters_as_run, methods
from emg2vsa.report.references import bibtex, cited, works_in
from emg2vsa.report.section import Quantities, Section


def paragraphs(results: StudyResults) -> list[Paragraph]:
    """The methods of this study, with citations as keys."""
    people, runs = results.people, results.runs
    versions = {name: value for name, value in results.provenance.items() if "digest of " not in name}
    return methods(
        results.study,
        people.trials if people else (),
        versions,
        people is not None and people.truth is not None,
        runs.scores if runs else (),
        runs.calibration if runs else None,
        people.choice if people else None,
        people is None or people.profiles is not None,
    )


def methods_text(results: StudyResults) -> str:
    """Plain text: headings, paragraphs, references."""
    told = paragraphs(results)
    works = works_in(each.text for each in told)
    parts = [f"{each.heading}\n{cited(each.text)}" for each in told]
    parts += ["References\n" + "\n".join(f"{work.text} {work.doi}".rstrip() for work in works)] if works else []
    return "\n\n".join(parts)


def references_bib(results: StudyResults) -> str:
    """The works that the methods cite, as BibTeX."""
    return bibtex(works_in(each.text for each in paragraphs(results)))


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    told = paragraphs(results)
    return {
        "told": [(each.heading, cited(each.text)) for each in told],
        "works": works_in(each.text for each in told),
        "filters": filters_as_run(results.people.trials) if results.people else [],
    }


_TEXT = """
<p>This text follows from the settings that ran, and may be printed as it stands:
<a href="methods.txt">methods.txt</a>{% if works %}, <a href="references.bib">references.bib</a>{% endif %}.</p>
{% for heading, text in told %}
<details><summary>{{ heading }}</summary>
<p>{{ text }}</p>
{% if heading == "Signal processing" and filters %}
<p>Filters as they ran:</p>
{{ filters | bullets }}
{% endif %}
</details>
{% endfor %}
{% if works %}
<details><summary>References</summary>
<ul>{% for work in works %}<li>{{ work.text }}
{% if work.doi %}<a href="https://doi.org/{{ work.doi }}">doi:{{ work.doi }}</a>{% endif %}</li>{% endfor %}</ul>
</details>
{% endif %}
"""

METHODS = Section("methods", "Methods", _TEXT, words=_words)
