"""A laboratory's own devices, as docs/how-to/add-a-device.md shows them: in rig info, in files and in a session.

They stand behind real lines. What is said of a package that breaks the contract.
"""

from __future__ import annotations

import math
import os
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from pathlib import Path

import numpy as np
import pytest

from benchmarks.small_study import small_study
from casr.errors import PluginError
from casr.plugins import found_plugins
from emg2vsa.cli import main
from emg2vsa.devices import registry
from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.joints import export_of, joint_names, joint_of
from emg2vsa.devices.registry import Around
from emg2vsa.errors import DeviceError, StudyError
from emg2vsa.lab.by_hand import jog
from emg2vsa.lab.device_states import info
from emg2vsa.lab.session_devices import devices
from emg2vsa.rig.open_rig import open_camera, open_force
from emg2vsa.rig.rig_settings import GuardSettings
from emg2vsa.rig_file import load_rig
from emg2vsa.session.open_session import folder_of, open_session
from emg2vsa.session.raw_files import SampleFile
from emg2vsa.study_file import load_study
from emg2vsa.worlds.far_ends.ports import VirtualSerialPort
from tests.plugins.conftest import device_example

if sys.platform != "win32":
    import tty

Install = Callable[..., Path]
PATIENT = GuardSettings(stale_s=0.5)
RIG = """
[actuator]
kind = "lab-actuator"
port = "{motor}"
[force]
kind = "lab-box"
port = "{box}"
[camera]
kind = "lab-camera"
host = "127.0.0.1"
port = {camera}
height = 40
width = 60
[experiment]
specimens = ["S1"]
angles_deg = {{ modular = [0] }}
"""
SESSION = """
[session]
[session.emg]
kind = "lab-emg"
port = "{emg}"
channels = {{ EDC = "1", FDS = "3" }}
[session.force]
kind = "rig"
rig = "rig.toml"
axis = [0, 0, 1]
"""


class Sender:
    """A device on a pseudo-terminal that sends lines by itself, whether anybody reads them or not."""

    def __init__(self, rate_hz: float, line: Callable[[float], str]) -> None:
        self.mute, self._rate_hz, self._line, self._ended = False, rate_hz, line, threading.Event()
        self._ends = os.openpty()
        tty.setraw(self._ends[1])
        os.set_blocking(self._ends[0], False)
        self.name = os.ttyname(self._ends[1])
        self._thread = threading.Thread(target=self._send)

    def __enter__(self) -> Sender:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ended.set()
        self._thread.join()
        for end in self._ends:
            os.close(end)

    def _send(self) -> None:
        clock, sent = WallClock(), 0
        while not self._ended.wait(0.005):
            due = int(clock.now_s() * self._rate_hz)
            lines = "".join(f"{self._line(n / self._rate_hz)}\n" for n in range(sent, due))
            sent = due
            with suppress(BlockingIOError):  # nobody reads
                os.write(self._ends[0], b"" if self.mute else lines.encode())


no_ports = pytest.mark.skipif(sys.platform == "win32", reason="no virtual serial ports")


@pytest.fixture
def box() -> Iterator[Sender]:
    """The force box: 2 N along z that tremble."""
    with Sender(500.0, lambda time_s: f"0.1 0.2 {2 + 0.01 * math.sin(40 * time_s):.4f} 0 0 0.01") as sender:
        yield sender


@pytest.fixture
def emg() -> Iterator[str]:
    """The amplifier: three columns, mV."""
    line = lambda time_s: f"{math.sin(500 * time_s):.4f} 9.9 {2 * math.sin(500 * time_s):.4f}"  # noqa: E731
    with Sender(1000.0, line) as sender:
        yield sender.name


@pytest.fixture
def camera() -> Iterator[int]:
    """The camera: 40 x 60 pixels, 20 pictures a second."""
    ended = threading.Event()
    picture = np.arange(2400, dtype=np.uint8).tobytes()

    def send(listening: socket.socket) -> None:
        while not ended.is_set():
            try:
                client, _ = listening.accept()
                with client:
                    while not ended.wait(0.05):
                        client.sendall(picture)
            except OSError:
                continue

    with socket.create_server(("127.0.0.1", 0)) as listening:
        listening.settimeout(0.1)
        thread = threading.Thread(target=send, args=(listening,))
        thread.start()
        yield listening.getsockname()[1]
        ended.set()
        thread.join()


