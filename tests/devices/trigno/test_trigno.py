"""The client of the Trigno server, against conversations written by hand and against the emulated server."""

from __future__ import annotations

import contextlib
import socket
import struct
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Self

import numpy as np
import pytest

from emg2vsa.devices.clock import FastClock, WallClock
from emg2vsa.devices.streams import Block
from emg2vsa.devices.trigno import TrignoSettings
from emg2vsa.devices.trigno import driver as trigno
from emg2vsa.devices.trigno.driver import Place, TrignoSource, places_of
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.session.liveness import Liveness
from emg2vsa.session.sample_clock import SampleClock
from emg2vsa.worlds.far_ends.trigno_server import TrignoServer
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import Person, Response

GREETING = b"Delsys Trigno System Digital Protocol Version 3.6.0 \r\n\r\n"
END = b"\r\n\r\n"
SENSORS = {
    f"SENSOR {n} {question}": reply
    for n in (1, 4)
    for question, reply in {
        "PAIRED?": "YES", "ACTIVE?": "YES", "TYPE?": "O", "MODE?": "40", "SERIAL?": f"SID7000{n}", "FIRMWARE?": "40.48",
        "STARTINDEX?": str(n), "EMGCHANNELCOUNT?": "1", "RANGE?": "HIGH", "BANDWIDTH?": "NARROW",
        "CHANNEL 1 RATE?": "1925.92592592593", "CHANNEL 1 GAIN?": "300", "CHANNEL 1 UNITS?": "V",
    }.items()
}  # fmt: skip
REPLIES = SENSORS | {
    "MASTER?": "YES", "BACKWARDS COMPATIBILITY OFF": "OK", "BACKWARDS COMPATIBILITY?": "NO", "ENDIAN LITTLE": "OK",
    "ENDIANNESS?": "LITTLE", "FRAME INTERVAL?": "0.0135", "BASE FIRMWARE?": "Firmware: 2.1\r\n",
    "BASE SERIAL?": "BID: 123\r\n", "START": "OK", "STOP": "OK", "QUIT": "BYE",
}  # fmt: skip


class WrittenServer:
    """Says what a test has written down: a reply to each command, and pieces of data after START."""

    def __init__(
        self, replies: dict[str, str], data: Sequence[bytes] = (), *, greeting: bytes = GREETING, ending: str = ""
    ) -> None:
        self.asked: list[str] = []
        self._replies, self._data, self._greeting, self._ending = replies, data, greeting, ending
        self._commands, self._emg = (socket.create_server(("127.0.0.1", 0)) for _ in range(2))
        self._threads = [threading.Thread(target=self._talk, daemon=True)]

    @property
    def settings(self) -> TrignoSettings:
        ports = {"command_port": self._commands.getsockname()[1], "emg_port": self._emg.getsockname()[1]}
        return TrignoSettings(channels={"EDC": "4", "FDS": "1"}, **ports)

    def __enter__(self) -> Self:
        self._threads[0].start()
        return self

    def __exit__(self, *error: object) -> None:
        for each in (self._commands, self._emg):
            each.close()
        for thread in self._threads:
            thread.join(5)

    def _talk(self) -> None:
        with contextlib.suppress(OSError):
            line, _ = self._commands.accept()
            line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            line.sendall(self._greeting)
            heard = b""
            while data := line.recv(4096):
                heard += data
                while END in heard:
                    command, heard = heard.split(END, 1)
                    self.asked.append(command.decode())
                    reply = self._replies.get(self.asked[-1], "INVALID COMMAND")
                    line.sendall(reply.encode() + END)
                    if (self.asked[-1], reply) == ("START", "OK"):
                        self._threads.append(threading.Thread(target=self._send, daemon=True))
                        self._threads[-1].start()
            line.close()

    def _send(self) -> None:
        with contextlib.suppress(OSError):
            emg, _ = self._emg.accept()
            emg.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            for piece in self._data:
                emg.sendall(piece)
                time.sleep(2e-3)
            if self._ending == "reset":
                time.sleep(0.3)
                emg.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            if self._ending != "silence":
                emg.close()
            else:
                self._open = emg


def counter(n: int) -> np.ndarray:
    """(n, 16) whose slot s counts up from 100 s + 1, mV."""
    return ((np.arange(n)[:, None] + 1 + 100 * np.arange(1, 17)) * 1e-3).astype("<f4")


def read_until_lost(source: TrignoSource) -> tuple[list[Block], str]:
    blocks: list[Block] = []
    end_s = time.monotonic() + 60
    while time.monotonic() < end_s:
        try:
            blocks += source.read()
        except DeviceError as error:
            return blocks, str(error)
        time.sleep(1e-3)
    raise AssertionError("the end of the stream was not told")


