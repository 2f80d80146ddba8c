"""One task done by this package and by others: timed together, each with the digits of what it returns."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mpmath import mp, mpf

Numbers = Mapping[str, Any]
"""Arrays by name; a library leaves out what it does not give."""
Run = Callable[[], Numbers]
Exact = Mapping[str, Mapping[Any, mpf]]
"""Of some of the numbers: name, index into the array, value."""

REPEATS = 9
SECONDS_EACH = 2.0
"""Processor time after which a run is not repeated any more."""
CAP = 16.0
SMALLEST = mpf("1e-15")
"""An error below this counts as none of the 13 digits wanted, however small a p is."""


@dataclass(frozen=True)
class Peer:
    """Another way to the same numbers; noted: how many times slower the statistics notes (3e) found it."""

    name: str
    run: Run
    noted: float | None = None


@dataclass(frozen=True)
class Task:
    title: str
    ours: Run
    peers: tuple[Peer, ...]
    exact: Callable[[], Exact]
    note: str = ""


@dataclass(frozen=True)
class Measured:
    """seconds, digits : by the name of the way, ours under ''. ratio of a peer: times slower than ours."""

    task: Task
    seconds: dict[str, float]
    digits: dict[str, dict[str, float]] = field(repr=False)

    def ratio(self, peer: Peer) -> float:
        return self.seconds[peer.name] / self.seconds[""]

    def met(self, peer: Peer) -> bool:
        """At least half the ratio noted; also where none is."""
        return peer.noted is None or self.ratio(peer) >= peer.noted / 2


def measured(task: Task) -> Measured:
    """Time and digits of every way, printed."""
    runs = {"": task.ours} | {peer.name: peer.run for peer in task.peers}
    seconds = best_times(runs)
    exact = task.exact()
    found = Measured(task, seconds, {name: digits(run(), exact) for name, run in runs.items()})
    _show(found, list(exact))
    return found


def best_times(runs: dict[str, Run]) -> dict[str, float]:
    """Smallest processor time of each run, repeats interleaved; short runs are repeated more often."""
    best, spent = dict.fromkeys(runs, float("inf")), dict.fromkeys(runs, 0.0)
    for _ in range(REPEATS):
        for name, run in runs.items():
            for _ in range(20 if best[name] < 0.02 else int(spent[name] < SECONDS_EACH)):
                start = time.process_time()
                run()
                took = time.process_time() - start
                best[name], spent[name] = min(best[name], took), spent[name] + took
    return best


def digits(found: Numbers, exact: Exact) -> dict[str, float]:
    """Fewest correct digits of each number over the indices that are known exactly."""
    return {
        name: min(_digits(np.asarray(found[name])[index], truth) for index, truth in values.items())
        for name, values in exact.items()
        if name in found
    }


def _digits(value: Any, truth: mpf) -> float:
    if not np.isfinite(value):
        return 0.0
    error = abs(mpf(float(value)) - truth)
    relative = error / abs(truth) if truth else error
    return CAP if relative == 0 else float(min(CAP, max(0, -mp.log10(relative))))


def _show(found: Measured, names: list[str]) -> None:
    width = [max(6, len(name) + 2) for name in names]
    heads = "".join(f"{name:>{w}}" for name, w in zip(names, width, strict=True))
    print(f"\n{found.task.title}\n{'':48}{'ms':>9}{'ours is':>10}{'wanted':>9}      digits of{heads}")
    for peer in (None, *found.task.peers):
        key = "" if peer is None else peer.name
        given = found.digits[key]
        shown = "".join(f"{given[name]:{w}.1f}" if name in given else f"{'-':>{w}}" for name, w in zip(names, width, strict=True))
        print(f"{key or 'emg2vsa':48}{1e3 * found.seconds[key]:9.2f}{_ratio(found, peer)}{'':15}{shown}", flush=True)
    if found.task.note:
        print(found.task.note)


def _ratio(found: Measured, peer: Peer | None) -> str:
    if peer is None:
        return " " * 19
    wanted = "" if peer.noted is None else f"{peer.noted / 2:7.0f}x"
    mark = "" if found.met(peer) else "*"
    return f"{found.ratio(peer):9.1f}x{wanted + mark:>9}"
