"""A line for each press while a run goes on, from the log, so that no terminal can hold up the control loop."""

from __future__ import annotations

import contextlib
import sys
import threading
from pathlib import Path
from types import TracebackType
from typing import Self

_LOOK_S = 0.2
_TAIL_BYTES = 512


class PressLines:
    """Says on the error stream which presses are over, from `__enter__` to `__exit__`."""

    def __init__(self, folder: Path, repetitions: int) -> None:
        self._log, self._repetitions, self._said = folder / "log.csv", repetitions, 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()
        self._thread.join()

    def _watch(self) -> None:
        # no log yet, or nobody who reads: the run goes on all the same
        while not self._ended.wait(_LOOK_S):
            with contextlib.suppress(OSError, IndexError):
                self._look()

    def _look(self) -> None:
        with self._log.open("rb") as log:
            log.seek(max(0, self._log.stat().st_size - _TAIL_BYTES))
            lines = log.read().decode("ascii").split("\n")
        time_s, repetition, phase = lines[-2].split(",")[:3]  # what follows the last line end is no whole row
        if repetition == "repetition":
            return
        done = int(repetition) - (phase not in ("pause", "done"))
        for press in range(self._said + 1, done + 1):
            print(f"press {press} of {self._repetitions} done at {float(time_s):.1f} s", file=sys.stderr, flush=True)
        self._said = max(self._said, done)
