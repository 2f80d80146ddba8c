"""The emulated Trigno base station on its five TCP ports of the loopback."""

from __future__ import annotations

import contextlib
import errno
import os
import selectors
import socket
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.clock import Clock
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.ports import IDLE_S, Serving
from emg2vsa.worlds.far_ends.trigno_base import END, FRAME_S, GREETING, SLOTS, TrignoBase
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.sensors import EmgSampler

HOSTS = (socket.AF_INET, "127.0.0.1"), (socket.AF_INET6, "::1")
"""Windows tries IPv6 first for localhost, and waits long where nobody listens there."""
MOST_WAITING_BYTES = 1 << 20
"Kept for a client that does not read; what comes then is lost for it."
MOST_COMMAND_BYTES = 1 << 14
START_DELAY_S = 1.8
"First samples come about 2 s after START, its clients say; one of them (pytrigno) gives up after 2.0 s."
_TRIES = 50


class Ports(NamedTuple):
    """TCP ports; 0 is any that is free."""

    command: int = 50040
    legacy_emg: int = 50041
    legacy_aux: int = 50042
    emg: int = 50043
    aux: int = 50044


ANY_PORTS = Ports(0, 0, 0, 0, 0)


@dataclass(eq=False)
class _Client:
    socket: socket.socket
    port: str
    heard: bytes = b""
    waiting: bytearray = field(default_factory=bytearray)
    frame_bytes: int = 0
    lost_frames: int = 0


