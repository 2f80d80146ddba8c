"""The reference of the study file, for people: Markdown from its JSON schema."""

from __future__ import annotations

from typing import Any

from emg2vsa.settings import PAPER
from emg2vsa.study_file.schema import json_schema


def reference() -> str:
    """The reference of the study file, as Markdown."""
    return markdown(json_schema(), _HEAD, PAPER)


def markdown(schema: dict[str, Any], head: str, paper: dict[str, dict[str, Any]]) -> str:
    """``head``, then every table of ``schema`` with its keys; ``paper``: what the mode of that name sets."""
    definitions = schema["definitions"]
    lines = head.splitlines()
    for name, described in schema["properties"].items():
        optional = "" if name in schema["required"] else " (may be left out)"
        many = described.get("type") == "array"
        lines += ["", f"## `{_heading(name, many)}`{optional}", "", described["description"], ""]
        lines += _table(definitions, _target(described), paper.get(name, {}))
        lines += _inner(definitions, _target(described), name)
    return "\n".join(lines) + "\n"


_HEAD = """\
# The study file

Written by `python -m emg2vsa.study_file`; do not edit.

A study file is TOML. Every problem in it is reported at once, as `file:line: key: wanted ...; found ...`. Unknown keys
are errors. Units are part of the names. Relative paths start at the folder of the study file; `~` and environment
variables are not expanded. With `mode = "paper"` the keys with a value under *paper* take it, unless the file sets
them. An editor that knows TOML schemas checks the file as you type, if its first line is
`#:schema ../study.schema.json`."""


def _heading(name: str, many: bool) -> str:
    return f"[[{name}]]" if many else f"[{name}]"


def _target(described: dict[str, Any]) -> str:
    """Name of the class behind a property; "" where it is a plain value."""
    inner = described
    for key in ("items", "additionalProperties"):
        inner = inner[key] if isinstance(inner.get(key), dict) else inner
    ref = inner.get("$ref") or inner.get("allOf", [{}])[0].get("$ref", "")
    return str(ref).rpartition("/")[2]


def _table(definitions: dict[str, Any], name: str, paper: dict[str, Any]) -> list[str]:
    heads = ["key", "value", "default", *(["paper"] if paper else []), "meaning"]
    rows = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    definition = definitions[name]
    for key, described in definition["properties"].items():
        if _target(described):
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
        target = _target(described)
        if not target:
            continue
        free = ".<muscle>" if isinstance(described.get("additionalProperties"), dict) else ""
        path = f"{at}.{key}{free}"
        lines += ["", f"### `{_heading(path, described.get('type') == 'array')}`", "", described["description"]]
        if at.startswith("recordings.files"):
            continue
        lines += ["", *_table(definitions, target, {})]
        lines += _inner(definitions, target, path)
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
