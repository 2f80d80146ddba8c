"""What was measured, as Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from benchmarks.bench.measure import HOW
from benchmarks.bench.results import AreaResult, CaseResult, Row
from benchmarks.bench.timing import Spread

HOW_MEASURED = (
    "A time is the median of the rounds, with its interquartile range. A ratio is taken within each round against the "
    "first row: median and 5 % to 95 % of the rounds; above 1 means slower than the first row."
)
HEAD = ("#", "library", "way", "work", "CPU ms", "ratio", "error", "digits", "peak MB")


HEADLINE = ("case", "ours, CPU ms", "fastest of equal work and error", "faster, less exact or other work", "floor, ms")
HOW_COMPARED = (
    "Beside a row stands its time over that of our first row: below 1 ours is not faster. Errors are equal where the "
    "other's is below 1e-10 (relative) or 1.25 times ours. The floor is what moving the bytes, or the flops, takes "
    "alone on this machine, by a copy and a product of matrices in the same run; blank where nobody counted them."
)


TABLES = "<!-- tables: {} -->"
"""Stands in a page for what the documentation site makes of a JSON file beside it."""


def page(area: AreaResult, picture: str = "") -> str:
    """The page of an area: question, answer and one picture. The site adds `tables` where the page ends."""
    lines = [
        f"# {area.name}", "", area.question, "",
        f"Written by `emg2vsa tools bench {area.name}` ([how it is timed](README.md)).", "",
        *_headlines(area), f"**Answer.** {area.meaning}", "",
        *([f"![{area.name}: time against size or error]({picture})", ""] if picture else []),
        TABLES.format(f"{area.name}.json"),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def tables(area: AreaResult, plots: Mapping[str, Sequence[str]]) -> str:
    """Provenance and every table. plots : file names of the plots of a case, and of a family of cases."""
    memory = f" {HOW}" if any(row.peak_mb is not None for case in area.cases for row in case.rows) else ""
    lines = [f"**On what.** {provenance(area)}{memory}", ""]
    families: set[str] = set()
    for case in area.cases:
        lines += [f"## {case.name}", "", *case_lines(case), ""]
        lines += [f"![{case.name}: time against error]({name})\n" for name in plots.get(case.name, ())]
        if case.family and case.family not in families and case is _last_of(area, case.family):
            families.add(case.family)
            lines += [f"![{case.family}: time against size]({name})\n" for name in plots.get(case.family, ())]
    lines += _notices(area)
    return "\n".join(lines).rstrip() + "\n"


def case_lines(case: CaseResult) -> list[str]:
    """The table of a case, with what its errors are against."""
    lines = [f"{case.size:g} {case.size_unit}. Error ({case.error_unit}) against {case.truth}.", ""]
    lines += table(HEAD, [_cells(i, row) for i, row in enumerate(case.rows, 1)])
    rows_of: dict[str, list[str]] = {}
    for i, row in enumerate(case.rows, 1):
        for note in _notes(row):
            rows_of.setdefault(note, []).append(str(i))
    notes = [f"Row {', '.join(rows)}: {note}." for note, rows in rows_of.items()]
    return lines + (["", " ".join(notes)] if notes else [])


def index(areas: Iterable[AreaResult]) -> str:
    """The page of all areas, one row each; the answer stands on the page of the area."""
    lines = [
        "# Benchmarks", "",
        "Time and error of this project beside other libraries, measured in one run.",
        "`emg2vsa tools bench AREA` writes the page of an area again; `emg2vsa tools bench --list` names the areas.",
        "The tables of an area are in its JSON file; the documentation site shows them on its page.",
        "How it is timed, and why: [decision 29](../decisions/0029-how-we-time.md).", "",
        HOW_MEASURED, "",
    ]  # fmt: skip
    rows = [(f"[{area.name}]({area.name}.md)", area.question) for area in areas]
    return "\n".join(lines + table(("area", "question"), rows)) + "\n"


def provenance(area: AreaResult) -> str:
    """Processor, load and versions, one line."""
    of = area.machine
    libraries = ", ".join(f"{name} {version}" for name, version in of["libraries"].items())
    return (
        f"{of['processor']}, {of['cores']} cores, load {of['load']}; {of['system']}, Python {of['python']}; "
        f"emg2vsa {of['emg2vsa']} ({of['revision']}), {area.size} size; {libraries}."
    )


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return lines + ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]


def slug(text: str) -> str:
    """Part of a file name."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


def ratio_text(ratio: Spread | None) -> str:
    """Median and range, e.g. ``2.40 (2.31 to 2.55)``."""
    return "1" if ratio is None else f"{ratio.median:.3g} ({ratio.low:.3g} to {ratio.high:.3g})"


def number(value: float | None, form: str = ".3g") -> str:
    return "" if value is None else format(value, form)


def _cells(i: int, row: Row) -> list[str]:
    library = f"**{row.library}**" if row.ours else row.library
    if row.failed:
        return [str(i), library, row.name, row.work, "failed", "", "", "", ""]
    cpu = f"{number(row.median_ms)} ± {number(row.iqr_ms, '.2g')}"
    error = "0" if row.error == 0 else number(row.error, ".2g")
    ratio = ratio_text(row.ratio)
    return [
        str(i), library, row.name, row.work, cpu, ratio, error, number(row.digits, ".1f"), number(row.peak_mb, ".1f")
    ]  # fmt: skip


def _notes(row: Row) -> list[str]:
    slow = row.first_ms is not None and row.median_ms is not None and row.first_ms > max(5 * row.median_ms, 50)
    parts = [row.note, row.failed, f"first call {row.first_ms:.0f} ms" if slow else ""]
    return [part.rstrip(".") for part in parts if part]


def _notices(area: AreaResult) -> list[str]:
    lines = [f"not installed: {name}" for name in area.absent]
    lines += [f"not measured: {what}" for what in area.missing]
    return ["## Not measured", "", *(f"- {line}" for line in lines)] if lines else []


def _headlines(area: AreaResult) -> list[str]:
    """A row a case: ours beside the fastest of equal work and error."""
    rates, rows = area.machine.get("rates", {}), []
    for case in area.cases:
        if case.rows[0].median_ms:
            alike, rough = case.fastest(alike=True), case.fastest(alike=False)
            quicker = rough if rough and rough.ratio and rough.ratio.median < 1 else None
            floor = number(case.floor_ms(rates), ".2g")
            own = number(case.rows[0].median_ms)
            rows.append((case.name, own, _beside(case, alike), _beside(case, quicker, said=""), floor))
    return [*table(HEADLINE, rows), "", HOW_COMPARED, ""] if rows else []


def _beside(case: CaseResult, peer: Row | None, said: str = " (**not faster**)") -> str:
    """Another library's row, its time over that of our first row and of our fastest, and what is said where all of ours
    are slower."""
    if peer is None or peer.ratio is None:
        return "none"
    ratio, best, error = peer.ratio.median, case.ours, ""
    ratios = _ratio(ratio)
    if best.ratio is not None:
        ratio /= best.ratio.median
        ratios += f", {_ratio(ratio)} of {best.name}"
    if peer.work != "equal":
        ratios += f" ({peer.note or 'as used'})"
    if peer.error:
        error = f"; error {number(peer.error, '.2g')}, ours {number(case.rows[0].error, '.2g')}"
    return f"{peer.label}: {ratios}{said if ratio < 0.97 else ''}{error}"


def _ratio(ratio: float) -> str:
    return f"{ratio:.2f}" if ratio >= 0.1 else f"{ratio:.1g}"


def _last_of(area: AreaResult, family: str) -> CaseResult:
    return [case for case in area.cases if case.family == family][-1]
