"""The schema and the reference of the rig file: current, complete, and within what TOML editors read."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from emg2vsa.rig_file.__main__ import REFERENCE, SCHEMA
from emg2vsa.rig_file.reference import json_schema, reference

ROOT = Path(__file__).resolve().parents[2]
NEWER_THAN_DRAFT_4 = {"$defs", "const", "prefixItems", "propertyNames", "title", "examples", "deprecated"}


def nodes(schema: Any) -> Iterator[dict[str, Any]]:
    """Every schema within a schema; the names of properties and definitions are no keywords."""
    if not isinstance(schema, dict):
        return
    yield schema
    for key, value in schema.items():
        named = key in ("properties", "definitions")
        for part in value.values() if named else value if isinstance(value, list) else [value]:
            yield from nodes(part)


def test_the_written_schema_is_current() -> None:
    assert json.loads((ROOT / SCHEMA).read_text()) == json_schema(), "run python -m emg2vsa.rig_file"


def test_the_written_reference_is_current() -> None:
    assert (ROOT / REFERENCE).read_text(encoding="utf-8") == reference(), "run python -m emg2vsa.rig_file"


def test_only_draft_4_keywords_and_every_key_described() -> None:
    found = list(nodes(json_schema()))
    assert len(found) > 80
    for node in found:
        assert not set(node) & NEWER_THAN_DRAFT_4
        assert isinstance(node.get("exclusiveMinimum", True), bool)
    for definition in (json_schema(), *json_schema()["definitions"].values()):
        assert all(described["description"] for described in definition["properties"].values())


def test_a_condition_that_is_none_is_refused_by_editors() -> None:
    angles = json_schema()["definitions"]["ExperimentTable"]["properties"]["angles_deg"]
    assert angles["additionalProperties"] is False
    assert list(angles["properties"]) == ["high-stiffness", "modular", "constant-min", "constant-mean", "constant-max"]
    assert angles["properties"]["modular"] == {"type": "array", "items": {"type": "number", "minimum": 0}}


def test_the_reference_has_every_table_and_where_it_may_be_left_out() -> None:
    heads = [line for line in reference().splitlines() if line.startswith("##")]
    assert heads == [
        "## `[rig]` (may be left out)", "### `[rig.guards]`", "## `[actuator]`", "## `[motor]` (may be left out)",
        "## `[force]`", "## `[camera]` (may be left out)", "## `[experiment]`", "## `[emulated]` (may be left out)",
    ]  # fmt: skip
    assert "| `f_max_n` | number > 0 | `7` | The press turns back here. |" in reference()
