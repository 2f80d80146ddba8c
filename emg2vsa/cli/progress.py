"""What a run shows: a bar on a terminal, one line per stage elsewhere; always on the error stream."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TextIO

from casr.terminal import VOICE
from emg2vsa.pipeline.plan import Step
from emg2vsa.pipeline.run_study import Progress

_BAR_WIDTH = 24


@dataclass
class Screen:
    """Progress of one wave of steps after the other."""

    stream: TextIO
    explain: bool = False
    _stage: str = ""
    _total: int = 0
    _done: int = 0
    _failed: int = 0
    _start: float = 0.0

    def begin(self, stage: str, total: int) -> None:
        self._stage, self._total, self._done, self._failed, self._start = stage, total, 0, 0, time.monotonic()
        self._draw()

    def step(self, step: Step) -> None:
        self._done += 1
        if step.status == "failed":
            self._failed += 1
        elif self.explain and step.reasons:
            self.say(f"{step.id}: {shortened(step.reasons)}")
        self._draw()

    def advance(self, done: int) -> None:
        self._done = done
        self._draw()

    def end(self) -> None:
        seconds = time.monotonic() - self._start
        done = self._done - self._failed
        failed = f", {self._failed} failed" if self._failed else ""
        self.say(f"{self._stage}: {done} of {self._total} done{failed}, {seconds:.1f} s")

    def _draw(self) -> None:
        if not self.stream.isatty():
            return
        share = self._done / max(self._total, 1)
        left = (time.monotonic() - self._start) * (1 / share - 1) if share else 0.0
        bar = "#" * round(_BAR_WIDTH * share)
        eta = f", about {left:.0f} s left" if share else ""
        self.stream.write(f"\r\x1b[K{self._stage} [{bar:<{_BAR_WIDTH}}] {self._done}/{self._total}{eta}")
        self.stream.flush()

    def say(self, text: str) -> None:
        clear = "\r\x1b[K" if self.stream.isatty() else ""
        self.stream.write(f"{clear}{text}\n")
        self.stream.flush()


def shortened(reasons: tuple[str, ...], most: int = 3) -> str:
    """The first few reasons and how many more there are."""
    more = f" and {len(reasons) - most} more" if len(reasons) > most else ""
    return ", ".join(reasons[:most]) + more


def progress(explain: bool = False, quiet: bool = False) -> Progress:
    """Progress for a terminal or a log; none when ``quiet``, nor with ``-q``. ``-v`` explains too."""
    screen = Screen(sys.stderr, explain or VOICE.verbose)
    if quiet or VOICE.quiet:
        return Progress(lambda stage, total: None, lambda step: None, lambda: None, screen.say)
    return Progress(screen.begin, screen.step, screen.end, screen.say)


def counter(what: str) -> Callable[[int, int, str], None]:
    """A bar for work that is not a study's steps: called with done, total and the name of the thing at hand."""
    screen = Screen(sys.stderr)

    def show(done: int, total: int, name: str) -> None:
        if VOICE.quiet:
            return
        if done <= 1:
            screen.begin(what, total)
        screen.advance(done)
        if done == total:
            screen.end()

    return show
