"""Every actuator is what the rig takes it for: mypy finds nothing where each stands for its protocol."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TYPED = """
from collections.abc import Callable
from emg2vsa.devices.dynamixel.driver import Dynamixel
from emg2vsa.devices.dynamixel.driver import open_dynamixel
from emg2vsa.devices.board import Board
from emg2vsa.devices.protocols import Actuator, Measurements
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.opening import open_qbmove
from emg2vsa.devices.qbmove.driver import RigidMotor
from emg2vsa.worlds.far_ends.dynamixel.far_end import DYNAMIXEL as dynamixel
from emg2vsa.worlds.far_ends.qbmove.far_end import QBMOVE as qbmove
from emg2vsa.worlds.far_ends.qbmove.far_end import RIGID_MOTOR as motor

factories: list[Callable[..., Board]] = [
    open_qbmove, open_dynamixel, Qbmove, Dynamixel, qbmove.driver, motor.driver, dynamixel.driver,
]

def actuators(one: Qbmove, two: RigidMotor, three: Dynamixel) -> list[Actuator]:
    return [one, two, three]

def boards(one: Qbmove, two: Dynamixel) -> list[Board]:
    return [one, two]
"""
WRONG = "\ndef wrong(at: Measurements) -> Actuator:\n    return at\n"


@pytest.mark.slow
@pytest.mark.parametrize(("text", "errors"), [(TYPED, 0), (TYPED + WRONG, 1)], ids=["boards", "no board"])
def test_an_actuator_typed_as_its_protocol(text: str, errors: int, tmp_path: Path) -> None:
    (tmp_path / "typed.py").write_text(text)
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file", "pyproject.toml", str(tmp_path / "typed.py")]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout
    found = [line for line in said.splitlines() if ": error:" in line]
    assert len(found) == errors, said
    assert said.splitlines()[-1].startswith(f"Found {errors} error" if errors else "Success: no issues found in 1")
