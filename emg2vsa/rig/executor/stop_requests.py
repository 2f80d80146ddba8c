"""What asks a run to stop: a signal of the system, Ctrl-C, or a file named ``stop`` in the folder of the run."""

from __future__ import annotations

import signal
import threading
from pathlib import Path
from types import FrameType
from typing import Any, Self

from casr.atomic import write_text_atomic

STOP_FILE = "stop"
_NAMES = ("SIGTERM", "SIGHUP", "SIGQUIT", "SIGINT")  # not every system has SIGHUP and SIGQUIT
_LONGEST_TEXT = 200
_LOOK_S = 0.01


class StopRequests:
    """Called, tells the reason to stop, or None: the ``stop`` of `execute`. Signals are caught within a with statement.

    The first Ctrl-C is a request like the others. A second one interrupts, as Ctrl-C does otherwise, but only once, and
    only where the first has not been told yet: a loop that hangs is cut off, the way out that has begun is not. To be
    used in the main thread, which is where Python delivers signals.
    """

    def __init__(self, folder: Path) -> None:
        """``folder`` : of the run; whoever makes a file ``stop`` there gives its text as the reason."""
        self._file = folder / STOP_FILE
        self._reason: str | None = None
        self._told = self._interrupted = False
        self._before: dict[signal.Signals, Any] = {}
        self._watch: threading.Thread | None = None
        self._over = threading.Event()

    def __call__(self) -> str | None:
        if self._reason is None and self._watch is None:
            self._reason = self._asked_by_file()
        self._told = self._reason is not None
        return self._reason

    def __enter__(self) -> Self:
        for name in _NAMES:
            if number := getattr(signal, name, None):
                self._before[number] = signal.signal(number, self._caught)
        # a disk that is held up holds up this thread, and not the control loop
        self._watch = threading.Thread(target=self._look_on, daemon=True)
        self._watch.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._over.set()
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _caught(self, number: int, frame: FrameType | None) -> None:
        if number == signal.SIGINT and self._reason and not (self._told or self._interrupted):
            self._interrupted = True
            raise KeyboardInterrupt
        name = "Ctrl-C" if number == signal.SIGINT else signal.Signals(number).name
        self._reason = self._reason or name

    def _look_on(self) -> None:
        while self._reason is None and not self._over.wait(_LOOK_S):
            found = self._asked_by_file()
            self._reason = self._reason or found

    def _asked_by_file(self) -> str | None:
        try:
            text = self._file.read_text(encoding="utf-8", errors="replace")
        except OSError:
            return None
        return " ".join(text.split())[:_LONGEST_TEXT] or f"file {STOP_FILE}"


def request_stop(folder: Path, reason: str) -> None:
    """Ask the run in ``folder`` to stop, for this reason; a request that is there stays as it is.

    OSError when the disk refuses.
    """
    path = folder / STOP_FILE
    if not path.exists():
        write_text_atomic(path, f"{reason}\n")


def stop_requested(folder: Path) -> bool:
    """Has the run in ``folder`` been asked to stop, by whomever?"""
    return (folder / STOP_FILE).exists()
