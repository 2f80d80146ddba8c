"""The emulated participant on NI inputs, an ATI box and LSL streams, where the study says that they are."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from emg2vsa.devices.clock import FastClock, VirtualClock, WallClock
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.devices.lsl.settings import LslEmgSettings
from emg2vsa.devices.netft.driver import open_net_ft
from emg2vsa.devices.netft.settings import NetFtSettings
from emg2vsa.devices.ni_daq.settings import NiGaugeSettings
from emg2vsa.devices.registry import Around
from emg2vsa.devices.rig_force.settings import RigForceSettings
from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.devices.trigno.settings import TrignoSettings
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.session.views import ForceMessage, ParticipantState
from emg2vsa.session_settings import SessionSettings
from emg2vsa.worlds.far_ends.netft_server import RdtServer
from emg2vsa.worlds.far_ends.serve import Table, force_box, serve
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import Person, Response
from tests.devices.ni_daq.emulated_card import EmulatedNi

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


def a_task(clock: VirtualClock, channels: str = "Dev1/ai0:1", **options: float) -> object:
    ni = EmulatedNi(EmulatedParticipant(PERSON), {"Dev1/ai0": "EDC", "Dev1/ai1": "FDS"}, clock, **options)
    task = ni.Task()
    task.ai_channels.add_ai_voltage_chan(channels, min_val=-5.0, max_val=5.0)
    task.timing.cfg_samp_clk_timing(1000.0, sample_mode=ni.constants.AcquisitionType.CONTINUOUS, samps_per_chan=4000)
    return ni, task  # type: ignore[return-value]


def test_ni_gives_volts_behind_the_gain_in_steps_of_16_bits() -> None:
    clock = VirtualClock()
    _, task = a_task(clock, gain=1000.0)
    task.start()
    clock.sleep_until(2.0)
    rows = np.array(task.read(number_of_samples_per_channel=-1))
    assert rows.shape == (2, 2001)
    steps = rows / (10 / 65536)
    assert np.allclose(steps, np.round(steps))
    # rest tone, noise and hum, without the drift of the baseline
    fast = signal.butter(2, 15, "highpass", fs=1000, output="sos")
    rest_v = np.abs(signal.sosfiltfilt(fast, rows)).mean(axis=1) / 1000.0
    assert rest_v[1] == pytest.approx(0.6 * PERSON.rest_v, rel=0.25)


def test_ni_overflows_when_nobody_reads() -> None:
    clock = VirtualClock()
    ni, task = a_task(clock)
    task.start()
    assert task.in_stream.input_buf_size == 10_000  # the driver's own least size
    clock.sleep_until(9.9)
    assert task.in_stream.avail_samp_per_chan == 9901
    assert len(task.read(number_of_samples_per_channel=-1)[0]) == 9901
    clock.sleep_until(20.0)
    with pytest.raises(ni.errors.DaqReadError, match="-200279") as caught:
        task.read(number_of_samples_per_channel=-1)
    assert caught.value.error_code == -200279
    assert isinstance(caught.value, ni.errors.Error)


def test_ni_waits_for_samples_and_gives_up_in_time() -> None:
    clock = VirtualClock()
    ni, task = a_task(clock)
    task.start()
    data = np.zeros((2, 100))
    reader = ni.stream_readers.AnalogMultiChannelReader(task.in_stream)
    assert reader.read_many_sample(data, 100) == 100
    assert clock.now_s() == pytest.approx(0.1, abs=0.002)
    assert np.all(data.std(axis=1) > 0)
    with pytest.raises(ni.errors.DaqReadError, match="-200284"):
        task.read(number_of_samples_per_channel=5000, timeout=1.0)


@pytest.mark.parametrize(("channels", "code"), [("Dev2/ai0", -200220), ("Dev1/ai77", -200170), ("Dev1/port0", -200170)])
def test_ni_refuses_what_the_card_has_not(channels: str, code: int) -> None:
    with pytest.raises(Exception, match=str(code)):
        a_task(VirtualClock(), channels)


def test_ni_saturates_at_the_range_and_can_be_unplugged() -> None:
    clock = VirtualClock()
    ni, task = a_task(clock, gain=1e7)
    task.start()
    clock.sleep_until(1.0)
    rows = np.array(task.read(number_of_samples_per_channel=-1))
    assert rows.min() == -5.0
    assert rows.max() == pytest.approx(5.0 - 10 / 65536)
    ni.unplug()
    with pytest.raises(ni.errors.DaqError, match="-200220"):
        task.read(number_of_samples_per_channel=-1)


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
