"""Small wrong changes of one source file, as splices of its text: every other line stays what and where it is.

A seeded sample of mutants over all packages, each package in proportion to its lines.
"""

from __future__ import annotations

import ast
import random
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path

PACKAGES = ("emg2vsa", "casr")


@dataclass(frozen=True)
class Chosen:
    """One mutant of the sample. module : path of its file in the tree."""

    module: str
    mutant: Mutant


def package_of(module: Path) -> str:
    """``emg2vsa.statistics`` of emg2vsa/statistics/anova.py; ``emg2vsa`` of the modules that stand alone."""
    return ".".join(module.parts[:2]) if len(module.parts) > 2 else module.parts[0]


def sample(tree: Path, *, seed: int, count: int, package: str = "") -> list[Chosen]:
    """``count`` mutants of the packages whose name begins with ``package``.

    Packages are drawn by systematic sampling of their lines, one after the other: so a package has its share to within
    one mutant, and a small one its chance. Within a package a kind of change is drawn first, then one of its mutants:
    else constants would crowd out the rest. Raises ValueError for an unknown package.
    """
    modules = [path.relative_to(tree) for each in PACKAGES for path in sorted((tree / each).rglob("*.py"))]
    modules = [module for module in modules if package_of(module).startswith(package)]
    if not modules:
        raise ValueError(f"--package: expected a package of emg2vsa or casr, but found {package!r}. Name one of them.")
    rng = random.Random(seed)
    lines = [len(_text(tree / module).splitlines()) for module in modules]
    ends, every = list(accumulate(lines)), sum(lines) / count
    start = rng.uniform(0, every)
    names = Counter(package_of(modules[bisect_right(ends, start + k * every)]) for k in range(count))
    chosen = []
    for name, wanted in names.items():
        kinds: dict[str, list[Chosen]] = {}
        for module in modules:
            if package_of(module) == name:
                for mutant in mutants_of(_text(tree / module)):
                    kinds.setdefault(mutant.kind, []).append(Chosen(module.as_posix(), mutant))
        for _ in range(min(wanted, sum(map(len, kinds.values())))):
            of_kind = kinds[rng.choice(sorted(kind for kind, left in kinds.items() if left))]
            chosen.append(of_kind.pop(rng.randrange(len(of_kind))))
    rng.shuffle(chosen)  # so that a run that was ended early is a sample too
    return chosen


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.Gt,
    ast.LtE: ast.GtE,
    ast.Gt: ast.Lt,
    ast.GtE: ast.LtE,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
BOUNDS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
}
ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.MatMult: ast.Mult,
}


@dataclass(frozen=True)
class Mutant:
    """One wrong change: ``source[start:stop]`` becomes ``after``. kind : of the change. line : 1-based."""

    kind: str
    line: int
    start: int
    stop: int
    before: str
    after: str

    def applied(self, source: str) -> str:
        """The source with this change."""
        return source[: self.start] + self.after + source[self.stop :]


def mutants_of(source: str) -> list[Mutant]:
    """All mutants of a module, in the order of its text. Raises SyntaxError if it is not Python.

    Annotations, decorators, strings, imports and the inside of f-strings are left as they are.
    """
    starts = [0]
    for text in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(text))
    lines = source.splitlines()

    def place(line: int, byte: int) -> int:
        return starts[line - 1] + len(lines[line - 1].encode()[:byte].decode())

    found = []
    for kind, old, new in _changes(ast.parse(source)):
        start = place(old.lineno, old.col_offset)
        stop = place(old.end_lineno or old.lineno, old.end_col_offset or 0)
        after = ast.unparse(new)
        if isinstance(new, ast.expr) and not isinstance(new, (ast.Constant, ast.Call, ast.Name, ast.Subscript)):
            after = f"({after})"
        found.append(Mutant(kind, old.lineno, start, stop, source[start:stop], after))
    return sorted(set(found), key=lambda mutant: (mutant.start, mutant.stop, mutant.kind, mutant.after))