@pytest.fixture
def motor() -> Iterator[str]:
    """The actuator: its shaft lags a degree behind its motor."""
    state = {"motors": "off", "where": 0.0}

    def answer(data: bytes) -> bytes:
        said = []
        for question in data.decode().splitlines():
            word, *rest = question.split()
            if word == "motors" and rest:
                state["motors"] = rest[0]
            if word == "go":
                state["where"] = float(rest[0])
            place = f"{state['where']:.3f} {state['where'] - 1:.3f}"
            told = {"where": place, "current": "0.25", "limit": "1.5", "firmware": "2.1"}
            said.append(told.get(word) or (str(state["motors"]) if question == "motors" else "ok"))
        return "".join(f"{each}\n" for each in said).encode()

    with VirtualSerialPort(answer) as port:
        yield port.name


@pytest.fixture
def lab(install: Install) -> None:
    entries, modules = device_example()
    install(entries=entries, modules=modules)


@pytest.fixture
def rig_file(lab: None, tmp_path: Path, box: Sender, camera: int, motor: str) -> Path:
    path = tmp_path / "rig.toml"
    path.write_text(RIG.format(box=box.name, camera=camera, motor=motor))
    return path


@no_ports
def test_rig_info_shows_a_labs_own_devices(rig_file: Path) -> None:
    actuator, force, camera = info(load_rig(rig_file))
    assert actuator.usable, actuator.problem
    assert actuator.lines[0] == "firmware 2.1, motors off"
    assert actuator.lines[1].startswith("a run may use: positions -")
    assert force.usable, force.problem
    assert force.lines[1] == "made for 70 N along z"
    assert force.lines[2].startswith("force 0.100, 0.200, ")
    assert camera.usable, camera.problem
    assert camera.lines[0].startswith("frames of 40 x 60 pixels, ")


@no_ports
def test_a_force_box_is_biased_and_told_when_it_falls_silent(rig_file: Path, box: Sender) -> None:
    sensor, clock = open_force(load_rig(rig_file).devices.force, PATIENT, WallClock()), WallClock()
    sensor.start()
    assert sensor.read().force_n[2] == pytest.approx(2.0, abs=0.02)
    sensor.bias()
    clock.sleep_until(0.2)
    assert sensor.read().size_n < 0.1
    assert sensor.counts().records >= len(sensor.read_all()) > 20
    box.mute = True
    clock.sleep_until(clock.now_s() + 0.2)
    sensor.read()
    clock.sleep_until(clock.now_s() + 1.2)
    with pytest.raises(DeviceError, match=r"lab box at .* expected 500 lines a second, but found none"):
        sensor.read()
    sensor.close()


@no_ports
def test_a_camera_gives_pictures_and_facts(rig_file: Path) -> None:
    settings = load_rig(rig_file).devices.camera
    camera = open_camera(settings, PATIENT, WallClock())
    camera.start()
    assert camera.frames()[0].image[1, 0] == 60
    assert registry.known("camera", settings).call("facts", camera, settings)["kind"] == "lab-camera"
    camera.close()