def samples_of(blocks: Sequence[Block]) -> np.ndarray:
    expected = 0
    for block in blocks:
        assert block.first == expected
        expected += len(block.samples)
    return np.concatenate([block.samples for block in blocks])


def test_samples_cut_anywhere_are_put_together() -> None:
    wire = counter(90).tobytes()
    pieces = [wire[:1], wire[1:63], wire[63:200], wire[200:264], wire[264:3000], wire[3000:]]
    with WrittenServer(REPLIES, pieces) as server:
        source = TrignoSource(server.settings, WallClock())
        source.start()
        blocks, found = read_until_lost(source)
        source.close()
    samples = samples_of(blocks)
    np.testing.assert_array_equal(samples, counter(90)[:, [3, 0]].astype(float))
    assert "a closed connection" in found
    assert source.counts() == (90, 0)


def test_what_is_asked_and_what_is_known() -> None:
    with WrittenServer(REPLIES, [counter(30).tobytes()]) as server:
        source = TrignoSource(replace(server.settings, delay_s=0.048), WallClock())
        source.start()
        info = source.info
        source.close()
    assert (info.kind, info.channels, info.unit, info.range_max) == ("emg", ("EDC", "FDS"), "V", 11e-3)
    assert (info.fs_hz, info.delay_s, info.frame) == (pytest.approx(26 / 0.0135), 0.048, 26)
    for fact, value in {
        "EDC, sensor": "4",
        "EDC, serial": "SID70004",
        "FDS, slot": "1",
        "base serial": "BID: 123",
        "serial": "BID: 123",
        "manufacturer": "Delsys",
        "model": "Trigno",
        "EDC, band": "20 to 450 Hz",
    }.items():
        assert info.facts[fact] == value
    orders = [each for each in server.asked if not each.endswith("?")]
    assert orders == ["BACKWARDS COMPATIBILITY OFF", "ENDIAN LITTLE", "START", "STOP", "QUIT"]


def test_the_place_of_a_quattro_channel() -> None:
    quattro = {"STARTINDEX?": "5", "EMGCHANNELCOUNT?": "4", "RANGE?": "LOW"}
    quattro |= {f"CHANNEL {c} {of}": say for c in range(1, 5) for of, say in (("UNITS?", "V"), ("RATE?", "2222.2222"))}
    replies = REPLIES | {f"SENSOR 4 {question}": reply for question, reply in quattro.items()}
    with WrittenServer(replies, [counter(30).tobytes()]) as server:
        source = TrignoSource(replace(server.settings, channels={"EDC": "4.1", "FDS": "4.3"}), WallClock())
        source.start()
        blocks, _ = read_until_lost(source)
        source.close()
    np.testing.assert_array_equal(samples_of(blocks), counter(30)[:, [4, 6]].astype(float))
    # the port runs at the highest rate, and the smaller range clips first
    assert (source.info.fs_hz, source.info.frame, source.info.range_max) == (2222.2222, 30, 5.5e-3)


def test_samples_that_the_radio_lost() -> None:
    values = counter(120)
    values[20:46, 3] = 0  # a frame of one sensor
    values[60:86] = 0  # and of all
    values[[100, 103, 104], 3] = 0  # a few samples may be 0
    pieces = [values[start : start + 7].tobytes() for start in range(0, 120, 7)]
    with WrittenServer(REPLIES, pieces) as server:
        source = TrignoSource(server.settings, WallClock())
        source.start()
        blocks, _ = read_until_lost(source)
        source.close()
    expected = values[:, [3, 0]].astype(float)
    expected[20:46, 0] = np.nan
    expected[60:86] = np.nan
    np.testing.assert_array_equal(samples_of(blocks), expected)
    assert source.counts() == (68, 52)


@pytest.mark.parametrize(("ending", "found"), [("reset", "reset"), ("", "a closed connection")])
def test_a_stream_that_breaks_gives_first_what_it_sent(ending: str, found: str) -> None:
    with WrittenServer(REPLIES, [counter(40).tobytes()], ending=ending) as server:
        source = TrignoSource(server.settings, WallClock())
        source.start()
        blocks, told = read_until_lost(source)
        source.close()
    samples = samples_of(blocks)
    np.testing.assert_array_equal(samples, counter(len(samples))[:, [3, 0]].astype(float))
    # a reset takes with it what the receiver had not fetched
    assert len(samples) == 40 or (ending and len(samples) > 0)
    assert found in told
    assert "Trigno Control Utility" in told


def test_a_stream_that_stalls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trigno, "SILENT_S", 0.1)
    with WrittenServer(REPLIES, [counter(40).tobytes()], ending="silence") as server:
        source = TrignoSource(server.settings, WallClock())
        source.start()
        blocks, told = read_until_lost(source)
        source.close()
    assert len(samples_of(blocks)) == 40
    assert "found nothing for 0.1 s" in told


