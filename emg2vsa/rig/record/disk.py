"""Who waits for the disk: the caller, or a thread, so that a control loop never does."""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from collections.abc import Callable, Iterator
from queue import SimpleQueue
from typing import Protocol

from emg2vsa.errors import DeviceError

LARGEST_QUEUE = 2000
"""Writes that may wait: five seconds of a run with all its frames and forces, some 20 MB."""


class Disk(Protocol):
    """Does writes in their order."""

    def do(self, write: Callable[[], None]) -> None:
        """Do ``write``, now or soon. DeviceError: this write, or one before it, was refused."""

    def finish(self) -> None:
        """Return when all writes are done. DeviceError: one was refused."""


class _AtOnce:
    def do(self, write: Callable[[], None]) -> None:
        write()

    def finish(self) -> None:
        """Nothing waits."""


AT_ONCE: Disk = _AtOnce()
"""The caller waits for every write."""


class DiskThread:
    """Writes in a thread; a write that is refused is told at the next call, once.

    Writes reach the system one after the other and a moment later than they are asked for, so that what kills the
    program takes those that wait: of a disk that is not held up, no more than the newest turn.
    """

    def __init__(self) -> None:
        self._waiting: SimpleQueue[Callable[[], object] | None] = SimpleQueue()
        self._refused: deque[BaseException] = deque()
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def do(self, write: Callable[[], None]) -> None:
        self._tell()
        if self._waiting.qsize() >= LARGEST_QUEUE:
            raise DeviceError(
                "the disk of the run",
                wanted="one that keeps up with the control loop",
                found=f"{self._waiting.qsize()} writes that wait",
                do="Record to a disk of this computer, and look for programs that hold it up.",
            )
        self._waiting.put(write)

    def finish(self) -> None:
        done = threading.Event()
        self._waiting.put(done.set)
        done.wait()
        self._tell()

    def close(self) -> None:
        """End the thread when all writes are done."""
        self._waiting.put(None)
        self._thread.join()

    def _tell(self) -> None:
        if self._refused:
            first = self._refused.popleft()
            self._refused.clear()  # a file that refused one write refuses those after it
            raise first

    def _work(self) -> None:
        while (write := self._waiting.get()) is not None:
            try:
                write()
            except BaseException as error:  # told where it is waited for, in the loop
                self._refused.append(error)


@contextlib.contextmanager
def disk_for(background: bool) -> Iterator[Disk]:
    """Writes in a thread of their own, or each at once."""
    if not background:
        yield AT_ONCE
        return
    disk = DiskThread()
    try:
        yield disk
    finally:
        disk.close()
