"""Streams of the Lab Streaming Layer, from real outlets on this computer."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest

from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.lsl import driver as lsl
from emg2vsa.devices.lsl.driver import LslSource
from emg2vsa.devices.lsl.outlets import SESSION_SOURCE
from emg2vsa.devices.streams import Block
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.session.sample_clock import SampleClock

FS_HZ = 1000.0


@pytest.fixture(scope="module")
def pylsl(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """pylsl, on this computer alone."""
    config = tmp_path_factory.mktemp("lsl") / "lsl_api.cfg"
    peers = "[multicast]\nResolveScope = machine\n[lab]\nKnownPeers = {127.0.0.1}\n"
    config.write_text(f"{peers}SessionID = {config.parent.name}\n[log]\nlevel = -3\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LSLAPICFG", str(config))
        yield pytest.importorskip("pylsl", reason="pylsl is not installed")


@pytest.fixture
def clock() -> WallClock:
    return WallClock()


class Sender:
    """An outlet whose channel c has the value 1000 c + number of the sample, in the unit of the stream."""

    def __init__(
        self, pylsl: Any, name: str, kind: str, labels: Sequence[str], units: Sequence[str], *,
        fs_hz: float = FS_HZ, form: str = "double64", described: bool = True,
    ) -> None:  # fmt: skip
        info = pylsl.StreamInfo(name, kind, len(labels), fs_hz, form, f"source of {name}")
        channels = info.desc().append_child("channels") if described else None
        for label, unit in zip(labels, units, strict=True):
            if channels is not None:
                channel = channels.append_child("channel")
                channel.append_child_value("label", label)
                channel.append_child_value("unit", unit)
        self._lsl, self._columns, self.sent = pylsl, np.arange(len(labels)) * 1000.0, 0
        self._outlet = pylsl.StreamOutlet(info)

    def push(self, n: int, last_stamp_s: float | None = None) -> None:
        values = self._columns + np.arange(self.sent, self.sent + n)[:, None]
        self._outlet.push_chunk(values, self._lsl.local_clock() if last_stamp_s is None else last_stamp_s)
        self.sent += n

    def run(self, source: LslSource, seconds: float) -> list[Block]:
        """Push and read for a time; a chunk each 10 ms, stamped by a device that keeps its rate."""
        blocks: list[Block] = []
        start_s = self._lsl.local_clock()
        for chunk in range(1, round(seconds * 100) + 1):
            time.sleep(max(0.0, start_s + 0.01 * chunk - self._lsl.local_clock()))
            self.push(10, start_s + 0.01 * chunk)
            blocks += source.read()
        time.sleep(0.05)
        return blocks + source.read()


def begun(source: LslSource, sender: Sender) -> None:
    """Start a source whose first sample is not sent before it listens."""
    import threading

    ended = threading.Event()

    def push() -> None:
        while not ended.wait(0.02):
            sender.push(1)

    thread = threading.Thread(target=push)
    thread.start()
    try:
        source.start()
    finally:
        ended.set()
        thread.join()
    source.read()


def test_a_stream_that_a_session_sends_is_no_device_unless_it_is_named(pylsl: Any, clock: WallClock) -> None:
    sent = pylsl.StreamInfo("emg2vsa EMG", "EMG", 2, FS_HZ, "float32", f"{SESSION_SOURCE}computer-study-EMG")
    named = {name: LslSource("emg", {"EDC": None}, clock, stream=name)._is_meant(sent) for name in (None, sent.name())}
    assert named == {None: False, "emg2vsa EMG": True}


def test_channels_by_label_in_volts_on_the_session_s_clock(pylsl: Any, clock: WallClock) -> None:
    units = ("uV", "mV", "microvolts", "V")
    sender = Sender(pylsl, "amplifier", "EMG", ("a", "b", "c", "d"), units)
    roles = {"EDC": "c", "FDS": "b", "FCR": "d"}
    source = LslSource("emg", roles, clock, stream="amplifier", delay_s=0.004)
    begun(source, sender)
    before = source.counts().samples
    blocks = sender.run(source, 1.0)
    samples = np.concatenate([block.samples for block in blocks])
    numbers = samples[:, 2] - 3000
    np.testing.assert_allclose(np.diff(numbers), 1)
    np.testing.assert_allclose(samples[:, 0], (2000 + numbers) * 1e-6)
    np.testing.assert_allclose(samples[:, 1], (1000 + numbers) * 1e-3)
    assert len(samples) >= 1000
    assert blocks[0].first == before
    assert source.counts().samples == before + len(samples)
    stamps_s = np.concatenate([block.stamps_s for block in blocks if block.stamps_s is not None])
    assert len(stamps_s) == len(samples)
    assert 0 < clock.now_s() - stamps_s[-1] < 5
    assert all(block.arrived_s == block.stamps_s[-1] for block in blocks if block.stamps_s is not None)
    info = source.info
    assert (info.channels, info.unit, info.fs_hz, info.delay_s) == (("EDC", "FDS", "FCR"), "V", FS_HZ, 0.004)
    assert info.facts["source id"] == "source of amplifier"
    offset_s, uncertainty_s = (float(each.split()[0]) for each in info.facts["clock offset"].split("±"))
    assert abs(offset_s) < 0.1
    assert 0 < uncertainty_s < 0.1
    source.close()


def test_a_sender_that_is_started_anew_is_found_again(pylsl: Any, clock: WallClock) -> None:
    sender = Sender(pylsl, "force plate", "Force", ("Fz",), ("N",))
    source = LslSource("force", {"force": None}, clock, stream="force plate")
    begun(source, sender)
    times = SampleClock(FS_HZ)
    for block in sender.run(source, 3.3):
        times.add(block.first, len(block.samples), block.arrived_s)
        last_s, received = block.arrived_s, block.first + len(block.samples)
    del sender
    time.sleep(0.3)
    again = Sender(pylsl, "force plate", "Force", ("Fz",), ("N",))
    blocks: list[Block] = []
    while not blocks:
        again.push(1)
        time.sleep(0.01)
        blocks = source.read()
        assert clock.now_s() < last_s + 60
    blocks = again.run(source, 1.3)
    missing = round((blocks[0].arrived_s - last_s) * FS_HZ) - (blocks[0].first + len(blocks[0].samples) - received)
    for block in blocks:
        times.add(block.first, len(block.samples), block.arrived_s)
    assert times.report().missing == pytest.approx(missing, abs=0.3 * FS_HZ)
    source.close()


def test_streams_that_cannot_be_used(pylsl: Any, clock: WallClock, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lsl, "MOST_RESOLVE_S", 0.2)
    monkeypatch.setattr(lsl, "FIRST_S", 0.3)
    senders = [
        Sender(pylsl, "left", "EMG", ("a", "b"), ("uV", "uV")),
        Sender(pylsl, "right", "emg", ("a", "a"), ("uV", "")),
        Sender(pylsl, "when it likes", "Force", ("Fz",), ("N",), fs_hz=0.0),
        Sender(pylsl, "words", "Markers", ("text",), ("",), form="string"),
        Sender(pylsl, "undescribed", "Force", ("x",), ("N",), described=False),
    ]
    time.sleep(0.5)
    found = pylsl.resolve_streams(2.0)  # once is enough; the senders stay as they are
    monkeypatch.setattr(pylsl, "resolve_streams", lambda wait_time: found)
    one, two = {"EDC": "a"}, {"EDC": "a", "FDS": "z"}
    for kind, channels, stream, error, words in (
        ("emg", one, None, DeviceError, "session.emg.stream: expected one LSL stream of type EMG, but found 2 of "
                                        "them: "),
        ("emg", one, "middle", DeviceError, "expected one LSL stream 'middle', but found none; the network has "),
        ("emg", two, "left", SettingError, "emg.channels.FDS: expected one channel with the label 'z', but found "
                                           "'a', 'b'"),
        ("emg", one, "right", SettingError, "expected one channel with the label 'a', but found 'a', 'a'"),
        ("emg", {"EDC": None}, "left", SettingError, "expected one channel, or a label"),
        ("emg", {"EDC": "Fz"}, "when it likes", DeviceError, "expected a stream with a regular rate"),
        ("emg", {"EDC": "text"}, "words", DeviceError, "found text"),
        ("force", {"force": "a"}, "left", DeviceError, "LSL stream 'left', force: expected the unit N or mN, but "
                                                       "found 'uV'"),
        ("force", {"force": None}, "undescribed", DeviceError, "found ''. Let the sender state the unit"),
        ("emg", one, "left", DeviceError, "expected samples, but found no sample for 0.3 s"),
    ):  # fmt: skip
        source = LslSource(kind, channels, clock, stream=stream)
        with pytest.raises(error) as caught:
            source.start()
        assert words in str(caught.value)
    assert len(senders) == 5


def test_without_pylsl(clock: WallClock, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pylsl", None)
    with pytest.raises(DeviceError, match=r'session\.force\.kind = "lsl": expected the extra.*"\.\[lsl\]"'):
        LslSource("force", {"force": None}, clock)


def test_stamps_of_a_foreign_clock_are_refused(pylsl: Any, clock: WallClock) -> None:
    sender = Sender(pylsl, "foreign", "Force", ("Fz",), ("N",))
    push = sender.push
    sender.push = lambda n: push(n, time.time())  # type: ignore[method-assign, assignment, misc]
    source = LslSource("force", {"force": None}, clock, stream="foreign")
    with pytest.raises(DeviceError, match="time stamps of the LSL clock"):
        begun(source, sender)


def test_a_read_does_not_wait_for_the_sender_s_clock(
    pylsl: Any, clock: WallClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    sender = Sender(pylsl, "slow answer", "Force", ("Fz",), ("N",))
    source = LslSource("force", {"force": None}, clock, stream="slow answer")
    begun(source, sender)
    asked = []
    monkeypatch.setattr(source, "_set_offset", lambda inlet: (asked.append(1), time.sleep(2.0)))
    longest_s, end_s = 0.0, time.monotonic() + 1.5
    while time.monotonic() < end_s:
        sender.push(10)
        before_s = time.monotonic()
        source.read()
        longest_s = max(longest_s, time.monotonic() - before_s)
        time.sleep(0.01)
    source.close()
    assert asked
    assert longest_s < 1.5
