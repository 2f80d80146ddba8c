"""The emulated Trigno server speaks as its clients expect: their own bytes, one receive per reply, whole samples."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from emg2vsa.devices.clock import FastClock
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.trigno_server import Ports, TrignoServer
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import Person, Response

SPEED = 10.0
SAMPLE, AUX, LEGACY_AUX = 64, 576, 192


def a_person() -> EmulatedParticipant:
    responses = {"S1": Response(42e-6, 20e-6, 7.63)}
    return EmulatedParticipant(Person(name="P01", responses=responses, muscle_share={"EDC": 0.4, "FDS": 0.6}))


@pytest.fixture
def server() -> Iterator[TrignoServer]:
    with TrignoServer(a_person(), {1: "EDC", 5: "FDS"}, FastClock(SPEED), start_delay_s=0.3) as server:
        yield server


def connected(port: int, host: str = "127.0.0.1") -> socket.socket:
    return socket.create_connection((host, port), 5)


def commander(server: TrignoServer, host: str = "127.0.0.1") -> socket.socket:
    line = connected(server.ports.command, host)
    assert line.recv(1024).startswith(b"Delsys Trigno System Digital Protocol Version 3.6.0")
    return line


def asked(line: socket.socket, command: str) -> str:
    """As clients do: one send, one receive, four bytes cut off."""
    line.sendall(f"{command}\r\n\r\n".encode("ascii"))
    reply = line.recv(128)
    assert reply.endswith(b"\r\n\r\n")
    return reply[:-4].decode("ascii")


def received(line: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count and (more := line.recv(count - len(data))):
        data += more
    return data


@pytest.mark.parametrize("host", ["127.0.0.1", "::1"])
def test_greeting_comes_in_one_piece_over_both_families(server: TrignoServer, host: str) -> None:
    try:
        socket.create_server((host, 0), family=socket.AF_INET6 if ":" in host else socket.AF_INET).close()
    except OSError:
        pytest.skip(f"this computer has no {host}")
    with connected(server.ports.command, host) as line:
        greeting = line.recv(1024)
    assert greeting[:45] == b"Delsys Trigno System Digital Protocol Version"
    assert greeting.endswith(b"\r\n\r\n")


@pytest.mark.parametrize(
    ("command", "reply"),
    [
        ("MASTER?", "YES"),
        ("MASTER", "NEW MASTER"),
        ("TRIGGER START OFF", "OK"),
        ("TRIGGER?", "START OFF STOP OFF"),
        ("BACKWARDS COMPATIBILITY?", "YES"),
        ("BACKWARDS COMPATIBILITY OFF", "OK"),
        ("UPSAMPLING?", "UPSAMPLING ON"),
        ("UPSAMPLE OFF", "OK"),
        ("ENDIANNESS?", "LITTLE"),
        ("ENDIAN LITTLE", "OK"),
        ("FRAME INTERVAL?", "0.0135"),
        ("MAX SAMPLES EMG?", "26"),
        ("MAX SAMPLES AUX?", "2"),
        ("SENSOR 1 PAIRED?", "YES"),
        ("SENSOR 2 PAIRED?", "NO"),
        ("SENSOR 2 TYPE?", "INVALID SENSOR"),
        ("SENSOR 5 TYPE?", "O"),
        ("SENSOR 5 STARTINDEX?", "5"),
        ("SENSOR 1 MODE?", "0"),
        ("SENSOR 1 SETMODE 66", "SENSOR 1 SET TO MODE 66"),
        ("SENSOR 1 SETMODE 9999", "CANNOT COMPLETE"),
        ("SENSOR 1 EMGCHANNELCOUNT?", "1"),
        ("SENSOR 1 AUXCHANNELCOUNT?", "3"),
        ("SENSOR 1 CHANNEL 1 RATE?", "1925.92592592593"),
        ("SENSOR 1 CHANNEL 1 SAMPLES?", "26"),
        ("SENSOR 1 CHANNEL 1 UNITS?", "V"),
        ("SENSOR 1 CHANNEL 2 UNITS?", "g"),
        ("SENSOR 1 CHANNEL 9 RATE?", "INVALID COMMAND"),
        ("SENSOR 17 PAIRED?", "INVALID COMMAND"),
        ("start", "INVALID COMMAND"),
        ("", "INVALID COMMAND"),
    ],
)
def test_replies(server: TrignoServer, command: str, reply: str) -> None:
    with commander(server) as line:
        assert asked(line, command) == reply


def test_several_commands_of_one_message_are_answered_in_one_write(server: TrignoServer) -> None:
    with commander(server) as line:
        line.sendall(b"UPSAMPLE OFF\r\nENDIANNESS?\r\nBASE SERIAL?\r\n\r\n")
        assert line.recv(1024) == b"OK\r\n\r\nLITTLE\r\n\r\nBID: 12345\r\n\r\n\r\n"


def test_pairing_is_completed_unasked(server: TrignoServer) -> None:
    with commander(server) as line:
        assert "INITIATED" in asked(line, "SENSOR 2 PAIR")
        assert b"COMPLETE" in line.recv(1024)
        assert asked(line, "SENSOR 2 PAIRED?") == "YES"


def test_only_the_master_starts(server: TrignoServer) -> None:
    with commander(server) as first, commander(server) as second:
        assert asked(second, "MASTER?") == "NO"
        assert asked(second, "START") == "CANNOT COMPLETE"
        assert asked(second, "MASTER") == "NEW MASTER"
        assert asked(first, "START") == "CANNOT COMPLETE"
        assert asked(second, "START") == "OK"


def test_whole_samples_reach_a_client_that_never_reassembles(server: TrignoServer) -> None:
    # libemg and pytrigno: greeting, data sockets, START, then receives of exactly one sample
    with commander(server) as line, connected(server.ports.emg) as emg, connected(server.ports.aux):
        assert asked(line, "START") == "OK"
        samples = [emg.recv(SAMPLE) for _ in range(1350)]
        assert {len(sample) for sample in samples} == {SAMPLE}
        values = np.frombuffer(b"".join(samples), "<f4").reshape(-1, 16)
        assert np.all(values[:, [0, 4]].std(axis=0) > 1e-7)
        others = np.delete(values, [0, 4], axis=1)
        assert not others.any()
        assert asked(line, "STOP") == "OK"


def test_rates_on_all_ports(server: TrignoServer) -> None:
    ports = server.ports
    with (
        commander(server) as line,
        connected(ports.emg) as emg,
        connected(ports.legacy_emg) as legacy,
        connected(ports.aux) as aux,
        connected(ports.legacy_aux) as legacy_aux,
    ):
        assert asked(line, "UPSAMPLE OFF") == "OK"
        assert asked(line, "START") == "OK"
        frames = 100
        for data, size in ((emg, 26 * SAMPLE), (legacy, 15 * SAMPLE), (aux, 2 * AUX), (legacy_aux, 2 * LEGACY_AUX)):
            assert len(received(data, frames * size)) == frames * size
        gravity = np.frombuffer(received(aux, AUX), "<f4").reshape(16, 9)
        assert gravity[[0, 4], 2].tolist() == [1.0, 1.0]
        assert not gravity[1].any()


def test_stop_ends_the_stream_and_start_goes_on_with_new_samples(server: TrignoServer) -> None:
    with commander(server) as line, connected(server.ports.emg) as emg:
        asked(line, "START")
        assert received(emg, 27 * SAMPLE)
        assert asked(line, "STOP") == "OK"
        time.sleep(0.1)
        emg.setblocking(False)
        data = b""
        while True:
            try:
                data += emg.recv(1 << 16)
            except BlockingIOError:
                break
        assert len(data) % SAMPLE == 0
        time.sleep(0.1)
        with pytest.raises(BlockingIOError):
            emg.recv(1)
        emg.settimeout(60)
        assert asked(line, "START") == "OK"
        assert len(received(emg, 270 * SAMPLE)) == 270 * SAMPLE


def test_the_master_leaves_and_the_stream_ends(server: TrignoServer) -> None:
    with connected(server.ports.emg) as emg:
        with commander(server) as line:
            asked(line, "START")
            assert received(emg, SAMPLE)
        end_s = time.monotonic() + 60
        while server.base.streaming and time.monotonic() < end_s:
            time.sleep(0.01)
        assert not server.base.streaming
        with commander(server) as line:
            assert asked(line, "MASTER?") == "YES"
            assert asked(line, "QUIT") == "BYE"
            assert line.recv(1) == b""


def test_a_client_that_does_not_read_holds_nobody_up(server: TrignoServer) -> None:
    with commander(server) as line, connected(server.ports.emg) as emg, connected(server.ports.emg) as deaf:
        asked(line, "START")
        assert len(received(emg, 4000 * SAMPLE)) == 4000 * SAMPLE
        deaf.close()
        assert len(received(emg, 270 * SAMPLE)) == 270 * SAMPLE


def test_faults(server: TrignoServer) -> None:
    with commander(server) as line, connected(server.ports.emg) as emg:
        asked(line, "START")
        assert received(emg, SAMPLE * 27)
        server.unpair(1)
        unpaired = asked(line, "SENSOR 1 PAIRED?")
        end_s = time.monotonic() + 60
        newest = np.ones(16)
        while newest[0] != 0.0:  # samples of before come first
            assert time.monotonic() < end_s
            newest = np.frombuffer(received(emg, 27 * SAMPLE), "<f4").reshape(-1, 16)[-1]
        assert newest[4] != 0.0
        assert unpaired == "NO"
        server.disconnect()
        while emg.recv(1 << 16):
            pass
        assert line.recv(1) == b""


def test_a_port_that_is_taken_is_named(server: TrignoServer) -> None:
    ports = Ports(command=server.ports.command, legacy_emg=0, legacy_aux=0, emg=0, aux=0)
    with pytest.raises(DeviceError, match=rf"port {server.ports.command}.*command"):
        TrignoServer(a_person(), {1: "EDC"}, FastClock(SPEED), ports=ports)


CONVERSATIONS = {
    # bytes as the client sends them, and what it looks for in one receive of its own size
    "pytrigno and libemg": [(b"START\r\n\r\n", 128, b"OK"), (b"STOP\r\n\r\n", 128, b"OK")],
    "delsys-trigno-client": [
        (b"MASTER\r\n\r\n", 1024, b"NEW MASTER"), (b"SENSOR 1 PAIRED?\r\n\r\n", 1024, b"YES"),
        (b"START\r\n\r\n", 1024, b"OK"), (b"STOP\r\n\r\n", 1024, b"OK"), (b"QUIT\r\n\r\n", 1024, b"BYE"),
    ],
    "a fork of pytrigno that sets modes": [
        (b"SENSOR 1 MODE?\r\n\r\n", 128, b"0"), (b"SENSOR 1 SETMODE 7\r\n\r\n", 128, b"SENSOR 1 SET TO MODE 7"),
        (b"SENSOR 1 ACTIVE?\r\n\r\n", 128, b"YES"), (b"START\r\n\r\n", 128, b"OK"),
    ],
    "trignoclient": [
        (b"ENDIANESS?\r\n\r\n", 512, b"INVALID COMMAND"),  # codespell:ignore
        (b"UPSAMPLING?\r\n\r\n", 512, b"UPSAMPLING ON"),
        (b"BACKWARDS COMPATIBILITY?\r\n\r\n", 512, b"YES"), (b"FRAME INTERVAL?\r\n\r\n", 512, b"0.0135"),
        (b"SENSOR 5 STARTINDEX?\r\n\r\n", 512, b"5"), (b"SENSOR 5 EMGCHANNELCOUNT?\r\n\r\n", 512, b"1"),
        (b"START\r\n\r\n", 512, b"OK"),
    ],
}  # fmt: skip


@pytest.mark.parametrize("client", CONVERSATIONS)
def test_conversations_of_clients(server: TrignoServer, client: str) -> None:
    with commander(server) as line, connected(server.ports.emg), connected(server.ports.aux):
        for sent, size, looked_for in CONVERSATIONS[client]:
            line.sendall(sent)
            reply = line.recv(size)
            assert looked_for in reply
            assert reply.endswith(b"\r\n\r\n")


def test_a_client_that_starts_before_it_has_read_the_greeting(server: TrignoServer) -> None:
    # DelsysTrignoLSL: two connections at once, START at once, then chunks of 1024 bytes cut into samples of 64
    with connected(server.ports.emg) as emg, connected(server.ports.command) as line:
        line.sendall(b"START\r\n\r\n")
        said = b""
        while b"OK\r\n\r\n" not in said:
            said += line.recv(1024)
        assert said.startswith(b"Delsys Trigno System")
        chunks = [emg.recv(1024) for _ in range(200)]
        assert sum(len(chunk) % SAMPLE for chunk in chunks) == 0
        line.sendall(b"STOP\r\n\r\n")
        assert line.recv(1024) == b"OK\r\n\r\n"


class Counting(TrignoServer):
    """Slot 1 counts samples instead of measuring."""

    count = 0

    def _send_frame(self, run: int, muscles_v: NDArray[np.float64]) -> None:
        muscles_v[:, 0] = self.count + np.arange(len(muscles_v))
        self.count += len(muscles_v)
        super()._send_frame(run, muscles_v)


def steps(data: bytes) -> NDArray[np.float64]:
    return np.diff(np.frombuffer(data, "<f4").reshape(-1, 16)[:, 0])


def test_frames_that_are_late_stalled_or_lost() -> None:
    with (
        Counting(a_person(), {1: "EDC", 5: "FDS"}, FastClock(SPEED), start_delay_s=3.0) as server,
        commander(server) as line,
        connected(server.ports.emg) as emg,
    ):
        begun = time.monotonic()
        asked(line, "START")
        data = received(emg, 27 * SAMPLE)
        assert time.monotonic() - begun >= 3.0 / SPEED
        begun = time.monotonic()
        server.stall(5.0)
        data += received(emg, 600 * 27 * SAMPLE)
        assert time.monotonic() - begun >= 5.0 / SPEED
        assert set(steps(data)) == {1.0}
        server.drop(3)
        # the gap may come right after what was read last
        data = data[-SAMPLE:] + received(emg, 200 * 27 * SAMPLE)
        assert sorted(set(steps(data))) == [1.0, 3 * 27 + 1.0]
        assert np.sum(steps(data) > 1) == 1
