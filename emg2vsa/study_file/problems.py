"""Values of a TOML file as dataclass fields declare them, and what is wrong with those that are none.

A kind of value is a number, text, truth value, choice, array, table with free keys or dataclass, with limits; or a
table whose dataclass depends on its key ``kind`` (`Tagged`). TOML has no null: a key that may be None is one that may
be left out. A problem tells the place, what was wanted, what was found and what to do.
"""

from __future__ import annotations

import json
import math
import operator
import re
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

from casr.errors import PluginError
from emg2vsa.devices import registry
from emg2vsa.settings import Limit, Tagged

KeyPath = tuple[str | int, ...]


@dataclass(frozen=True)
class Problem:
    """One problem at one key."""

    path: KeyPath
    wanted: str
    found: str
    do: str = ""

    def __str__(self) -> str:
        return f"{written(self.path)}: expected {self.wanted}, but found {self.found}." + (
            f" {self.do}" if self.do else ""
        )


def written(path: KeyPath) -> str:
    """A key path as people write it: ``specimens[1].stiffness_n_per_mm``."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.lstrip(".")


def shown(value: object) -> str:
    """A value as TOML writes it, cut where it is long."""
    if isinstance(value, dict):
        return "a table"
    try:
        text = json.dumps(value, default=str, ensure_ascii=False)
    except ValueError:  # Python writes no whole number of more than 4300 digits
        return "a number of thousands of digits"
    except RecursionError:  # dotted keys nest without end
        return "tables within tables by the hundred"
    return text if len(text) <= 60 else text[:57] + "..."


def nearest(name: str, known: Iterable[str], else_say: str = "") -> str:
    """A question for the nearest known name, or ``else_say``."""
    from difflib import get_close_matches  # a file without faults does without it

    near = get_close_matches(name, list(known), n=1, cutoff=0.5)
    return f"Did you mean {near[0]!r}?" if near else else_say


@dataclass(frozen=True)
class Pattern:
    """Limit of a text: the whole of it fits the regular expression ``text``."""

    text: str
    wanted: str


class Kind(NamedTuple):
    """``of``: float, int, str, bool, Literal, tuple, dict, Union, Tagged or a dataclass. ``parts``: choices, inner
    kinds, or the role of a device."""

    of: Any
    parts: tuple[Any, ...]
    limits: tuple[Any, ...]
    is_table: bool


def kind_of(hint: Any) -> Kind:
    """The kind that a type hint declares."""
    limits: tuple[Any, ...] = ()
    if get_origin(hint) is Annotated:
        hint, *rest = get_args(hint)
        limits = tuple(rest)
        if rest and isinstance(rest[0], Tagged):
            return Kind(Tagged, (rest[0].role,), (), True)
    of, parts = get_origin(hint) or hint, get_args(hint)
    if of in (Union, UnionType):
        of, parts = Union, tuple(part for part in parts if part is not NoneType)
        if len(parts) == 1:
            return kind_of(parts[0])
    if of is not Literal:
        parts = tuple(part if part is Ellipsis else kind_of(part) for part in parts)
    return Kind(of, parts, limits, is_dataclass(of))


@cache
def kinds_of(table: type) -> dict[str, Kind]:
    """Key of a table to its kind."""
    hints = get_type_hints(table, include_extras=True)
    return {each.name: kind_of(hints[each.name]) for each in fields(table)}


@cache
def required_keys(table: type) -> tuple[str, ...]:
    """Keys that have no default."""
    return tuple(f.name for f in fields(table) if f.default is MISSING and f.default_factory is MISSING)


def checked(hint: Any, value: object, at: KeyPath, file: type | None = None) -> tuple[Any, list[Problem]]:
    """``value`` as ``hint`` declares it, and its problems. ``file``: whose tables are searched for an unknown key.

    A None stands for a key that was left out.
    With problems, what can be kept is kept: the faulty keys of a table take their defaults. None where nothing can be.
    """
    reading = _Reading(file, [])
    made = reading.value(kind_of(hint), value, at)
    return None if made is _FAULTY else made, reading.problems


def checked_tables(file: type, raw: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """All tables of ``file`` that can be made, those with defaults included, and the problems of all."""
    reading = _Reading(file, [])
    made = reading.keys(file, raw, ())
    for each in fields(file):
        if each.name not in raw and each.name not in required_keys(file):
            made[each.name] = each.default if each.default_factory is MISSING else each.default_factory()
    return made, reading.problems


_FAULTY: Any = object()
_NUMBER = r"\s*[+-]?\d+(\.\d+)?([eE][+-]?\d+)?\s*"
_PLAIN: dict[Any, tuple[tuple[type, ...], str]] = {
    float: ((int, float), "a number"),
    int: ((int,), "a whole number"),
    str: ((str,), "text in quotes"),
    bool: ((bool,), "true or false"),
    dict: ((dict,), "a table"),
    tuple: ((list, tuple), "an array [...]"),
}


class _Reading(NamedTuple):
    """A walk over one value; ``problems`` grows."""

    file: type | None
    problems: list[Problem]

    def value(self, kind: Kind, given: Any, at: KeyPath) -> Any:
        """``given`` as ``kind``, or ``_FAULTY``."""
        if kind.of is Tagged:
            return self.tagged(kind.parts[0], given, at)
        if kind.is_table:
            return self.table(kind.of, given, at)
        if kind.of is Union:
            return self.one_of(kind.parts, given, at)
        if kind.of is Literal:
            same = [choice for choice in kind.parts if given == choice and not isinstance(given, bool)]
            return same[0] if same else self.no_choice(kind.parts, given, at)
        types, wanted = _PLAIN[kind.of]
        if not isinstance(given, types) or (isinstance(given, bool) and kind.of is not bool):
            if kind.of is tuple and kind.parts[0].is_table:
                wanted = f"tables under [[{written(at)}]]"
            return self.fault(Problem(at, wanted, shown(given), _unquoted(kind.of, given)))
        value: Any = _as_float(given) if kind.of is float else given
        if kind.of is float and not math.isfinite(value):
            return self.fault(Problem(at, "a finite number", shown(given)))
        for limit in kind.limits:
            if wanted := _beyond(limit, value):
                return self.fault(Problem(at, wanted, shown(given)))
        if kind.of is tuple:
            return self.array(kind.parts, value, at)
        return self.free_keys(kind.parts, value, at) if kind.of is dict else value

    def fault(self, problem: Problem) -> Any:
        self.problems.append(problem)
        return _FAULTY

    def no_choice(self, choices: tuple[Any, ...], value: Any, at: KeyPath, more: str = "", found: str = "") -> Any:
        *most, last = map(repr, choices)
        wanted = f"{', '.join(most)} or {last}" if most else last
        near = isinstance(value, str) and not found
        do = nearest(value, [each for each in choices if isinstance(each, str)]) if near else ""
        return self.fault(Problem(at, wanted, found or shown(value), f"{do} {more}".strip()))

    def one_of(self, kinds: tuple[Kind, ...], value: Any, at: KeyPath) -> Any:
        """The first kind that ``value`` is; else one problem that names them all."""
        tries = [_Reading(self.file, []) for _ in kinds]
        for reading, kind in zip(tries, kinds, strict=True):
            made = reading.value(kind, value, at)
            if made is not _FAULTY:
                return made
        first, last = tries[0].problems[0], tries[-1].problems[0]
        wanted = " or ".join(dict.fromkeys(reading.problems[0].wanted for reading in tries))
        return self.fault(Problem(at, wanted, last.found, last.do or first.do))

    def array(self, parts: tuple[Any, ...], values: list[Any], at: KeyPath) -> Any:
        if parts[-1] is Ellipsis:
            kinds = parts[:1] * len(values)
        elif len(values) > len(parts):
            return self.fault(Problem(at, f"at most {len(parts)} entries", shown(values)))
        else:
            kinds = parts
        for index in range(len(values), len(kinds)):
            self.fault(Problem((*at, index), "one more entry", "nothing"))
        made = [self.value(kind, each, (*at, i)) for i, (kind, each) in enumerate(zip(kinds, values, strict=False))]
        return _FAULTY if len(made) < len(kinds) or _FAULTY in made else tuple(made)

    def free_keys(self, parts: tuple[Any, ...], given: Mapping[str, Any], at: KeyPath) -> Any:
        known = parts[0]
        made = {}
        for key, value in given.items():
            if known.of is Literal and key not in known.parts:
                made[key] = self.no_choice(known.parts, key, (*at, key))
            else:
                made[key] = self.value(parts[1], value, (*at, key))
        return _FAULTY if _FAULTY in made.values() else made

    def tagged(self, role: str, given: Any, at: KeyPath) -> Any:
        """Settings of the kind of device that ``given`` names."""
        if not isinstance(given, dict):
            return self.fault(Problem(at, "a table", shown(given)))
        name, place = given.get("kind", registry.ROLES[role].default), (*at, "kind")
        try:
            if isinstance(name, str) and (kind := registry.kind_of(role, name)) is not None:
                with registry.blamed(kind.plugin, "settings that can be made"):
                    return self.of_kind(kind, given, name, at)
        except PluginError as error:
            return self.fault(Problem(place, f"{error.wanted} from the {error.where}", error.found, error.do))
        if name is None:
            return self.fault(Problem(place, "a key 'kind'", "nothing"))
        known = registry.kinds(role)
        if isinstance(name, str) and (others := registry.roles_of(name)):
            others_said = f"{shown(name)}, which is of the role {' and '.join(others)}"
            return self.no_choice(tuple(known), name, place, found=others_said)
        added = ", ".join(str(each.plugin) for each in known.values() if each.plugin)
        return self.no_choice(tuple(known), name, place, f"Of other packages: {added}." if added else "")

    def of_kind(self, kind: registry.Kind, given: Mapping[str, Any], name: str, at: KeyPath) -> Any:
        own = kinds_of(kind.settings)
        of_others = {} if own.keys() >= given.keys() else _keys_of_kinds(kind.role)
        strange = [key for key in given if key not in own and key in of_others]
        for key in strange:
            wanted = f"keys of this kind only ({key!r} is of {of_others[key]!r})"
            self.fault(Problem((*at, key), wanted, f"{key!r} with kind = {name!r}"))
        sound = len(self.problems)
        made = self.table(kind.settings, {key: given[key] for key in given if key not in strange}, at)
        if len(self.problems) == sound:
            self.problems.extend(Problem((*at, *wrong.path), *wrong[1:]) for wrong in kind.call("check", made))
        return made

    def table(self, table: type, given: Any, at: KeyPath) -> Any:
        if not isinstance(given, dict):
            return self.fault(Problem(at, "a table", shown(given)))
        made = self.keys(table, given, at)
        return table(**made) if all(key in made for key in required_keys(table)) else _FAULTY

    def keys(self, table: type, given: Mapping[str, Any], at: KeyPath) -> dict[str, Any]:
        """Those keys of ``given`` that are without fault, or could be mended."""
        kinds, made = kinds_of(table), {}
        for key, value in given.items():
            if key in kinds and value is None:
                continue
            if key in kinds:
                made[key] = self.value(kinds[key], value, (*at, key))
            else:
                self.fault(self.unknown(table, key, at))
        for key in required_keys(table):
            if key not in given:
                of_kind = f" with kind = {given['kind']!r}" if "kind" in kinds and "kind" in given else ""
                wanted = f"a key {key!r}{of_kind}" if at else f"a table {_heading(key, kinds[key])}"
                self.fault(Problem((*at, key), wanted, "nothing"))
        return {key: value for key, value in made.items() if value is not _FAULTY}

    def unknown(self, table: type, key: str, at: KeyPath) -> Problem:
        """The problem of a key that its table does not have, with the nearest key, here or in another table."""
        path, known = (*at, key), tuple(kinds_of(table))
        if path in _GONE:
            return Problem(path, "a known key", repr(key), _GONE[path])
        do = nearest(key, known, f"The keys are {', '.join(known)}.")
        for name, kind in kinds_of(self.file).items() if self.file else ():
            if kind.is_table and name not in path and key in _keys_of(kind):
                return Problem(path, "a known key", repr(key), f"{do} [{name}] has a key of that name.")
        return Problem(path, "a known key", repr(key), do)


_GONE: dict[KeyPath, str] = dict.fromkeys(
    (("discrimination", "equivalence_margin"), ("discrimination", "resamples"), ("discrimination", "seed")),
    "Remove it: the rig's presses are compared over mountings now, and [claims] says what differences matter.",
)
"""Keys of version 0.1.0 that nothing reads any more, and what to do."""


def _keys_of(table: Kind) -> Iterable[str]:
    return _keys_of_kinds(table.parts[0]) if table.of is Tagged else kinds_of(table.of)


def _keys_of_kinds(role: str) -> dict[str, str]:
    """Key to the first kind of the role that has it."""
    kinds = reversed(registry.kinds(role).items())
    return {key: name for name, kind in kinds for key in kinds_of(kind.settings)}


def _heading(name: str, kind: Kind) -> str:
    return f"[[{name}]]" if kind.of is tuple else f"[{name}]"


def _unquoted(of: Any, given: Any) -> str:
    is_number = of in (float, int) and isinstance(given, str) and re.fullmatch(_NUMBER, given)
    return "Write it without quotes." if is_number else ""


def _as_float(value: Any) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


_HOLDS = {">": operator.gt, ">=": operator.ge, "<": operator.lt, "<=": operator.le}


def _beyond(limit: Limit | Pattern, value: Any) -> str:
    """What ``limit`` asks for, where ``value`` goes beyond it; else nothing."""
    if isinstance(limit, Pattern):
        return "" if re.fullmatch(limit.text, value) else limit.wanted
    if limit.sign in _HOLDS:
        return "" if _HOLDS[limit.sign](value, limit.bound) else f"a number {limit.sign} {limit.bound}"
    entries = f"at least {limit.bound} entr{'y' if limit.bound == 1 else 'ies'}"
    return "" if len(value) >= limit.bound else "text that is not empty" if isinstance(value, str) else entries
