"""The RDT client against an emulated box on a virtual clock."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.netft.box import NetFtConfig, parse_config
from emg2vsa.devices.netft.datagrams import Datagram, LoopbackDatagrams
from emg2vsa.devices.netft.driver import SPARE_DATAGRAMS, NetFt
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.netft_box import BoxSettings, RdtBox, configuration_page

LOAD = np.array([1.0, -2.0, 3.0, 0.1, -0.2, 0.3])


class Rig:
    """A started client, its box and their clock."""

    def __init__(self, load=lambda time_s: LOAD, *, buffered=False, **settings):
        self.clock = VirtualClock()
        settings = {"noise": (1e-6, 1e-6)} | settings
        self.box = RdtBox(lambda times_s: list(map(load, times_s)), BoxSettings(**settings))
        line = LoopbackDatagrams("box", self.box, self.clock)
        self.sensor = NetFt(line, parse_config(configuration_page(self.box)), self.clock, buffered=buffered)
        self.sensor.start()
        self.sensor.read()

    def wait(self, time_s):
        self.clock.sleep_until(self.clock.now_s() + time_s)


class Wire:
    """A line that plays datagrams and keeps what was sent."""

    name = "wire"

    def __init__(self, *datagrams: bytes):
        self.sent: list[bytes] = []
        self._datagrams = list(datagrams)

    def send(self, data: bytes) -> None:
        self.sent.append(data)

    def receive(self) -> Datagram | None:
        if len(self.sent) > 1 and self._datagrams:
            return Datagram(self._datagrams.pop(0), 0.0)
        return None

    def close(self) -> None:
        assert not self._datagrams, "left over"


def test_bytes_of_a_session():
    record = "00000001 00001b58 80010000 000003e8 fffffc18 00000000 0000000a fffffff6 00000001"
    wire = Wire(bytes.fromhex(record))
    sensor = NetFt(wire, NetFtConfig(1e-3, 1e-2, 1000.0), VirtualClock())
    sensor.start()
    sample = sensor.read()
    sensor.bias()
    sensor.close()
    np.testing.assert_allclose(sample.force_n, [1, -1, 0])
    np.testing.assert_allclose(sample.torque_nm, [0.1, -0.1, 0.01])
    assert sample.status.warnings == ("monitor condition latched",)
    assert [sent.hex() for sent in wire.sent] == [
        "1234000000000000",
        "1234000200000000",
        "1234004200000000",
        "1234000000000000",
    ]


def test_nothing_is_biased_unless_asked():
    rig = Rig()
    rig.wait(0.01)
    np.testing.assert_allclose(rig.sensor.read().force_n, LOAD[:3], atol=1e-4)
    rig.sensor.bias()
    rig.wait(0.01)
    np.testing.assert_allclose(rig.sensor.read().force_n, 0, atol=1e-4)


@pytest.mark.parametrize(
    "units",
    [
        {"force_unit": "kN", "n_per_unit": 1e3, "torque_unit": "Nmm", "nm_per_unit": 1e-3, "counts_per_torque": 1000},
        {"force_unit": "lbf", "n_per_unit": 4.4482216152605, "counts_per_force": 12345},
    ],
)
def test_newton_whatever_the_box_counts_in(units):
    rig = Rig(rating=(1e6,) * 6, **units)
    rig.wait(0.01)
    sample = rig.sensor.read()
    np.testing.assert_allclose(sample.force_n, LOAD[:3], atol=2e-3)
    np.testing.assert_allclose(sample.torque_nm, LOAD[3:], atol=1e-4)


@pytest.mark.parametrize("rate_hz", [100, 1000, 2333, 7000])
def test_a_slow_loop_gets_the_newest_sample_and_does_not_lag(rate_hz):
    rig = Rig(lambda time_s: [time_s] * 6, rate_hz=rate_hz)
    for _ in range(100):
        rig.wait(0.005)
        sample = rig.sensor.read()
        assert rig.clock.now_s() - sample.time_s <= 1 / rate_hz + 1e-6
        np.testing.assert_allclose(sample.force_n, sample.time_s, atol=1e-4)


def test_the_newest_of_a_buffered_datagram():
    rig = Rig(lambda time_s: [time_s] * 6, rate_hz=7000, buffer=40, buffered=True)
    rig.wait(0.04)
    sample = rig.sensor.read()
    assert rig.clock.now_s() - sample.time_s <= 40 / 7000
    np.testing.assert_allclose(sample.force_n, sample.time_s, atol=1e-4)


def test_lost_records_are_counted_once():
    rig = Rig()
    rig.box.faults.lose = 3
    rig.wait(0.01)
    for _ in range(2):
        rig.sensor.read()
        assert rig.sensor.counts().lost == 3
    rig.sensor.start()
    rig.wait(0.01)
    rig.sensor.read()
    assert rig.sensor.counts().lost == 0


def test_a_repeated_or_late_record_is_not_the_newest():
    rig = Rig(lambda time_s: [time_s] * 6)
    rig.box.faults.doubled = True
    rig.wait(0.002)
    rig.sensor.read()
    assert rig.sensor.counts().lost == 0
    rig.box.faults.doubled, rig.box.faults.shuffled = False, 2
    rig.wait(0.0021)
    np.testing.assert_allclose(rig.sensor.read().force_n, rig.clock.now_s(), atol=1e-3)
    assert rig.sensor.counts()[1:] == (0, 1, 2, 0)


def test_datagrams_of_no_sensible_length_are_passed_over():
    good = "00000001" + "00" * 32
    sensor = NetFt(Wire(bytes(35), bytes.fromhex(good), b"noise"), NetFtConfig(1.0, 1.0, 1000.0), VirtualClock())
    sensor.start()
    assert sensor.read().status.code == 0
    sensor.close()


def test_a_silent_box_is_told():
    rig = Rig()
    rig.box.faults.mute = True
    rig.wait(0.04)
    rig.sensor.read()
    rig.wait(0.02)
    with pytest.raises(DeviceError, match=r"none for 61 ms.*another program"):
        rig.sensor.read()
    rig.box.faults.mute = False
    rig.wait(0.01)
    rig.sensor.read()
    assert rig.sensor.counts().lost == 60


def test_a_frozen_force_is_told():
    rig = Rig()
    rig.box.faults.stuck = True
    rig.wait(0.2)
    rig.sensor.read()
    rig.wait(0.1)
    with pytest.raises(DeviceError, match="same six counts for 300 ms"):
        rig.sensor.read()
    rig.box.faults.stuck = False
    rig.wait(0.01)
    rig.sensor.read()


@pytest.mark.parametrize(
    ("axia", "named"), [(False, "transducer saturation or A/D error"), (True, "force or torque out of range")]
)
def test_saturation_is_named_by_product(axia, named):
    rig = Rig(lambda time_s: [0, 0, 300 if time_s > 0.1 else 0, 0, 0, 0], axia=axia)
    assert rig.sensor.read().status.code == 0
    rig.wait(0.1)
    assert rig.sensor.read().status.faults == (named,)
    on_demand = Rig()
    on_demand.box.faults.saturated = True
    on_demand.wait(0.01)
    assert on_demand.sensor.read().status.code == 0x80020000


def test_a_box_that_never_answers():
    clock = VirtualClock()
    sensor = NetFt(Wire(), NetFtConfig(1.0, 1.0, 1000.0), clock)
    with pytest.raises(DeviceError, match="none for 1000 ms"):
        sensor.start()


def test_reading_before_start():
    with pytest.raises(DeviceError, match="Start the sensor"):
        NetFt(Wire(), NetFtConfig(1.0, 1.0, 1000.0), VirtualClock()).read()


def test_the_newest_client_has_the_stream():
    rig = Rig()
    other = NetFt(LoopbackDatagrams("other", rig.box, rig.clock), rig.sensor.config, rig.clock)
    other.start()
    rig.wait(0.06)
    other.read()
    with pytest.raises(DeviceError, match="another program"):
        rig.sensor.read()


def test_garbage_between_good_records_neither_hangs_nor_counts():
    rng = np.random.default_rng(1)
    rig = Rig(lambda time_s: [time_s] * 6, rate_hz=500)
    calls = []
    receive = rig.sensor._line.receive

    def flooded():
        calls.append(1)
        if len(calls) % 2:
            return receive()
        return Datagram(rng.integers(0, 256, 36, dtype=np.uint8).tobytes(), 0.0)

    rig.sensor._line.receive = flooded
    for _ in range(1000):
        before = len(calls)
        rig.wait(0.005)
        sample = rig.sensor.read()
        assert len(calls) - before <= SPARE_DATAGRAMS + 4
        np.testing.assert_allclose(sample.force_n, sample.time_s, atol=1e-4)
    assert rig.sensor.counts().lost == 0
    assert rig.sensor.counts().refused > 1000


def test_a_hold_up_is_caught_up_with_in_one_turn():
    rig = Rig(lambda time_s: [time_s] * 6, rate_hz=7000)
    rig.wait(0.3)
    assert rig.clock.now_s() - rig.sensor.read().time_s <= 1 / 7000 + 1e-6


def test_every_record_once_with_its_number():
    rig = Rig(lambda time_s: [time_s] * 6, rate_hz=1000)
    rig.sensor.read_all()
    for _ in range(3):
        rig.wait(0.005)
        newest = rig.sensor.read()
        samples = rig.sensor.read_all()
        assert len(samples) == 5
        assert samples[-1].sequence == newest.sequence
        np.testing.assert_allclose(np.diff([sample.time_s for sample in samples]), 1e-3, atol=1e-9)
    assert rig.sensor.read_all() == []
    assert rig.sensor.read().sequence == newest.sequence  # nothing has come: the same number again