class TrignoServer(Serving):
    """Serves within a with statement, on ``ports``.

    Parameters
    ----------
    participant : whose EMG it is. slots : slot (1 to 16) to muscle; the others have no sensor. clock : of both.
    ports : to listen on. DeviceError when one is taken.
    start_delay_s : from START to the first sample. delay_s : from a sample to its frame's arrival, beside the frame.
    """

    def __init__(
        self,
        participant: EmulatedParticipant,
        slots: Mapping[int, str],
        clock: Clock,
        *,
        ports: Ports = ANY_PORTS,
        start_delay_s: float = START_DELAY_S,
        delay_s: float = 0.0,
    ) -> None:
        self.base = TrignoBase(slots)
        self.start_delay_s = start_delay_s
        self._participant, self._slots, self._clock, self._delay_s = participant, dict(slots), clock, delay_s
        self._lock = threading.RLock()
        self._clients: list[_Client] = []
        self._run = 0
        self._stall_end_s = 0.0
        self._dropping = 0
        self._selector = selectors.DefaultSelector()
        self._listening: list[socket.socket] = []
        self.ports = Ports(*(self._listen(name, port) for name, port in ports._asdict().items()))
        super().__init__(self._serve, self._send_frames, name="Trigno server")

    def _close(self) -> None:
        for each in [*self._listening, *(client.socket for client in self._clients)]:
            each.close()
        self._selector.close()

    # faults

    def drop(self, frames: int = 1) -> None:
        """The next frames are lost on the radio; nothing tells the client."""
        with self._lock:
            self._dropping += frames

    def stall(self, seconds: float) -> None:
        """Nothing is sent for a time, and then all at once."""
        with self._lock:
            self._stall_end_s = self._clock.now_s() + seconds

    def disconnect(self) -> None:
        """Every connection is cut; new ones are taken."""
        with self._lock:
            for client in list(self._clients):
                self._forget(client)

    def unpair(self, slot: int) -> None:
        """The sensor of a slot is gone: zeros from now on."""
        with self._lock:
            self.base.sensors[slot].paired = False

    @property
    def lost_frames(self) -> int:
        """Frames that present clients were too slow for."""
        with self._lock:
            return sum(client.lost_frames for client in self._clients)

    # connections and commands

    def _listen(self, name: str, port: int) -> int:
        """On one port of both families; where any will do, on another if it is taken in one of them."""
        for _ in range(_TRIES):
            bound: list[socket.socket] = []
            try:
                for family, host in HOSTS:
                    with contextlib.suppress(_no_such_family):
                        bound.append(_listener(family, host, bound[0].getsockname()[1] if bound else port))
            except OSError as error:
                for each in bound:
                    each.close()
                if port:
                    raise DeviceError(
                        f"port {port}",
                        wanted=f"a free TCP port for the emulated Trigno server ({name})",
                        found=os.strerror(error.errno or 0),
                        do="End the program that holds it, or choose other ports.",
                    ) from error
                continue
            for each in bound:
                self._selector.register(each, selectors.EVENT_READ, name)
            self._listening += bound
            return int(bound[0].getsockname()[1])
        raise DeviceError(
            "127.0.0.1 and ::1", wanted="a port free on both", found="none", do="Choose the ports yourself."
        )

    def _serve(self) -> None:
        while not self._ended.is_set():
            for key, _ in self._selector.select(IDLE_S):
                with self._lock:
                    if isinstance(key.data, str):
                        self._accept(key.fileobj, key.data)
                    elif key.data in self._clients:
                        self._hear(key.data)

    def _accept(self, listener: object, port: str) -> None:
        assert isinstance(listener, socket.socket)
        try:
            connection, _ = listener.accept()
        except OSError:
            return
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client = _Client(connection, port)
        self._clients.append(client)
        self._selector.register(connection, selectors.EVENT_READ, client)
        if port == "command":
            if self.base.master is None:
                self.base.master = client
            self._tell(client, GREETING + END)

    def _hear(self, client: _Client) -> None:
        try:
            data = client.socket.recv(4096)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._forget(client)
        elif client.port == "command":
            *commands, client.heard = (client.heard + data).split(END.encode("ascii"))
            client.heard = client.heard[-MOST_COMMAND_BYTES:]
            for several in commands:
                self._answer(client, several.decode("ascii", "replace"))

    def _answer(self, client: _Client, text: str) -> None:
        """Commands of one message, each on a line of its own; their replies go out in one write."""
        commands, before = text.strip("\r\n").split("\r\n"), self.base.streaming
        replies = [self.base.reply(client, command) for command in commands]
        if self.base.streaming != before:
            self._begin_or_end()
        self._tell(client, "".join(reply + END for reply in replies))
        for reply in replies:
            if reply.endswith("INITIATED"):
                done = reply.replace("INITIATED", "COMPLETE") + END
                threading.Timer(IDLE_S, self._tell, (client, done)).start()
        if "QUIT" in commands:
            self._forget(client)

    def _begin_or_end(self) -> None:
        self._run += 1
        for client in self._clients:
            if client.port != "command" and client.frame_bytes:
                # the frame under way is sent to its end, so that clients keep their place in it
                del client.waiting[len(client.waiting) % client.frame_bytes :]

    def _tell(self, client: _Client, text: str) -> None:
        with self._lock:
            client.waiting += text.encode("ascii")
            self._flush(client)

    def _forget(self, client: _Client) -> None:
        if client not in self._clients:
            return
        self._clients.remove(client)
        with contextlib.suppress(KeyError, ValueError):
            self._selector.unregister(client.socket)
        client.socket.close()
        if client.port == "command":
            before = self.base.streaming
            self.base.leave(client)
            if self.base.streaming != before:
                self._begin_or_end()

    def _flush(self, client: _Client) -> None:
        try:
            while client.waiting:
                del client.waiting[: client.socket.send(client.waiting)]
        except BlockingIOError:
            pass
        except OSError:
            self._forget(client)

    # frames

    def _send_frames(self) -> None:
        while not self._ended.is_set():
            if not self.base.streaming:
                self._clock.sleep_until(self._clock.now_s() + FRAME_S / 2)
                continue
            with self._lock:
                run, samples = self._run, self.base.emg_samples(legacy=False)
            start_s = self._clock.now_s() + self.start_delay_s
            muscles = tuple(self._slots.values())
            sampler = EmgSampler(self._participant, muscles, samples / FRAME_S, start_s=start_s)
            frame = 0
            while self._goes_on(run):
                frame += 1
                # no later than one idle time before it looks again whether it shall end
                due_s = start_s + frame * FRAME_S + self._delay_s
                while self._goes_on(run) and self._clock.now_s() < due_s:
                    self._clock.sleep_until(min(due_s, self._clock.now_s() + IDLE_S))
                self._send_frame(run, sampler.take(samples))

    def _goes_on(self, run: int) -> bool:
        return self.base.streaming and self._run == run and not self._ended.is_set()

    def _send_frame(self, run: int, muscles_v: NDArray[np.float64]) -> None:
        emg_v = np.zeros((len(muscles_v), SLOTS))
        with self._lock:
            if not self._goes_on(run):
                return
            if self._dropping:
                self._dropping -= 1
                return
            for column, slot in enumerate(self._slots):
                if self.base.sensors[slot].paired:
                    emg_v[:, slot - 1] = muscles_v[:, column]
            base, made = self.base, {}
            held = self._clock.now_s() < self._stall_end_s
            for client in [each for each in self._clients if each.port != "command"]:
                if client.port not in made:
                    legacy = client.port.startswith("legacy")
                    emg = client.port.endswith("emg")
                    made[client.port] = base.emg_bytes(emg_v, legacy) if emg else base.aux_bytes(legacy)
                client.frame_bytes = len(made[client.port])
                if len(client.waiting) < MOST_WAITING_BYTES:
                    client.waiting += made[client.port]
                else:
                    client.lost_frames += 1
                if not held:
                    self._flush(client)


class _no_such_family(OSError):
    """A host without IPv6."""


def _listener(family: socket.AddressFamily, host: str, port: int) -> socket.socket:
    try:
        listener = socket.create_server((host, port), family=family)
    except OSError as error:
        if family == socket.AF_INET6 and error.errno in (errno.EAFNOSUPPORT, errno.EADDRNOTAVAIL):
            raise _no_such_family from error
        raise
    listener.setblocking(False)
    return listener
