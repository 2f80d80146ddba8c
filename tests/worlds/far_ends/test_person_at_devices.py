"""The emulated participant on NI inputs, an ATI box and LSL streams, where the study says that they are."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.devices.clock import FastClock, WallClock
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.devices.lsl import LslEmgSettings
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.netft.driver import open_net_ft
from emg2vsa.devices.ni_daq import NiGaugeSettings
from emg2vsa.devices.registry import Around
from emg2vsa.devices.rig_force import RigForceSettings
from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.devices.trigno import TrignoSettings
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.session.views import ForceMessage, ParticipantState
from emg2vsa.session_settings import SessionSettings
from emg2vsa.worlds.far_ends.netft_server import RdtServer
from emg2vsa.worlds.far_ends.serve import Table, force_box, serve
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import Person, Response

PERSON = Person(
    name="P03", responses={"S1": Response(42e-6, 20e-6, 7.63)}, muscle_share={"EDC": 0.4, "FDS": 0.6}, seed=(3,)
)
STATE = ParticipantState("start", "", "main", 1, 10, (0.5, 7.0), 7.0, (1.0, 5.0), "safe", False, "en")


class StillPage:
    """START, for ever."""

    def participant(self) -> ParticipantState:
        return STATE

    def force(self) -> ForceMessage:
        return ForceMessage(0, 0.0, 0.0, "none", "", "start")


def pressed(person: EmulatedParticipant, felt: Callable[[], float], most_s: float = 20.0) -> float:
    """The largest force that is felt in some seconds after START."""
    person.place("S1")
    person.watch(StillPage())
    largest, end_s = 0.0, time.monotonic() + most_s
    while largest < 5.0 and time.monotonic() < end_s:
        largest = max(largest, felt())
    return largest


def test_the_force_reaches_the_rigs_driver_through_the_box() -> None:
    clock, person = FastClock(5.0), EmulatedParticipant(PERSON)
    with RdtServer(force_box(person, (0.0, 0.0, -1.0)), clock) as server:
        sensor = open_net_ft(
            NetFtSettings(host=server.host, rdt_port=server.rdt_port, http_port=server.http_port),
            Around(WallClock(), 2.0),
        )
        sensor.start()
        try:
            assert pressed(person, lambda: -sensor.read().force_n[2]) >= 5.0
        finally:
            sensor.close()


def test_ports_of_the_box_that_are_taken_are_named() -> None:
    person = EmulatedParticipant(PERSON)
    box = force_box(person, (0.0, 0.0, 1.0))
    with RdtServer(box, WallClock()) as server, pytest.raises(DeviceError, match=f"{server.rdt_port}.*two free ports"):
        RdtServer(box, WallClock(), rdt_port=server.rdt_port)


def test_lsl_streams_say_what_they_are(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = tmp_path_factory.mktemp("lsl") / "lsl_api.cfg"
    config.write_text(
        f"[multicast]\nResolveScope = machine\n[lab]\nKnownPeers = {{127.0.0.1}}\nSessionID = {config.parent.name}\n"
    )
    monkeypatch.setenv("LSLAPICFG", str(config))
    pylsl = pytest.importorskip("pylsl")
    from emg2vsa.worlds.far_ends.lsl import LslOutlets

    clock = WallClock()
    with LslOutlets(EmulatedParticipant(PERSON), {"EDC": "ch7", "FDS": "ch9"}, clock) as outlets:
        assert outlets.names == ("emulated EMG", "emulated force")
        # other tests of this process may have left streams of these types
        found = {info.name(): info for info in pylsl.resolve_streams(3.0)}
        assert [found[name].type() for name in outlets.names] == ["EMG", "Force"]
        inlet = pylsl.StreamInlet(found["emulated EMG"])
        channel = inlet.info(5.0).desc().child("channels").child("channel")
        assert (channel.child_value("label"), channel.child_value("unit")) == ("ch7", "V")
        samples, stamps = [], []
        end_s = time.monotonic() + 30.0
        while len(samples) <= 1500 and time.monotonic() < end_s:
            chunk, times = inlet.pull_chunk(0.1)
            samples += chunk
            stamps += times
        inlet.close_stream()
    assert len(samples) > 1500
    assert np.median(np.diff(stamps)) == pytest.approx(1 / 2000.0, rel=0.01)


SETTINGS = SessionSettings(
    emg=TrignoSettings(command_port=51940, emg_port=51943, channels={"EDC": "1", "FDS": "5"}),
    force=RigForceSettings(rig="rig.toml"),
)
BOX = NetFtSettings(host="127.0.0.1", rdt_port=51950, http_port=51951)


def test_devices_stand_where_the_study_says() -> None:
    with serve(Table(EmulatedParticipant(PERSON), SETTINGS, BOX, FastClock(2.0), 0.1)) as served:
        assert served.trigno is not None
        assert (served.trigno.ports.command, served.trigno.ports.emg) == (51940, 51943)
        assert "RDT 51950, HTTP 51951" in served.lines[1]


@pytest.mark.parametrize(
    ("settings", "force", "said"),
    [
        (replace(SETTINGS, emg=replace(SETTINGS.emg, host="10.0.0.7")), BOX, r"session\.emg\.host.*10\.0\.0\.7"),
        (SETTINGS, replace(BOX, host=None), "force.host.*127.0.0.1"),
        (SETTINGS, NiGaugeSettings(channels="Dev1/ai0:5", cal_file="a.cal"), "found ni-daq"),
        (
            SessionSettings(emg=SimulatedEmgSettings(), force=SimulatedForceSettings()),
            None,
            "simulated and simulated",
        ),
        (
            SessionSettings(emg=LslEmgSettings(channels={"EDC": "EDC"}), force=SimulatedForceSettings()),
            None,
            "--speed.*LSL",
        ),
    ],
)
def test_devices_that_cannot_be_emulated(settings: SessionSettings, force: ForceSettings | None, said: str) -> None:
    table = Table(EmulatedParticipant(PERSON), settings, force, FastClock(2), 0)
    with pytest.raises(SettingError, match=said), serve(table):
        pass
