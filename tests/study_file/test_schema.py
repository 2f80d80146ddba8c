"""The schema and the reference: current, complete, and within what TOML editors read.

What the names of files tell, and a draft that loads.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest

from emg2vsa import settings
from emg2vsa.study_file import load_study
from emg2vsa.study_file.draft import draft, naming_of
from emg2vsa.study_file.draft_channel import FILL, DraftChannel
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


@pytest.mark.parametrize(
    ("files", "pattern", "people", "specimens"),
    [
        (["anna_hard.csv", "anna_soft.csv", "ben_hard.csv"], "{participant}_{specimen}.csv", "anna ben", "hard soft"),
        (
            ["2026-05-01_ama_A_press.csv", "2026-05-02_ama_B_press.csv", "2026-05-03_bo_A_press.csv"],
            "*_{participant}_{specimen}_press.csv", "ama bo", "A B",
        ),
        (["P01/S1.c3d", "P01/S2.c3d", "P02/S1.c3d"], "{participant}/{specimen}.c3d", "P01 P02", "S1 S2"),
        (["S1/P01.c3d", "S2/P01.c3d", "S1/P02.c3d"], "{specimen}/{participant}.c3d", "P01 P02", "S1 S2"),
        (
            ["a_x_1.csv", "a_x_2.csv", "b_x_1.csv", "b_y_1.csv"],
            "{participant}_{specimen}_{repetition}.csv", "a b", "x y",
        ),
        (
            ["a_1_x.csv", "a_2_y.csv", "b_1_y.csv", "b_2_x.csv"],  # an order, which nothing needs
            "{participant}_*_{specimen}.csv", "a b", "x y",
        ),
        (["20260501_a_x.csv"], "*_a_x.csv", "P01", "specimen"),
        (["r_S1.csv", "r_S2.csv"], "r_{specimen}.csv", "P01", "S1 S2"),
        (["anna_S1.csv", "ben_S1.csv", "carl_S1.csv"], "{participant}_S1.csv", "anna ben carl", "specimen"),
        ([f"anna_S1_{i}.csv" for i in range(1, 7)], "anna_S1_{repetition}.csv", "P01", "specimen"),
        (
            [f"anna_S{k}_{i}.csv" for k in (1, 2) for i in range(1, 7)],
            "anna_{specimen}_{repetition}.csv", "P01", "S1 S2",
        ),
        (
            [f"{who}_S1_{i}.csv" for who in ("anna", "ben") for i in (1, 2, 3)],
            "{participant}_S1_{repetition}.csv", "anna ben", "specimen",
        ),
        (["x_11.csv", "x_12.csv", "y_11.csv"], "{participant}_{specimen}.csv", "x y", "11 12"),
        (["P1_t.csv", "P2_t.csv"], "{participant}_t.csv", "P1 P2", "specimen"),
        (["x_1.csv", "x_2.csv", "y_1.csv"], "{participant}_{repetition}.csv", "x y", "specimen"),
    ],
)  # fmt: skip
def test_names(files: list[str], pattern: str, people: str, specimens: str) -> None:
    found = naming_of(files)
    assert found is not None
    assert found.pattern == pattern
    assert (" ".join(found.participants), " ".join(found.specimens)) == (people, specimens)


def test_what_names_do_not_tell_is_to_be_filled_in(tmp_path: Path) -> None:
    naming = naming_of(["anna_1.csv", "anna_2.csv", "ben_1.csv"])
    text = draft("s", naming, [], {"EDC": DraftChannel("E", "V")}, DraftChannel("Fz", "N"), {}, [])
    assert f"# {FILL}: 'anna' was taken for a participant; it may be a specimen of one participant." in text
    assert f'name = "specimen"  # {FILL}: the names of the files do not tell what was pressed' in text
    assert "# Check: The number in their names was taken for the repetition." in text
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    for name in ("anna_1.csv", "anna_2.csv", "ben_1.csv"):
        (tmp_path / name).touch()
    found = {entry.key: len(entry.parts) for entry in load_study(tmp_path / "study.toml").recordings}
    assert found == {"anna/specimen": 2, "ben/specimen": 1}


def test_files_named_otherwise_are_told() -> None:
    found = naming_of(["a_x.csv", "a_y.csv", "b_x.csv", "test.csv", "mvc/a_x.csv"])
    assert found is not None
    assert found.left_out == ("test.csv", "mvc/a_x.csv")


def test_names_without_a_pattern_are_listed(tmp_path: Path) -> None:
    files = ["é1_ü.csv", "b1_x.csv"]
    assert naming_of(files) is None
    emg = {"E D": DraftChannel('a "b"', "mV")}
    text = draft("s", None, files, emg, DraftChannel("Fz", "N"), {}, ["b1_x.csv"])
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    study = load_study(tmp_path / "study.toml")
    assert [entry.emg_file.name for entry in study.recordings] == files
    assert study.recordings[0].channels.emg["E D"].name == 'a "b"'


@pytest.mark.parametrize(
    ("channel", "line"),
    [
        (DraftChannel("Fz", "kg"), f'unit = "kgf"   # {FILL}'),
        (DraftChannel("Fz", None), f'unit = "N"   # {FILL}'),
        (DraftChannel("Fz", "counts"), f"newtons_per_unit = 1.0   # {FILL}"),
        (DraftChannel("Fz", "N", 500.0), "fs_hz = 500"),
        (DraftChannel("Fz", "N", no_rate=True), f"fs_hz = 1000   # {FILL}"),
        (DraftChannel("Fz", "Newton", sign=-1), "sign = -1"),
    ],
)
def test_what_the_file_does_not_say_is_marked(channel: DraftChannel, line: str, tmp_path: Path) -> None:
    naming = naming_of(["a_x.csv", "a_y.csv", "b_x.csv"])
    force = replace(channel, is_force=True)
    text = draft("s", naming, [], {"EDC": DraftChannel("E", "V")}, force, {"x": 2.5}, [])
    assert line in text.split("[channels.force]")[1]
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    assert load_study(tmp_path / "study.toml").stiffness_n_per_mm == {"x": 2.5}


def test_a_name_with_a_line_end_leaves_the_draft_valid() -> None:
    files = ["a\nb = 1/P1_S1.csv", "a\nb = 1/P2_S1.csv", "odd\x07.csv"]
    text = draft("x", naming_of(files), files, {}, None, {}, files)
    assert tomllib.loads(text)["recordings"]["pattern"].startswith("a\nb = 1/")
    assert "#   a\\nb = 1/P1_S1.csv" in text
