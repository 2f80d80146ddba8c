"""What was measured, as plain data that goes to JSON and back."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from benchmarks.bench.timing import Spread

SCHEMA = "emg2vsa-bench-1"
MOST_DIGITS = 16.0
ENOUGH = 1e-10
"Relative errors that are alike: a result is shown to four digits."
MARGIN = 1.25
"Errors that are alike otherwise: seeds scatter by more."


@dataclass(frozen=True)
class Row:
    """One way of one case. Times are processor ms of one call; ratio : times slower than the first way, None for it;
    error, digits, peak_mb : None where not measured. failed : what the way raised instead."""

    library: str
    name: str
    work: str
    note: str
    ours: bool
    least_ms: float | None = None
    median_ms: float | None = None
    iqr_ms: float | None = None
    first_ms: float | None = None
    rounds: int = 0
    ratio: Spread | None = None
    error: float | None = None
    digits: float | None = None
    peak_mb: float | None = None
    failed: str = ""

    @property
    def label(self) -> str:
        return f"{self.library}: {self.name}"


@dataclass(frozen=True)
class CaseResult:
    """The rows of a case, in the order of its ways; see ``case.Case`` for the rest."""

    name: str
    size: float
    size_unit: str
    error_unit: str
    truth: str
    family: str
    rows: tuple[Row, ...]
    bytes_moved: float = 0.0
    flops: float = 0.0

    @property
    def ours(self) -> Row:
        """Our row of equal work and least time."""
        own = (row for row in self.rows if row.ours and row.work == "equal" and row.median_ms)
        return min(own, key=_time, default=self.rows[0])

    def fastest(self, alike: bool) -> Row | None:
        """Of other libraries' rows the fastest: of equal work and an error like that of our first row, or of the rest,
        whose work is other or whose error is larger."""
        enough = max(MARGIN * abs(self.rows[0].error or 0.0), ENOUGH if self.error_unit == "relative" else 0.0)
        others = [
            row for row in self.rows
            if not row.ours and row.median_ms
            and (row.work == "equal" and abs(row.error or 0.0) <= enough) == alike
        ]  # fmt: skip
        return min(others, key=_time, default=None)

    def floor_ms(self, rates: dict[str, float]) -> float | None:
        """Time that memory or arithmetic alone takes at the machine's rates, whichever is longer."""
        if not rates or not (self.bytes_moved or self.flops):
            return None
        return 1e3 * max(self.bytes_moved / rates["bytes_per_s"], self.flops / rates["flops_per_s"])


def _time(row: Row) -> float:
    return row.median_ms or math.inf


@dataclass(frozen=True)
class AreaResult:
    """absent : peers that are not installed. missing : what could not be
    measured here, and why."""

    name: str
    question: str
    meaning: str
    size: str
    machine: dict[str, Any]
    absent: tuple[str, ...]
    missing: tuple[str, ...]
    cases: tuple[CaseResult, ...]


def digits_of(error: float) -> float:
    """-log10 of a relative error, 0 to 16."""
    if math.isnan(error):
        return 0.0
    return MOST_DIGITS if error <= 0 else max(0.0, min(MOST_DIGITS, -math.log10(error)))


def to_json(area: AreaResult) -> dict[str, Any]:
    """With ``schema``; numbers that are not finite become null in the file (``casr.terminal.finite``)."""
    return {"schema": SCHEMA, **asdict(area)}


def from_json(value: dict[str, Any]) -> AreaResult:
    """The inverse of ``to_json``; ValueError for another schema."""
    if value.get("schema") != SCHEMA:
        raise ValueError(f"schema {value.get('schema')!r}, expected {SCHEMA!r}")
    cases = tuple(CaseResult(**{**case, "rows": tuple(_row(row) for row in case["rows"])}) for case in value["cases"])
    rest = {key: item for key, item in value.items() if key not in ("schema", "cases", "absent", "missing")}
    return AreaResult(**rest, absent=tuple(value["absent"]), missing=tuple(value["missing"]), cases=cases)


def _row(value: dict[str, Any]) -> Row:
    return Row(**{**value, "ratio": value["ratio"] and Spread(**value["ratio"])})
