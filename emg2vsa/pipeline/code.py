"""The code behind a result: modules of this project with digests of their code, and libraries with their versions.

Used by a step is what the file of its stage imports, in functions too, what those modules import in turn, and what
they imported by name while the step ran (``casr.by_name``), which its record in the ledger tells. Reached by a module
is what steps could use: every module that is named in a string counts as well, and every plugin of a group.

Comments and docstrings do not count, nor do imports for type checkers alone. In the file of a stage imports inside
functions that only planning calls do not count either: what they give is in the key as settings and files.
"""

from __future__ import annotations

import ast
import importlib
import os
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

from casr.plugins import PLUGINS
from emg2vsa.errors import DataError
from emg2vsa.pipeline.fingerprint import PACKAGES, Fingerprints, Part, State, digest, part_of, state_of
from emg2vsa.pipeline.stage import PLANNED

_MODULE = re.compile(rf"({'|'.join(PACKAGES)})(\.\w+)+(:\w+)?$")
_STANDARD = frozenset(sys.stdlib_module_names) | {"__future__"}
_STAGES = "emg2vsa.pipeline.stages"
_LOADED: dict[str, State] = {}
"""States of our files that this process has loaded, as its first plan, or the one before they were loaded, saw them."""


class Reached(NamedTuple):
    """modules : name to digest. libraries : distribution to version, Python's own too. states : of the files read."""

    modules: Part
    libraries: Part
    states: dict[str, State | None]

    def changed(self) -> str:
        """A file that has changed since; "" for none."""
        return next((path for path, state in self.states.items() if state_of(path) != state), "")


class _Module(NamedTuple):
    """path, state : of its file when it was digested. own, foreign : modules of this project, and libraries, that are
    imported with it. named : both of those that it names in strings, and groups of plugins."""

    path: str
    state: State
    digest: str
    own: Sequence[str]
    foreign: Sequence[str]
    named: Sequence[str]


class Code:
    """What modules use and reach, remembered with the digests of other files."""

    def __init__(self, prints: Fingerprints) -> None:
        self._prints = prints
        self._files: dict[str, tuple[str, State]] = {}
        self._modules: dict[str, _Module | None] = {}
        self._found: dict[tuple[bool, tuple[str, ...]], Reached] = {}
        self._installed: dict[str, list[tuple[str, str]]] = {}

    def used(self, root: str, loaded: Sequence[str] = ()) -> Reached:
        """What a step uses whose stage is declared in ``root``. loaded : what it imported or looked up by name."""
        return self._closure((root, *loaded), reach=False)

    def reached(self, root: str) -> Reached:
        """Everything that ``root`` reaches, itself included."""
        return self._closure((root,), reach=True)

    def _closure(self, roots: tuple[str, ...], *, reach: bool) -> Reached:
        if (reach, roots) not in self._found:
            modules: dict[str, _Module] = {}
            foreign = {name for name in roots if not _is_own(name)}
            queue = list(roots)
            while queue:
                name = queue.pop()
                module = None if name in modules else self._module(name)
                if module is not None:
                    modules[name] = module
                    foreign.update(module.foreign)
                    queue += module.own
                    if reach:
                        queue += module.named
                        foreign.update(other for other in module.named if not _is_own(other))
            self._found[reach, roots] = Reached(
                part_of({name: module.digest for name, module in modules.items()}),
                part_of(self._versions(foreign)),
                {module.path: module.state for module in modules.values()},
            )
        return self._found[reach, roots]

    def _module(self, name: str) -> _Module | None:
        """None for no module. A module is read once. Its state is that of the first question about any, so that an edit
        while a study runs is noticed, whenever the module is first used."""
        if name not in self._modules:
            if not self._files:
                self._files = {found: at for package in PACKAGES for found, at in _files_of(package)}
                for each, at in self._files.items():
                    self._refuse_old(each, *at)
            self._modules[name] = self._digested(name, *self._files[name]) if name in self._files else None
        return self._modules[name]

    def _refuse_old(self, name: str, path: str, state: State) -> None:
        """DataError : this process has loaded other code than the file has now, and would keep its results under the
        key of the new one."""
        if not _is_loaded(name, path):
            _LOADED[path] = state
            return
        first = _LOADED.setdefault(path, state)
        if state != first:
            known = self._prints.known(path, first)
            new = self._digested(name, path, state)
            if known is None or new is None or known[0] != new.digest:  # comments do not count
                raise DataError(
                    path, wanted="the program's code as it is loaded", found="that it changed since",
                    do="Start Python anew, and run the study again.",
                )  # fmt: skip
            _LOADED[path] = state

    def _digested(self, name: str, path: str, state: State) -> _Module | None:
        above = name.rpartition(".")[0]
        package = name if path.endswith("__init__.py") else above
        found = self._prints.computed(path, lambda data: _digested(data, package), state)
        if found is None:
            return None
        code, own, foreign, named = found
        # a package runs before its modules; of names that may be modules few are
        return _Module(path, state, code, [each for each in (*own, above) if each in self._files], foreign, named)

    def _versions(self, names: Iterable[str]) -> dict[str, str]:
        found = {"python": f"{sys.version_info[0]}.{sys.version_info[1]}"}
        for name in sorted(names):
            found |= dict(self._distributions(name))
        return found

    def _distributions(self, name: str) -> list[tuple[str, str]]:
        """Distributions of an import name, of a group of plugins, or of one name in it, with versions; an import name
        can be ``absent``."""
        if not self._installed:
            self._installed = {key: list(map(tuple, of)) for key, of in self._prints.installed(_installed).items()}
        first = name if name.startswith(PLUGINS) else name.partition(".")[0]
        if first in _STANDARD:
            return []
        return self._installed.get(first, [] if first.startswith(PLUGINS) else [(_one_name(first), "absent")])


