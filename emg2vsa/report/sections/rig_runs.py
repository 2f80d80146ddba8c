"""The rig's presses: how many of each condition and angle, and which were rejected."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

import numpy as np

from emg2vsa.devices.joints import export_of
from emg2vsa.discrimination.run_table import CONDITIONS
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, most, with_interval
from emg2vsa.report.section import Quantities, Section, of_runs
from emg2vsa.report.table import Column, Columns, Table, records, table_of
from emg2vsa.report.wording import count, listed, signed
from emg2vsa.run_scores.product import RunScores, WeighedPress
from emg2vsa.statistics.drift import Order

_NUMBER = re.compile(r"-?\b\d+(\.\d+)?(e[-+]?\d+)?\b")
_PLACE = re.compile(r"^\S*/press-\d+, ")
"The folder of a press, before what is wrong with it."
_SHOWN_RUNS = 3


def _quantities(results: StudyResults) -> Items:
    runs = results.pressed.scores
    yield "runs.count", len(runs)
    yield "runs.simulated", results.pressed.simulated
    yield "runs.presses", sum(run.repetitions.size for run in runs)
    yield "runs.rejected", sum(run.verdicts.count("rejected") for run in runs)
    if math.isfinite(largest_n := _largest_n(runs)):
        yield "runs.largest_force_n", largest_n
    if weighed := _weighed(runs):
        yield "runs.weighed", len(weighed)
        yield "runs.weighed_not_ok", sum(press.verdict != "ok" for press in weighed)
    if found := results.pressed.discrimination:
        yield "runs.order", found.drift.order
        session = found.drift.session
        change = 100 * np.expm1((session.value, *session.interval(1 - found.settings.alpha)))
        yield from with_interval("runs.drift_percent", *change)


_ORDERS: dict[Order, str] = {
    "differs": "Drift of CASR from the first mounting to the last, {}, is taken out of every comparison.",
    "same": "The order of mountings tells too little of drift, which widens every interval.",
    "unknown": "Nobody knows the order of mountings, so that drift may widen every interval.",
}


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    rank = {name: i for i, name in enumerate(CONDITIONS)}

    def place(run: RunScores) -> tuple[int, str, float]:
        return rank.get(run.condition, len(rank)), run.condition, run.angle_deg

    runs = [[*of] for _, of in groupby(sorted(results.pressed.scores, key=place), key=place)]
    rejected = [_rejected(of) for of in runs]
    columns: Columns = {
        Column("condition", "Condition"): [of[0].condition for of in runs],
        Column("angle_deg", "Angle (°)", digits=2): [of[0].angle_deg for of in runs],
        Column("specimens", "Specimens"): [listed([run.specimen for run in of]) for of in runs],
        Column("presses", "Presses"): [sum(run.repetitions.size for run in of) for of in runs],
        Column("rejected", "Rejected"): [sum(map(len, kinds)) for kinds in rejected],
        Column("peak_n", "Largest force (N)", digits=3): list(map(_largest_n, runs)),
        Column("reasons", "Reasons"): ["; ".join(f"{of[0][0]} ({len(of)})" for of in kinds) for kinds in rejected],
    }
    yield table_of("runs", "Presses of every condition and angle", columns)
    weighed = _weighed(results.pressed.scores)
    kinds = tuple("holds" if press.verdict == "ok" else "fails" for press in weighed)
    caption = "κ by force over depth of each press, with its 95 % interval, from presses.csv of its run; not ok first"
    yield Table("runs_weighed", caption, _OF_A_PRESS, records(weighed, _OF_A_PRESS), kinds=kinds)


_OF_A_PRESS = (
    Column("folder", "Run"), Column("press", "Press"), Column("specimen", "Specimen named"),
    Column("stated_n_per_mm", "κ stated (N/mm)"), Column("kappa_n_per_mm", "κ of the press (N/mm)"),
    Column("low_n_per_mm", "Low"), Column("high_n_per_mm", "High"), Column("verdict", "Verdict"),
    Column("said", "In words"),
)  # fmt: skip


def _weighed(runs: Sequence[RunScores]) -> list[WeighedPress]:
    return sorted((press for run in runs for press in run.weighed), key=lambda press: press.verdict == "ok")


def _kinds(told: Iterable[tuple[str, str]]) -> list[list[tuple[str, str]]]:
    """What is said of a run, and its name: texts that differ by their numbers alone together."""
    kinds: dict[str, list[tuple[str, str]]] = {}
    for text, run in told:
        kinds.setdefault(_NUMBER.sub("#", text.replace(run, "")), []).append((text, run))
    return [*kinds.values()]


def _rejected(runs: Sequence[RunScores]) -> list[list[tuple[str, str]]]:
    """Reasons of rejected presses, the most frequent kind first."""
    presses = ((run.name, *press) for run in runs for press in zip(run.reasons, run.verdicts, strict=True))
    told = [(_PLACE.sub("", why).split(". ")[0].removesuffix("."), n) for n, why, v in presses if v == "rejected"]
    return sorted(_kinds(told), key=len, reverse=True)


def _largest_n(runs: Sequence[RunScores]) -> float:
    """NaN where no run tells."""
    return most(np.concatenate([run.peak_n for run in runs]))


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    runs, found = results.pressed.scores, results.pressed.discrimination
    n, calibration = sum(run.simulated for run in runs), results.pressed.calibration
    absent = calibration.notes if calibration and not calibration.conditions else ()
    change = [q.get(f"runs.drift_percent{end}", np.nan) for end in ("", ".low", ".high")]
    drift = "{} % [{}, {}]".format(*(signed(float(each)) for each in change))
    return {
        "skipped": sum(not run.over_bytes for run in runs),
        "emulated": "" if n == 0 else "These runs" if n == len(runs) else f"{n} of {len(runs)} runs",
        "notes": [_note(told) for told in _kinds((note, run.name) for run in runs for note in run.notes)],
        "absent": absent if found else [results.why_absent("discrimination")],
        "order": _ORDERS[found.drift.order].format(drift) if found else "",
        "remark": export_of(results.study.schedule.actuator).remark,
    }


def _note(told: Sequence[tuple[str, str]]) -> str:
    """The first of a kind of notes, and the runs that it concerns."""
    names = list(dict.fromkeys(name for _, name in told))
    like = f"{len(told)} such notes with other numbers, " if len({text for text, _ in told}) > 1 else ""
    where = ", ".join(names[:_SHOWN_RUNS]) + ", …" * (len(names) > _SHOWN_RUNS)
    return f"{told[0][0]} ({like}{count(len(names), 'run')}: {where})"


_TEXT = """
<p>{{ q["runs.presses"] }} presses in {{ q["runs.count"] }} runs were scored; {{ q["runs.rejected"] }} were rejected.
<strong>{{ emulated }} {{ "come from a simulated rig" if emulated else "These runs were measured" }}
{%- if skipped %} ({{ skipped | count("run") }} emulated, not over bytes){% endif %}.</strong>
{% if "runs.largest_force_n" in q %}
The largest force, {{ q["runs.largest_force_n"] | number }} N, passes F_max, as filter, bus and motors are late.
{% endif %}
{{ order }}
{% if remark %}
<strong>{{ remark }}</strong>
{% endif %}
Boxes in figures are Hazen's quartiles.</p>
{{ folded("runs", "Presses of every condition and angle") }}
{% if "runs.weighed" in q %}
<p>{{ q["runs.weighed"] }} presses tell by force over depth which specimen lay there;
<strong>{{ q["runs.weighed_not_ok"] or "none" }}</strong> of them {{ "is" if q["runs.weighed_not_ok"] == 1 else "are" }}
doubtful, rejected or ended.</p>
{{ folded("runs_weighed", "Which specimen each press tells") }}
{% endif %}
{% if notes %}
<details><summary>{{ notes | length | count("kind") }} of notes about the runs</summary>{{ notes | bullets }}</details>
{% endif %}
{% for why in absent %}
<p>{{ why }}</p>
{% endfor %}
"""

RUNS = Section("runs", "Presses of the rig", _TEXT, of_runs, _quantities, _tables, words=_words)
