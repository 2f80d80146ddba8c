"""``emg2vsa rig scan`` and ``info`` against an emulated rig behind real ports.

``emg2vsa rig emulate``: what it writes for other commands, and the lines typed into it.
"""

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
from emg2vsa.lab.emulation import check_replaceable, emulation, served_file
from emg2vsa.lab.rig_lock import rig_lock
from emg2vsa.rig_file import load_rig
from emg2vsa.run_folders.presses import is_simulated

Rig = Callable[..., tuple[int, str, str]]
NO_MOTOR = "/dev/no-such-motor: expected a serial port, but found "


def test_scan_lists_ports_and_ids(rig: Rig, served: SimpleNamespace) -> None:
    port = served.servers.port
    status, out, _ = rig("scan", "--port", port, "--id", 1, "--id", 2, "--wait-ms", 500)
    assert (status, out) == (0, f"{port}\n  id 1\n")
    status, out, _ = rig("scan", "--port", port, "--id", 1, "--wait-ms", 500, "--json")
    assert json.loads(out)["devices"] == [{"device": port, "usable": True, "problem": None, "lines": ["id 1"]}]


def test_scan_asks_no_port_that_is_not_named(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    adapter = SimpleNamespace(device="/dev/no-such-adapter", vid=0x0403, manufacturer="")
    monkeypatch.setattr("emg2vsa.devices.qbmove.conversation.list_ports.comports", lambda: [adapter])
    monkeypatch.setattr("emg2vsa.devices.serial_line.serial.Serial", lambda *args, **options: pytest.fail("opened"))
    assert rig("scan")[:2] == (0, "/dev/no-such-adapter\n  an adapter as actuators have; ask it with --port\n")


def test_scan_with_a_rig_file_looks_for_all_its_devices(rig: Rig, served: SimpleNamespace) -> None:
    status, out, _ = rig("scan", served.path, "--id", 1, "--wait-ms", 500)
    assert status == 1  # for the motor, which is not there
    assert f"{served.servers.port}\n  id 1\n" in out
    assert f"/dev/no-such-motor\n  not usable: {NO_MOTOR}" in out
    assert "\n  status 0x00000000: good\n" in out
    assert "\n  frames of 300 x 300 pixels, " in out


def test_scan_of_a_silent_line(rig: Rig, served: SimpleNamespace) -> None:
    served.bench.wire.mute = True
    port = served.servers.port
    status, out, _ = rig("scan", "--port", port, "--id", 1)
    assert status == 1
    assert f"{port}\n  not usable: {port}: expected a qbmove that answers, but found none." in out


def test_scan_without_ports(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("emg2vsa.devices.qbmove.conversation.list_ports.comports", list)
    assert rig("scan")[:2] == (1, "no serial port with an actuator's adapter; name another with --port\n")


@pytest.mark.parametrize(("kind", "wrong", "wanted"), [("qbmove", 0, "1 to 255"), ("dynamixel", 254, "0 to 252")])
def test_an_id_that_no_device_of_the_kind_has_is_not_asked(
    kind: str, wrong: int, wanted: str, rig: Rig, served: SimpleNamespace
) -> None:
    """Id 0 of a qbmove and 254 of a Dynamixel are those of all devices at once."""
    port = served.servers.port
    status, out, _ = rig("scan", "--port", port, "--kind", kind, "--baud", 2_000_000, "--id", wrong)
    said = f"--id: expected ids of {wanted}, but found {wrong}. Leave it out to ask all."
    assert (status, out) == (1, f"{port}\n  not usable: {said}\n")


def test_info_tells_what_each_device_knows(rig: Rig, served: SimpleNamespace) -> None:
    status, out, _ = rig("info", served.path)
    assert status == 1
    assert f"[actuator] {served.servers.port}, id 1\n  firmware QBMMP v6.1.0, id 1\n" in out
    assert "\n  position limits of motor 2: -15000 to 15000 ticks\n" in out
    assert "\n  motors off\n" in out
    assert "\n  set up for runs\n" in out
    assert "\n  a run may use: positions -131.836 to 131.836 degrees, 20 to 80 % of full stiffness\n" in out
    assert "\n    11 Pos. limits [inf, sup]       -15000, 15000, -15000, 15000\n" in out
    assert f"[motor] /dev/no-such-motor, id 1\n  not usable: {NO_MOTOR}" in out
    assert "\n  1e+06 counts/N, 1e+06 counts/(N m)\n" in out
    assert "[camera] http://127.0.0.1:" in out


def test_info_of_the_rigid_motor_tells_of_its_one_motor(
    rig: Rig, rig_file: Callable[..., Path], served: SimpleNamespace
) -> None:
    _, out, _ = rig("info", rig_file(motor_port=served.servers.port))
    motor = out[out.index("[motor]") :].partition("[force]")[0]
    assert "\n  motor at " in motor
    assert "shaft at" not in motor
    assert "motors at" not in motor


def test_info_without_any_device_says_so_of_each(rig: Rig, rig_file: Callable[..., Path]) -> None:
    status, out, err = rig("info", rig_file())
    assert (status, err) == (1, "")
    assert out.count("not usable") == 4


@pytest.mark.parametrize("command", ["info", "scan"])
def test_no_device_is_asked_while_a_run_uses_the_rig(command: str, rig: Rig, served: SimpleNamespace) -> None:
    with rig_lock(served.path, served.path.parent / "runs" / "S1_0_modular"):
        status, out, err = rig(command, served.path)
    assert (status, "[force]" in out) == (2, False)
    assert f"{served.path}: expected a rig that no other process uses, but found process " in err


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
    monkeypatch.setattr("emg2vsa.worlds.far_ends.ports.sys", SimpleNamespace(platform="win32"))
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


NUMBERS = {"[actuator]": "0000000017", "[motor]": "0000000018", "[force]": "FT12345"}


def test_serial_numbers_of_the_file_are_told_by_the_emulated_devices_and_show_exchanged_ports(
    rig: Rig, rig_file: Callable[..., Path], tmp_path: Path
) -> None:
    path, written = rig_file(), tmp_path / "emulated.toml"
    text = path.read_text()
    for table, number in NUMBERS.items():
        text = text.replace(f"{table}\n", f'{table}\nserial_number = "{number}"\n')
    path.write_text(text)
    with emulation(load_rig(path), write=written) as served:
        status, out, _ = rig("info", written)
        assert (status, out.count(", told by the device\n")) == (0, 3)
        assert all(f"\n  serial number {number}, told by the device\n" in out for number in NUMBERS.values())
        ports = served.servers.port, served.servers.idle_port
        swapped = written.read_text().replace(ports[0], "here").replace(ports[1], ports[0]).replace("here", ports[1])
        written.write_text(swapped)
        status, out, _ = rig("info", written)
    exchanged = ", told by the device. The ports of [actuator] and [motor] are exchanged: exchange them in rig.toml.\n"
    assert (status, out.count(exchanged)) == (1, 2)
