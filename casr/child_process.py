"""A child process that answers this one: how it starts, how both talk, what it died of, and that it ends with this one.

`Child` is the parent's end. The child is a new Python with the modules of this one, one thread for linear algebra, and
nothing open but two pipes, whose other ends are the `Pipes` that ``module.function`` is called with. Ctrl-C is for the
parent. The child ends when the parent closes its pipes, and with the parent, also where that is killed: on Linux at
once, whatever it is doing; elsewhere with its next message. It is scheduled as an ordinary program, also where the
parent is not.

A message in a pipe is its length and its bytes.
"""

from __future__ import annotations

import atexit
import contextlib
import faulthandler
import importlib
import os
import select
import signal
import struct
import sys
import time
import weakref
from collections.abc import Iterator
from io import FileIO
from typing import Any

import numpy as np

from casr.one_thread import VARIABLES

HEAD = struct.Struct("<Q")
_MB = 1_000_000
_END_SECONDS = 5.0
_WATCHDOG_AFTER_SECONDS = 2.0
_PEEK_SECONDS = 0.002
_KEPT = {"MALLOC_MMAP_THRESHOLD_": str(8 * _MB), "MALLOC_TRIM_THRESHOLD_": str(32 * _MB)}
"""For glibc: a child keeps so much memory from one request to the next. Pages that are taken anew for the arrays of a
recording cost more than its decoding."""
_FROM_OUTSIDE = frozenset(
    getattr(signal, name) for name in ("SIGKILL", "SIGTERM", "SIGHUP", "SIGXCPU") if hasattr(signal, name)
)
"""Signals that no fault of a program sends. The system sends SIGKILL where memory runs out."""


class Pipes:
    """What comes from the other process, and what goes to it. OSError or EOFError where it has gone."""

    def __init__(self, from_other: FileIO, to_other: FileIO) -> None:
        self.from_other, self.to_other = from_other, to_other

    def send(self, message: bytes) -> None:
        """Wait until the pipe has taken it. BlockingIOError where the pipe is not to be waited for, and is full."""
        write_whole(self.to_other, HEAD.pack(len(message)) + message)

    def receive(self) -> np.ndarray[Any, Any]:
        """(n,) uint8, the next message."""
        (size,) = HEAD.unpack(read_whole(self.from_other, HEAD.size).data)
        return read_whole(self.from_other, size)

    def readable(self, seconds: float = 0.0) -> bool:
        """Whether a message has begun to come within the time, or none will come any more."""
        if sys.platform == "win32":
            import _winapi  # noqa: PLC0415  (there is none elsewhere)
            import msvcrt  # noqa: PLC0415

            deadline = time.monotonic() + seconds
            handle = msvcrt.get_osfhandle(self.from_other.fileno())
            with contextlib.suppress(OSError):
                while not _winapi.PeekNamedPipe(handle)[0]:
                    if time.monotonic() >= deadline:
                        return False
                    time.sleep(_PEEK_SECONDS)
            return True
        poll = select.poll()
        poll.register(self.from_other, select.POLLIN)
        return bool(poll.poll(1e3 * seconds))

    def close(self) -> None:
        for end in (self.to_other, self.from_other):
            with contextlib.suppress(OSError):
                end.close()


