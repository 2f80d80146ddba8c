"""Who was recorded: the verdict on each session, what failed, and which trials were rejected or warned."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from emg2vsa.extraction.reasons import most_frequent
from emg2vsa.fits import by_recording
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.session_page import session_verdict
from emg2vsa.report.table import Cell, Column, Row, Table, records, rows_of
from emg2vsa.report.wording import count
from emg2vsa.session_verdict import doubts_between
from emg2vsa.study import RecordingEntry


def _applies(results: StudyResults) -> bool:
    return bool(results.study.recordings or results.failures)


def _quantities(results: StudyResults) -> Items:
    if results.people is not None:
        yield "study.participants", len(results.study.participants)
        yield "study.recordings", len(results.study.recordings)
        yield "study.recordings_read", len(results.people.trials)


_COUNTS = {"found": "Trials", "ok": "Ok", "warned": "Warned", "rejected": "Rejected"}


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    if results.failures:
        columns = (Column("key", "For"), Column("stage", "Step"), Column("message", "Why"))
        yield Table("failures", "Steps that could not be done", columns, records(results.failures, columns))
    if results.people is not None:
        yield _sessions(results)
        for verdict, chosen in _judged(results).items():
            yield _listing(results, verdict, chosen)


def _sessions(results: StudyResults) -> Table:
    people = results.recorded
    fits = by_recording(people.fits)
    doubts = doubts_between(people.trials, fits, results.study.judgements)
    entries: dict[str, list[RecordingEntry]] = {}
    for entry in results.study.recordings:
        entries.setdefault(entry.participant, []).append(entry)
    without_page = {failure.key for failure in results.failures if failure.stage == "pages"}
    rows: list[Row] = []
    links = []
    for name, (trials, failures) in results.by_participant().items():
        session = session_verdict(name, entries[name], trials, fits, failures, doubts)
        row: dict[str, Cell] = {"participant": name, "session": session.verdict, "recordings": len(session.specimens)}
        rows.append(row | {key: sum(getattr(each, key) for each in session.specimens) for key in _COUNTS})
        links.append(f"{results.pages}/{name}.html" if results.pages and name not in without_page else "")
    columns = (
        Column("participant", "Participant"), Column("session", "Session"), Column("recordings", "Recordings"),
        *(Column(key, head) for key, head in _COUNTS.items()),
    )  # fmt: skip
    caption = "Sessions: good, usable, to repeat, or unreadable"
    return Table("sessions", caption, columns, tuple(rows), links=tuple(links))


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
    columns = (
        Column("participant", "Participant"), Column("specimen", "Specimen"), Column("press", "Press"),
        Column("reason", "Reason"),
    )  # fmt: skip
    rows = rows_of(
        {
            "participant": fits.participant[chosen],
            "specimen": fits.specimen[chosen],
            "press": fits.repetition[chosen].astype(str),
            "reason": fits.reason[chosen],
        }
    )
    return Table(verdict, f"Trials {verdict}, with reasons", columns, rows)


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    if results.people is None:
        return {"judged": [], "sessions": ""}
    enter = "enter" if "warned" in results.study.hypotheses.use else "do not enter"
    uses = {
        "rejected": "No test uses them.",
        "warned": f"They {enter} the tests.",
        "accepted": "The study file accepts them by hand, and they enter the tests.",
    }
    judged = []
    for verdict, chosen in _judged(results).items():
        reasons = [reason for text in results.people.fits.reason[chosen].tolist() for reason in text.split("; ")]
        told = f"{count(len(chosen.nonzero()[0]), 'trial')} {verdict}"
        judged.append((verdict, told, uses[verdict], "; ".join(most_frequent(reasons, 5)) if reasons else ""))
    verdicts = Counter(str(row["session"]) for row in _sessions(results).rows)
    sessions = ", ".join(f"{n} {verdict}" for verdict, n in verdicts.most_common())
    return {"judged": [each for each in judged if each[3]], "sessions": sessions}


_TEXT = """
{% if sessions %}
<p>Sessions: {{ sessions }}.</p>
{{ folded("sessions", "Every session, with a page for each participant") }}
{% endif %}
{% if q['study.failures'] %}
{{ table("failures") }}
{% endif %}
{% for name, told, use, frequent in judged %}
<p>{{ told }}. {{ use }} Most frequent reasons: {{ frequent }}.</p>
{{ folded(name, "List of the trials " ~ name) }}
{% endfor %}
"""

PARTICIPANTS = Section("participants", "Participants", _TEXT, _applies, _quantities, _tables, words=_words)
