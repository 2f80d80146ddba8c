"""The schema and the reference: current, complete, and within what TOML editors read."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from emg2vsa import settings
from scripts.file_reference import FILES, field_docs, rig_schema, study_schema, text_of

ROOT = Path(__file__).resolve().parents[2]
DRAFT_4 = {
    "$schema", "$ref", "definitions", "description", "default", "type", "enum", "allOf", "anyOf", "required",
    "properties", "additionalProperties", "items", "additionalItems", "minItems", "maxItems", "minProperties",
    "minLength", "pattern", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum",
}  # fmt: skip


def nodes(schema: Any) -> Iterator[dict[str, Any]]:
    """Every schema within a schema; the names of properties and definitions are no keywords."""
    if not isinstance(schema, dict):
        return
    yield schema
    for key, value in schema.items():
        inner = (
            value.values() if key in ("properties", "definitions") else value if isinstance(value, list) else [value]
        )
        if key not in ("default", "enum", "required"):
            for part in inner:
                yield from nodes(part)


@pytest.mark.parametrize("path", FILES, ids=str)
def test_what_is_written_is_current(path: Path) -> None:
    assert (ROOT / path).read_text(encoding="utf-8") == text_of(path), "run python scripts/file_reference.py"


@pytest.mark.parametrize("schema", [study_schema, rig_schema])
def test_only_draft_4_keywords(schema: Callable[[], dict[str, Any]]) -> None:
    for node in nodes(schema()):
        assert set(node) <= DRAFT_4
        assert isinstance(node.get("exclusiveMinimum", True), bool)
        assert node.get("type") != "null"


@pytest.mark.parametrize("make", [study_schema, rig_schema])
def test_every_reference_leads_somewhere(make: Callable[[], dict[str, Any]]) -> None:
    schema = make()
    targets = {node["$ref"].rpartition("/")[2] for node in nodes(schema) if "$ref" in node}
    assert targets == set(schema["definitions"])


def test_every_setting_is_described() -> None:
    docs = field_docs(settings)
    for schema in (study_schema(), rig_schema()):
        for table in (schema, *schema["definitions"].values()):
            assert all(described["description"] for described in table["properties"].values())
    assert docs["FilterSettings", "band_hz"].startswith("EMG band-pass: -3 dB edges")
    assert {key for name, key in docs if name == "FitSettings"} == {f.name for f in fields(settings.FitSettings)}


def accepts(schema: dict[str, Any], value: Any, root: dict[str, Any]) -> bool:
    """Whether ``value`` fits: as much of Draft 4 as the generated schema uses, read from its specification."""
    if "$ref" in schema:
        return accepts(root["definitions"][schema["$ref"].rpartition("/")[2]], value, root)
    if not all(accepts(part, value, root) for part in schema.get("allOf", [])):
        return False
    if "anyOf" in schema and not any(accepts(part, value, root) for part in schema["anyOf"]):
        return False
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float)}
    kind = kinds.get(schema.get("type", ""), object)
    if not isinstance(value, kind) or (isinstance(value, bool) and schema.get("type") in ("integer", "number")):
        return False
    if value not in schema.get("enum", [value]):
        return False
    if isinstance(value, dict):
        named, other = schema.get("properties", {}), schema.get("additionalProperties", {})
        known = all(key in named or other is not False for key in value)
        fits = all(accepts(named.get(key, other or {}), item, root) for key, item in value.items())
        return known and fits and set(schema.get("required", ())) <= set(value)
    if isinstance(value, list):
        items = schema.get("items", {})
        each = items if isinstance(items, list) else [items] * len(value)
        size = schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value))
        return size and all(accepts(item, part, root) for item, part in zip(each, value, strict=True))
    if isinstance(value, (int, float)) and "minimum" in schema:
        return value > schema["minimum"] or (value == schema["minimum"] and not schema.get("exclusiveMinimum"))
    return True


@pytest.mark.parametrize("name", ["palpation", "recorded"])
def test_the_studies_fit_the_schema(name: str) -> None:
    schema = study_schema()
    study = tomllib.loads((ROOT / "studies" / name / "study.toml").read_text())
    assert accepts(schema, study, schema)
    for table, key, wrong in (("recordings", "layout", "bid"), ("study", "named", "x"), ("study", "name", 1)):
        assert not accepts(schema, {**study, table: {**study[table], key: wrong}}, schema)
    assert not accepts(schema, {**study, "specimens": [{"name": "S1", "stiffness_n_per_mm": 0}]}, schema)
    assert not accepts(schema, {**study, "filters": {"band_hz": [10, "450"]}}, schema)
