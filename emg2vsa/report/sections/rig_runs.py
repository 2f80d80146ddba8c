"""The rig's presses: how many of each condition and angle, and which were rejected."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence

import numpy as np

from emg2vsa.devices.joints import export_of
from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.run_table import CONDITIONS
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, most, with_interval
from emg2vsa.report.section import Quantities, Section, of_runs
from emg2vsa.report.table import Column, Columns, Table, table_of
from emg2vsa.report.wording import count, listed
from emg2vsa.run_scores import RunScores
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
    if found := results.pressed.discrimination:
        yield "runs.order", found.drift.order
        yield from with_interval("runs.drift_percent", *_drift_percent(found))


def _drift_percent(found: Discrimination) -> tuple[float, float, float]:
    """Of CASR from the first mounting to the last, low and high."""
    session = found.drift.session
    estimate, low, high = 100 * np.expm1((session.value, *session.interval(1 - found.settings.alpha)))
    return float(estimate), float(low), float(high)


_ORDERS: dict[Order, str] = {
    "differs": "it tells what drift does, which is taken out of every comparison",
    "same": "it tells too little of drift, so every comparison is as uncertain as the trend within mountings allows",
    "unknown": "nobody knows it, so every comparison is as uncertain as the trend within mountings allows",
}


def _order(results: StudyResults) -> str:
    found = results.pressed.discrimination
    return f"Order of mountings: {_ORDERS[found.drift.order]}." if found else ""


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    order = {name: i for i, name in enumerate(CONDITIONS)}
    by_design: dict[tuple[str, float], list[RunScores]] = {}
    for run in results.pressed.scores:
        by_design.setdefault((run.condition, run.angle_deg), []).append(run)
    designs = sorted(by_design, key=lambda design: (order.get(design[0], len(order)), *design))
    runs = [by_design[design] for design in designs]
    rejected = [_rejected(of) for of in runs]
    columns: Columns = {
        Column("condition", "Condition"): [condition for condition, _ in designs],
        Column("angle_deg", "Angle (°)", digits=2): [angle for _, angle in designs],
        Column("specimens", "Specimens"): [listed([run.specimen for run in of]) for of in runs],
        Column("presses", "Presses"): [sum(run.repetitions.size for run in of) for of in runs],
        Column("rejected", "Rejected"): [sum(map(len, kinds)) for kinds in rejected],
        Column("peak_n", "Largest force (N)", digits=3): list(map(_largest_n, runs)),
        Column("reasons", "Reasons"): ["; ".join(f"{of[0]} ({len(of)})" for of in kinds) for kinds in rejected],
    }
    yield table_of("runs", "Presses of every condition and angle", columns)


def _rejected(runs: Sequence[RunScores]) -> list[list[str]]:
    """Reasons of rejected presses, those that differ by their numbers alone together, the most frequent kind first."""
    kinds: dict[str, list[str]] = {}
    for run in runs:
        for reason, verdict in zip(run.reasons, run.verdicts, strict=True):
            if verdict == "rejected":
                what = _PLACE.sub("", reason).split(". ")[0].removesuffix(".")
                kinds.setdefault(_NUMBER.sub("#", what), []).append(what)
    return sorted(kinds.values(), key=len, reverse=True)


def _largest_n(runs: Sequence[RunScores]) -> float:
    """NaN where no run tells."""
    return most(np.concatenate([run.peak_n for run in runs]))


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    runs = results.pressed.scores
    n = sum(run.simulated for run in runs)
    return {
        "emulated": "" if n == 0 else "These runs" if n == len(runs) else f"{n} of {len(runs)} runs",
        "notes": _notes(runs),
        "kinds": count(len(_notes(runs)), "kind"),
        "absent": _absent(results),
        "order": _order(results),
        "remark": export_of(results.study.schedule.actuator).remark,
        "told_n": math.isfinite(_largest_n(runs)),
    }


def _absent(results: StudyResults) -> Sequence[str]:
    """Why sections that tests and calibration fill are not there."""
    runs = results.pressed
    if runs.discrimination is None:
        return [results.why_absent("discrimination")]
    return runs.calibration.notes if runs.calibration and not runs.calibration.conditions else ()


def _notes(runs: Sequence[RunScores]) -> list[str]:
    """Notes that differ by their numbers alone are one kind: its first, and the runs it concerns."""
    kinds: dict[str, list[tuple[str, str]]] = {}
    for run in runs:
        for note in run.notes:
            kinds.setdefault(_NUMBER.sub("#", note), []).append((note, run.name))
    return [_note([note for note, _ in of], list(dict.fromkeys(name for _, name in of))) for of in kinds.values()]


def _note(notes: Sequence[str], names: list[str]) -> str:
    like = f"{len(notes)} such notes with other numbers, " if len(set(notes)) > 1 else ""
    where = ", ".join([*names[:_SHOWN_RUNS], *(["…"] if len(names) > _SHOWN_RUNS else [])])
    return f"{notes[0]} ({like}{count(len(names), 'run')}: {where})"


_TEXT = """
{% if emulated %}
<p>{{ q['runs.presses'] }} presses in {{ q['runs.count'] }} runs were scored, {{ q['runs.rejected'] }} were rejected.
<strong>{{ emulated }} come from a simulated rig,</strong> whose actuator, force sensor and camera share one world.</p>
{% else %}
<p><strong>These runs were measured,</strong> as far as their folders say.</p>
{% endif %}
{% if remark %}
<p><strong>{{ remark }}</strong></p>
{% endif %}
{% if told_n %}
<p>The largest force of a press was {{ q['runs.largest_force_n'] | number }} N. Filter, bus and motors are late, so the
force goes beyond F_max, at which the probe turns back.</p>
{% endif %}
{% if order %}
<p>{{ order }}{% if q["runs.drift_percent.low"] == q["runs.drift_percent.low"] %} Drift of CASR from the first mounting
to the last: {{ q["runs.drift_percent"] | signed }} % [{{ q["runs.drift_percent.low"] | signed }},
{{ q["runs.drift_percent.high"] | signed }}].{% endif %}</p>
{% endif %}
{{ folded("runs", "Presses of every condition and angle") }}
{% if notes %}
<details><summary>{{ kinds }} of notes about the runs</summary>{{ notes | bullets }}</details>
{% endif %}
{% for why in absent %}
<p>{{ why }}</p>
{% endfor %}
"""

RUNS = Section("runs", "Presses of the rig", _TEXT, of_runs, _quantities, _tables, words=_words)
