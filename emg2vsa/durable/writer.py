"""Who waits for the disk: the caller, or a thread, so that neither a control loop nor a session ever does.

Writes reach the system one after the other, in the order in which they were asked for. Only a line that is sealed comes
later than its turn: after everything that waits with it, once that has reached the disk itself (fsync). Then the line
reaches it too, before the next one is written: so whatever a sealed line speaks of is there when the line is.

A write that is refused ends an `AppendFile`, and is told at the next call, once. A `SealedFile` keeps what was refused:
the disk is asked again every half second, nothing else is written meanwhile, and ``trouble`` says so.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import NamedTuple, Protocol

from emg2vsa.durable.system import SYSTEM, OperatingSystem
from emg2vsa.errors import DeviceError

LARGEST_QUEUE = 2000
"""Writes that may wait: five seconds of a run with all its frames and forces, some 20 MB."""
LARGEST_WAITING_BYTES = 64_000_000
"""Most bytes of pieces that are kept: two minutes of 64 channels at 2000 Hz. Those beyond are given up."""
DISK_TROUBLE = "The disk does not take the recording"
"""How the sentence of `Writer.trouble` begins."""
_AGAIN_S = 0.5


class _Sealed(Protocol):
    pending_bytes: int

    def write_all(self) -> None: ...

    def close(self) -> None: ...


class _Once(NamedTuple):
    write: Callable[..., None]
    given: tuple[object, ...]


class _Kept(NamedTuple):
    write: Callable[[bytes], None]
    content: bytes
    is_line: bool


_Write = _Once | _Kept | threading.Event


class Writer:
    """Writes of one recording: in a thread, or (``background`` false) within the call, for virtual time.

    What kills the program takes the writes that wait: of a disk that is not held up, no more than the newest turn.
    """

    def __init__(self, *, background: bool, system: OperatingSystem = SYSTEM) -> None:
        self.system = system
        self.sealed_files: list[_Sealed] = []
        self.trouble = ""
        "Sentence on what the disk refuses; empty while it takes everything."
        self.sealed_lines = 0
        "Lines that have reached the disk itself."
        self._asked: SimpleQueue[_Write | None] = SimpleQueue()
        self._taken: deque[_Write] = deque()
        "Writes that the worker has taken over and not done."
        self._asking = threading.Lock()  # of those who ask; the worker never holds it
        self._asked_bytes = self._done_bytes = 0
        self._refused: deque[BaseException] = deque()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._work, name="writer", daemon=True) if background else None
        if self._thread:
            self._thread.start()

    def do(self, write: Callable[..., None], *given: object) -> None:
        """Do ``write(*given)`` once, now or soon. DeviceError: this write, or one before it, was refused."""
        if self._thread is None:
            write(*given)
            return
        self._tell()
        if (waiting := self._asked.qsize() + len(self._taken)) >= LARGEST_QUEUE:
            raise DeviceError(
                "the disk of the run", wanted="one that keeps up with the control loop",
                found=f"{waiting} writes that wait",
                do="Record to a disk of this computer, and look for programs that hold it up.",
            )  # fmt: skip
        self._asked.put(_Once(write, given))

    def keep(self, write: Callable[[bytes], None], piece: bytes) -> bool:
        """Do ``write(piece)``, which keeps the piece until the disk takes it. False where too many wait for that."""
        with self._asking:
            if self._asked_bytes - self._done_bytes + len(piece) > LARGEST_WAITING_BYTES:
                return False
            self._ask(_Kept(write, piece, False))
        return True

    def seal(self, write: Callable[[bytes], None], line: bytes) -> None:
        """Do ``write(line)``, which brings it to the disk itself, after everything that was asked for before."""
        with self._asking:
            self._ask(_Kept(write, line, True))

    def wait(self, timeout_s: float | None = None) -> bool:
        """Return when everything asked for before is done, or after the time, s; whether it is."""
        if self._thread is None:
            return self._work_off()
        done = threading.Event()
        self._asked.put(done)
        return done.wait(timeout_s)

    def finish(self) -> None:
        """Return when everything is done. DeviceError: a write was refused."""
        self.wait()
        self._tell()

    def close(self) -> None:
        """Do what waits, and give sealed files back. DeviceError where the disk still does not take those."""
        self._closing.set()
        if self._thread:
            self._asked.put(None)
            self._thread.join()
        else:
            self._work_off()
        left = self._asked_bytes - self._done_bytes + sum(file.pending_bytes for file in self.sealed_files)
        for file in self.sealed_files:
            file.close()
        self.sealed_files = []
        if left:
            raise DeviceError(
                "the disk of the session", wanted="room for what was recorded last",
                found=f"{left} bytes that were not written ({self.trouble})",
                do="Free some disk space; everything recorded before is whole. Go on with --resume.",
            )  # fmt: skip

    def _ask(self, write: _Kept) -> None:
        self._asked_bytes += len(write.content)
        self._asked.put(write)
        if self._thread is None:
            self._work_off()

    def _tell(self) -> None:
        if self._refused:
            first = self._refused.popleft()
            self._refused.clear()  # a file that refused one write refuses those after it
            raise first

    def _work(self) -> None:
        while (first := self._asked.get()) is not None:
            self._taken.append(first)
            while not self._work_off():
                if self._closing.wait(_AGAIN_S):
                    self._work_off()
                    return
        self._work_off()

    def _work_off(self) -> bool:
        """Do what waits. False where the disk refuses what is kept; it waits still."""
        try:
            if self.trouble:  # before more is taken: what waits is counted, and must not grow into the memory
                self._seal_all()
            while self._take():
                self._write_pieces()
                self._write_lines()
            if self._closing.is_set():
                self._seal_all()
        except OSError as error:
            self.trouble = f"{DISK_TROUBLE}: {error.strerror or error}. Free some disk space."
            return False
        self.trouble = ""
        return True

    def _take(self) -> bool:
        """Take over what was asked for; whether anything is to be done."""
        try:
            while (write := self._asked.get_nowait()) is not None:
                self._taken.append(write)
            self._asked.put(None)  # the end is for the thread to see
        except Empty:
            pass
        return bool(self._taken)

    def _write_pieces(self) -> None:
        """All but lines and those who wait. A line may speak of fewer samples than have reached the disk, never of
        more: so lines that wait together share the time that samples take to reach the disk itself."""
        later: list[_Write] = []
        try:
            while self._taken:
                write = self._taken.popleft()
                if isinstance(write, _Once):
                    self._do_once(write)
                elif isinstance(write, _Kept) and not write.is_line:
                    self._done_bytes += len(write.content)
                    write.write(write.content)
                else:
                    later.append(write)
        finally:
            self._taken.extendleft(reversed(later))

    def _write_lines(self) -> None:
        while self._taken:
            line = self._taken[0]
            if isinstance(line, _Kept):
                self._seal_all()
                line.write(line.content)
                self.sealed_lines += 1
                self._done_bytes += len(line.content)
            elif isinstance(line, threading.Event):
                self.trouble = ""  # whoever waited will look
                line.set()
            self._taken.popleft()

    def _do_once(self, write: _Once) -> None:
        try:
            write.write(*write.given)
        except BaseException as error:  # told where it is waited for, in the loop
            self._refused.append(error)

    def _seal_all(self) -> None:
        for file in self.sealed_files:
            file.write_all()


AT_ONCE = Writer(background=False)
"""The caller waits for every write."""
