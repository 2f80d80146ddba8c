"""Who was recorded, were they enough, what failed, and which trials are not simply ok."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from emg2vsa.companions.visits import visit_differences
from emg2vsa.extraction import Trials
from emg2vsa.extraction.reasons import by_hand, most_frequent
from emg2vsa.extraction.remedies import remedies_of
from emg2vsa.fits import Fits, by_recording
from emg2vsa.hypotheses import EFFECT_F, EPSILON, RHO, TARGET, Hypotheses
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, named
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.session_page import session_verdict
from emg2vsa.report.table import FEW_ON_PAGE, Column, Columns, Table, activity_column, records, table_of
from emg2vsa.report.wording import bounded, listed
from emg2vsa.session_verdict import doubts_between
from emg2vsa.statistics.power import power_rm, power_table
from emg2vsa.study import RecordingEntry


def _quantities(results: StudyResults) -> Items:
    if results.people is None:
        return
    yield "study.participants", len(results.study.participants)
    yield from named("study", recordings=len(results.study.recordings), recordings_read=len(results.people.trials))
    # the paper's 14 people and ten repetitions
    yield "power.n14", float(power_rm(14, 10, EFFECT_F, RHO, EPSILON, 0.05))
    if (found := results.people.hypotheses) is not None:
        study_power, specimens, people = found.power.repetitions, found.power.specimens, found.power.people
        yield from named("power", study=study_power, study_specimens=specimens, people_for_specimens=people)


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    if results.failures:
        columns = (Column("key", "For"), Column("stage", "Step"), Column("message", "Why"))
        yield Table("failures", "Steps that could not be done", columns, records(results.failures, columns))
    if results.people is None:
        return
    yield _sessions(results)
    yield _judged(results)
    if (found := results.people.hypotheses) is not None and found.power.people:
        yield _sensitivity(found)
    if len(results.study.visits) > 1:
        yield _visits(results)


def _visits(results: StudyResults) -> Table:
    """How b of later visits differs from that of the first."""
    study, people = results.study, results.recorded
    confidence = 1 - study.hypotheses.alpha
    found = visit_differences(people.fits, study.hypotheses.use, study.visits, confidence)
    heads = {"mean": "b less that of the first visit", "low": "from", "high": "to", "sd": "SD over people"}
    columns: Columns = {
        Column("specimen", "Specimen"): found.specimen, Column("visit", "Visit"): found.visit,
        Column("people", "People at both"): found.people,
        **{activity_column(f"{of}_v", head, results.scale): getattr(found, of) for of, head in heads.items()},
    }  # fmt: skip
    told = f"Difference of b between visits, mean over people, {100 * confidence:g} % intervals"
    return table_of("visits", told, columns)


def _missed(results: StudyResults) -> list[str]:
    """People, or specimens of theirs, of whom nothing was read at a visit."""
    said = []
    for who, (_, trials, _) in results.by_participant().items():
        for visit in results.study.visits:
            there = [t.specimen for t in trials if visit in t.visit]
            lacks = [name for name in results.study.palpated if name not in there]
            if lacks:
                said.append(f"{who} {f'on {listed(lacks)} ' if there else ''}at visit {visit}")
    return said


def _at_visit(
    entries: Sequence[RecordingEntry], trials: Sequence[Trials], fits: Mapping[tuple[str, str], Fits], visit: str
) -> tuple[list[RecordingEntry], list[Trials], dict[tuple[str, str], Fits]]:
    """What is of one visit."""
    rows = {(t.participant, t.specimen): np.flatnonzero(t.visit == visit) for t in trials if visit in t.visit}
    own = [
        replace(t, repetition=t.repetition[at], verdict=t.verdict[at], reasons=tuple(t.reasons[i] for i in at.tolist()))
        for t in trials if (at := rows.get((t.participant, t.specimen))) is not None
    ]  # fmt: skip
    of = {cell: replace(fits[cell], verdict=fits[cell].verdict[at], reason=fits[cell].reason[at])
          for cell, at in rows.items() if cell in fits}  # fmt: skip
    return [replace(entry, visit=visit, further=()) for entry in entries], own, of


def _sessions(results: StudyResults) -> Table:
    people, own = results.recorded, results.by_participant()
    fits = by_recording(people.fits)
    doubts = doubts_between(people.trials, fits, results.study.judgements)
    without_page = {failure.key for failure in results.failures if failure.stage == "pages"}
    visits = results.study.visits or ("",)
    judged = []
    for name, (entries, trials, failed) in own.items():
        for visit in visits:
            given = _at_visit(entries, trials, fits, visit) if visit else (entries, trials, fits)
            judged.append(session_verdict(name, *given, failed, doubts))
    columns: Columns = {
        Column("participant", "Participant"): [name for name in own for _ in visits],
        **({Column("visit", "Visit"): [*visits] * len(own)} if results.study.visits else {}),
        Column("session", "Session"): [session.verdict for session in judged],
        Column("recordings", "Recordings"): [
            sum(not visit or each.found > 0 for each in session.specimens)
            for session, visit in zip(judged, [*visits] * len(own), strict=True)
        ],
    }
    for key, head in {"found": "Trials", "ok": "Ok", "doubtful": "Doubtful", "rejected": "Rejected"}.items():
        columns[Column(key, head)] = [sum(getattr(each, key) for each in session.specimens) for session in judged]
    linked = {name: results.pages and name not in without_page for name in own}
    links = (f"{results.pages}/{name}.html" if linked[name] else "" for name in own for _ in visits)
    made = table_of("sessions", "Sessions: good, usable, to repeat, or unreadable", columns)
    return replace(made, links=tuple(links))


def _judged(results: StudyResults) -> Table:
    """Trials that are not simply ok: not used, accepted by hand, or with a remark."""
    fits = results.recorded.fits
    chosen = (fits.verdict != "ok") | (fits.reason != "")
    verdicts = np.where(_accepted(fits), "accepted", fits.verdict)
    values = (fits.participant, fits.specimen, fits.repetition.astype(str), verdicts, fits.reason)
    heads = ("Participant", "Specimen", "Press", "Verdict", "Reason")
    columns: Columns = {Column(h.lower(), h): of[chosen] for h, of in zip(heads, values, strict=True)}
    reasons = [reason for text in fits.reason[chosen].tolist() for reason, _ in remedies_of(text)]
    often = f"; most frequent reasons: {'; '.join(most_frequent(reasons, 5))}" if reasons else ""
    return table_of(
        "judged", f"Trials rejected, doubtful, accepted by hand or with a remark{often}", columns, FEW_ON_PAGE
    )


def _accepted(fits: Fits) -> NDArray[np.bool_]:
    """Trials (n,) that a person accepted in the study file."""
    return np.asarray((fits.verdict == "ok") & np.array([by_hand(reason) for reason in fits.reason.tolist()], bool))


def _sensitivity(found: Hypotheses) -> Table:
    """How the power to tell the specimens apart depends on what nobody knew beforehand."""
    people, specimens = found.participants.size, found.specimens.size
    heads = "Correlation ρ", "Sphericity ε", "Power here", f"People for a power of {bounded(TARGET, 2)}"
    table = power_table(people, specimens, EFFECT_F, alpha=found.alpha, power=TARGET)
    values = (*np.meshgrid(table.rho, table.epsilon, indexing="ij"), table.power, table.people)
    columns = zip(map(Column, ("rho", "epsilon", "power", "people"), heads), map(np.ravel, values), strict=True)
    caption = f"Power of {people} people to tell {specimens} specimens apart at f = {EFFECT_F:g}"
    return table_of("power_sensitivity", caption, dict(columns))


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    if results.people is None:
        return {"sessions": ""}
    fits, verdicts = results.people.fits, Counter(str(row["session"]) for row in _sessions(results).rows)
    sessions = listed([f"{number} {verdict}" for verdict, number in verdicts.most_common()])
    return {
        "sessions": sessions,
        "missed": _missed(results),
        "accepted": int(np.count_nonzero(_accepted(fits))),
        "rho": f"{RHO:g}",
        "epsilon": f"{EPSILON:g}",
    }


_TEXT = """
{% if sessions %}
<p>The sessions are judged as follows: {{ sessions }}.
{% if q['trials.rejected'] %}
No test uses the {{ q['trials.rejected'] | count("rejected trial") }}.
{% endif %}
{% if q['trials.doubtful'] %}
The tests {{ "use" if "doubtful" in study.hypotheses.use else "do not use" }} the
{{ q['trials.doubtful'] | count("doubtful trial") }}.
{% endif %}
{% if accepted %}
The tests use the {{ accepted | count("trial") }} that the study file accepts by hand.
{% endif %}</p>
{{ folded("sessions", "Every session, with a page for each participant") }}
{% endif %}
{% if has("visits") %}
<p>The presses of a person at all {{ study.visits | length }} visits count as those of one person, and b of a person is
the mean over them; what differs between visits is no scatter of presses.
{% if missed %}Nothing was read of {{ missed | listed }}.
Presses of a visit that lacks a specimen which the person pressed at another visit are doubtful: what differs between
visits would bias comparisons of specimens.{% endif %}</p>
{{ table("visits") }}
{% endif %}
{{ table("failures") }}
{{ folded("judged", "Trials rejected, doubtful, accepted by hand or with a remark") }}
{% if q['power.study'] is defined and q['power.study'] == q['power.study'] %}
<p>The paper planned its sample for a test between repetitions. With the people of this study, that test has a power of
{{ q['power.study'] | bounded }}
{%- if q['power.study_specimens'] == q['power.study_specimens'] %}, and a test between specimens has
{{ q['power.study_specimens'] | bounded }}{% endif %}, at a correlation ρ of {{ rho }} and a sphericity ε of
{{ epsilon }}.</p>
{% endif %}
{{ folded("power_sensitivity", "Power between specimens by correlation and sphericity") }}
"""

PARTICIPANTS = Section(
    "participants", "Participants", _TEXT, lambda results: bool(results.study.recordings or results.failures),
    _quantities, _tables, words=_words,
)  # fmt: skip