def _is_loaded(name: str, path: str) -> bool:
    """By this process, or perhaps by the server that its workers are forked from, which lives as long."""
    if getattr(sys.modules.get(name), "__file__", None) == path:
        return True
    if "multiprocessing.forkserver" not in sys.modules:
        return False
    top = os.path.dirname(str(sys.modules[name.partition(".")[0]].__file__))
    return path.startswith(top + os.sep)


def _is_own(name: str) -> bool:
    return name.partition(".")[0] in PACKAGES


@cache
def folder_of(package: str) -> str:
    """Folder of one of our packages."""
    return os.path.dirname(str(importlib.import_module(package).__file__))


def _files_of(package: str) -> Iterator[tuple[str, tuple[str, State]]]:
    """Every module of a package, its file, and the state of that."""
    folders = [(package, folder_of(package))]
    while folders:
        name, folder = folders.pop()
        with os.scandir(folder) as entries:
            for entry in entries:
                stem, dot, kind = entry.name.partition(".")
                if not dot and entry.is_dir() and stem.isidentifier():
                    folders.append((f"{name}.{stem}", entry.path))
                elif kind == "py" and (state := state_of(entry.path)) is not None:
                    yield name if stem == "__init__" else f"{name}.{stem}", (entry.path, state)


def _installed() -> dict[str, list[tuple[str, str]]]:
    """Import name, group of plugins, and one name in a group, to its distributions with their versions; slow, and
    loaded by this alone."""
    from importlib.metadata import distributions, packages_distributions, version

    names = {name: list(of) for name, of in packages_distributions().items()}
    for distribution in distributions():
        if distribution.name in PACKAGES:  # its modules count, whatever its version
            continue
        for entry in distribution.entry_points:
            if _is_own(entry.group):
                for key in (f"{PLUGINS}{entry.group}", f"{PLUGINS}{entry.group} {entry.name}"):
                    names.setdefault(key, []).append(distribution.name)
    return {name: [(_one_name(one), version(one)) for one in sorted(set(of))] for name, of in names.items()}


