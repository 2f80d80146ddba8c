"""The JSON schema of a study file, for editors: from the classes, described by the texts under their fields."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Sequence
from functools import cache
from types import ModuleType
from typing import Any

from pydantic import TypeAdapter

from emg2vsa import settings
from emg2vsa.study_file import tables


def json_schema() -> dict[str, Any]:
    """The schema of a study file."""
    return schema_of(tables.StudyFile, (tables, settings))


def schema_of(file: type, modules: Sequence[ModuleType]) -> dict[str, Any]:
    """The schema of a file, in Draft 4, the draft that TOML editors read. ``modules``: where its tables are defined."""
    schema = TypeAdapter(file).json_schema(ref_template="#/definitions/{model}")
    definitions = schema.pop("$defs")
    for name, definition in {**definitions, file.__name__: schema}.items():
        kind = next(getattr(module, name) for module in modules if hasattr(module, name))
        for key, described in definition["properties"].items():
            described["description"] = _doc(kind, key, modules)
    root = {"$schema": "http://json-schema.org/draft-04/schema#", **schema, "definitions": definitions}
    whole: dict[str, Any] = _draft_4(root)
    return whole


@cache
def field_docs(module: ModuleType) -> dict[tuple[str, str], str]:
    """(class, field) to the text literal under the field."""
    docs = {}
    for node in ast.parse(inspect.getsource(module)).body:
        if isinstance(node, ast.ClassDef):
            for line, after in zip(node.body, node.body[1:], strict=False):
                if (
                    isinstance(line, ast.AnnAssign)
                    and isinstance(line.target, ast.Name)
                    and isinstance(after, ast.Expr)
                ):
                    docs[node.name, line.target.id] = str(ast.literal_eval(after.value))
    return docs


def _doc(kind: type, key: str, modules: Sequence[ModuleType]) -> str:
    """Text under the field, in the class itself or in the one it inherits the field from."""
    docs = {place: text for module in modules for place, text in field_docs(module).items()}
    return next(docs[of.__name__, key] for of in kind.__mro__ if (of.__name__, key) in docs)


def _draft_4(node: Any) -> Any:
    """``node`` with the keywords of newer drafts written as Draft 4 has them."""
    if isinstance(node, list):
        return [_draft_4(item) for item in node]
    if not isinstance(node, dict):
        return node
    # a dict of named parts may well hold one called "title" or "default"
    named = {key: {name: _draft_4(part) for name, part in node[key].items()} for key in _NAMED if key in node}
    new = {key: _draft_4(value) for key, value in node.items() if key not in (*_NAMED, "title", "prefixItems", "const")}
    for limit, bound in (("exclusiveMinimum", "minimum"), ("exclusiveMaximum", "maximum")):
        if limit in new:
            new |= {bound: new[limit], limit: True}
    if "prefixItems" in node:
        new |= {"items": _draft_4(node["prefixItems"]), "additionalItems": False}
    if "propertyNames" in node:
        names = node["propertyNames"]["enum"]
        del new["propertyNames"]
        named["properties"] = dict.fromkeys(names, new["additionalProperties"])
        new["additionalProperties"] = False
    if "const" in node:
        new["enum"] = [node["const"]]
    if "$ref" in new and len(new) > 1:
        new["allOf"] = [{"$ref": new.pop("$ref")}]
    if new.get("default", "") is None:
        del new["default"]
    return _without_null(new | named)


_NAMED = ("properties", "definitions")


def _without_null(node: dict[str, Any]) -> dict[str, Any]:
    """TOML has no null: a key that may be None is one that may be left out."""
    if "anyOf" not in node:
        return node
    branches = [branch for branch in node["anyOf"] if branch != {"type": "null"}]
    rest = {key: value for key, value in node.items() if key != "anyOf"}
    if len(branches) > 1:
        return rest | {"anyOf": branches}
    return rest | ({"allOf": branches} if "$ref" in branches[0] else branches[0])
