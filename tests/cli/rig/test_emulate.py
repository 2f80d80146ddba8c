"""``emg2vsa rig emulate``: what it writes for other commands, and the lines typed into it."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from emg2vsa.errors import SettingError
from emg2vsa.lab.emulation import check_replaceable, served_file
from emg2vsa.rig_file import load_rig
from emg2vsa.run_folders.presses import is_simulated

Rig = Callable[..., tuple[int, str, str]]


@pytest.fixture
def typed(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Lines on standard input."""
    return lambda lines: monkeypatch.setattr("sys.stdin", io.StringIO(lines))


def test_the_written_file_leads_to_the_emulated_devices(served: SimpleNamespace, tmp_path: Path) -> None:
    file = load_rig(served.path)
    (tmp_path / "elsewhere").mkdir()
    written = tmp_path / "elsewhere" / "emulated.toml"
    written.write_text(served_file(file, served.servers, written.parent))
    again = load_rig(written)
    assert (again.rig, again.experiment) == (file.rig, file.experiment)
    assert again.emulated == replace(file.emulated, behind_ports=True)
    assert again.schedules.resolve() == file.schedules.resolve()
    assert again.runs.resolve() == tmp_path / "runs-emulated"
    devices, motor = again.devices, again.devices.motor
    assert motor
    assert devices.actuator.port == served.servers.port != motor.port == served.servers.idle_port
    assert (devices.force.http_port, devices.force.rdt_port) == (
        served.servers.force.http_port, served.servers.force.rdt_port,
    )  # fmt: skip
    assert devices.camera
    assert devices.camera.source == served.servers.camera_url


def test_only_files_of_its_own_are_replaced(served: SimpleNamespace, tmp_path: Path) -> None:
    check_replaceable(tmp_path / "new.toml")
    (tmp_path / "old.toml").write_text(served_file(load_rig(served.path), served.servers, tmp_path))
    check_replaceable(tmp_path / "old.toml")
    with pytest.raises(SettingError, match="another file"):
        check_replaceable(served.path)


def test_faults_are_put_on_beforehand(rig: Rig, rig_file: Callable[..., Path], typed: Callable[[str], None]) -> None:
    typed("quit\n")
    faults = ["--fault", "ignore at 2 N for 1.5 s", "--fault", "gain 0.5"]
    status, out, err = rig("emulate", rig_file(), *faults)
    assert (status, err) == (0, "")
    assert "# ignore on: no position command reaches the actuator, all else does, at 2 N, for 1.5 s\n" in out
    assert "# gain: the force sensor gives 0.5 times the load\n" in out


def test_it_serves_until_quit(
    rig: Rig, rig_file: Callable[..., Path], typed: Callable[[str], None], tmp_path: Path
) -> None:
    typed("help\n\ngap 2\nfire\nquit\nstuck on\n")
    status, out, err = rig("emulate", rig_file(), "--rigid", "--write", tmp_path / "emulated.toml")
    assert (status, err) == (0, "")
    assert out.startswith("# S1 at 0 degrees under the rigid motor")
    assert "the next 2 datagrams of the force sensor are lost" in out
    assert "found 'fire'. Type help" in out
    assert out.endswith("end of the emulation\n")
    assert "stuck on:" not in out
    told = tomllib.loads(out.partition("\n# written")[0])
    written = load_rig(tmp_path / "emulated.toml").devices
    assert written.motor
    assert (told["motor"]["port"], told["actuator"]["port"]) == (written.motor.port, written.actuator.port)


def test_on_windows_it_says_what_to_do(
    rig: Rig, rig_file: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("emg2vsa.worlds.bench.servers.sys", SimpleNamespace(platform="win32"))
    status, out, err = rig("emulate", rig_file())
    assert (status, out) == (2, "")
    assert "expected a system with virtual serial ports, but found Windows. Use emg2vsa rig run --virtual." in err


@pytest.mark.slow
def test_in_another_shell(rig: Rig, rig_file: Callable[..., Path], tmp_path: Path) -> None:
    written = tmp_path / "emulated.toml"
    command = [sys.executable, "-m", "emg2vsa.cli", "rig", "emulate", str(rig_file()), "--write", str(written)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as emulation:
        try:
            use_from_here(emulation, rig, written)
        finally:
            emulation.kill()  # else a failure waits for it for ever
    assert is_simulated([tmp_path / "runs-emulated" / "S1_0_modular"])
    ended = json.loads((tmp_path / "runs-emulated" / "S1_0_modular" / "ended.json").read_text())
    assert ended["how"] == "completed"


def use_from_here(emulation: subprocess.Popen[str], rig: Rig, written: Path) -> None:
    assert emulation.stdout
    assert emulation.stdin
    while not emulation.stdout.readline().startswith("# help"):
        assert emulation.poll() is None
    assert rig("info", written)[0] == 0
    status, out, _ = rig("run", written, "--specimen", "S1", "--angle", "0", "--condition", "modular")
    assert status == 0, out
    emulation.stdin.write("dark on\n")
    emulation.stdin.flush()
    assert emulation.stdout.readline() == "dark on: the camera gives no frames\n"
    emulation.terminate()
    assert emulation.wait() == 0