def _changes(tree: ast.AST) -> Iterator[tuple[str, ast.expr | ast.stmt, ast.expr | ast.stmt]]:
    for field, value in ast.iter_fields(tree):
        if field in ("annotation", "returns", "decorator_list"):
            continue
        for node in value if isinstance(value, list) else [value]:
            if isinstance(node, (ast.Import, ast.ImportFrom, ast.JoinedStr)) or not isinstance(node, ast.AST):
                continue
            if isinstance(node, ast.expr):
                yield from _of_expression(node, inside_slice=isinstance(tree, (ast.Slice, ast.Subscript)))
            if isinstance(node, ast.stmt):
                yield from _of_statement(node)
            yield from _changes(node)


def _of_expression(node: ast.expr, *, inside_slice: bool) -> Iterator[tuple[str, ast.expr, ast.expr]]:
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        for kind, table in (("comparison", COMPARISONS), ("off by one", BOUNDS)):
            if operator := table.get(type(node.ops[0])):
                yield kind, node, ast.Compare(node.left, [operator()], node.comparators)
    elif isinstance(node, ast.BinOp) and (arithmetic := ARITHMETIC.get(type(node.op))):
        yield "arithmetic", node, ast.BinOp(node.left, arithmetic(), node.right)
    elif isinstance(node, ast.BoolOp):
        yield "boolean", node, ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.Not, ast.USub)):
        yield "boolean" if isinstance(node.op, ast.Not) else "arithmetic", node, node.operand
    elif isinstance(node, ast.Constant):
        yield from _of_constant(node, inside_slice)
    elif isinstance(node, ast.Call):
        yield from _of_call(node)
    elif isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice):
        for bound in ("lower", "upper"):
            if getattr(node.slice, bound) is not None:
                parts = {name: getattr(node.slice, name) for name in ("lower", "upper", "step")} | {bound: None}
                yield "slice", node, ast.Subscript(node.value, ast.Slice(**parts), node.ctx)


def _of_constant(node: ast.Constant, inside_slice: bool) -> Iterator[tuple[str, ast.expr, ast.expr]]:
    value = node.value
    if isinstance(value, bool):
        yield "boolean", node, ast.Constant(not value)
    elif isinstance(value, int):
        yield "off by one" if inside_slice else "constant", node, ast.Constant(value + 1)
    elif isinstance(value, float):
        yield "constant", node, ast.Constant(1.1 * value or 1.0)


def _of_call(node: ast.Call) -> Iterator[tuple[str, ast.expr, ast.expr]]:
    name = node.func.id if isinstance(node.func, ast.Name) else ""
    texts = {ast.dump(each) for each in node.args[:2] if not isinstance(each, ast.Starred)}
    if len(texts) == 2 and name not in ("min", "max"):
        swapped = [node.args[1], node.args[0], *node.args[2:]]
        yield "argument order", node, ast.Call(node.func, swapped, node.keywords)
    if name == "range":
        last = ast.BinOp(node.args[min(1, len(node.args) - 1)], ast.Sub(), ast.Constant(1))
        shorter: list[ast.expr] = [last] if len(node.args) == 1 else [node.args[0], last, *node.args[2:]]
        yield "off by one", node, ast.Call(node.func, shorter, node.keywords)


def _of_statement(node: ast.stmt) -> Iterator[tuple[str, ast.expr | ast.stmt, ast.expr | ast.stmt]]:
    if isinstance(node, ast.Return) and node.value is not None and not _is_none(node.value):
        yield "return", node.value, ast.Constant(None)
    elif _is_removable(node):
        yield "removed statement", node, ast.Pass()
    elif isinstance(node, (ast.If, ast.While)):
        yield "boolean", node.test, ast.UnaryOp(ast.Not(), node.test)


def _is_removable(node: ast.stmt) -> bool:
    """Whether the names that later statements need are still there without it."""
    if isinstance(node, ast.Assign):
        return isinstance(node.targets[0], (ast.Attribute, ast.Subscript))
    if isinstance(node, ast.Expr):
        return not (isinstance(node.value, ast.Constant) and isinstance(node.value.value, str))
    return isinstance(node, (ast.AugAssign, ast.Raise))


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None