def _one_name(library: str) -> str:
    """A library has one name, however an import or its authors spell it."""
    return re.sub(r"[-_.]+", "-", library).lower()


def _digested(source: bytes, package: str) -> list[Any]:
    """Digest of the code; modules of this project, and libraries, that it may import; what it names."""
    tree = ast.parse(source)
    nodes: list[ast.AST] = []
    code = digest(_dumped(tree, nodes))
    unused = {below for top in _unused(tree, nodes, package) for below in ast.walk(top)}
    names: set[str] = set()
    named: set[str] = set()
    for node in nodes:
        if node in unused:
            continue
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            origin = _origin(node, package)
            names.update([origin, *(f"{origin}.{alias.name}" for alias in node.names)])
        elif isinstance(node, ast.Call) and _called(node) in ("import_module", "module_named"):
            named.update(_first_text(node))
        elif isinstance(node, ast.Call) and _called(node) in ("plugins", "plugin_named"):
            named.update(f"{PLUGINS}{group}" for group in _first_text(node))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and _MODULE.match(node.value):
            named.add(node.value.partition(":")[0])
    foreign = {first for name in names if not _is_own(name) and (first := name.partition(".")[0]) not in _STANDARD}
    return [code, sorted(filter(_is_own, names)), sorted(foreign), sorted(named)]


def _dumped(node: ast.AST, nodes: list[ast.AST]) -> str:
    """``ast.dump`` without docstrings, three times as fast; every node with fields is added to ``nodes``."""
    kind = node.__class__.__name__
    if not (fields := _fields_of(kind)):
        return f"{kind}()"
    nodes.append(node)
    dumped = []
    for name, optional in fields:
        value = getattr(node, name)
        if isinstance(value, ast.AST):
            dumped.append(f"{name}={_dumped(value, nodes)}")
        elif isinstance(value, list):
            kept = [each for each in value if not _is_text(each)] if name == "body" else value
            items = [_dumped(each, nodes) if isinstance(each, ast.AST) else repr(each) for each in kept]
            dumped.append(f"{name}=[{', '.join(items)}]")
        elif value is not None or not optional:
            dumped.append(f"{name}={value!r}")
    return f"{kind}({', '.join(dumped)})"


@cache
def _fields_of(name: str) -> list[tuple[str, bool]]:
    """Fields of a kind of node, and whether they may be left out."""
    kind = getattr(ast, name)
    return [(name, getattr(kind, name, ...) is None) for name in kind._fields]


def _unused(tree: ast.Module, nodes: list[ast.AST], package: str) -> Iterator[ast.AST]:
    """What is for type checkers alone, and for planning alone in the file of a stage."""
    for node in nodes:
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            yield from node.body
    if package == _STAGES:
        yield from _of_planning(tree)


def _of_planning(tree: ast.Module) -> frozenset[ast.AST]:
    """Functions of a stage's file that nothing but planning calls: nothing else in the file names them."""
    functions = {each.name: each for each in tree.body if isinstance(each, ast.FunctionDef)}
    others = (each for each in tree.body if not isinstance(each, ast.FunctionDef))
    queue: list[ast.AST] = [name for each in others for name in _without_planned(each)]
    called: set[str] = set()
    while queue:
        node = queue.pop()
        if isinstance(node, ast.Name) and node.id in functions and node.id not in called:
            called.add(node.id)
            queue.append(functions[node.id])
        queue += ast.iter_child_nodes(node)
    return frozenset(function for name, function in functions.items() if name not in called)


def _without_planned(node: ast.AST) -> Iterator[ast.AST]:
    """The names in a statement but those that it gives a `Stage` for planning."""
    if isinstance(node, ast.keyword) and node.arg in PLANNED:
        return
    if isinstance(node, ast.Name):
        yield node
    for child in ast.iter_child_nodes(node):
        yield from _without_planned(child)


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
