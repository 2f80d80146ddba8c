"""The commands that set a rig up, against an emulated rig behind real ports."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
import tomllib
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.lab.by_hand import AtHome, Jogged
from emg2vsa.lab.rig_lock import lock_path, rig_lock, rig_user
from emg2vsa.rig.rig_settings import RigSettings
from tests.cli.rig.conftest import MOTORS_OFF, motors

Rig = Callable[..., tuple[int, str, str]]
WRONG = """\
[rig]
push_axis = [1, 0, 0] # of the sensor
push_sign = -1 # which way
home_ticks = 3800
gear_mm_per_degree = 0.1

"""


FRICTION_MM = 0.35
"The soft springs of moves by hand leave the shaft so far behind."


@pytest.fixture
def calliper(served: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """A person who looks at the emulated bench; what they were asked."""
    asked: list[str] = []
    start_mm, touch_mm = served.bench.probe()[0], 0.0

    def answer(question: str) -> str:
        nonlocal touch_mm
        asked.append(question)
        now_mm = served.bench.probe()[0]
        if "towards the pad" in question:
            return "y" if now_mm > start_mm else "n"
        if "Set a calliper" in question:
            touch_mm = now_mm
            return ""
        return f"{touch_mm - now_mm:.2f}" if "How far" in question else "y"

    monkeypatch.setattr("emg2vsa.cli.rig.choice._asked", answer)
    return asked


@pytest.mark.realtime
@pytest.mark.slow
def test_four_wrong_settings_are_found_and_mended(rig: Rig, served: SimpleNamespace, calliper: list[str]) -> None:
    text = served.path.read_text()
    served.path.write_text(WRONG + text)
    status, out, err = rig("commission", served.path)
    assert status == 0, out + err
    assert [line.split()[0] for line in out.splitlines() if "WRONG" in line] == [
        "push_axis", "push_sign", "gear_mm_per_degree", "home_deg",
    ]  # fmt: skip
    assert "Write push_axis, push_sign, gear_mm_per_degree, home_ticks, serial_number into" in calliper[-1]
    written = served.path.read_text().replace('serial_number = "FT00000"\n', "", 1)
    assert "push_axis = [0.0, 0.0, 1.0] # of the sensor\npush_sign = 1 # which way\n" in written
    assert written.endswith(text)
    found = tomllib.loads(written)["rig"]
    assert found["gear_mm_per_degree"] == pytest.approx(0.2, rel=0.01)
    assert "home_deg" not in found  # the unit of the file stays
    home_deg = found["home_ticks"] * DEG_PER_TICK
    assert RigSettings().depth_at(home_deg) == pytest.approx(0.0, abs=0.5)  # where it began, 2 mm above
    assert motors(served.bench) == MOTORS_OFF

    status, out, _ = rig("commission", served.path)
    assert status == 0
    assert "WRONG" not in out
    assert "these settings are right" in out


@pytest.mark.realtime
def test_moves_by_hand_and_the_proof_of_the_watchdog(rig: Rig, served: SimpleNamespace) -> None:
    status, out, err = rig("jog", served.path, "--mm", 1, "--json")
    assert status == 0, err
    moved = json.loads(out)
    assert moved["shaft_deg"] - moved["from_deg"] == pytest.approx(moved["moved_deg"], abs=1e-9)
    assert (moved["touched"], len(moved["force_n"])) == (False, 3)
    assert served.bench.probe()[0] == pytest.approx(1.0, abs=FRICTION_MM)
    assert moved["asked_mm"] == pytest.approx(1.0)
    assert moved["short"] == (abs(moved["moved_mm"] - 1) > 0.2)
    status, out, _ = rig("jog", served.path, "--mm", 5, "--deg-per-s", 10)
    assert status == 1
    assert "ended the move; back until the probe is free" in out
    assert served.bench.probe()[1] < 0.5
    assert motors(served.bench) == MOTORS_OFF

    status, out, _ = rig("home", served.path)
    assert (status, motors(served.bench)) == (0, MOTORS_OFF)
    assert served.bench.probe()[0] == pytest.approx(0.0, abs=FRICTION_MM)
    assert out.startswith("shaft at ")

    path = served.path
    path.write_text(path.read_text().replace("watchdog_s = 5", "watchdog_s = 0.5", 1))
    status, out, err = rig("prove-watchdog", path, "--yes")
    assert status == 0, out + err
    assert "motors off: the motors go off by themselves, or stop\n" in out
    proof = json.loads((path.parent / "rig.watchdog.json").read_text())["actuator"]
    assert (proof["verdict"], proof["firmware"], proof["device_id"]) == ("motors off", "QBMMP v6.1.0", 1)

    assert rig("jog", path, "--deg", 5)[0] == 0
    status, out, err = rig("zero", path, "--yes", "--json")
    assert status == 0, err
    after = json.loads(out)["after"]
    assert all(abs(angle_deg) <= 16 * DEG_PER_TICK for angle_deg in (*after["motors_deg"], after["shaft_deg"]))
    at = served.bench.answer(bytes.fromhex("3a3a 01 02 84 84"))
    assert all(abs(int.from_bytes(at[k : k + 2], signed=True)) <= 16 for k in (5, 7, 9))


@pytest.mark.realtime
def test_sigterm_during_a_jog_switches_off(rig: Rig, served: SimpleNamespace) -> None:
    threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGTERM)).start()
    status, _, _ = rig("jog", served.path, "--mm", -4, "--deg-per-s", 2)
    assert status == 130
    assert motors(served.bench) == MOTORS_OFF


REFUSED = {
    ("jog", "--mm", "1", "--deg-per-s", "100"): "--deg-per-s: expected above 0 and at most 25, but found 100.",
    ("jog", "--mm", "1", "--limit-n", "80"): "--limit-n: expected above 0 and at most 25, but found 80.",
    ("jog", "--mm", "40"): "probe: expected a position of -131.836 to 131.836 degrees, but found 200",
    ("commission", "--reach-deg", "0"): "--reach-deg: expected above 0 and at most 180, but found 0.",
    ("parameters", "--yes", "--set", "99=7"): "expected a parameter that the device lists, but found 99.",
    ("parameters", "--yes", "--set", "13=1.5"): "expected 1 values of type 'h' for parameter 13, Current limit",
    ("zero",): "standard input: expected an answer, but found the end of the input. Run it in a terminal, or add",
}


def test_what_cannot_be_is_refused(rig: Rig, served: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("builtins.input", lambda: (_ for _ in ()).throw(EOFError))
    for words, said in REFUSED.items():
        status, _, err = rig(words[0], served.path, *words[1:])
        assert status == 2, words
        assert said in " ".join(err.split())
        assert motors(served.bench) == MOTORS_OFF, words


def test_zero_tare_and_parameters(rig: Rig, served: SimpleNamespace, tmp_path: Path) -> None:
    status, out, err = rig("zero", served.path, "--yes")
    assert (status, "stored" in out) == (0, True), err
    served.bench.box._bias = (0.0, 0.0, -5.0, 0.0, 0.0, 0.0)
    status, out, _ = rig("tare", served.path)
    assert status == 0
    assert out.startswith("before: ")

    backup = tmp_path / "before.json"
    status, out, err = rig("parameters", served.path, "--backup", backup, "--set", "13=1200", "--yes")
    assert status == 0, err
    assert "13 Current limit                1200" in out
    assert json.loads(backup.read_text())["parameters"]["13"] == {"name": "Current limit", "values": [1500.0]}
    status, out, _ = rig("parameters", served.path, "--json")
    assert json.loads(out)["parameters"]["13"]["values"] == [1200]
    status, _, err = rig("parameters", served.path, "--backup", backup)
    assert status == 2
    assert f"{backup}: expected a new file, but found an existing file." in err


def test_off_ends_a_silent_process_and_switches_off(rig: Rig, served: SimpleNamespace, tmp_path: Path) -> None:
    """The process holds the rig's lock with a run in its folder, and hangs with the motors on."""
    folder = tmp_path / "runs" / "S1_0_modular"
    folder.mkdir(parents=True)
    hang = (
        "import sys, time; from pathlib import Path; from emg2vsa.lab.rig_lock import rig_lock\n"
        "with rig_lock(Path(sys.argv[1]), Path(sys.argv[2])): print('held', flush=True); time.sleep(60)"
    )
    process = subprocess.Popen([sys.executable, "-c", hang, str(served.path), str(folder)], stdout=subprocess.PIPE)
    try:
        assert process.stdout is not None
        process.stdout.readline()
        served.bench.answer(bytes.fromhex("3a3a 01 03 80 03 83"))
        user = rig_user(served.path)
        assert user is not None
        assert user.pid == process.pid
        status, _, err = rig("jog", served.path, "--mm", 1)
        assert status == 2
        assert f"expected a rig that no other process uses, but found process {process.pid}." in err
        begin_s = time.monotonic()
        status, out, err = rig("off", served.path)
        assert time.monotonic() - begin_s > 1.0
        assert [line for line in err.splitlines() if line.startswith("process")] == [
            f"process {process.pid} uses the rig: asked to stop", f"process {process.pid} is silent: ended",
        ]  # fmt: skip
        assert process.wait(60) == -signal.SIGKILL
        assert (folder / "stop").read_text() == "emg2vsa rig off\n"
    finally:
        process.kill()
    assert status == 1  # for the motor, which is not there
    assert "[actuator] motors off; motors at " in out
    assert "[motor] NOT confirmed off: /dev/no-such-motor: expected a serial port" in out
    assert motors(served.bench) == MOTORS_OFF
    assert rig_user(served.path) is None


