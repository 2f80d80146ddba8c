"""The page of mutation results: rates with their intervals, all mutants, and what each survivor is."""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from pathlib import Path
from typing import Any

JUDGED = Path(__file__).with_name("judged.json")


def wilson(successes: int, n: int) -> tuple[float, float]:
    """95 % interval of a share (Wilson 1927)."""
    z = 1.959963984540054
    middle, spread = successes + z**2 / 2, z * math.sqrt(successes * (n - successes) / n + z**2 / 4)
    return (middle - spread) / (n + z**2), (middle + spread) / (n + z**2)


def page(samples: list[dict[str, Any]]) -> str:
    """The rates of the results of ``python -m benchmarks.mutation``; the documentation site adds `tables`."""
    return f"{HEAD}\n{_rates(samples, _judged())}\n\n<!-- tables: mutation -->\n"


def tables(samples: list[dict[str, Any]]) -> str:
    """Every mutant, one section a sample."""
    judged, out = _judged(), []
    for each in samples:
        survivors = [row for row in each["mutants"] if row["state"] == "survived"]
        out += [f"\n## {_named(each)}: survivors\n", "| place | change | what it is |", "|---|---|---|"]
        out += [f"| {_place(row)} | {_change(row)} | {judged.get(key(row), 'not judged')} |" for row in survivors]
        out += [f"\n## {_named(each)}: all mutants\n", "| place | kind | change | end |", "|---|---|---|---|"]
        for row in each["mutants"]:
            end = f"killed by `{row['by']}`" if row["state"] == "killed" else row["state"]
            out.append(f"| {_place(row)} | {row['kind']} | {_change(row)} | {end.replace('|', chr(92) + '|')} |")
    return "\n".join(out)


def _judged() -> dict[str, str]:
    found: dict[str, str] = json.loads(JUDGED.read_text(encoding="utf-8"))
    return found


HEAD = """# Small wrong changes that the tests notice

Written by `python -m benchmarks.mutation --table`. A mutant is one wrong change of one expression or statement, in a
copy of the project of its own. The test files that execute its line run first, then others of its package, at most 10
files in all, without tests marked `slow` or `realtime`, until a test fails or a run has used 40 s of processor time
(the first 4 files are one run, the others another). Survivors were then judged by a person: "killed by other tests"
are those that a fast or real-time test beyond these ten files fails on, tried by hand; "equivalent" are those that
change no result, which do not count. A run that was ended early has tried only part of its sample, in random order:
its rate is of those it tried. What killed a mutant of `confirmed` passes on the unchanged code. "Noticed" is what the
tests did before any was written for a survivor, so a new sample may be expected to come out alike; "noticed now" also
counts the survivors that have got a test since.
"""


ELSEWHERE, EQUIVALENT = "Killed by the suite", "Equivalent"
"""How a judgement begins of a survivor that other tests of the suite kill, and of one that no test can."""
SINCE = re.compile(r"\. (Written|Mended): ")
"""What a judgement says of a survivor that a test was written or mended for."""


def _rates(samples: list[dict[str, Any]], judged: dict[str, str]) -> str:
    heads = (
        "sample", "mutants tried", "killed", "timed out", "killed by other tests", "equivalent", "survived",
        "noticed", "95 % interval", "noticed now",
    )  # fmt: skip
    rows = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    rows += [_rate(_named(each), each["mutants"], each["drawn"], judged) for each in samples]
    if len(samples) > 1:
        together = [row for each in samples for row in each["mutants"]]
        rows.append(_rate("together", together, sum(each["drawn"] for each in samples), judged))
    return "\n".join(rows)


def _rate(name: str, mutants: list[dict[str, Any]], drawn: int, judged: dict[str, str]) -> str:
    states = Counter(_state(row, judged) for row in mutants)
    n = len(mutants) - states[EQUIVALENT]
    noticed = n - states["survived"]
    low, high = wilson(noticed, n)
    since = sum(row["state"] == "survived" and SINCE.search(judged.get(key(row), "")) is not None for row in mutants)
    counts = (states[state] for state in ("killed", "timed out", ELSEWHERE, EQUIVALENT, "survived"))
    share = f"{100 * noticed / n:.0f} % | {100 * low:.0f} to {100 * high:.0f} % | {100 * (noticed + since) / n:.0f} %"
    return f"| {name} | {len(mutants)} of {drawn} | {' | '.join(map(str, counts))} | {share} |"


def _state(row: dict[str, Any], judged: dict[str, str]) -> str:
    """That of the trial, or for a survivor that of its judgement, where that is one of the two."""
    said = judged.get(key(row), "") if row["state"] == "survived" else ""
    return next((start for start in (ELSEWHERE, EQUIVALENT) if said.startswith(start)), row["state"])


def _named(each: dict[str, Any]) -> str:
    return f"Seed {each['seed']}" + (f", {each['about']}" if each.get("about") else "")


def key(row: dict[str, Any]) -> str:
    """Of a mutant in ``judged.json``: place, change."""
    return f"{row['module']}:{row['line']} {row['before']} -> {row['after']}"


def _place(row: dict[str, Any]) -> str:
    return f"{row['module']}:{row['line']}"


def _change(row: dict[str, Any]) -> str:
    before, after = (" ".join(row[name].split()).replace("|", "\\|") for name in ("before", "after"))
    return f"`{_short(before)}` → `{_short(after)}`"


def _short(text: str) -> str:
    """At most 70 characters, without a part of a word at its end."""
    return text if len(text) <= 70 else re.sub(r"\w+$", "", text[:68])[:67] + "..."
