"""``python scripts/file_reference.py`` in the checkout writes schema and reference of study file and rig file anew.

Both are what the classes of the tables and the texts under their fields say: a JSON schema for editors, and Markdown.
"""

from __future__ import annotations

import ast
import inspect
import json
from collections.abc import Sequence
from dataclasses import MISSING, fields
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, Literal, Union

from emg2vsa.devices.registry import ROLES, kind_of
from emg2vsa.rig_file.tables import RigTables
from emg2vsa.settings import PAPER, Limit, Tagged
from emg2vsa.study_file.problems import Kind, Pattern, kinds_of, required_keys
from emg2vsa.study_file.tables import StudyFile


def study_schema() -> dict[str, Any]:
    """The schema of a study file."""
    return schema_of(StudyFile)


def rig_schema() -> dict[str, Any]:
    """The schema of a rig file."""
    return schema_of(RigTables)


def schema_of(file: type) -> dict[str, Any]:
    """The schema of a file, in Draft 4, the draft that TOML editors read."""
    definitions: dict[str, Any] = {}
    root = _table_schema(file, definitions)
    head = {"$schema": "http://json-schema.org/draft-04/schema#"}
    return head | root | {"definitions": dict(sorted(definitions.items()))}


@cache
def field_docs(module: ModuleType | None) -> dict[tuple[str, str], str]:
    """(class, field) to the text literal under the field."""
    docs: dict[tuple[str, str], str] = {}
    for node in ast.parse(inspect.getsource(module)).body if module and module.__name__ != "builtins" else ():
        if isinstance(node, ast.ClassDef):
            for line, after in zip(node.body, node.body[1:], strict=False):
                if (
                    isinstance(line, ast.AnnAssign)
                    and isinstance(line.target, ast.Name)
                    and isinstance(after, ast.Expr)
                ):
                    docs[node.name, line.target.id] = str(ast.literal_eval(after.value))
    return docs


def _table_schema(table: type, definitions: dict[str, Any]) -> dict[str, Any]:
    """The schema of one table; those of the tables within it are added to ``definitions``."""
    properties: dict[str, Any] = {}
    docs = {place: text for of in table.__mro__ for place, text in field_docs(inspect.getmodule(of)).items()}
    for each in fields(table):
        inner = _value_schema(kinds_of(table)[each.name], definitions)
        described = {"allOf": [inner]} if "$ref" in inner else inner
        if each.default not in (MISSING, None):
            described["default"] = list(each.default) if isinstance(each.default, tuple) else each.default
        # in the class itself or in the one that it inherits the field from
        text = next(docs[of.__name__, each.name] for of in table.__mro__ if (of.__name__, each.name) in docs)
        properties[each.name] = described | {"description": text}
    schema = {"type": "object", "description": inspect.getdoc(table), "properties": properties}
    required = {"required": list(required_keys(table))} if required_keys(table) else {}
    return schema | required | {"additionalProperties": False}


def _kinds_schema(role: str, definitions: dict[str, Any]) -> dict[str, Any]:
    """The schema of a table that is one of our kinds of devices, each with its own keys."""
    of_role = []
    for name in ROLES[role].kinds:
        kind = kind_of(role, name)
        assert kind is not None
        table = definitions[kind.settings.__name__] = _table_schema(kind.settings, definitions)
        if ROLES[role].default is None:
            del table["properties"]["kind"]["default"]
            table["required"] = ["kind", *table.get("required", ())]
        of_role.append({"$ref": f"#/definitions/{kind.settings.__name__}"})
    return {"anyOf": of_role} if len(of_role) > 1 else of_role[0]


_TYPES = {float: "number", int: "integer", str: "string", bool: "boolean"}


def _value_schema(kind: Kind, definitions: dict[str, Any]) -> dict[str, Any]:
    if kind.of is Tagged:
        return _kinds_schema(kind.parts[0], definitions)
    if kind.is_table:
        name = kind.of.__name__
        if name not in definitions:
            definitions[name] = _table_schema(kind.of, definitions)
        return {"$ref": f"#/definitions/{name}"}
    if kind.of is Union:
        return {"anyOf": [_value_schema(part, definitions) for part in kind.parts]}
    if kind.of is Literal:
        return {"type": _TYPES[type(kind.parts[0])], "enum": list(kind.parts)}
    if kind.of in _TYPES:
        return {"type": _TYPES[kind.of]} | _limits_of(kind.limits)
    least = [limit.bound for limit in kind.limits]
    if kind.of is dict:
        return _free_keys(kind.parts, definitions) | ({"minProperties": least[0]} if least else {})
    if kind.parts[-1] is Ellipsis:
        items = {"type": "array", "items": _value_schema(kind.parts[0], definitions)}
        return items | ({"minItems": least[0]} if least else {})
    each = [_value_schema(part, definitions) for part in kind.parts]
    return {"type": "array", "items": each, "additionalItems": False, "minItems": len(each), "maxItems": len(each)}


