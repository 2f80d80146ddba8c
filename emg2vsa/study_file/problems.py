"""What is wrong with a study file or a rig file: the place, what was wanted, what was found, what to do."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from emg2vsa.study_file.lines import KeyPath
from emg2vsa.study_file.tables import StudyFile


@dataclass(frozen=True)
class Problem:
    """One problem at one key."""

    path: KeyPath
    wanted: str
    found: str
    do: str = ""

    def __str__(self) -> str:
        return f"{written(self.path)}: wanted {self.wanted}; found {self.found}." + (f" {self.do}" if self.do else "")


def written(path: KeyPath) -> str:
    """A key path as people write it: ``specimens[1].stiffness_n_per_mm``."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.lstrip(".")


def shown(value: object) -> str:
    """A value as TOML writes it, cut where it is long."""
    if isinstance(value, dict):
        return "a table"
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= 60 else text[:57] + "..."


def nearest(name: str, known: Iterable[str], else_say: str = "") -> str:
    """A question for the nearest known name, or ``else_say``."""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.5)
    return f"Did you mean {near[0]!r}?" if near else else_say


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def checked(kind: Any, value: object, at: KeyPath, file: type = StudyFile) -> tuple[Any, list[Problem]]:
    """``value`` as ``kind``, a table of ``file``, and its problems.

    With problems, what can be kept is kept: the faulty keys take their defaults, so that the checks across keys still
    see the rest. None where nothing can be kept.
    """
    try:
        return _valid(kind, value), []
    except ValidationError as error:
        details = error.errors(include_url=False)
    problems = _problems(kind, value, details, at, file)
    if any(d["type"] == "missing" and isinstance(d["loc"][-1], str) for d in details):
        return None, problems
    try:
        return _valid(kind, _without(value, [_in_data(value, d["loc"]) for d in details])), problems
    except ValidationError:
        return None, problems


def _valid(kind: Any, value: object) -> Any:
    # strict JSON: a text is no number, yet an array may become a tuple and a whole number a float
    return _adapter(kind).validate_json(json.dumps(value, default=str), strict=True)


def _in_data(value: Any, loc: Sequence[str | int]) -> KeyPath:
    """The part of a pydantic location that exists in the data; unions append the name of the branch they tried."""
    path: KeyPath = ()
    for part in loc:
        inside = part in value if isinstance(value, dict) else isinstance(value, list) and part in range(len(value))
        if not inside:
            break
        value, path = value[part], (*path, part)
    return path


def _without(value: Any, paths: Iterable[KeyPath]) -> Any:
    """A copy of ``value`` less the innermost key of each path."""
    copy = json.loads(json.dumps(value, default=str))
    for path in set(paths):
        table, key = copy, None
        node = copy
        for part in path:
            if isinstance(part, str):
                table, key = node, part
            node = node.get(part, {}) if isinstance(node, dict) else node[part]
        if key is not None:
            table.pop(key, None)
    return copy


def _problems(kind: Any, value: Any, details: list[ErrorDetails], at: KeyPath, file: type) -> list[Problem]:
    """One problem for each faulty key; the branches of a union are joined by "or"."""
    joined: dict[KeyPath, Problem] = {}
    for detail in details:
        inside = _in_data(value, detail["loc"])
        if detail["type"] == "missing":
            inside = tuple(detail["loc"])
        problem = _problem(kind, detail, inside, at, file)
        earlier = joined.get(problem.path)
        if earlier and earlier.wanted != problem.wanted:
            problem = Problem(problem.path, f"{earlier.wanted} or {problem.wanted}", problem.found, problem.do)
        joined[problem.path] = problem
    return list(joined.values())


def _problem(kind: Any, detail: ErrorDetails, inside: KeyPath, at: KeyPath, file: type) -> Problem:
    path = (*at, *inside)
    if detail["type"] == "missing":
        return Problem(path, "one more entry" if isinstance(inside[-1], int) else f"a key {inside[-1]!r}", "nothing")
    if detail["type"] == "unexpected_keyword_argument":
        return unknown_key(kind, inside, at, file)
    return Problem(path, _wanted(detail), shown(detail["input"]), _advice(detail))


def _advice(detail: ErrorDetails) -> str:
    given = detail["input"]
    if not isinstance(given, str):
        return ""
    if detail["type"] == "literal_error":
        return nearest(given, re.findall(r"'([^']+)'", detail["ctx"]["expected"]))
    is_quoted_number = detail["type"] in ("float_type", "int_type") and _NUMBER.fullmatch(given)
    return "Write it without quotes." if is_quoted_number else ""


_NUMBER = re.compile(r"\s*[+-]?\d+(\.\d+)?([eE][+-]?\d+)?\s*")


def unknown_key(kind: Any, inside: KeyPath, at: KeyPath, file: type = StudyFile) -> Problem:
    """The problem of a key that its table does not have, with the nearest key, here or in another table."""
    key, path = str(inside[-1]), (*at, *inside)
    known = table_keys(kind, inside[:-1])
    hint = nearest(key, known, f"The keys are {', '.join(known)}.")
    elsewhere = [table for table, keys in _keys_by_table(file).items() if key in keys and table not in path]
    return Problem(
        path, "a known key", repr(key), f"{hint} [{elsewhere[0]}] has a key of that name." if elsewhere else hint
    )


def table_keys(kind: Any, inside: KeyPath) -> tuple[str, ...]:
    """Keys of the table at ``inside`` a value of ``kind``."""
    for part in inside:
        kind = get_type_hints(_bare(kind))[str(part)] if is_dataclass(_bare(kind)) else _entry(_bare(kind))
    return tuple(f.name for f in fields(_bare(kind)))


def _bare(kind: Any) -> Any:
    """``kind`` of a key that may be omitted, without the None."""
    return next(k for k in get_args(kind) if k is not NoneType) if NoneType in get_args(kind) else kind


def _entry(kind: Any) -> Any:
    """Kind of the entries of an array, or of the values of a table with free keys."""
    return get_args(kind)[1] if get_origin(kind) is dict else get_args(kind)[0]


@cache
def _keys_by_table(file: type) -> dict[str, tuple[str, ...]]:
    kinds = {name: _bare(kind) for name, kind in get_type_hints(file).items()}
    return {name: table_keys(kind, ()) for name, kind in kinds.items() if is_dataclass(kind)}


_KINDS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "string_type": "text in quotes",
    "bool_type": "true or false",
    "tuple_type": "an array [...]",
    "dict_type": "a table",
    "dataclass_type": "a table",
    "string_too_short": "text that is not empty",
    "string_pattern_mismatch": "letters, digits, - _ and dots only, the first a letter or digit",
    "finite_number": "a finite number",
}
_LIMITS = {
    "greater_than": ("gt", "a number > {}"),
    "greater_than_equal": ("ge", "a number >= {}"),
    "less_than": ("lt", "a number < {}"),
    "less_than_equal": ("le", "a number <= {}"),
    "too_short": ("min_length", "at least {} entry"),
    "too_long": ("max_length", "at most {} entries"),
    "literal_error": ("expected", "{}"),
}


def _wanted(detail: ErrorDetails) -> str:
    kind = detail["type"]
    if kind in _LIMITS:
        name, form = _LIMITS[kind]
        limit = detail["ctx"][name]
        return form.format(f"{limit:g}" if isinstance(limit, float) else limit)
    return _KINDS.get(kind, detail["msg"])
