"""What a result depends on, as short digests: file contents, code, settings, library versions.

File and module digests are remembered by size, modification time and inode, so that an unchanged study is recognised
without reading its data again.
"""

from __future__ import annotations

import ast
import dataclasses
import hashlib
import importlib.metadata
import importlib.util
import json
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from emg2vsa.atomic import write_text_atomic

PACKAGES = frozenset({"emg2vsa", "casr"})
NOT_CODE = frozenset({"emg2vsa", "casr", "emg2vsa.settings", "emg2vsa.errors", "emg2vsa.study"})
"""Modules that only declare: a step's settings enter its key by value, and error texts change no result."""


def digest(*parts: str | bytes) -> str:
    """16 hexadecimal digits of the parts, order and borders included."""
    state = hashlib.blake2b(digest_size=8)
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        state.update(len(data).to_bytes(8, "little"))
        state.update(data)
    return state.hexdigest()


def as_json(value: Any) -> Any:
    """Settings as plain JSON values, in a fixed order."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: as_json(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {str(key): as_json(item) for key, item in sorted(value.items())}
    if isinstance(value, (list, tuple)):
        return [as_json(item) for item in value]
    return str(value) if isinstance(value, Path) else value


@cache
def library_version(name: str) -> str:
    """Installed version, or ``absent``."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "absent"


def library_versions(names: Iterable[str]) -> dict[str, str]:
    """Name to version, Python's own first."""
    return {"python": f"{sys.version_info[0]}.{sys.version_info[1]}"} | {name: library_version(name) for name in names}


class Fingerprints:
    """Digests of files and modules, remembered between runs in one JSON file."""

    def __init__(self, memory: Path) -> None:
        self._memory = memory
        try:
            self._known: dict[str, list[Any]] = json.loads(memory.read_text())
        except (OSError, ValueError):
            self._known = {}
        self._changed = False
        self._modules: dict[str, tuple[str, list[str]] | None] = {}
        self._reached: dict[tuple[str, ...], dict[str, str]] = {}

    def save(self) -> None:
        """Write the memory back if it changed."""
        if self._changed:
            write_text_atomic(self._memory, json.dumps(self._known))
            self._changed = False

    def file(self, path: Path) -> str:
        """Digest of a file's content; ``missing`` where there is none."""
        return str(self._remembered(path, lambda data: [digest(data)])[0])

    def code(self, roots: Iterable[str]) -> dict[str, str]:
        """Module name to digest, for the roots and every project module they reach through imports.

        Comments and docstrings do not count; a changed helper of a helper does.
        """
        wanted = tuple(roots)
        if wanted not in self._reached:
            found: dict[str, str] = {}
            queue = list(wanted)
            while queue:
                name = queue.pop()
                module = None if name in found or name in NOT_CODE else self._module(name)
                if module is not None:
                    found[name] = module[0]
                    queue.extend(module[1])
            self._reached[wanted] = dict(sorted(found.items()))
        return self._reached[wanted]

    def _module(self, name: str) -> tuple[str, list[str]] | None:
        if name not in self._modules:
            path = _module_file(name)
            if path is None:
                self._modules[name] = None
            else:
                package = name if path.name == "__init__.py" else name.rpartition(".")[0]
                known = self._remembered(path, lambda data: _normalised(data, package))
                self._modules[name] = (known[0], known[1])
        return self._modules[name]

    def _remembered(self, path: Path, compute: Any) -> list[Any]:
        try:
            stat = path.stat()
        except OSError:
            return ["missing", []]
        state = [stat.st_size, stat.st_mtime_ns, stat.st_ino]
        known = self._known.get(str(path))
        if known is None or known[0] != state:
            known = [state, compute(path.read_bytes())]
            self._known[str(path)] = known
            self._changed = True
        value: list[Any] = known[1]
        return value


@cache
def _package_folder(package: str) -> Path:
    spec = importlib.util.find_spec(package)
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).parent


def _module_file(name: str) -> Path | None:
    package, *inner = name.split(".")
    base = _package_folder(package).joinpath(*inner)
    for path in (base.with_suffix(".py"), base / "__init__.py"):
        if path.is_file():
            return path
    return None


def _normalised(source: bytes, package: str) -> list[Any]:
    tree = ast.parse(source)
    imports: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imports.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = ".".join([*package.split(".")[: len(package.split(".")) - node.level + 1], node.module or ""]).strip(
                "."
            )
            origin = base if node.level else (node.module or "")
            imports.add(origin)
            imports.update(f"{origin}.{alias.name}" for alias in node.names)
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [s for s in body if not _is_text(s)]  # type: ignore[attr-defined]
    own = sorted(name for name in imports if name.split(".")[0] in PACKAGES)
    return [digest(ast.dump(tree)), own]


def _is_text(statement: ast.AST) -> bool:
    value = statement.value if isinstance(statement, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)