@no_ports
def test_a_session_records_a_labs_own_devices(rig_file: Path, emg: str, tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(small_study(participants=["P01"], specimens=["S1"], task="press", tables=SESSION.format(emg=emg)))
    study, clock = load_study(path), WallClock()
    _, makers = devices(study, study.session, "P01", clock, None)
    with open_session(study, "P01", clock, makers) as desk:
        begun_s = clock.now_s()

        def beside(now_s: float) -> None:
            if now_s > begun_s + 1.5:
                desk.session.end("ended", "test")

        desk.run(clock, beside)
    emg_file, force_file = (
        SampleFile(folder_of(study, "P01") / f"sitting-1_{name}.samples") for name in ("emg", "force")
    )
    assert emg_file.info.channels == ("EDC", "FDS")
    assert emg_file.info.facts["device"].startswith("lab EMG at ")
    assert force_file.info.facts["device"].startswith("lab box at ")
    for file, scale in ((emg_file, (1e-3, 2e-3)), (force_file, (2.0,))):
        samples = file.read(0, file.stop)
        assert len(samples) > 400
        assert np.nanmax(np.abs(samples), axis=0) == pytest.approx(scale, rel=0.05)


@no_ports
def test_an_actuator_speaks_of_degrees(lab: None, motor: str) -> None:
    kind = registry.kind_of("actuator", "lab-actuator")
    assert kind is not None
    board = kind.opened(kind.settings(port=motor), Around(WallClock()))
    with closing(board), board:
        board.activate()
        assert board.is_active()
        board.command(30.0, 0.5)
        at = board.measurements()
        assert (at.motors_deg, at.shaft_deg, board.currents_a(), board.current_limit_a()) == ((30,), 29, (0.25,), 1.5)
        assert board.pressing().joint.torque_nm(at, 30.0, 0.5) == pytest.approx(-6.0 * math.radians(1.0))
        with pytest.raises(DeviceError, match=r"but found 91 and 0\.5"):
            board.command(91.0, 0.5)
        board.deactivate()
        assert not board.is_active()


class Bench:
    """The actuator over a pad at 6 degrees, and what the force box feels there.

    The motor pulls towards its command with 12 N m/rad at preset 1; the pad has 2 N/mm at 0.2 mm per degree."""

    def __init__(self) -> None:
        self.motors, self.presets, self.most_n = "off", set[float](), 0.0
        self._command_deg, self._preset = 0.0, 0.2

    def shaft_deg(self) -> float:
        if self.motors == "off" or self._command_deg < 6.0:
            return min(self._command_deg, 6.0)
        pad, joint = 0.4 * math.degrees(0.2) / 1000, math.radians(12.0 * self._preset)  # N m per degree
        return (joint * self._command_deg + pad * 6.0) / (joint + pad)

    def force_n(self) -> float:
        return 0.4 * max(0.0, self.shaft_deg() - 6.0)

    def __call__(self, data: bytes) -> bytes:
        return "".join(f"{self._answer(*question.split())}\n" for question in data.decode().splitlines()).encode()

    def _answer(self, word: str, *rest: str) -> str:
        if word == "motors" and rest:
            self.motors = rest[0]
        if word == "go":
            self._command_deg, self._preset = map(float, rest)
            self.presets.add(self._preset)
            self.most_n = max(self.most_n, self.force_n())
        place = f"{self.shaft_deg():.4f}"
        told = {"where": f"{place} {place}", "current": "0.25", "limit": "1.5", "firmware": "2.1"}
        return told.get(word) or ("ok" if rest else self.motors)


@no_ports
def test_a_labs_actuator_is_moved_by_hand_until_it_touches(lab: None, camera: int, tmp_path: Path) -> None:
    bench, path = Bench(), tmp_path / "rig.toml"
    felt = Sender(500.0, lambda time_s: f"0 0 {bench.force_n() + 0.01 * math.sin(40 * time_s):.4f} 0 0 0")
    with VirtualSerialPort(bench) as motor, felt:
        path.write_text(f"[rig.guards]\nstale_s = 0.1\n{RIG.format(box=felt.name, camera=camera, motor=motor.name)}")
        moved = jog(load_rig(path), deg=40.0)
    assert moved.touched
    assert 2.0 <= bench.most_n < 2.4
    assert moved.force_n[2] < 0.5
    assert (bench.motors, bench.presets) == ("off", {0.2})


def test_a_report_on_a_labs_actuator_says_nothing_of_a_dynamixel(lab: None) -> None:
    assert export_of("dynamixel").remark
    assert not export_of("lab-actuator").remark


def test_schedules_are_made_for_a_labs_own_joint(lab: None) -> None:
    assert "lab-actuator" in joint_names()
    assert joint_of("lab-actuator", 12.0).stiffness_nm_per_rad(0.5) == 6.0


def force_table(table: str) -> str:
    return (
        RIG.format(box="/dev/none", camera=1, motor="/dev/none")
        .replace("lab-actuator", "qbmove")
        .replace('kind = "lab-box"\nport = "/dev/none"', table)
    )


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ('kind = "lab-boxx"', "force.kind: expected 'net-ft', 'ni-daq' or 'lab-box', but found \"lab-boxx\". Did you "
                              "mean 'lab-box'? Of other packages: lab-box of lab-tools 1.0."),
        ('kind = "lab-emg"', "force.kind: expected 'net-ft', 'ni-daq' or 'lab-box', but found \"lab-emg\", which is of "
                             "the role emg."),
        ('kind = "lab-actuator"', "but found \"lab-actuator\", which is of the role actuator."),
        ('kind = "qbmove"', "but found \"qbmove\", which is of the role actuator."),
        ('kind = "lab-box"', "force.port: expected a key 'port' with kind = 'lab-box', but found nothing."),
        ('kind = "lab-box"\nport = ""', "force.port: expected text that is not empty"),
        ('kind = "lab-box"\nport = "x"\nhost = "y"', "force.host: expected keys of this kind only ('host' is of "
                                                     "'net-ft'), but found 'host' with kind = 'lab-box'."),
        ('kind = "net-ft"\nport = "x"', "force.port: expected keys of this kind only ('port' is of 'lab-box'), but"),
        ('kind = "lab-box"\nport = "x"\nsize = 9', "force.size: expected a known key, but found 'size'. The keys are "
                                                   "kind, serial_number, bias, port."),
        ("kind = 3", "force.kind: expected 'net-ft', 'ni-daq' or 'lab-box', but found 3."),
        ("bias = true", "force.kind: expected a key 'kind', but found nothing."),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_labs_table_is_said_at_its_key(lab: None, tmp_path: Path, table: str, said: str) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(force_table(table))
    with pytest.raises(StudyError) as caught:
        load_rig(path)
    (problem,) = caught.value.problems
    assert said in problem


def test_a_kinds_own_check_is_heard(lab: None, tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    session = SESSION.format(emg="/dev/x")
    for channels, said in (
        (
            'EDC = "1", FDS = "9"',
            "session.emg.channels.FDS: expected the number of a column, '1' to '8', but found '9'",
        ),
        ('EDC = "1", FDS = "1"', "session.emg.channels.FDS: expected a channel of its own for each muscle, but found"),
        ('EDC = "1"', "session.emg.channels.FDS: expected the source's channel of the muscle 'FDS', but found nothing"),
    ):
        changed = session.replace('EDC = "1", FDS = "3"', channels)
        path.write_text(small_study(participants=["P01"], specimens=["S1"], task="press", tables=changed))
        with pytest.raises(StudyError) as caught:
            load_study(path)
        assert said in str(caught.value)


HEAD = """
from dataclasses import dataclass
from typing import Literal
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.devices.registry import Kind
@dataclass(frozen=True, kw_only=True)
class Own(ForceSettings):
    kind: Literal["own"] = "own"
"""
GROUPS = {"emg2vsa.devices": {"own": "lab_tools:OWN"}}
BROKEN = {
    "import no_such_module_at_all": "expected a module that can be imported from the plugin own of lab-tools 1.0, but "
                                    "found ModuleNotFoundError",
    "OWN = 3": "expected a Kind of emg2vsa.devices.registry from the plugin own of lab-tools 1.0, but found an object "
               "of type int. Tell the authors of lab-tools, or uninstall it.",
    f"{HEAD}OWN = Kind('thermometer', Own, open=print)": "expected one of the roles actuator, force, camera, emg, "
                                                        "session-force from the plugin own",
    f"{HEAD}OWN = Kind('force', dict, open=print)": "expected settings that inherit from "
                                                   "emg2vsa.devices.device_settings.ForceSettings from",
    f"{HEAD}OWN = Kind(['force'], Own, open=print)": "from the plugin own of lab-tools 1.0, but found ['force'].",
    f"{HEAD}    y: 'Nope' = 1\nOWN = Kind('force', Own, open=print)": "expected settings whose annotations can be read "
        "from the plugin own of lab-tools 1.0, but found NameError: name 'Nope' is not defined.",
    f"{HEAD}    kind: Literal['own'] = 'own'\n    bias: bytes = b''\nOWN = Kind('force', Own, open=print)": "expected "
        "settings that can be made from the plugin own of lab-tools 1.0, but found KeyError",
    f"{HEAD}    def __post_init__(self): raise ValueError('odd')\nOWN = Kind('force', Own, open=print)":
        "expected settings that can be made from the plugin own of lab-tools 1.0, but found ValueError: odd.",
    f"{HEAD}class Mute(Exception):\n    def __str__(self): raise ValueError\ndef check(own): raise Mute\n"
    "OWN = Kind('force', Own, open=print, check=check)": "expected check of its Kind to do its work from the plugin "
        "own of lab-tools 1.0, but found Mute.",
    f"{HEAD}OWN = Kind('force', Own, open=print, check=lambda own: [(3, 4, 5, 6)])": "expected check of its Kind to do "
        "its work from the plugin own of lab-tools 1.0, but found TypeError: 3 is no tuple of keys.",
    HEAD.replace('"own"', '"other"') + "OWN = Kind('force', Own, open=print)": 'expected settings with kind: Literal['
        '"own"], as the entry point is called from the plugin own of lab-tools 1.0, but found kind: \'other\'',
    f"{HEAD}OWN = Kind('force', Own, open=print, check=lambda own: 1 / 0)": "expected check of its Kind to do its work "
        "from the plugin own of lab-tools 1.0, but found ZeroDivisionError",
    f"{HEAD}OWN = Kind('force', Own, open=print, check=lambda own: iter([(('bias',), 'a zero', 'none')]))":
        "force.bias: expected a zero, but found none.",
}  # fmt: skip
"""Code of a package, and what is said at the table that names its kind."""


@pytest.mark.parametrize("code", BROKEN)
def test_a_package_that_breaks_the_contract_is_one_problem(install: Install, tmp_path: Path, code: str) -> None:
    install(code=code, entries=GROUPS)
    path = tmp_path / "rig.toml"
    path.write_text(force_table('kind = "own"\nbias = true'))
    with pytest.raises(StudyError) as caught:
        load_rig(path)
    assert BROKEN[code] in str(caught.value)
    path.write_text(force_table('kind = "net-ft"').replace('kind = "lab-camera"', "source = 0").replace("port = 1", ""))
    if "host" in path.read_text():
        path.write_text(path.read_text().replace('host = "127.0.0.1"\n', ""))
    assert load_rig(path).devices.force.kind == "net-ft"


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("open=lambda own, around: 1 / 0", "expected open of its Kind to do its work, but found ZeroDivisionError"),
        ("open=lambda own, around: own", "expected a device with name, rating, rate_hz, start, read, read_all, counts, "
                                         "bias, close, but found no name, rating"),
        ("open='lab_tools:absent'", "found AttributeError: module 'lab_tools' has no attribute 'absent'"),
    ],
)  # fmt: skip
def test_a_device_that_cannot_be_opened_is_one_error(install: Install, kind: str, said: str) -> None:
    install(code=f"{HEAD}OWN = Kind('force', Own, {kind})", entries=GROUPS)
    found = registry.kind_of("force", "own")
    assert found is not None
    with pytest.raises(PluginError) as caught:
        open_force(found.settings(), PATIENT, WallClock())
    assert str(caught.value).startswith("plugin own of lab-tools 1.0: ")
    assert said in str(caught.value)


