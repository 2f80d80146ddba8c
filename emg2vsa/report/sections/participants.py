"""Who was recorded, and were they enough?

The verdict on each session, what failed, and which trials were rejected or warned. Sample size: the computation of the
paper, and the power of the test that its main claim rests on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from emg2vsa.extraction.reasons import most_frequent
from emg2vsa.fits import by_recording
from emg2vsa.hypotheses import EFFECT_F, EPSILON, RHO, TARGET, Hypotheses
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.session_page import session_verdict
from emg2vsa.report.table import FEW_ON_PAGE, Column, Columns, Table, records, table_of
from emg2vsa.report.wording import bounded, count, listed
from emg2vsa.session_verdict import doubts_between
from emg2vsa.statistics.power import power_rm, power_table
from emg2vsa.study import RecordingEntry

_PARTICIPANTS, _REPETITIONS, _ALPHA = 14, 10, 0.05
"""The sample size of the paper."""


def _applies(results: StudyResults) -> bool:
    return bool(results.study.recordings or results.failures)


def _quantities(results: StudyResults) -> Items:
    if results.people is None:
        return
    yield "study.participants", len(results.study.participants)
    yield "study.recordings", len(results.study.recordings)
    yield "study.recordings_read", len(results.people.trials)
    planned = power_rm(_PARTICIPANTS, _REPETITIONS, EFFECT_F, RHO, EPSILON, _ALPHA)
    yield f"power.n{_PARTICIPANTS}", float(planned)
    if (found := results.people.hypotheses) is not None:
        keys = ("power.study", "power.study_specimens", "power.people_for_specimens")
        yield from zip(keys, (found.power.repetitions, found.power.specimens, found.power.people), strict=True)


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    if results.failures:
        columns = (Column("key", "For"), Column("stage", "Step"), Column("message", "Why"))
        yield Table("failures", "Steps that could not be done", columns, records(results.failures, columns))
    if results.people is None:
        return
    yield _sessions(results)
    yield from (_listing(results, verdict, chosen) for verdict, chosen in _judged(results).items())
    if (found := results.people.hypotheses) is not None and found.power.people:
        yield _sensitivity(found)


def _sessions(results: StudyResults) -> Table:
    people, own = results.recorded, results.by_participant()
    fits = by_recording(people.fits)
    doubts = doubts_between(people.trials, fits, results.study.judgements)
    entries: dict[str, list[RecordingEntry]] = {}
    for entry in results.study.recordings:
        entries.setdefault(entry.participant, []).append(entry)
    without_page = {failure.key for failure in results.failures if failure.stage == "pages"}
    judged = [
        session_verdict(name, entries[name], trials, fits, failed, doubts) for name, (trials, failed) in own.items()
    ]
    columns: Columns = {
        Column("participant", "Participant"): list(own),
        Column("session", "Session"): [session.verdict for session in judged],
        Column("recordings", "Recordings"): [len(session.specimens) for session in judged],
    }
    for key, head in {"found": "Trials", "ok": "Ok", "warned": "Warned", "rejected": "Rejected"}.items():
        columns[Column(key, head)] = [sum(getattr(each, key) for each in session.specimens) for session in judged]
    links = (f"{results.pages}/{name}.html" if results.pages and name not in without_page else "" for name in own)
    made = table_of("sessions", "Sessions: good, usable, to repeat, or unreadable", columns)
    return replace(made, links=tuple(links))


def _judged(results: StudyResults) -> dict[str, np.ndarray]:
    """Trials that are not simply ok, by what was said of them."""
    fits = results.recorded.fits
    return {
        "rejected": fits.verdict == "rejected",
        "warned": fits.verdict == "warned",
        "accepted": (fits.verdict == "ok") & (fits.reason != ""),
    }


def _listing(results: StudyResults, verdict: str, chosen: np.ndarray) -> Table:
    fits = results.recorded.fits
    columns: Columns = {
        Column("participant", "Participant"): fits.participant[chosen],
        Column("specimen", "Specimen"): fits.specimen[chosen],
        Column("press", "Press"): fits.repetition[chosen].astype(str),
        Column("reason", "Reason"): fits.reason[chosen],
    }
    reasons = [reason for text in fits.reason[chosen].tolist() for reason in text.split("; ") if reason]
    often = f"; most frequent: {'; '.join(most_frequent(reasons, 5))}" if reasons else ""
    return table_of(verdict, f"Trials {verdict}, with reasons{often}", columns, FEW_ON_PAGE)


def _sensitivity(found: Hypotheses) -> Table:
    """How the power to tell the specimens apart depends on what nobody knew beforehand."""
    people, specimens = found.participants.size, found.specimens.size
    heads = "Correlation ρ", "Sphericity ε", "Power here", f"People for a power of {bounded(TARGET, 2)}"
    table = power_table(people, specimens, EFFECT_F, alpha=found.alpha, power=TARGET)
    values = (*np.meshgrid(table.rho, table.epsilon, indexing="ij"), table.power, table.people)
    columns = map(Column, ("rho", "epsilon", "power", "people"), heads)
    caption = f"Power of {people} people to tell {specimens} specimens apart at f = {EFFECT_F:g}"
    return table_of("power_sensitivity", caption, dict(zip(columns, map(np.ravel, values), strict=True)))


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    if results.people is None:
        return {"judged": {}, "sessions": ""}
    n = {verdict: int(np.count_nonzero(chosen)) for verdict, chosen in _judged(results).items()}
    enter = "use" if "warned" in results.study.hypotheses.use else "do not use"
    said = {
        "rejected": f"No test uses the {count(n['rejected'], 'rejected trial')}.",
        "warned": f"The tests {enter} the {count(n['warned'], 'warned trial')}.",
        "accepted": f"The tests use the {count(n['accepted'], 'trial')} that the study file accepts by hand.",
    }
    verdicts = Counter(str(row["session"]) for row in _sessions(results).rows)
    sessions = listed([f"{number} {verdict}" for verdict, number in verdicts.most_common()])
    return {"judged": {verdict: text for verdict, text in said.items() if n[verdict]}, "sessions": sessions}


_TEXT = """
{% if sessions %}
<p>The sessions are judged as follows: {{ sessions }}. {{ judged.values() | join(" ") }}</p>
{{ folded("sessions", "Every session, with a page for each participant") }}
{% endif %}
{% if q['study.failures'] %}
{{ table("failures") }}
{% endif %}
{% for name in judged %}
{{ folded(name, "Trials " ~ name ~ ", with reasons") }}
{% endfor %}
{% if q['power.study'] is defined and q['power.study'] == q['power.study'] %}
<p>The paper planned its sample for a test between repetitions. With the people of this study, that test has a power of
{{ q['power.study'] | bounded }}, and a test between specimens has {{ q['power.study_specimens'] | bounded }}.</p>
{% endif %}
{{ folded("power_sensitivity", "Power between specimens by correlation and sphericity") }}
"""

PARTICIPANTS = Section("participants", "Participants", _TEXT, _applies, _quantities, _tables, words=_words)