def _free_keys(parts: tuple[Any, ...], definitions: dict[str, Any]) -> dict[str, Any]:
    names, value = parts[0], _value_schema(parts[1], definitions)
    if names.of is Literal:
        return {"type": "object", "properties": dict.fromkeys(names.parts, value), "additionalProperties": False}
    return {"type": "object", "additionalProperties": value}


def _limits_of(limits: Sequence[Limit | Pattern]) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for limit in limits:
        if isinstance(limit, Pattern):
            made["pattern"] = f"^{limit.text}$"
        elif limit.sign == "length >=":
            made["minLength"] = limit.bound
        else:
            bound = "minimum" if ">" in limit.sign else "maximum"
            made[bound] = limit.bound
            made |= {} if "=" in limit.sign else {f"exclusive{bound.capitalize()}": True}
    return made


def study_reference() -> str:
    """The reference of the study file, as Markdown."""
    return markdown(study_schema(), _STUDY_HEAD, PAPER)


def rig_reference() -> str:
    """The reference of the rig file, as Markdown."""
    return markdown(rig_schema(), _RIG_HEAD, {})


def markdown(schema: dict[str, Any], head: str, paper: dict[str, dict[str, Any]]) -> str:
    """``head``, then every table of ``schema`` with its keys; ``paper``: what the mode of that name sets."""
    definitions = schema["definitions"]
    lines = head.splitlines()
    for name, described in schema["properties"].items():
        optional = "" if name in schema["required"] else " (may be left out)"
        many = described.get("type") == "array"
        lines += ["", f"## `{_heading(name, many)}`{optional}", "", described["description"], ""]
        lines += _tables(definitions, _targets(described), name, "###", paper.get(name, {}))
    return "\n".join(lines) + "\n"


_STUDY_HEAD = """\
# The study file

Written by `python scripts/file_reference.py`; do not edit.

A study file is TOML. Every problem in it is reported at once, as `file:line: key: expected ..., but found ...`. Unknown
keys are errors. Units are part of the names. Relative paths start at the folder of the study file; `~` and environment
variables are not expanded. With `mode = "paper"` the keys with a value under *paper* take it, unless the file sets
them. An editor that knows TOML schemas checks the file as you type, if its first line is
`#:schema ../study.schema.json`."""

_RIG_HEAD = """\
# The rig file

Written by `python scripts/file_reference.py`; do not edit.

A rig file is TOML and lies beside the study file. Every problem in it is reported at once, as `file:line: key:
expected ..., but found ...`. Unknown keys are errors. Units are part of the names. Relative paths start at the folder
of the rig file; `~` and environment variables are not expanded. What each guard means:
[how-to/engineer.md](../how-to/engineer.md). An editor that knows TOML schemas checks the file as you type, if its first
line is `#:schema ../rig.schema.json`.

Files of versions up to 0.2.0 are read as before: `home_ticks`, `position_ticks` and `max_preset_ticks` under `[rig]`,
`following_ticks`, `following_ticks_per_s` and `current_ma` under `[rig.guards]` stand for `home_deg`, `position_deg`,
`full_preset`, `following_deg`, `following_deg_per_s` and `current_a`, in ticks of a qbmove, 32768 to a turn of its
shaft, and in mA. A key may stand in one of its two spellings. `emg2vsa rig commission` writes the one that is there."""


def _heading(name: str, many: bool) -> str:
    return f"[[{name}]]" if many else f"[{name}]"


def _targets(described: dict[str, Any]) -> list[str]:
    """Names of the classes behind a property: several for a choice of kinds, none for a plain value."""
    inner = described
    for key in ("items", "additionalProperties"):
        inner = inner[key] if isinstance(inner.get(key), dict) else inner
    refs = [inner.get("$ref"), *(each.get("$ref") for key in ("allOf", "anyOf") for each in inner.get(key, ()))]
    return [str(ref).rpartition("/")[2] for ref in refs if ref]


