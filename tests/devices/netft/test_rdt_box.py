"""The emulated box byte by byte, and on real sockets: our client, and two that know nothing of it."""

from __future__ import annotations

import http.client
import socket
import struct
import time
from contextlib import closing
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pytest

from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.netft.box import Command, parse_records, request_bytes
from emg2vsa.devices.netft.datagrams import UdpLine
from emg2vsa.devices.netft.driver import open_net_ft
from emg2vsa.devices.registry import Around
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.netft_box import BoxSettings, RdtBox, configuration_page
from emg2vsa.worlds.far_ends.netft_server import RdtServer

LOAD = np.array([1.0, -2.0, 3.0, 0.1, -0.2, 0.3])
QUIET = {"noise": (0.0, 0.0), "counts_per_force": 1000, "counts_per_torque": 10}


def quiet_box(**settings):
    return RdtBox(lambda times_s: [LOAD] * len(times_s), BoxSettings(**(QUIET | settings)))


def heard(box, *requests, until_s=0.01):
    """Datagrams after requests at 0.5 s."""
    datagrams = []
    for request in requests:
        box.request(bytes.fromhex(request), lambda data, time_s: datagrams.append(data), 0.5)
    box.run_until(0.5 + until_s)
    return datagrams


def test_one_record_byte_by_byte():
    # 3500 internal samples by 0.5 s; counts 1000, -2000, 3000 and 1, -2, 3
    wire = "00000001 00000dad 00000000 000003e8 fffff830 00000bb8 00000001 fffffffe 00000003"
    assert heard(quiet_box(), "1234000200000001") == [bytes.fromhex(wire)]


def test_rates_are_whole_fractions_of_7000_hz():
    for asked, records in [(1000, 100), (7000, 700), (150, 16), (99, 10), (2333, 234)]:
        box = quiet_box(rate_hz=asked)
        assert abs(len(heard(box, "1234000200000000", until_s=0.1)) - records) <= 1
        rate = int(ElementTree.fromstring(configuration_page(box)).findtext("comrdtrate"))
        assert rate >= asked
        assert rate == 7000 // round(7000 / rate)


def test_ft_sequence_counts_internal_samples():
    data = b"".join(heard(quiet_box(), "1234000200000000"))
    numbers = [(rdt, ft) for rdt, ft, *_ in struct.iter_unpack(">III6i", data)]
    assert [rdt for rdt, _ in numbers] == list(range(1, 11))
    assert {after[1] - before[1] for before, after in pairwise(numbers)} == {7}