class Child:
    """The parent's end of a process in which ``module.function(pipes, *arguments)`` runs.

    module, function : imported in the child only. arguments : numbers. quiet : what it writes to stderr is thrown away.
    nice : less is more of the processor, where the system permits that. OSError : it could not be started.
    """

    def __init__(self, module: str, function: str, *arguments: int, quiet: bool, nice: int = 0) -> None:
        import subprocess  # noqa: PLC0415  (the child has no use for them)
        import threading  # noqa: PLC0415

        how: dict[str, Any] = {}
        self._lifeline: FileIO | None = None
        childs_end = -1
        if sys.platform == "win32":
            how["creationflags"] = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
        else:
            how["process_group"] = 0
        if sys.platform == "linux":
            childs_end, ours = os.pipe()
            self._lifeline = FileIO(ours, "w")
            how["pass_fds"] = [childs_end]
        search = os.pathsep.join(os.path.abspath(folder) for folder in sys.path)
        call = f"begin({module!r}, {function!r}, {arguments!r}, {childs_end}, {nice})"
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", f"from casr.child_process import begin; {call}"],
                env=_KEPT | os.environ | {"PYTHONPATH": search} | dict.fromkeys(VARIABLES, "1"),
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL if quiet else None,
                bufsize=0, **how,
            )  # fmt: skip
        finally:
            if childs_end >= 0:
                os.close(childs_end)
        assert isinstance(self._process.stdin, FileIO)
        assert isinstance(self._process.stdout, FileIO)
        self.pipes = Pipes(self._process.stdout, self._process.stdin)
        self._open, self._ending = True, threading.RLock()
        _children.add(self)

    @property
    def alive(self) -> bool:
        """Whether it runs, and can be asked."""
        if self._open and self._process.poll() is not None:
            self.end()
        return self._open

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def wait(self, seconds: float = _END_SECONDS) -> int | None:
        """Its exit code, negative for a signal, once it has ended; None where it still runs after the time."""
        deadline = time.monotonic() + seconds
        while (code := self._process.poll()) is None and time.monotonic() < deadline:
            time.sleep(_PEEK_SECONDS)
        return code

    def died_of(self) -> tuple[str, bool]:
        """Why it has ended, in words, and whether somebody else killed it. It is ended where it has not."""
        code = self.wait()
        self.end()
        if code is None:
            return "no valid answer", False
        if code >= 0:
            return f"exit code {code}", False
        return (signal.strsignal(-code) or f"signal {-code}").lower(), -code in _FROM_OUTSIDE

    def close(self, seconds: float) -> int | None:
        """Let it end by itself, and end it after the time; its exit code, None where it had to be ended."""
        self.pipes.close()
        code = self.wait(seconds)
        self.end()
        return code

    def end(self) -> None:
        """End it at once; a second time does nothing."""
        with self._ending:  # a descriptor that is closed twice may be another's by then
            if self._open:
                self._process.kill()
                self._process.wait()
                self.let_go()

    def let_go(self) -> None:
        """Close what this process has of it."""
        self._open = False
        self.pipes.close()
        if self._lifeline is not None:
            self._lifeline.close()


_children: weakref.WeakSet[Child] = weakref.WeakSet()


def _end_children() -> None:
    for child in tuple(_children):
        child.end()


def _let_go_of_children() -> None:
    """After a fork: they belong to the parent of this process."""
    for child in tuple(_children):
        child.let_go()
    _children.clear()


atexit.register(_end_children)
if sys.platform != "win32":
    os.register_at_fork(after_in_child=_let_go_of_children)


def begin(module: str, function: str, arguments: tuple[int, ...], lifeline: int, nice: int) -> None:
    """The child's life.

    lifeline : descriptor of a pipe that the parent holds open and never writes to; -1: there is none.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    pipes = Pipes(FileIO(os.dup(0), "r"), FileIO(os.dup(1), "w"))
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)  # what foreign code prints must not be taken for an answer
    if sys.platform == "linux":
        if lifeline >= 0:
            _die_with_parent(lifeline)
        with contextlib.suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
            os.nice(nice)
    with contextlib.suppress(EOFError, BrokenPipeError):  # the parent has closed its ends
        getattr(importlib.import_module(module), function)(pipes, *arguments)
    os._exit(0)


def _die_with_parent(lifeline: int) -> None:
    """Linux signals the end of the lifeline; unhandled, that signal ends a process whatever it is doing.

    The pipe of messages would not do: the signal of a message may come when the child works on it already.
    """
    if sys.platform == "linux":
        import fcntl  # noqa: PLC0415  (there is none on Windows)

        fcntl.fcntl(lifeline, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(lifeline, fcntl.F_SETFL, fcntl.fcntl(lifeline, fcntl.F_GETFL) | os.O_ASYNC)
        if select.select([lifeline], [], [], 0)[0]:  # it ended before
            os._exit(0)


@contextlib.contextmanager
def limited(seconds: float, memory_mb: float) -> Iterator[None]:
    """In the child: memory limited by the system, where it does; and a watchdog that needs no interpreter lock, in case
    the parent cannot keep time.

    seconds : that the child may work; the watchdog ends it 2 s later.
    memory_mb : of data, MB.
    """
    if sys.platform != "win32":
        import resource  # noqa: PLC0415  (there is none on Windows)

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        asked = int(memory_mb * _MB)
        resource.setrlimit(resource.RLIMIT_DATA, (asked if hard < 0 else min(asked, hard), hard))
    # stdin is nowhere by now
    faulthandler.dump_traceback_later(seconds + _WATCHDOG_AFTER_SECONDS, exit=True, file=0)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()


def read_whole(file: FileIO, size: int) -> np.ndarray[Any, Any]:
    """(size,) uint8. Raises EOFError where the file ends before."""
    part = np.empty(size, np.uint8)
    filled = 0
    while filled < size:
        got = file.readinto(part[filled:].data)
        if not got:
            raise EOFError
        filled += got
    return part


def write_whole(file: FileIO, part: Any) -> None:
    """Write all bytes of a part, in as many turns as the pipe takes. BlockingIOError : the pipe takes nothing now."""
    rest = memoryview(part).cast("B")
    while rest:
        taken = file.write(rest)
        if taken is None:
            raise BlockingIOError
        rest = rest[taken:]
