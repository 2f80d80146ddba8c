"""Digests of file contents and of settings. Those of files are remembered, so that unchanged data are not read again.

A file counts as unchanged while size, times of modification and of change, and inode are the same. A file that was
changed within the last moments is read again next time: the clock of a file system is coarser than a program is fast.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import json
import os
import sys
import time
from collections.abc import Callable, Hashable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

from casr.atomic import write_bytes_atomic
from emg2vsa.pipeline.stage import Keyed

State = tuple[int, int, int, int]
"""Size, times of modification and of change (ns), inode."""

PACKAGES = ("emg2vsa", "casr")
"""Those of this project."""
MISSING = "missing"
_SETTLED_NS = 1_000_000_000
_START, _MIDDLE = b'{"sum": "', b'", "seen": '
_INSTALLED = "installed libraries and plugins"


def digest(*parts: str | bytes) -> str:
    """16 hexadecimal digits of the parts, order and borders included."""
    state = hashlib.blake2b(digest_size=8)
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        state.update(len(data).to_bytes(8, "little"))
        state.update(data)
    return state.hexdigest()


def state_of(path: str | Path) -> State | None:
    """What tells that a file may have changed; None where there is none."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_size, found.st_mtime_ns, found.st_ctime_ns, found.st_ino


class Fingerprints:
    """What was computed from files, remembered between runs in one JSON file. Nothing is lost with it but time.

    warn : is told when the memory was damaged.
    """

    def __init__(self, memory: Path, warn: Callable[[str], None] = lambda text: None) -> None:
        self._memory = memory
        self._known = _read(memory, warn)
        self._changed = False

    def save(self) -> None:
        """Write the memory back if it changed; where nothing may be written, the next program reads the files again."""
        if self._changed:
            with contextlib.suppress(OSError):
                files = json.dumps(self._known).encode()
                write_bytes_atomic(self._memory, _head(files) + files + b"}")
                self._changed = False

    def file(self, path: str | Path) -> str:
        """Digest of a file's content; ``missing`` where there is none."""
        return self.seen(str(path))[1]

    def seen(self, path: str) -> tuple[State | None, str]:
        """State and digest of a file's content, as of one moment."""
        state = state_of(path)
        value = self.known(path, state) or self.computed(path, digest, state)
        return state, MISSING if value is None else str(value)

    def computed(self, path: str, compute: Callable[[bytes], Any], state: State | None) -> Any:
        """What ``compute`` makes of the content of a file in that ``state``; None where there is none to read.

        One path has one ``compute``: modules have their code, all else a digest.
        """
        if state is None:
            return None
        if (known := self.known(path, state)) is not None:
            return known
        value, state = _steady(path, state, compute)
        if state is not None:
            settled = min(abs(time.time_ns() - moment) for moment in state[1:3]) > _SETTLED_NS
            self._known[path] = [state if settled else (), value]
            self._changed = True
        return value

    def known(self, path: str, state: State | None) -> Any:
        """What is remembered of a file in that ``state``; None for nothing."""
        known = self._known.get(path)
        return known[1] if known is not None and tuple(known[0]) == state else None

    def installed(self, look: Callable[[], Any]) -> Any:
        """What ``look`` finds of the installed libraries and plugins, until a folder of libraries changes."""
        libraries = (path for path in sys.path if path.endswith("-packages") or _holds_distributions(path))
        folders = [[path, found[1]] for path in libraries if (found := state_of(path)) is not None]
        known = self._known.get(_INSTALLED)
        if known is None or known[0] != folders:
            known = [folders, look()]
            self._known[_INSTALLED] = known
            self._changed = True
        return known[1]

    def forget(self, path: str | Path) -> None:
        """Read the file anew next time, whatever its state says."""
        self._changed |= self._known.pop(str(path), None) is not None


def _holds_distributions(path: str) -> bool:
    with contextlib.suppress(OSError):
        return any(name.endswith((".dist-info", ".egg-info")) for name in os.listdir(path or "."))
    return False


def _steady(path: str, state: State, compute: Callable[[bytes], Any]) -> tuple[Any, State | None]:
    """What was computed, and the state that it belongs to: read again if the file changed meanwhile."""
    if not os.path.isfile(path):  # a pipe or a device may never end
        return None, None
    for _ in range(10):
        try:
            data = Path(path).read_bytes()
        except OSError:
            return None, None
        after = state_of(path)
        if after == state:
            break
        state = after or state
    return compute(data), state