def _tables(definitions: dict[str, Any], names: list[str], at: str, level: str, paper: dict[str, Any]) -> list[str]:
    """The keys of a table, or of each kind that it may be, and the tables within it."""
    if len(names) == 1:
        return _table(definitions, names[0], paper) + _inner(definitions, names[0], at)
    lines: list[str] = []
    for name in names:
        (kind,) = definitions[name]["properties"]["kind"]["enum"]
        lines += ["", f'{level} `{_heading(at, many=False)}` with `kind = "{kind}"`', ""]
        default = " The default." if "default" in definitions[name]["properties"]["kind"] else ""
        lines += [definitions[name]["description"] + default, "", *_table(definitions, name, paper, of_kind=True)]
    return lines[1:]


_OF_KIND = "Of the device; each kind has keys of its own."


def _table(definitions: dict[str, Any], name: str, paper: dict[str, Any], *, of_kind: bool = False) -> list[str]:
    """The keys of a table; of_kind: the heading above it says its kind."""
    heads = ["key", "value", "default", *(["paper"] if paper else []), "meaning"]
    rows = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    definition = definitions[name]
    for key, described in definition["properties"].items():
        if _targets(described) or (of_kind and key == "kind" and described["description"] == _OF_KIND):
            continue
        default = "required" if key in definition.get("required", ()) else _value(described.get("default"))
        paper_cell = [_value(paper.get(key))] if paper else []
        rows.append(
            "| " + " | ".join([f"`{key}`", _kind(described), default, *paper_cell, described["description"]]) + " |"
        )
    return rows if len(rows) > 2 else []


def _inner(definitions: dict[str, Any], name: str, at: str) -> list[str]:
    """The tables within a table; a stage's own table is described once only, where it stands at the top."""
    lines: list[str] = []
    for key, described in definitions[name]["properties"].items():
        targets = _targets(described)
        if not targets:
            continue
        free = f".<{'column' if key == 'form' else 'muscle'}>"
        path = f"{at}.{key}{free if isinstance(described.get('additionalProperties'), dict) else ''}"
        lines += ["", f"### `{_heading(path, described.get('type') == 'array')}`", "", described["description"]]
        if at.startswith("recordings.files"):
            continue
        lines += ["", *_tables(definitions, targets, path, "####", {})]
    return lines


def _value(value: Any) -> str:
    if value is None:
        return ""
    items = ", ".join(map(_literal, value)) if isinstance(value, (list, tuple)) else ""
    return f"`[{items}]`" if isinstance(value, (list, tuple)) else f"`{_literal(value)}`"


def _literal(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_literal(item)}" for key, item in value.items()) + "}"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"


_KINDS = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false"}


def _kind(described: dict[str, Any]) -> str:
    """What a value may be, in words."""
    if "anyOf" in described:
        return " or ".join(_kind(branch) for branch in described["anyOf"])
    if "enum" in described:
        return " or ".join(f"`{_literal(value)}`" for value in described["enum"])
    kind = described.get("type")
    if kind == "array":
        items = described["items"]
        each = [_kind(item) for item in items] if isinstance(items, list) else [_kind(items), "..."]
        return f"[{', '.join(each)}]"
    if kind == "object":
        if "properties" in described:
            names, kinds = zip(*described["properties"].items(), strict=True)
            return f"name = {_kind(kinds[0])}, ..., with names out of {', '.join(f'`{name}`' for name in names)}"
        return f"name = {_kind(described['additionalProperties'])}, ..."
    return _KINDS[str(kind)] + _limits(described)


def _limits(described: dict[str, Any]) -> str:
    lower, upper = described.get("minimum"), described.get("maximum")
    above = ">" if described.get("exclusiveMinimum") else ">="
    below = "<" if described.get("exclusiveMaximum") else "<="
    limits = ([f"{above} {lower:g}"] if lower is not None else []) + (
        [f"{below} {upper:g}"] if upper is not None else []
    )
    return " " + " and ".join(limits) if limits else ""


FILES = {
    Path("studies/study.schema.json"): study_schema,
    Path("studies/rig.schema.json"): rig_schema,
    Path("docs/reference/study-file.md"): study_reference,
    Path("docs/reference/rig-file.md"): rig_reference,
}
"""What is written to which file of the checkout."""


def text_of(path: Path) -> str:
    """What one of ``FILES`` should hold."""
    made = FILES[path]()
    return made if isinstance(made, str) else json.dumps(made, indent=2) + "\n"


if __name__ == "__main__":
    for path in FILES:
        path.write_text(text_of(path), encoding="utf-8")
