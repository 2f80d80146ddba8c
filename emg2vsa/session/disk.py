"""Files of a session that only grow, written in an order that survives a loss of power.

``lay`` adds to a file and never waits. ``seal`` adds to a file only after everything that was laid before has reached
the disk itself (fsync), and then reaches the disk itself: so whatever a sealed line speaks of is there when the line
is. A disk that refuses (full, unplugged) is asked again every half second; until it takes what waits, ``trouble`` says
so, and what a file holds beyond its last seal is written again, so that nothing is damaged and nothing is lost that
still fits into memory.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import threading
from collections import deque
from pathlib import Path
from typing import NamedTuple, Protocol

from emg2vsa.errors import DeviceError

LARGEST_WAITING_BYTES = 64_000_000
"""Samples that may wait for the disk: two minutes of 64 channels at 2000 Hz. Those beyond are given up, and counted."""
_SEAL_BYTES = 1_000_000
"""Samples are brought to the disk itself after so many bytes, if no line asks for it sooner."""
_AGAIN_S = 0.5
_BINARY = getattr(os, "O_BINARY", 0)
"""Windows would write a carriage return before every line feed."""


class System(Protocol):
    """The calls of the operating system that a session makes; an argument, so that a test can cut the power."""

    def open(self, path: Path) -> int:
        """Open a file for writing, made where it is missing; its folder is known to the disk itself afterwards."""

    def write(self, handle: int, offset: int, piece: bytes) -> None:
        """Write all of a piece. OSError where the disk does not take all of it."""

    def truncate(self, handle: int, size: int) -> None:
        """Cut a file."""

    def sync(self, handle: int) -> None:
        """Return when what was written to a file has reached the disk itself."""

    def close(self, handle: int) -> None:
        """Give a file back."""

    def rename(self, path: Path, to: Path) -> None:
        """Give a file another name, which is known to the disk itself afterwards."""


class OperatingSystem:
    """The real one."""

    def open(self, path: Path) -> int:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | _BINARY, 0o644)
        sync_folder(path.parent)
        return handle

    def write(self, handle: int, offset: int, piece: bytes) -> None:
        os.lseek(handle, offset, os.SEEK_SET)
        view = memoryview(piece)
        while view:
            view = view[os.write(handle, view) :]

    def truncate(self, handle: int, size: int) -> None:
        os.ftruncate(handle, size)

    def sync(self, handle: int) -> None:
        os.fsync(handle)

    def close(self, handle: int) -> None:
        os.close(handle)

    def rename(self, path: Path, to: Path) -> None:
        os.replace(path, to)
        sync_folder(path.parent)


SYSTEM: System = OperatingSystem()


def sync_folder(folder: Path) -> None:
    """Names of files reach the disk itself; Windows has no such call, and its file systems need none."""
    if hasattr(os, "O_DIRECTORY"):
        handle = os.open(folder, os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def write_sealed(system: System, path: Path, content: bytes) -> None:
    """A file that is there whole, on the disk itself, or not at all. OSError where the disk does not take it."""
    unfinished = path.with_name(f".{path.name}.unfinished")
    handle = system.open(unfinished)
    try:
        system.truncate(handle, 0)
        system.write(handle, 0, content)
        system.sync(handle)
    finally:
        system.close(handle)
    system.rename(unfinished, path)


class GrowingFile:
    """A file, and what of it is on the disk itself: ``sealed`` bytes. ``pending_bytes`` more are to be written."""

    def __init__(self, path: Path, handle: int, size: int) -> None:
        self.path, self.handle, self.sealed = path, handle, size
        self.pending_bytes = self.given_up = 0
        "``given_up``: bytes that a full disk did not take in time."
        self._pending: list[bytes] = []
        self._written = self._written_bytes = 0
        "Of ``_pending``, what the system has taken."

    def add(self, piece: bytes) -> None:
        """Have a piece written next."""
        self._pending.append(piece)
        self.pending_bytes += len(piece)

    def write_pending(self, system: System) -> None:
        """Write what is not written. OSError where the disk does not take it; no part of it stays in the file."""
        if self._written == len(self._pending):
            return
        offset = self.sealed + self._written_bytes
        try:
            system.write(self.handle, offset, b"".join(self._pending[self._written :]))
        except OSError:
            with contextlib.suppress(OSError):  # the next attempt writes over what stays
                system.truncate(self.handle, offset)
            raise
        self._written, self._written_bytes = len(self._pending), self.pending_bytes

    def seal(self, system: System) -> None:
        """Write what is not written, and wait for the disk itself. OSError where it does not take all.

        After a failed fsync the system may have dropped the pages, so everything since the last seal is written again.
        """
        self.write_pending(system)
        if self._pending:
            try:
                system.sync(self.handle)
            except OSError:
                self._written = self._written_bytes = 0
                raise
            self.sealed += self.pending_bytes
            self._pending = []
            self._written = self._written_bytes = self.pending_bytes = 0


class _Piece(NamedTuple):
    file: GrowingFile
    content: bytes
    is_line: bool


class SessionDisk:
    """Writes of one session, in their order: in a thread, or (``background`` false) at once, for virtual time."""

    def __init__(self, *, background: bool, system: System = SYSTEM) -> None:
        self._system = system
        self._files: list[GrowingFile] = []
        self._waiting: deque[_Piece] = deque()
        self._waiting_bytes = 0
        self._changed = threading.Condition()
        self._trouble, self._closing = "", False
        self.sealed_lines = 0
        "Lines that have reached the disk itself."
        self._thread = threading.Thread(target=self._work, name="session disk", daemon=True) if background else None
        if self._thread:
            self._thread.start()

    def open(self, path: Path) -> GrowingFile:
        """A file to grow at its end, made where it is missing. DeviceError where the folder does not take it."""
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            handle = self._system.open(path)
            file = GrowingFile(path, handle, path.stat().st_size)
        except OSError as error:
            raise DeviceError(
                path, wanted="a file to record to", found=error.strerror or str(error),
                do="Check the folder, its permissions and the disk.",
            ) from error  # fmt: skip
        with self._changed:
            self._files.append(file)
        return file

    def lay(self, file: GrowingFile, content: bytes) -> bool:
        """Add samples. False where they were given up, because too much waits for a disk that refuses."""
        with self._changed:
            if self._waiting_bytes + len(content) > LARGEST_WAITING_BYTES:
                file.given_up += len(content)
                return False
            self._add(_Piece(file, content, False))
        self._now()
        return True

    def seal(self, file: GrowingFile, content: bytes) -> None:
        """Add a line after everything that was laid before."""
        with self._changed:
            self._add(_Piece(file, content, True))
        self._now()

    @property
    def trouble(self) -> str:
        """What the disk refuses, in a sentence; "" while it takes everything."""
        return self._trouble

    def wait(self, timeout_s: float = 30.0) -> bool:
        """Return when nothing waits any more, or after the time; whether nothing does."""
        if self._thread is None:
            self._now()
            return not self._trouble
        with self._changed:
            return self._changed.wait_for(lambda: not self._waiting and not self._trouble, timeout_s)

    def close(self) -> None:
        """Write and seal what waits, and give the files back. DeviceError where the disk still refuses."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        if self._thread:
            self._thread.join()
        else:
            self._now()
        left = self._waiting_bytes + sum(file.pending_bytes for file in self._files)
        for file in self._files:
            self._system.close(file.handle)
        self._files = []
        if left:
            raise DeviceError(
                "the disk of the session", wanted="room for what was recorded last",
                found=f"{left} bytes that were not written ({self._trouble})",
                do="Free some disk space; everything recorded before is whole. Go on with --resume.",
            )  # fmt: skip

    def _add(self, piece: _Piece) -> None:
        self._waiting.append(piece)
        self._waiting_bytes += len(piece.content)
        self._changed.notify_all()

    def _now(self) -> None:
        if self._thread is None:
            self._work_off()

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._closing)
                if self._closing and not self._waiting:
                    break
            if not self._work_off():
                with self._changed:
                    if self._changed.wait_for(lambda: self._closing, _AGAIN_S):
                        break
        self._work_off()

    def _work_off(self) -> bool:
        """Write what waits. False where the disk refuses; what was refused waits still."""
        try:
            for file in self._files:
                file.write_pending(self._system)
            if self._trouble:
                self._seal_what_was_refused()
            while self._waiting:
                self._lay_samples()
                self._seal_lines()
            if self._closing:
                for file in self._files:
                    file.seal(self._system)
        except OSError as error:
            self._trouble = f"The disk does not take the recording: {error.strerror or error}. Free some disk space."
            return False
        self._trouble = ""
        with self._changed:
            self._changed.notify_all()
        return True

    def _seal_what_was_refused(self) -> None:
        """Before more is taken: what waits is counted, and must not grow into the memory. A line comes in its turn."""
        for file in self._files:
            if not (self._waiting and self._waiting[0].is_line and self._waiting[0].file is file):
                file.seal(self._system)

    def _seal_lines(self) -> None:
        """The lines that wait before the next samples: the samples before them once, then each line by itself."""
        with self._changed:
            lines = list(itertools.takewhile(lambda piece: piece.is_line, self._waiting))
        for line in lines:
            for file in self._files:
                if file is not line.file:
                    file.seal(self._system)
            if not line.file.pending_bytes:  # else this line was refused before, and is there to be written again
                line.file.add(line.content)
            line.file.seal(self._system)
            self.sealed_lines += 1
            with self._changed:
                self._waiting_bytes -= len(self._waiting.popleft().content)

    def _lay_samples(self) -> None:
        """The samples that wait, those of a file in one write, also before the lines among them.

        A line may speak of fewer samples than have reached the disk, and never of more: so lines that wait together
        share the time that samples take to reach the disk itself.
        """
        with self._changed:
            pieces = [piece for piece in self._waiting if not piece.is_line]
            lines = [piece for piece in self._waiting if piece.is_line]
            self._waiting = deque(lines)
            self._waiting_bytes -= sum(len(piece.content) for piece in pieces)
        for piece in pieces:
            piece.file.add(piece.content)
        for file in self._files:
            if file.pending_bytes >= _SEAL_BYTES:
                file.seal(self._system)
            else:
                file.write_pending(self._system)