def _head(files: bytes) -> bytes:
    return _START + digest(files).encode() + _MIDDLE


def _read(memory: Path, warn: Callable[[str], None]) -> dict[str, list[Any]]:
    try:
        data = memory.read_bytes()
        files = data[len(_head(b"")) : -1]
        if data == _head(files) + files + b"}":
            known: dict[str, list[Any]] = json.loads(files)
            return known
        content = json.loads(data)
        if not isinstance(content, dict) or "seen" in content:
            raise ValueError("not as it was written")
        return {}  # of an earlier version, which kept something else: all is read anew
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError) as error:
        warn(f"{memory} is damaged ({error}). It is made anew; every file is read once more.")
        return {}


class Part(NamedTuple):
    """One part of a key: plain JSON values and their digest."""

    digest: str
    value: dict[str, Any]


def part_of(value: dict[str, Any]) -> Part:
    """The part that ``value`` is."""
    return Part(digest(json.dumps(value, sort_keys=True)), value)


class Values:
    """Settings as plain JSON values; a settings object that many steps share is converted once."""

    def __init__(self) -> None:
        self._seen: dict[int, tuple[Any, Any]] = {}
        self._held: dict[tuple[int, int], tuple[Any, set[str]]] = {}
        self._parts: dict[tuple[Hashable, ...], tuple[Any, Part, tuple[str, ...]]] = {}

    def part(self, settings: dict[str, Any]) -> tuple[Part, tuple[str, ...]]:
        """The settings of one step, and modules of this project whose objects they are: what uses these need not import
        those."""
        same = (*settings, *map(_same, settings.values()))
        known = self._parts.get(same)
        if known is None:
            # the settings are kept, so that no other object gets their id
            types = tuple(sorted(self._modules(settings.values())))
            self._parts[same] = known = (settings, part_of(self.plain(settings)), types)
        return known[1:]

    def _modules(self, values: Iterable[Any], depth: int = 3) -> set[str]:
        """Modules of this project that define the types of ``values``, and of what these hold, so many levels deep:
        what lies deeper is of modules that the upper ones import. Of several values of one type the last counts."""
        found: set[str] = set()
        for (kind, keyed), value in {_kind_of(value): value for value in values}.items():
            if kind.__module__.partition(".")[0] in PACKAGES:
                found.add(kind.__module__)
            if keyed or not depth:
                continue
            if dataclasses.is_dataclass(value):
                if (known := self._held.get((id(value), depth))) is None:
                    own = [getattr(value, each.name) for each in dataclasses.fields(value)]
                    self._held[id(value), depth] = known = (value, self._modules(own, depth - 1))
                found |= known[1]
            elif isinstance(value, (list, tuple, dict)):
                found |= self._modules(value.values() if isinstance(value, dict) else value, depth - 1)
        return found

    def plain(self, value: Any) -> Any:
        """``value`` in a fixed order. Paths count as nothing: what lies there enters a key by its content."""
        if value is None or isinstance(value, (str, int, float)):
            return value
        if isinstance(value, (list, tuple)):
            return [self.plain(item) for item in value if not isinstance(item, Path)]
        if isinstance(value, dict):
            return {str(key): self.plain(item) for key, item in sorted(value.items())}
        if isinstance(value, Keyed):
            return self.plain(value.key)
        if isinstance(value, Path):
            return None
        known = self._seen.get(id(value))
        if known is None:
            own = {each.name: getattr(value, each.name) for each in dataclasses.fields(value)}
            plain = {name: self.plain(item) for name, item in own.items() if not isinstance(item, Path)}
            self._seen[id(value)] = known = (value, plain)
        return known[1]


_PLAIN = frozenset((type(None), str, int, float, bool))


def _same(value: Any) -> Hashable:
    """Equal for settings that are surely the same: by what they are where they are plain, by their place otherwise."""
    kind = type(value)
    if kind in _PLAIN:
        return kind, value
    if kind is Keyed:
        return type(value.value), _same(value.key)
    return tuple(map(_same, value)) if isinstance(value, tuple) else id(value)


def _kind_of(value: Any) -> tuple[type, bool]:
    """The type of a value, and whether only a part of the value counts."""
    return (type(value.value), True) if isinstance(value, Keyed) else (type(value), False)