def started(server: WrittenServer, **changes: object) -> str:
    with server:
        source = TrignoSource(replace(server.settings, **changes), WallClock())
        with pytest.raises(DeviceError) as caught:
            source.start()
    return str(caught.value)


def both(question: str, reply: str) -> dict[str, dict[str, str]]:
    """The reply of both sensors."""
    return {"replies": {f"SENSOR {n} {question}": reply for n in (1, 4)}}


@pytest.mark.parametrize(
    ("server", "changes", "words"),
    [
        ({"replies": {"SENSOR 4 PAIRED?": "NO", "SENSOR 1 ACTIVE?": "NO"}}, {},
         "sensor 1 is not active, sensor 4 is not paired"),
        ({"replies": {"SENSOR 4 PAIRED?": "INVALID"}}, {}, "sensor 4 is not paired"),
        ({}, {"channels": {"EDC": "9", "FDS": "12"}}, "sensor 9 is not paired, sensor 12 is not paired. Pair it in the "
         "Trigno Control Utility, wake it up, or correct session.emg.channels (EDC = 9, FDS = 12)"),
        ({"replies": {"MASTER?": "NO"}}, {}, "another program does"),
        ({"replies": {"START": "CANNOT COMPLETE"}}, {}, "expected OK to START, but found CANNOT COMPLETE"),
        ({"replies": {"ENDIAN LITTLE": "INVALID COMMAND"}}, {}, "expected OK to ENDIAN LITTLE"),
        ({"replies": {"SENSOR 4 CHANNEL 1 UNITS?": "g"}}, {},
         "sensor 4 (EDC): expected EMG in V on channel 1, but found unit g"),
        *((both("CHANNEL 1 RATE?", rate), {}, "expected the rate of an EMG channel")
          for rate in ("CANNOT COMPLETE", "nan", "inf")),
        *(({"replies": {"SENSOR 4 STARTINDEX?": slot}}, {}, "a slot from 1 to 16") for slot in ("0", "17", "none")),
        ({"replies": {"SENSOR 4 STARTINDEX?": "1"}}, {}, "a slot of its own"),
        ({"replies": {"ENDIANNESS?": "BIG"}}, {}, "LITTLE as its byte order"),
        ({"replies": {"BACKWARDS COMPATIBILITY?": "YES"}}, {}, "NO as its backwards compatibility"),
        ({"greeting": b"HTTP/1.1 400 Bad Request\r\n\r\n"}, {}, "expected the greeting"),
        ({"greeting": b"220 mail ready\r\n\r\n"}, {}, "expected the greeting"),
        ({"greeting": b"Delsys"}, {}, "expected a reply to the greeting, but found none within"),
        ({"ending": "silence"}, {}, "expected first samples, but found none for 0.2 s after START. Switch off the "
         "start trigger"),
    ],
)  # fmt: skip
def test_one_clear_error(
    server: dict[str, Any], changes: dict[str, object], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trigno, "REPLY_S", 0.1 if server.get("greeting") == b"Delsys" else trigno.REPLY_S)
    monkeypatch.setattr(trigno, "FIRST_S", 0.2)
    said = started(WrittenServer(**{**server, "replies": REPLIES | server.get("replies", {})}), **changes)
    assert said.startswith("Trigno server at 127.0.0.1:")
    assert words in said


def test_no_server() -> None:
    with socket.create_server(("127.0.0.1", 0)) as nobody:
        port = nobody.getsockname()[1]
    settings = TrignoSettings(channels={"EDC": "1"}, command_port=port)
    with pytest.raises(DeviceError, match=r"expected a connection, but found .*refused.*session\.emg\.host"):
        TrignoSource(settings, WallClock()).start()


def test_the_wrong_data_port() -> None:
    with socket.create_server(("127.0.0.1", 0)) as nobody:
        port = nobody.getsockname()[1]
    said = started(WrittenServer(REPLIES), emg_port=port)
    assert f"EMG port 127.0.0.1:{port}: expected a connection" in said


def test_sensors_by_number() -> None:
    assert places_of({"EDC": "16", "FDS": "3.2"}) == {"EDC": Place(16, 1), "FDS": Place(3, 2)}


@pytest.mark.parametrize("text", ["0", "17", "-1", "EDC", "3.", "3.0", "3.22", "1e1", "", " 3"])
def test_a_sensor_that_cannot_be(text: str) -> None:
    with pytest.raises(SettingError, match=r"session\.emg\.channels\.EDC: expected the number of a Trigno sensor"):
        places_of({"EDC": text})