def test_buffered_mode_and_its_last_datagram():
    box = quiet_box(buffer=4)
    assert [len(data) // 36 for data in heard(box, "123400030000000a")] == [4, 4, 2]


def test_stop_and_nonsense():
    assert heard(quiet_box(), "1234000200000000", "1234000000000000") == []
    assert heard(quiet_box(), "4321000200000000") == []
    assert heard(quiet_box(), "1234999900000000") == []
    assert len(heard(quiet_box(), "1234000200000002", "43210000")) == 2


def test_a_new_request_counts_from_one():
    box = quiet_box()
    heard(box, "1234000200000000")
    assert heard(box, "1234000200000001")[0][:4] == b"\0\0\0\1"


def test_software_bias_is_not_answered():
    box = quiet_box()
    assert heard(box, "1234004200000000") == []
    assert heard(box, "1234000200000001")[0][12:] == bytes(24)


@pytest.mark.parametrize(("axia", "status"), [(False, "80020000"), (True, "c0000000")])
def test_out_of_range_is_said_in_the_products_own_bits(axia, status):
    box = quiet_box(rating=(1.0,) * 6, axia=axia)
    assert heard(box, "1234000200000001")[0][8:12].hex() == status


def test_equal_seeds_give_equal_noise():
    noisy = [heard(quiet_box(noise=(0.1, 0.1), seed=seed), "1234000200000000") for seed in (1, 1, 2)]
    assert noisy[0] == noisy[1] != noisy[2]


@pytest.fixture
def server():
    box = RdtBox(
        lambda times_s: [LOAD] * len(times_s), BoxSettings(force_unit="kN", n_per_unit=1e3, counts_per_force=10_000_000)
    )
    clock = WallClock()
    with RdtServer(box, clock) as server:
        yield server


def opened(server, clock, stale_s=5.0):
    return open_net_ft(
        NetFtSettings(host=server.host, rdt_port=server.rdt_port, http_port=server.http_port), Around(clock, stale_s)
    )


def test_our_client_over_udp_and_http(server):
    clock = WallClock()
    sensor = opened(server, clock)
    sensor.start()
    sample = sensor.read()
    sensor.close()
    np.testing.assert_allclose(sample.force_n, LOAD[:3], atol=30)
    np.testing.assert_allclose(sample.torque_nm, LOAD[3:], atol=2e-3)
    assert clock.now_s() - sample.time_s >= 0


def test_its_page_on_its_port(server):
    connection = http.client.HTTPConnection(server.host, server.http_port, timeout=60)
    answers = {}
    for path in ("/netftapi2.xml", "/netftapi2.xml?index=0", "/other"):
        connection.request("GET", path)
        answer = connection.getresponse()
        answers[path] = answer.status, answer.read()
    connection.close()
    assert [status for status, _ in answers.values()] == [200, 200, 404]
    assert answers["/netftapi2.xml"] == answers["/netftapi2.xml?index=0"]
    assert ElementTree.fromstring(answers["/netftapi2.xml"][1]).findtext("scfgfu") == "kN"


class WithoutRecvmsg(socket.socket):
    """As on Windows."""

    @property
    def recvmsg(self):
        raise AttributeError


def test_where_no_system_tells_the_age_of_a_datagram(server, monkeypatch):
    monkeypatch.setattr(socket, "socket", WithoutRecvmsg)
    line = UdpLine(server.host, server.rdt_port)
    assert line.receive() is None
    line.send(request_bytes(Command.STREAM, 2))
    with closing(line):
        end_s = time.monotonic() + 60
        while (datagram := line.receive()) is None:
            assert time.monotonic() < end_s
    assert datagram.age_s == 0
    assert parse_records(datagram.data)[0].rdt_sequence == 1


def test_the_newest_client_wins_over_udp(server):
    clock = WallClock()
    first, second = opened(server, clock, stale_s=0.05), opened(server, clock)
    first.start()
    second.start()
    second.read()
    clock.sleep_until(clock.now_s() + 0.06)
    with pytest.raises(DeviceError, match="another program"):
        first.read()
    second.close()
    first.close()


def test_a_port_where_nobody_listens():
    with RdtServer(RdtBox(lambda times_s: [LOAD] * len(times_s)), WallClock()) as server:
        sensor = opened(server, WallClock())
    with pytest.raises(DeviceError, match="refused"):
        sensor.start()


def test_pynetft_reads_it(server):
    pynetft = pytest.importorskip("pynetft")
    config = pynetft.Config(sensor_host=server.host, rdt_port=server.rdt_port, http_port=server.http_port)
    with pynetft.Client(config, queue_size=100) as client:
        stream = client.samples(timeout=60)
        samples = [next(stream) for _ in range(20)]
        health = client.health()
    assert samples[0].force_unit.value == "kN"
    assert samples[0].torque_unit.value == "N-m"
    np.testing.assert_allclose(1e3 * np.mean([s.force for s in samples], axis=0), LOAD[:3], atol=10)
    np.testing.assert_allclose(np.mean([s.torque for s in samples], axis=0), LOAD[3:], atol=1e-3)
    assert (health.lost_count, health.malformed_count, health.ft_stall_count, health.ft_backward_count) == (0,) * 4


def test_netft_reads_it(server):
    netft = pytest.importorskip("NetFT")
    sensor = netft.Sensor(server.host)
    sensor.sock.connect((server.host, server.rdt_port))
    sensor.sock.settimeout(5)
    np.testing.assert_allclose(np.divide(sensor.getMeasurement()[3:], 1e6), LOAD[3:], atol=2e-3)
    sensor.tare(10)
    np.testing.assert_allclose(np.divide(sensor.getMeasurement()[3:], 1e6), 0, atol=2e-3)
    sensor.sock.close()
