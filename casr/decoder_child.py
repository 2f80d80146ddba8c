"""The child's end of `casr.decoder_process`: it answers requests with what a decoder returns or raises.

One request is a pickle in a pipe. One answer is a head in another pipe, and parts: a pickle, and the buffers of its
arrays. A head of no parts has the number of the system's error that left no room for them.
The parts lie in memory that both processes share on Linux, elsewhere they follow the head in the pipe.
"""

from __future__ import annotations

import contextlib
import importlib
import mmap
import os
import pickle
import sys
from dataclasses import dataclass
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np

from casr.child_process import HEAD, Pipes, limited, write_whole

_MB = 1_000_000
_KEPT_BYTES = 64 * _MB
"""Shared memory beyond this is given back with the next answer."""
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


def serve(parent: Pipes, shared: int) -> None:
    """Answer requests until the pipe ends.

    shared : descriptor of the file in memory that answers are written to; -1: they follow in the pipe.
    """
    memory = SharedMemory(shared) if shared >= 0 else None
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
        if sum(memoryview(part).nbytes for part in parts) > limits.memory_mb * _MB / 2:  # for it stands in memory twice
            parts = _pickled((False, MemoryError()))
        _send(parts, parent.to_other, memory)


def _done(request: tuple[Any, ...], objects: dict[int, Any]) -> list[Any]:
    """The parts of the answer: a pickle, and the buffers that it refers to."""
    try:
        return _pickled((True, _carried_out(request, objects)))
    except Exception as raised:
        error = (
            MemoryError() if "std::bad_alloc" in str(raised) else raised
        )  # what C++ says where Python says the other
        error.__cause__ = error.__context__ = error.__traceback__ = None
        try:
            return _pickled((False, error))
        except Exception:  # an exception of a library that cannot be sent
            return _pickled((False, RuntimeError(f"{type(error).__name__}: {error}")))


def _carried_out(request: tuple[Any, ...], objects: dict[int, Any]) -> Any:
    match request:
        case ("import", module):
            importlib.import_module(module)
            return None
        case ("make", key, module, function, arguments):
            objects[key] = getattr(sys.modules[module], function)(*arguments)
            return None
        case ("ask", key, name, arguments):
            value = getattr(objects[key], name)
            return value(*arguments) if callable(value) else value
    raise ValueError(request)


def _pickled(value: Any) -> list[Any]:
    buffers: list[pickle.PickleBuffer] = []
    head = pickle.dumps(value, protocol=5, buffer_callback=buffers.append)
    return [head, *(buffer.raw() for buffer in buffers)]


def _send(parts: list[Any], answers: FileIO, shared: SharedMemory | None) -> None:
    sizes = [memoryview(part).nbytes for part in parts]
    try:
        memory = shared.room_for(sum(sizes)) if shared else np.empty(0, np.uint8)
    except OSError as error:  # a limit on the size of files, or no memory: this answer needs neither
        write_whole(answers, HEAD.pack(0) + HEAD.pack(error.errno or 0))
        return
    head = HEAD.pack(len(parts)) + np.array([*sizes, memory.size], np.dtype("<u8")).tobytes()
    if shared is None:
        write_whole(answers, head)
        for part in parts:
            write_whole(answers, part)
        return
    for part, start, size in zip(parts, np.cumsum([0, *sizes]), sizes, strict=False):
        memory[start : start + size] = np.frombuffer(part, np.uint8)
    write_whole(answers, head)


class SharedMemory:
    """Memory that this process and its child both see, by the descriptor of a file without a name."""

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor
        self._array = np.empty(0, np.uint8)

    def array(self, capacity: int) -> np.ndarray[Any, Any]:
        """(capacity,) uint8; the file must be as long."""
        if self._array.size != capacity:
            self._array = np.frombuffer(mmap.mmap(self.descriptor, capacity), np.uint8)
        return self._array

    def room_for(self, size: int) -> np.ndarray[Any, Any]:
        """(size or more,) uint8; the file is made longer, or shorter where far more than that is held."""
        if not size <= self._array.size <= max(_KEPT_BYTES, size):
            capacity = -(-max(size, 1) // mmap.PAGESIZE) * mmap.PAGESIZE
            os.ftruncate(self.descriptor, capacity)
            return self.array(capacity)
        return self._array

    def close(self) -> None:
        os.close(self.descriptor)