def test_before_the_start() -> None:
    source = TrignoSource(TrignoSettings(channels={"EDC": "1"}), WallClock())
    for use in (source.read, lambda: source.info):
        with pytest.raises(DeviceError, match="Start the source first"):
            use()
    source.close()


SPEED = 2.0


@pytest.fixture
def emulated() -> Iterator[tuple[TrignoServer, TrignoSource, FastClock]]:
    clock = FastClock(SPEED)
    person = Person(name="P1", responses={"S1": Response(42e-6, 20e-6, 7.6)}, muscle_share={"EDC": 0.4, "FDS": 0.6})
    with TrignoServer(EmulatedParticipant(person), {3: "EDC", 7: "FDS"}, clock, start_delay_s=0.3) as server:
        ports = {"command_port": server.ports.command, "emg_port": server.ports.emg}
        settings = TrignoSettings(channels={"EDC": "3", "FDS": "7"}, **ports)
        source = TrignoSource(settings, clock)
        source.start()
        yield server, source, clock
        source.close()


def listened(source: TrignoSource, clock: FastClock, seconds: float, times: SampleClock) -> int:
    n, end_s = 0, clock.now_s() + seconds
    while clock.now_s() < end_s:
        for block in source.read():
            times.add(block.first, len(block.samples), block.arrived_s)
            n += len(block.samples)
        time.sleep(1e-3)
    return n


@pytest.mark.realtime
def test_the_emulated_server_loses_a_frame(emulated: tuple[TrignoServer, TrignoSource, FastClock]) -> None:
    server, source, clock = emulated
    times = SampleClock(source.info.fs_hz, quantum=source.info.frame)
    listened(source, clock, 4.0, times)
    assert times.report().rate_hz == pytest.approx(source.info.fs_hz, rel=2e-3)
    assert times.problems() == ()
    server.drop(3)
    end_s = clock.now_s() + 8.0
    while not times.report().missing and clock.now_s() < end_s:
        listened(source, clock, 0.1, times)
    assert times.report().missing == 3 * 26
    assert source.counts().lost == 0
    server.unpair(3)
    listened(source, clock, 1.0, times)
    assert source.counts().lost > 1000


def test_a_sensor_that_the_emulated_server_has_lost_is_named(
    emulated: tuple[TrignoServer, TrignoSource, FastClock],
) -> None:
    server, source, clock = emulated
    server.unpair(3)
    liveness, end_s, told = Liveness(source.info, clock.now_s()), clock.now_s() + 60.0, ""
    while not told and clock.now_s() < end_s:
        for block in source.read():
            liveness.take(block.samples, clock.now_s())
        told = " ".join(each for each in liveness.problems(clock.now_s()) if "samples a second" not in each)
        time.sleep(1e-3)
    assert told == "EDC sends no values: check that its sensor is paired, charged and switched on."


def test_the_emulated_server_is_cut_off_and_found_again(
    emulated: tuple[TrignoServer, TrignoSource, FastClock],
) -> None:
    server, source, clock = emulated
    server.disconnect()
    _, told = read_until_lost(source)
    assert "Trigno server" in told
    source.start()
    times, end_s = SampleClock(source.info.fs_hz), clock.now_s() + 60.0
    while source.counts().samples <= 1000 and clock.now_s() < end_s:
        listened(source, clock, 0.1, times)
    assert source.counts().samples > 1000


def test_a_decimal_comma_a_range_in_words_and_a_value_without_end() -> None:
    commas = {f"SENSOR {n} CHANNEL 1 RATE?": "1925,92592592593" for n in (1, 4)} | {"FRAME INTERVAL?": "0,0135"}
    worded = {"SENSOR 1 RANGE?": "RANGE low", "SENSOR 4 STARTINDEX?": "SENSOR 4 STARTINDEX 4"}
    values = counter(52)
    values[20] = np.inf
    with WrittenServer(REPLIES | commas | worded, [values.tobytes()]) as server:
        source = TrignoSource(server.settings, WallClock())
        source.start()
        blocks, _ = read_until_lost(source)
        source.close()
    assert (source.info.fs_hz, source.info.frame, source.info.range_max) == (pytest.approx(1925.9259), 26, 5.5e-3)
    samples = samples_of(blocks)
    assert np.isnan(samples[20]).all()
    assert not np.isinf(samples).any()


def test_samples_that_come_together_with_the_end_of_the_connection_count() -> None:
    class Late(WallClock):
        """Looks at the port only after the server has sent all and closed it."""

        def now_s(self) -> float:
            if any(command == "START" for command in server.asked):
                time.sleep(0.1)
            return super().now_s()

    with WrittenServer(REPLIES, [counter(52).tobytes()]) as server:
        source = TrignoSource(server.settings, Late())
        source.start()
        blocks, _ = read_until_lost(source)
        source.close()
    assert len(samples_of(blocks)) == 52
