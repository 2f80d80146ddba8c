"""How old a datagram is when the computer's clock is set meanwhile."""

from __future__ import annotations

import socket
import sys
import time

import pytest

from emg2vsa.devices.netft.datagrams import UdpLine

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="only Linux says when a datagram came")


@pytest.fixture
def box():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as far:
        far.bind(("127.0.0.1", 0))
        yield far


@pytest.fixture
def line(box):
    opened = UdpLine(*box.getsockname())
    opened.send(b"hello")
    yield opened
    opened.close()


def received(line):
    end_s = time.monotonic() + 60
    while (datagram := line.receive()) is None:
        assert time.monotonic() < end_s
    return datagram


def test_a_datagram_that_waited_is_old(box, line):
    address, ages_s = box.recvfrom(99)[1], []
    while len(ages_s) < 20 and max(ages_s, default=0.0) < 0.045:  # the system begins to say so a little late
        assert line.receive() is None
        box.sendto(b"waits", address)
        time.sleep(0.05)
        ages_s.append(received(line).age_s)
    assert 0.045 < ages_s[-1] < 5


@pytest.mark.parametrize("step_s", [1, 3600, -1, -3600])
def test_a_step_of_the_clock_makes_none_older_than_it_can_be(box, line, monkeypatch, step_s):
    address = box.recvfrom(99)[1]
    while line.receive() is not None:
        pass
    before_s = time.monotonic()
    box.sendto(b"new", address)
    time_ns = time.time_ns
    monkeypatch.setattr(time, "time_ns", lambda: time_ns() + step_s * 10**9)
    datagram = received(line)
    assert 0 <= datagram.age_s <= time.monotonic() - before_s + 1e-3
