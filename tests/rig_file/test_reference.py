"""The schema and the reference of the rig file; that both are current is tested with those of the study file."""

from __future__ import annotations

from scripts.file_reference import rig_reference, rig_schema


def test_a_condition_that_is_none_is_refused_by_editors() -> None:
    angles = rig_schema()["definitions"]["ExperimentTable"]["properties"]["angles_deg"]
    assert angles["additionalProperties"] is False
    assert list(angles["properties"]) == ["high-stiffness", "modular", "constant-min", "constant-mean", "constant-max"]
    assert angles["properties"]["modular"] == {"type": "array", "items": {"type": "number", "minimum": 0}}


def test_the_reference_has_every_table_and_where_it_may_be_left_out() -> None:
    heads = [line for line in rig_reference().splitlines() if line.startswith("##")]
    assert heads == [
        "## `[rig]` (may be left out)", "### `[rig.losses]`", "### `[rig.guards]`", "## `[actuator]`",
        '### `[actuator]` with `kind = "qbmove"`', '### `[actuator]` with `kind = "dynamixel"`',
        "## `[motor]` (may be left out)", "## `[force]`", '### `[force]` with `kind = "net-ft"`',
        '### `[force]` with `kind = "ni-daq"`', "## `[camera]` (may be left out)", "## `[experiment]`",
        "## `[plate]` (may be left out)", "## `[emulated]` (may be left out)",
    ]  # fmt: skip
    assert "| `f_max_n` | number > 0 | `7` | The press turns back here. |" in rig_reference()
