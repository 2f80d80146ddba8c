"""The code behind a result: every module of this project that its stage reaches, and the libraries that those import.

Reached is what a module imports, anywhere in it, and what it names in a string: readers, decoders and engines are
imported by name. Where a module asks for the plugins of a group, the distributions that have some count as libraries.
Comments and docstrings do not count, nor do imports for type checkers alone.
"""

from __future__ import annotations

import ast
import importlib
import re
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from emg2vsa.pipeline.fingerprint import Fingerprints, Part, State, digest, part_of, state_of

PACKAGES = ("emg2vsa", "casr")
_MODULE = re.compile(rf"({'|'.join(PACKAGES)})(\.\w+)+(:\w+)?$")
_PLUGINS = "plugins "
"""Begins what stands for the distributions with plugins of a group, among names of libraries."""
_STANDARD = frozenset(sys.stdlib_module_names) | {"__future__"}


@dataclass(frozen=True)
class Reached:
    """modules : name to digest. libraries : distribution to version, Python's own too. states : of the files read."""

    modules: Part
    libraries: Part
    states: dict[str, State | None]

    def holds(self) -> bool:
        """Whether no file has changed since."""
        return all(state_of(path) == state for path, state in self.states.items())


class Code:
    """What modules reach, remembered with the digests of other files."""

    def __init__(self, prints: Fingerprints) -> None:
        self._prints = prints
        self._modules: dict[str, tuple[str, State | None, str, list[str], list[str]] | None] = {}
        self._reached: dict[str, Reached] = {}
        self._installed: dict[str, list[tuple[str, str]]] = {}

    def reached(self, root: str) -> Reached:
        """Everything that ``root`` reaches, itself included."""
        if root not in self._reached:
            found: dict[str, str] = {}
            states: dict[str, State | None] = {}
            foreign: set[str] = set()
            queue = [root]
            while queue:
                name = queue.pop()
                module = None if name in found else self._module(name)
                if module is not None:
                    path, state, found[name], own, others = module
                    states[path] = state
                    foreign.update(others)
                    queue += own
                    queue += [name.rpartition(".")[0]] if "." in name else []  # a package runs before its modules
            self._reached[root] = Reached(part_of(found), part_of(self._versions(foreign)), states)
        return self._reached[root]

    def _module(self, name: str) -> tuple[str, State | None, str, list[str], list[str]] | None:
        """Path, state when digested, digest, modules of this project and libraries that it imports; None for no module.

        A module is read once: an edit while a study runs is noticed by its state.
        """
        if name not in self._modules:
            path = module_file(name)
            if path is None:
                self._modules[name] = None
            else:
                package = name if path.endswith("__init__.py") else name.rpartition(".")[0]
                state = state_of(path)
                value = self._prints.computed(path, lambda data: _digested(data, package), state)
                self._modules[name] = None if value is None else (path, state, *value)
        return self._modules[name]

    def _versions(self, names: set[str]) -> dict[str, str]:
        found = {"python": f"{sys.version_info[0]}.{sys.version_info[1]}"}
        for name in sorted(names):
            found |= dict(self._distributions(name))
        return found

    def _distributions(self, name: str) -> list[tuple[str, str]]:
        """Distributions of an import name or of a group of plugins, with versions; an import name can be ``absent``."""
        if not self._installed:
            self._installed = {key: list(map(tuple, of)) for key, of in self._prints.installed(_installed).items()}
        return self._installed.get(name, [] if name.startswith(_PLUGINS) else [(name, "absent")])


@cache
def _folder(package: str) -> str:
    return str(Path(str(importlib.import_module(package).__file__)).parent)


@cache
def module_file(name: str) -> str | None:
    """File of a module of this project; None where there is none."""
    package, *inner = name.split(".")
    if package not in PACKAGES:
        return None
    base = "/".join([_folder(package), *inner])
    return next((path for path in (f"{base}.py", f"{base}/__init__.py") if Path(path).is_file()), None)


def _installed() -> dict[str, list[tuple[str, str]]]:
    """Import name, and group of plugins, to its distributions with their versions; slow, and loaded by this alone."""
    from importlib.metadata import distributions, packages_distributions, version

    names = {name: list(of) for name, of in packages_distributions().items()}
    for distribution in distributions():
        if distribution.name in PACKAGES:  # its modules count, whatever its version
            continue
        for entry in distribution.entry_points:
            if entry.group.startswith(tuple(f"{package}." for package in PACKAGES)):
                names.setdefault(f"{_PLUGINS}{entry.group}", []).append(distribution.name)
    return {name: [(one, version(one)) for one in sorted(set(of))] for name, of in names.items()}


def _digested(source: bytes, package: str) -> list[Any]:
    """Digest of the code, names in this project that may be modules it imports, names of foreign packages."""
    tree = ast.parse(source)
    names: set[str] = set()
    groups: set[str] = set()
    for node in _walk(tree):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            origin = _origin(node, package)
            names.update([origin, *(f"{origin}.{alias.name}" for alias in node.names)])
        elif isinstance(node, ast.Call) and _called(node) == "import_module":
            names.update(_first_text(node))
        elif isinstance(node, ast.Call) and _called(node) == "plugins":
            groups.update(_first_text(node))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and _MODULE.match(node.value):
            names.add(node.value.partition(":")[0])
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [statement for statement in body if not _is_text(statement)]  # type: ignore[attr-defined]
    firsts = {name.partition(".")[0] for name in names}
    foreign = firsts.difference(PACKAGES, _STANDARD) | {f"{_PLUGINS}{group}" for group in groups}
    own = sorted(name for name in names if name.partition(".")[0] in PACKAGES)
    return [digest(ast.dump(tree)), own, sorted(foreign)]


def _walk(tree: ast.AST) -> list[ast.AST]:
    """Every node but those below ``if TYPE_CHECKING:``."""
    found, queue = [], [tree]
    while queue:
        node = queue.pop()
        found.append(node)
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            queue += node.orelse
        else:
            queue += ast.iter_child_nodes(node)
    return found


def _origin(node: ast.ImportFrom, package: str) -> str:
    """Module that the names come from; a relative one counted from ``package``."""
    above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
    return ".".join([*above, *([node.module] if node.module else [])])


def _first_text(node: ast.Call) -> list[str]:
    return [a.value for a in node.args[:1] if isinstance(a, ast.Constant) and isinstance(a.value, str)]


def _called(node: ast.Call) -> str:
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


def _is_text(statement: ast.AST) -> bool:
    value = statement.value if isinstance(statement, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)
