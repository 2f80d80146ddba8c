"""What was registered before the data: how many verdicts, and every deviation of the study from its plan."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Table, records

_TEXT = """
<p>The plan of this study was registered on {{ of.registered_at[:10] }}. Data at that time: {{ of.collected }}
{% if of.amends %}This registration amends an earlier one ({{ of.amends[:12] }}). {% endif %}
Of {{ states.total() }} verdicts {{ states['as registered'] }} are as registered, {{ states['deviates'] }} deviate
from the plan{% if states['not registered'] %}, and {{ states['not registered'] }} were not registered{% endif %}.
{% if without %} {{ without }} registered claims have no verdict
here.{% endif %}{% if of.waits %} {{ of.waits }}.{% endif %}</p>
{{ folded("deviations", "Deviations from the registered plan") }}
{% if of.from_amended %}
<p>The study deviates from the plan that was amended:</p>
{{ of.from_amended | bullets }}
{% endif %}
{% if code %}
<p>The program is not the registered one:</p>
{{ code | bullets }}
{% endif %}
<p class="small" style="overflow-wrap: anywhere">{{ of.file }}, SHA-256 {{ of.sha256 }}</p>
"""
COLUMNS = (
    Column("what", "What"), Column("registered", "When registered"), Column("now", "Now"), Column("kind", "Kind"),
    Column("touched", "Claims that it may touch"),
)  # fmt: skip


def _quantities(results: StudyResults) -> Items:
    of = results.registered
    if of is not None:
        yield "registration.sha256", of.sha256
        yield "registration.registered_at", of.registered_at
        yield "registration.deviations", len(of.of_plan)
        yield "registration.awaited_recordings", len(of.awaited)
        yield "registration.awaited_runs", len(of.awaited_runs)


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    if results.registered and (rows := records(results.registered.of_plan, COLUMNS)):
        yield Table(
            "deviations", "Deviations from the registered plan, with the claims that they may touch", COLUMNS, rows
        )


def _words(results: StudyResults, q: Quantities) -> Mapping[str, object]:
    of, end = results.registered, ".registered"
    found = {key: str(value) for key, value in q.items() if key.startswith("claims.") and key.endswith(end)}
    states = Counter(
        "deviates" if "deviates" in state else state if state == "not registered" else "as registered"
        for state in found.values()
    )
    without = [key for key in (of.claims if of else ()) if f"claims.{key}{end}" not in found]
    code = [
        f"{each.what}: {each.registered}, now {each.now}."
        for each in (of.deviations if of else ())
        if each.kind == "code"
    ]
    return {"of": of, "states": states, "without": len(without), "code": code}


REGISTRATION = Section(
    "registration", "Registered plan", _TEXT, lambda results: results.registered is not None, _quantities, _tables,
    words=_words,
)  # fmt: skip
