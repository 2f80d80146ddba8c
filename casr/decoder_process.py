"""Foreign decoders of binary files run in a child process, so that a file can bring down nothing but that child.

A library such as ezc3d, scipy.io or OpenCV may crash, never end or ask for all memory on a damaged file. This process
keeps one warm child. The child imports the decoder of a format once, holds the opened files, and sends back what the
decoder returns or raises. Arrays come back as arrays that can be written to. The child ends with this process.

One request is a pickle in a pipe. One answer is the number of its parts, their sizes, and the parts: a pickle, and the
buffers of its arrays. It tells too what the child imported by name: the parent's work hangs on that.

The time limit holds everywhere. The memory limit is the one of the operating system: it holds on Linux; macOS and
Windows do not enforce one. Ctrl-C ends a request at once, except on Windows, where it waits for the time limit.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import pickle
import sys
import threading
import time
import weakref
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from casr.by_name import module_named, noting, used
from casr.child_process import HEAD, Child, Pipes, limited, read_whole, write_whole

_MB = 1_000_000
_MEMORY_PER_FILE_SIZE = 10.0
_SECONDS_PER_BYTE = 1.0 / (10 * _MB)


@dataclass(frozen=True)
class Limits:
    """What one request may cost. The defaults are for a small file; see `for_file`."""

    seconds: float = 10.0
    memory_mb: float = 600.0

    def for_file(self, path: Path) -> Limits:
        """One second more for every 10 MB of the file, and ten times its size more memory."""
        try:
            size = path.stat().st_size
        except OSError:
            return self
        return Limits(self.seconds + size * _SECONDS_PER_BYTE, self.memory_mb + _MEMORY_PER_FILE_SIZE * size / _MB)


def serve(parent: Pipes) -> None:
    """The child's end: answer requests until the pipe ends."""
    objects: dict[int, Any] = {}
    while True:
        request, released, limits, folder = pickle.loads(parent.receive().data)
        for key in released:
            objects.pop(key, None)
        if folder:
            with contextlib.suppress(OSError):  # then no relative path leads anywhere
                os.chdir(folder)
        with limited(limits.seconds, limits.memory_mb):
            parts = _done(request, objects)
        sizes = [memoryview(part).nbytes for part in parts]
        if sum(sizes) > limits.memory_mb * _MB / 2:  # for it stands in memory twice
            parts = _pickled((False, MemoryError(), set()))
            sizes = [memoryview(part).nbytes for part in parts]
        write_whole(parent.to_other, HEAD.pack(len(parts)) + np.array(sizes, "<u8").tobytes())
        while parts:  # what was sent stands in the parent's memory, and must not stand here too
            write_whole(parent.to_other, parts.pop(0))


def _done(request: tuple[Any, ...], objects: dict[int, Any]) -> list[Any]:
    """The parts of the answer: a pickle, and the buffers that it refers to."""
    with noting() as named:
        try:
            return _pickled((True, _carried_out(request, objects), named))
        except Exception as raised:
            # what C++ says where Python says the other
            error = MemoryError() if "std::bad_alloc" in str(raised) else raised
            error.__cause__ = error.__context__ = error.__traceback__ = None
            try:
                return _pickled((False, error, named))
            except Exception:  # an exception of a library that cannot be sent
                return _pickled((False, RuntimeError(f"{type(error).__name__}: {error}"), named))


def _carried_out(request: tuple[Any, ...], objects: dict[int, Any]) -> Any:
    match request:
        case ("import", module):
            module_named(module)
            return None
        case ("make", key, module, function, arguments, told):
            objects[key] = made = getattr(sys.modules[module], function)(*arguments)
            return getattr(made, told) if told else None
        case ("ask", key, name, arguments):
            value = getattr(objects[key], name)
            return value(*arguments) if callable(value) else value
    raise ValueError(request)


def _pickled(value: Any) -> list[Any]:
    buffers: list[pickle.PickleBuffer] = []
    head = pickle.dumps(value, protocol=5, buffer_callback=buffers.append)
    return [head, *(buffer.raw() for buffer in buffers)]


START_SECONDS = 60.0
"""Limit on starting the child and importing a decoder; it is not the file's fault."""


class DecoderFailed(Exception):
    """The decoder crashed, did not end, or needed too much memory.

    reason : a clause, such as "its reader took more than 10 s". limit : which limit was met; None for a crash.
    """

    def __init__(self, reason: str, limit: Literal["seconds", "memory"] | None = None) -> None:
        self.reason, self.limit = reason, limit
        super().__init__(reason, limit)

    def __str__(self) -> str:
        return self.reason


class DecoderLost(DecoderFailed):
    """The child was killed from outside, or could not be started: the file may be sound."""


