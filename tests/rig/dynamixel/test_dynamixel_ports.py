"""An emulated Dynamixel behind a serial port in real time, and every command of the rig at it."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path

import pytest

from emg2vsa import rig
from emg2vsa.cli import main
from emg2vsa.lab.emulation import Emulation
from emg2vsa.live.follow import Follower
from emg2vsa.worlds.far_ends.dynamixel import table
from tests.rig.dynamixel.conftest import FULL, Files

# a machine with other work must not trip the guards
SLACK = """\
[rig.guards]
stale_s = 0.1
late_s = 0.1
camera_s = 5
force_rate_n_per_s = 3000

[actuator]
watchdog_s = 2.5
reply_s = 0.8
"""
Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def served(rig_file: Files, tmp_path: Path) -> Iterator[tuple[Emulation, Path]]:
    """S1 under the motor, and the rig file that leads to it; slow enough for the machine's own time."""
    changes = ("[actuator]\n", SLACK), ("[emulated]\n", '[emulated]\nworld = "elastic"\ngap_mm = 2\n')
    path = tmp_path / "served.toml"
    with rig.emulation(rig.load(rig_file(*changes)), specimen="S1", write=path) as served:
        yield served, path


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Command:
    def run(*words: object) -> tuple[int, str, str]:
        status = main(["rig", *map(str, words)])
        said = capsys.readouterr()
        return status, said.out, said.err

    return run


def torque(served: Emulation) -> int:
    firmware = served.servers.bench.firmware
    return int(firmware.table.values[table.TORQUE_ENABLE])  # type: ignore[attr-defined]


def test_the_written_file_names_the_motor(served: tuple[Emulation, Path]) -> None:
    emulation, path = served
    actuator = tomllib.loads(path.read_text())["actuator"]
    assert actuator["port"] == emulation.servers.port
    assert {key: actuator[key] for key in ("kind", "model", "full_gain", "d_gain", "goal_current_a")} == {
        "kind": "dynamixel", "model": "xm430-w350", "full_gain": 800, "d_gain": 1500, "goal_current_a": 0.4,
    }  # fmt: skip
    assert rig.load(path).devices.actuator.full_preset == FULL
    assert emulation.actuator == "dynamixel (xm430-w350)"


def test_info_and_scan(served: tuple[Emulation, Path], command: Command) -> None:
    emulation, path = served
    status, out, _ = command("info", path)
    assert "xm430-w350, firmware 45, id 1" in out
    assert "set up for runs" in out
    assert f"full stiffness {FULL:g} N m/rad" in out
    assert torque(emulation) == 0
    port = emulation.servers.port
    status, out, _ = command("scan", "--port", port, "--kind", "dynamixel", "--id", 1, "--wait-ms", 500)
    assert (status, out) == (0, f"{port}\n  id 1, xm430-w350, firmware 45\n")


@pytest.mark.realtime
@pytest.mark.slow
def test_commission_measures_the_stiffness_and_writes_it(served: tuple[Emulation, Path], command: Command) -> None:
    emulation, path = served
    text = path.read_text()
    kept = [line for line in text.splitlines() if not line.startswith("full_stiffness_nm_per_rad")]
    path.write_text("\n".join(kept) + "\n")
    status, out, err = command("commission", path, "--yes")
    assert status == 0, out + err
    (line,) = (each for each in out.splitlines() if each.startswith("full_stiffness_nm_per_rad"))
    assert "WRONG" in line
    assert tomllib.loads(path.read_text())["actuator"]["full_stiffness_nm_per_rad"] == pytest.approx(FULL, rel=0.05)
    assert torque(emulation) == 0


@pytest.mark.realtime
@pytest.mark.slow
def test_the_watchdog_is_proven_and_a_run_of_two_presses_is_recorded_and_watched(
    served: tuple[Emulation, Path], command: Command
) -> None:
    emulation, path = served
    status, out, err = command("prove-watchdog", path, "--yes")
    assert status == 0, out + err
    assert json.loads(path.with_name("served.watchdog.json").read_text())["actuator"]["verdict"] == "motors off"
    assert torque(emulation) == 0
    one = "--specimen", "S1", "--angle", 0, "--condition", "modular"
    status, out, err = command("run", path, *one)
    assert status == 0, out + err
    assert "completed: 2 of 2 presses, " in out
    assert "left: probe retracted, motors off" in out
    assert torque(emulation) == 0
    moment = Follower(rig.load(path).runs).look()
    assert moment.run is not None
    assert (moment.run.specimen, moment.run.repetitions, moment.run.stiffness_percent) == ("S1", 2, (20.0, 80.0))
    assert moment.run.full_preset == pytest.approx(FULL)
    page = json.loads(json.dumps(asdict(moment), allow_nan=False))
    assert page["run"]["name"] == "S1_0_modular"
    curves = page["curves"]
    assert max(each for each in curves["filtered_n"] if each is not None) > 6
    assert max(each for each in curves["preset"] if each is not None) == pytest.approx(0.8 * FULL, abs=0.01)
    assert max(each for each in curves["shaft_mm"] if each is not None) > 3
    assert set(curves["measured_preset"]) == {None}


def test_off_ends_a_torque_that_was_left_on(served: tuple[Emulation, Path], command: Command) -> None:
    emulation, path = served
    bench = emulation.servers.bench
    bench.interrupt(lambda: bench.firmware.table.values.update({table.TORQUE_ENABLE: 1}))  # type: ignore[attr-defined]
    _, out, err = command("off", path)
    assert "actuator" in out + err
    assert torque(emulation) == 0
