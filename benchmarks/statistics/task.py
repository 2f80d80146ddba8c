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


@dataclass(frozen=True)
class Peer:
    """Another way to the same numbers. noted: the statistics notes (3e), times slower than ours, and milliseconds."""

    name: str
    run: Run
    noted: tuple[float, float] | None = None

    @property
    def wanted(self) -> float | None:
        """Half the ratio noted."""
        return self.noted and self.noted[0] / 2


@dataclass(frozen=True)
class Task:
    """noted_ms : what ours took on the machine of the notes."""

    title: str
    ours: Run
    peers: tuple[Peer, ...]
    exact: Callable[[], Exact]
    noted_ms: float | None = None
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
        """Also where nothing is wanted."""
        return peer.wanted is None or self.ratio(peer) >= peer.wanted


def measured(task: Task, repeats: int = REPEATS) -> Measured:
    """Time and digits of every way, printed."""
    runs = {"": task.ours} | {peer.name: peer.run for peer in task.peers}
    seconds = best_times(runs, repeats)
    exact = task.exact()
    found = Measured(task, seconds, {name: digits(run(), exact) for name, run in runs.items()})
    _show(found, list(exact))
    return found


def best_times(runs: dict[str, Run], repeats: int) -> dict[str, float]:
    """Smallest processor time of each run, repeats interleaved; short runs are repeated more often."""
    best, spent = dict.fromkeys(runs, float("inf")), dict.fromkeys(runs, 0.0)
    for _ in range(repeats):
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
    task, width = found.task, [max(6, len(name) + 2) for name in names]
    heads = "".join(f"{name:>{w}}" for name, w in zip(names, width, strict=True))
    print(f"\n{task.title}\n{'':45}{'ms':>9}{'noted ms':>10}{'ours is':>10}{'wanted':>9}   digits of{heads}")
    print(f"{'emg2vsa':45}{_times(found, '', task.noted_ms)}{'':19}{'':12}{_shown(found, '', names, width)}")
    for peer in task.peers:
        wanted = "" if peer.wanted is None else f"{peer.wanted:.0f}x" + ("" if found.met(peer) else "*")
        times = _times(found, peer.name, peer.noted and peer.noted[1])
        shown = _shown(found, peer.name, names, width)
        print(f"{peer.name:45}{times}{found.ratio(peer):9.1f}x{wanted:>9}{'':12}{shown}", flush=True)
    if task.note:
        print(task.note)


def _times(found: Measured, way: str, noted_ms: float | None) -> str:
    return f"{1e3 * found.seconds[way]:9.2f}" + ("" if noted_ms is None else f"{noted_ms:g}").rjust(10)


def _shown(found: Measured, way: str, names: list[str], width: list[int]) -> str:
    given = found.digits[way]
    return "".join((f"{given[n]:.1f}" if n in given else "-").rjust(w) for n, w in zip(names, width, strict=True))
