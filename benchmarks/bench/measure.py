"""One area measured in this process."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from benchmarks.bench.case import Area, Case, NotHere, Size, Way
from benchmarks.bench.machine import machine
from benchmarks.bench.memory import peak_mb
from benchmarks.bench.results import AreaResult, CaseResult, Row, digits_of
from benchmarks.bench.threads import pin_loaded
from benchmarks.bench.timing import Timed, first_call, timed

Say = Callable[[str], None]


def measure(
    area: Area,
    size: Size,
    *,
    rounds: int,
    budget_s: float = 2.0,
    only: str = "",
    ours_alone: bool = False,
    memory: bool = False,
    older: bool = False,
    say: Say = lambda _: None,
) -> AreaResult:
    """Every case of the area: times, errors, digits, and with ``memory`` peaks.

    rounds : 0 measures errors alone. only : a word that the name of a case or of its library and way must hold.
    ours_alone : no other library runs.
    older : the product is of another revision; a part whose functions it lacks is in ``missing``, not an error. A way
    that raises is a row that says so.
    """
    missing: list[str] = []
    results = []
    for case in _cases(area, size, missing, older):
        chosen = _chosen(case, only, ours_alone)
        if chosen is None:
            continue
        say(f"{area.name}: {case.name}")
        results.append(_measured(chosen, rounds, budget_s, memory))
    return AreaResult(
        name=area.name,
        question=area.question,
        meaning=area.meaning,
        size=size.value,
        machine=machine(tuple(area.peers.values())),
        absent=area.absent,
        missing=tuple(missing),
        cases=tuple(results),
    )


def _cases(area: Area, size: Size, missing: list[str], older: bool) -> Iterator[Case]:
    for part in area.parts:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                cases = list(part(size))
        except NotHere as error:
            missing.append(str(error))
            continue
        except (ImportError, AttributeError, TypeError) as error:
            if not older:
                raise
            missing.append(f"{part.__name__}, not in this revision: {error}")
            continue
        yield from cases


def _chosen(case: Case, only: str, ours_alone: bool) -> Case | None:
    """The case with the ways asked for, its first always; None where nothing was asked of it."""
    first, *others = case.ways
    if only and only.lower() not in case.name.lower():
        others = [way for way in others if only.lower() in f"{way.library} {way.name}".lower()]
        if not others:
            return None
    if ours_alone:
        others = [way for way in others if way.ours]
    return replace(case, ways=(first, *others))


def _measured(case: Case, rounds: int, budget_s: float, memory: bool) -> CaseResult:
    rows: dict[Way, Row] = {}
    first: dict[Way, tuple[float, Any]] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what peers warn of, their errors show
        for way in case.ways:
            try:
                first[way] = first_call(way.run)
            except Exception as error:  # peers break with versions of other libraries
                rows[way] = Row(way.library, way.name, way.work, way.note, way.ours, failed=_said(error))
        pin_loaded()
        times = timed(
            [way.run for way in first], [seconds for seconds, _ in first.values()], rounds=rounds, budget_s=budget_s
        )
        reference = times[0] if times and case.ways[0] in first else None
        for (way, (_, output)), time in zip(first.items(), times, strict=True):
            rows[way] = _row(case, way, time, output, None if time is reference else reference, memory)
    ordered = tuple(rows[way] for way in case.ways)
    return CaseResult(case.name, case.size, case.size_unit, case.error_unit, case.truth, case.family, ordered)


def _said(error: Exception) -> str:
    return f"{type(error).__name__}: {next(iter(str(error).splitlines()), '')}"[:120]


def _row(case: Case, way: Way, time: Timed, output: Any, reference: Timed | None, memory: bool) -> Row:
    error = case.error_of(way, output)
    return Row(
        library=way.library,
        name=way.name,
        work=way.work,
        note=way.note,
        ours=way.ours,
        first_ms=1e3 * time.first_s,
        rounds=time.known_s.size,
        **(_times(time, reference) if time.known_s.size else {}),
        error=error,
        digits=digits_of(error) if error is not None and case.error_unit == "relative" else None,
        peak_mb=peak_mb(way.run) if memory else None,
    )


def _times(time: Timed, reference: Timed | None) -> dict[str, Any]:
    return {
        "least_ms": 1e3 * time.least_s,
        "median_ms": 1e3 * time.median_s,
        "iqr_ms": 1e3 * time.iqr_s,
        "ratio": reference and time.ratio_to(reference),
    }
