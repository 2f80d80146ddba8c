"""Budgets of lines are kept, and the plan of the house shows the layers as they are: scripts/house.py."""

from __future__ import annotations

import importlib.util
import sys
import tomllib
from copy import deepcopy
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parent.parent
TOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]


@pytest.fixture(scope="module")
def house() -> ModuleType:
    spec = importlib.util.spec_from_file_location("house", ROOT / "scripts" / "house.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # its dataclasses look there
    spec.loader.exec_module(module)
    return module


def test_growth_beyond_a_budget_is_refused(house: ModuleType) -> None:
    tools = deepcopy(TOOLS)
    lines = house.sizes({"emg2vsa/signals": 0})["emg2vsa/signals"]
    tools["house"] = {"budgets": dict(TOOLS["house"]["budgets"]) | {"emg2vsa/signals": lines - 10}}
    assert any(said.startswith(f"emg2vsa/signals: {lines} lines, but") for said in house.faults(tools))
    tools["house"]["budgets"]["emg2vsa/signals"] = lines
    assert not any(said.startswith("emg2vsa/signals:") for said in house.faults(tools))


def test_a_package_without_a_budget_and_an_old_plan_are_told(house: ModuleType) -> None:
    tools = deepcopy(TOOLS)
    del tools["house"]["budgets"]["casr/pins"]
    assert any(one.startswith("casr/pins: no budget") for one in house.faults(tools))
    layers = next(one for one in tools["importlinter"]["contracts"] if one.get("containers") == ["casr"])["layers"]
    layers.reverse()
    assert any(one.startswith("docs/architecture.md: the plan") for one in house.faults(tools))


def test_sizes_alone_make_no_plan_old(house: ModuleType) -> None:
    row = "| `pins` | Pins of the {}. | {} | {} |"
    assert house.without_sizes(row.format("skin", 11, 1288)) == house.without_sizes(row.format("skin", 9, 900))
    assert house.without_sizes(row.format("skin", 11, 1288)) != house.without_sizes(row.format("dome", 11, 1288))