def test_the_command_says_one_line(install: Install, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    install(code=f"{HEAD}OWN = Kind('force', Own, open=lambda own, around: 1 / 0)", entries=GROUPS)
    path = tmp_path / "rig.toml"
    path.write_text(
        '[actuator]\n[force]\nkind = "own"\n[experiment]\nspecimens = ["S1"]\nangles_deg = { modular = [0] }'
    )
    assert main(["rig", "info", str(path)]) != 0
    said = capsys.readouterr()
    assert "not usable: plugin own of lab-tools 1.0: expected open of its Kind" in said.out + said.err
    assert "Traceback" not in said.out + said.err


def test_two_packages_with_one_kind_are_one_error_that_names_both(install: Install, tmp_path: Path) -> None:
    folder = install(code=f"{HEAD}OWN = Kind('force', Own, open=print)", entries=GROUPS)
    other = folder / "lab_more-2.0.dist-info"
    other.mkdir()
    (other / "METADATA").write_text("Metadata-Version: 2.1\nName: lab-more\nVersion: 2.0\n")
    (other / "entry_points.txt").write_text("[emg2vsa.devices]\nown = lab_more:OWN\n")
    found_plugins.cache_clear()
    path = tmp_path / "rig.toml"
    path.write_text(force_table('kind = "own"'))
    with pytest.raises(StudyError) as caught:
        load_rig(path)
    assert "from the plugin own, but found it in lab-more 2.0, lab-tools 1.0. Uninstall all but one" in str(
        caught.value
    )
    assert list(registry.kinds("force")) == ["net-ft", "ni-daq"]


def test_a_plugin_never_takes_the_place_of_ours(install: Install) -> None:
    code = HEAD.replace('"own"', '"net-ft"') + "OWN = Kind('force', Own, open=print)"
    install(code=code, entries={"emg2vsa.devices": {"net-ft": "lab_tools:OWN"}})
    found = registry.kind_of("force", "net-ft")
    assert found is not None
    assert found.plugin is None
    assert list(registry.kinds("force")) == ["net-ft", "ni-daq"]
