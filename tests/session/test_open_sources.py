"""Sources of a session from its settings: what opens, and one clear error for what cannot."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from emg2vsa.devices.clock import VirtualClock, WallClock
from emg2vsa.devices.lsl import LslEmgSettings, LslForceSettings
from emg2vsa.devices.lsl.driver import LslSource
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.ni_daq import NiEmgSettings, NiGaugeSettings
from emg2vsa.devices.ni_daq.inputs import NiEmg
from emg2vsa.devices.rig_force import RigForceSettings
from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.devices.trigno import TrignoSettings
from emg2vsa.devices.trigno.driver import TrignoSource
from emg2vsa.errors import DeviceError, InputError, SettingError
from emg2vsa.session.open_session import source_makers
from emg2vsa.session_settings import EmgSettings, SessionForceSettings, SessionSettings

MUSCLES = ("EDC", "FDS")
NI = NiEmgSettings(channels={"FDS": "Dev1/ai7", "EDC": "Dev1/ai6"}, gain=1000.0)
TRIGNO = TrignoSettings(channels={"EDC": "1", "FDS": "2"})
LSL = LslEmgSettings(channels={"EDC": "a", "FDS": "b"})
NOBODY = SimulatedEmgSettings()
RIG, NO_FORCE = RigForceSettings(rig="rig.toml"), SimulatedForceSettings()
BOX = NetFtSettings(host="127.0.0.1")
CAL = """<?xml version="1.0" encoding="utf-8"?>
<FTSensor Serial="FT1" BodyStyle="Mini45" Family="DAQ" NumGages="6" CalFileVersion="1.1">
<Calibration PartNumber="SI-290-10" CalDate="1/1/2020" ForceUnits="N" TorqueUnits="N-m" DistUnits="m"
 OutputMode="Ground Referenced Differential" OutputRange="20" HWTempComp="True" GainMultiplier="1"
 CableLossDetection="False" OutputBipolar="True">
%s</Calibration></FTSensor>
"""


def settings(emg: EmgSettings, force: SessionForceSettings = NO_FORCE) -> SessionSettings:
    return SessionSettings(emg=emg, force=force)


@pytest.fixture
def cal_file(tmp_path: Path) -> str:
    rows = "".join(
        f'<{tag} Name="{name}" values="{" ".join("1" if i == j else "0" for j in range(6))}" max="100" scale="1"/>'
        for tag in ("Axis", "UserAxis")
        for i, name in enumerate(("Fx", "Fy", "Fz", "Tx", "Ty", "Tz"))
    )
    rows += '<BasicTransform Dx="0" Dy="0" Dz="0" Rx="0" Ry="0" Rz="0"/>'
    path = tmp_path / "FT1.cal"
    path.write_text(CAL % rows)
    return str(path)


@pytest.mark.parametrize(("emg", "kind"), [(NI, NiEmg), (TRIGNO, TrignoSource), (LSL, LslSource)])
def test_every_kind_of_emg_opens_again_and_again(emg: EmgSettings, kind: type) -> None:
    pytest.importorskip({NiEmg: "nidaqmx", LslSource: "pylsl"}.get(kind, "numpy"))
    make_emg, _ = source_makers(settings(emg), MUSCLES, WallClock())
    first, second = make_emg(), make_emg()
    assert type(first) is type(second) is kind
    assert first is not second


@pytest.mark.parametrize(
    ("chosen", "which", "words"),
    [
        (settings(NOBODY), 0, 'session.emg.kind: expected a device, but found "simulated". Run the session with'),
        (settings(TRIGNO), 1, 'session.force.kind: expected a device, but found "simulated"'),
        (settings(replace(TRIGNO, channels={"EDC": "x", "FDS": "2"})), 0, "the number of a Trigno sensor"),
        (settings(TRIGNO, RIG), 1, "session.force.rig: expected a rig file, but found none"),
    ],
)
def test_one_clear_error(chosen: SessionSettings, which: int, words: str) -> None:
    with pytest.raises(SettingError) as caught:
        source_makers(chosen, MUSCLES, VirtualClock())[which]()
    assert words in str(caught.value)


def test_a_box_without_an_address() -> None:
    with pytest.raises(SettingError, match=r"force\.host: expected the address of the box"):
        source_makers(settings(TRIGNO, RIG), MUSCLES, VirtualClock(), rig_force=replace(BOX, host=None))[1]()


def test_a_box_that_does_not_answer() -> None:
    import socket

    with socket.create_server(("127.0.0.1", 0)) as nobody:
        port = nobody.getsockname()[1]
    box = replace(BOX, http_port=port)
    _, make_force = source_makers(settings(TRIGNO, RIG), MUSCLES, VirtualClock(), rig_force=box)
    with pytest.raises(DeviceError, match=f"http://127.0.0.1:{port}"):
        make_force()


def test_a_calibration_that_is_not_there(tmp_path: Path) -> None:
    gauges = NiGaugeSettings(channels="Dev1/ai0:5", cal_file=str(tmp_path / "none.cal"))
    with pytest.raises(InputError, match=r"none\.cal"):
        source_makers(settings(TRIGNO, RIG), MUSCLES, VirtualClock(), rig_force=gauges)[1]()


@pytest.mark.parametrize(
    ("package", "chosen", "which", "extra"),
    [("nidaqmx", settings(NI), 0, "daq"), ("pylsl", settings(LSL), 0, "lsl"),
     ("pylsl", settings(TRIGNO, LslForceSettings()), 1, "lsl")],
)  # fmt: skip
def test_an_extra_that_is_not_installed(
    package: str, chosen: SessionSettings, which: int, extra: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(DeviceError, match=rf"pip install \"\.\[{extra}\]\""):
        source_makers(chosen, MUSCLES, VirtualClock())[which]()


@pytest.mark.parametrize(("channels", "tasks"), [("Dev1/ai0:5", 1), ("Dev2/ai0:5", 2)])
def test_emg_and_gauges_on_one_card_are_one_task(
    channels: str, tasks: int, cal_file: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from emg2vsa.worlds.people.participant import EmulatedParticipant
    from emg2vsa.worlds.people.person import Person, Response
    from tests.devices.ni_daq.emulated_card import EmulatedNi

    clock, made = VirtualClock(), []
    person = Person(name="P1", responses={"S1": Response(42e-6, 20e-6, 7.6)}, muscle_share={"EDC": 0.4, "FDS": 0.6})
    card = EmulatedNi(EmulatedParticipant(person), {"Dev1/ai6": "EDC", "Dev1/ai7": "FDS", "Dev2/ai9": ""}, clock)
    real = card.Task
    monkeypatch.setattr(card, "Task", lambda: made.append(real()) or made[-1])
    monkeypatch.setitem(sys.modules, "nidaqmx", card)
    monkeypatch.setitem(sys.modules, "nidaqmx.constants", card.constants)
    gauges = NiGaugeSettings(channels=channels, cal_file=cal_file)
    emg, force = (make() for make in source_makers(settings(NI, RIG), MUSCLES, clock, rig_force=gauges))
    for source in (force, emg):
        source.start()
    clock.sleep_until(clock.now_s() + 0.1)
    assert len(made) == tasks
    assert emg.info.channels == MUSCLES
    assert emg.info.facts["FDS, input"] == "Dev1/ai7"
    assert sum(len(block.samples) for block in emg.read()) >= 100
    assert sum(len(block.samples) for block in force.read()) >= 100
    for source in (emg, force):
        source.close()