class InChild:
    """An object that lives in the child: ``module.function(*arguments)``, made anew when the child had to be replaced.

    library : named in the reason of a crash. module, function : what makes the object; imported in the child only.
    limits : of each request. told : an attribute whose value comes with the answer that it was made, as ``told``.
    DecoderFailed : the child crashed or met a limit. DecoderLost : it was killed, or could not be started. Whatever
        ``function`` raises is raised here too.
    """

    def __init__(
        self, library: str, module: str, function: str, arguments: tuple[Any, ...], limits: Limits, told: str = ""
    ) -> None:
        self._library, self._limits = library, limits
        self._made_by = module, function, arguments, told
        self.told: Any = None
        self._child: _Decoder | None = None
        self._key = 0
        with _lock:
            self._make()

    def ask(self, name: str, *arguments: Any) -> Any:
        """What the method ``name`` of the object returns or raises, or the value of its attribute ``name``."""
        with _lock:
            if self._child is None or not self._child.alive:
                self._make()
            assert self._child is not None
            return self._child.ask(("ask", self._key, name, arguments), self._limits, self._library)

    def _make(self) -> None:
        self._child = child = _running_child()
        module, function, arguments, told = self._made_by
        used([module])
        child.import_decoder(module, self._library)
        self._key = next(child.keys)
        self.told = child.ask(("make", self._key, module, function, arguments, told), self._limits, self._library)
        weakref.finalize(self, child.released.append, self._key)


_lock = threading.RLock()
_current: _Decoder | None = None


def child_pid() -> int | None:
    """Process id of the running child; None where no file needed one yet."""
    return _current.pid if _current is not None and _current.alive else None


def end_child() -> None:
    """End the child, if there is one; the next file starts another."""
    if _current is not None:
        _current.end()


def _running_child() -> _Decoder:
    global _current
    if _current is None or not _current.alive:
        try:
            _current = _Decoder()
        except OSError as error:
            raise DecoderLost(f"its reader could not be started ({error.strerror or error})") from error
    return _current


def _forget_child() -> None:
    """After a fork: the child belongs to the parent of this process."""
    global _current, _lock
    _lock = threading.RLock()
    _current = None


if sys.platform != "win32":
    os.register_at_fork(after_in_child=_forget_child)


class _Decoder(Child):
    """One request, one answer."""

    def __init__(self) -> None:
        super().__init__("casr.decoder_process", "serve", quiet=True)
        self.released: list[int] = []
        self._imported: set[str] = set()
        self.keys = itertools.count(1)

    def import_decoder(self, module: str, library: str) -> None:
        """Outside the limits of a file: starting Python and importing a library are not its fault."""
        if module not in self._imported:
            self.ask(("import", module), Limits(START_SECONDS, 1e6), library)
            self._imported.add(module)

    def ask(self, request: tuple[Any, ...], limits: Limits, library: str) -> Any:
        released, self.released[:] = tuple(self.released), []
        try:
            started = time.monotonic()
            message = pickle.dumps((request, released, limits, _working_folder()))
            self.pipes.send(message)
            # Windows cannot wait for a pipe; the child's own watchdog ends it there, and the pipe with it
            if sys.platform != "win32" and not self.pipes.readable(limits.seconds):
                self.end()
                raise _too_late(limits)
            ended_well, value = self._answer()
        except (OSError, EOFError, ValueError, MemoryError, pickle.UnpicklingError) as error:  # or a spoilt answer
            late = time.monotonic() - started >= limits.seconds
            raise _too_late(limits) if late else self._crashed(library) from error
        except BaseException:  # an answer may still come, which the next request would take for its own
            self.end()
            raise
        if ended_well:
            return value
        if isinstance(value, MemoryError):
            self.end()  # what it holds is not known
            raise DecoderFailed(f"its reader needed more than {limits.memory_mb:.0f} MB", "memory")
        raise value

    def _answer(self) -> tuple[bool, Any]:
        (count,) = HEAD.unpack(read_whole(self.pipes.from_other, HEAD.size).data)
        sizes = read_whole(self.pipes.from_other, count * HEAD.size).view(np.dtype("<u8")).tolist()
        parts = [read_whole(self.pipes.from_other, size) for size in sizes]
        ended_well, value, named = pickle.loads(parts[0].data, buffers=parts[1:])
        used(named)
        return ended_well, value

    def _crashed(self, library: str) -> DecoderFailed:
        how, from_outside = self.died_of()
        if from_outside:
            return DecoderLost(f"its reader was killed from outside ({library}, {how})")
        return DecoderFailed(f"its reader crashed ({library}, {how})")


def _working_folder() -> str:
    """The folder that paths are relative to; "" where it was removed."""
    try:
        return os.getcwd()
    except OSError:
        return ""


def _too_late(limits: Limits) -> DecoderFailed:
    return DecoderFailed(f"its reader took more than {limits.seconds:.3g} s", "seconds")