def test_off_lets_a_process_that_obeys_end_by_itself(rig: Rig, served: SimpleNamespace, tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "S1_0_modular"
    obey = (
        "import sys, time; from pathlib import Path; from emg2vsa.lab.rig_lock import rig_lock\n"
        "folder = Path(sys.argv[2])\n"
        "with rig_lock(Path(sys.argv[1]), folder):\n"
        "    print('held', flush=True)\n"
        "    while not (folder / 'stop').exists(): time.sleep(0.01)\n"
        "    for _ in range(15):\n"
        "        time.sleep(0.1); (folder / 'log.csv').open('a').write('row\\n')\n"
    )
    folder.mkdir(parents=True)
    process = subprocess.Popen([sys.executable, "-c", obey, str(served.path), str(folder)], stdout=subprocess.PIPE)
    try:
        assert process.stdout is not None
        process.stdout.readline()
        _, out, err = rig("off", served.path)
        assert process.wait(60) == 0
    finally:
        process.kill()
    assert f"process {process.pid} has ended by itself" in err
    assert "[actuator] motors off" in out


def test_off_by_port_needs_no_rig_file(rig: Rig, served: SimpleNamespace) -> None:
    served.bench.answer(bytes.fromhex("3a3a 01 03 80 03 83"))
    status, out, _ = rig("off", "--port", served.servers.port)
    assert (status, motors(served.bench)) == (0, MOTORS_OFF)
    assert out.startswith("[device] motors off; ")


@pytest.mark.parametrize("spoil", ["deleted", "spoilt"])
def test_off_finds_a_run_whose_lock_names_it_no_more(
    spoil: str, rig: Rig, served: SimpleNamespace, tmp_path: Path
) -> None:
    folder, dead = tmp_path / "runs" / "S1_0_modular", tmp_path / "runs" / "S1_0_modular-2"
    for each in (folder, dead):
        each.mkdir(parents=True)
        (each / "log.csv").write_text("row\n")
        (each / "ended.json").write_text('{"how": "killed"}')
    os.utime(dead / "log.csv", (1, 1))
    with rig_lock(served.path, folder):
        lock = lock_path(served.path)
        lock.unlink() if spoil == "deleted" else lock.write_text("{")
        _, out, err = rig("off", served.path)
    assert f"{folder} has not ended, though the rig's lock names no run: asked to stop" in err
    assert ((folder / "stop").exists(), (dead / "stop").exists()) == (True, False)
    assert "[actuator] motors off" in out


@pytest.mark.parametrize(("moved_mm", "short"), [(0.39, True), (0.95, False)])
def test_a_move_that_falls_short_is_told(
    rig: Rig, rig_file: Callable[..., Path], monkeypatch: pytest.MonkeyPatch, moved_mm: float, short: bool
) -> None:
    done = Jogged(0.0, 5 * moved_mm, 5 * moved_mm, moved_mm, (0.0, 0.0, 0.0), False, 1.0, short)
    monkeypatch.setattr("emg2vsa.lab.by_hand.jog", lambda *_, **__: done)
    at = AtHome(5 * moved_mm, moved_mm, (0.0, 0.0, 0.0), False, False, short)
    monkeypatch.setattr("emg2vsa.lab.by_hand.home", lambda *_, **__: at)
    status, out, _ = rig("jog", rig_file(), "--mm", 1)
    assert (status, f"the probe went {moved_mm} of 1.00 mm: friction holds" in out) == (0, short)
    status, out, _ = rig("home", rig_file())
    assert (status, "the probe fell short of home: friction holds" in out) == (0, short)


@pytest.mark.parametrize("motor", [[], ["--motor"]], ids=["actuator", "rigid motor"])
def test_the_emulated_rig_is_commissioned_in_virtual_time(
    rig: Rig, rig_file: Callable[..., Path], motor: list[str]
) -> None:
    path = rig_file()
    before = path.read_text()
    status, out, err = rig("commission", path, "--virtual", *motor)
    assert status == 0, err
    verdicts = {line.split()[0]: line for line in out.splitlines() if " right " in line}
    assert list(verdicts) == ["push_axis", "push_sign", "gear_mm_per_degree", "home_deg", "travel_mm"]
    assert path.read_text() == before


def test_a_rig_without_an_emulated_one_has_no_virtual_commissioning(rig: Rig, rig_file: Callable[..., Path]) -> None:
    path = rig_file()
    path.write_text(path.read_text().partition("[emulated]")[0])
    status, _, err = rig("commission", path, "--virtual")
    assert (status, "expected a table [emulated], but found none" in err) == (2, True)
