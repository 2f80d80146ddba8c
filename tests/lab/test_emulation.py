"""The emulated rig behind ports, from a program: its devices are asked by hand."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from emg2vsa import rig
from emg2vsa.lab.emulation import toml_lines
from emg2vsa.rig_file import RigFile


@pytest.mark.parametrize(
    "tables",
    [
        {"a": 1, "b": [1.5, -2e-07, 1e22], "c": True, "d": 'say "é\\n"\t'},
        {"x": {"y": {"z": []}, "w": ["a", "b"]}, "odd key": {"S 1.2": 3.0, "high-stiffness": [0]}},
    ],
)
def test_tables_as_toml(tables: dict[str, Any]) -> None:
    assert tomllib.loads("\n".join(toml_lines(tables))) == tables


@pytest.mark.skipif(sys.platform == "win32", reason="no virtual serial ports")
def test_what_is_served_answers_and_a_no_changes_nothing(file: RigFile, tmp_path: Path) -> None:
    heard: list[str] = []
    person = rig.Person(say=heard.append, ask=lambda question: "no")
    with rig.emulation(file, rigid=True, write=tmp_path / "served.toml", faults=["gain 0.5"]) as served:
        there = rig.load(tmp_path / "served.toml")
        assert there.leads_to_emulated
        assert served.faults == ("gain: the force sensor gives 0.5 times the load",)
        assert served.obey("gain lots").startswith("fault gain: expected off, or a number")
        states = {state.device.split()[0]: state.usable for state in rig.info(there)}
        assert (states["[motor]"], states["[force]"], states["[camera]"]) == (True, True, True)
        assert rig.tare(there).good
        before = rig.parameters(there, motor=True)
        assert rig.zero(there, motor=True, person=person) is None
        assert rig.parameters(there, change=(13, (1200.0,)), motor=True, person=person) is None
        assert rig.parameters(there, motor=True) == before
        assert heard[0].startswith("motors at ")
