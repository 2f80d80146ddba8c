"""EMG from the server of Delsys' Trigno Control Utility (SDK guide MAN-025).

Commands go to one TCP port. Samples come from another, in frames of 13.5 ms, without time and without number;
`emg2vsa.session.sample_clock` finds their times.
"""

from __future__ import annotations

import contextlib
import math
import re
import socket
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.clock import Clock, awaited
from emg2vsa.devices.registry import Around
from emg2vsa.devices.streams import Block, SourceBase, StreamCounts, StreamInfo
from emg2vsa.devices.trigno import SENSOR, TrignoSettings
from emg2vsa.errors import DeviceError, SettingError

GREETING = "Delsys Trigno System Digital Protocol"
END = b"\r\n\r\n"
REPLY_S = 5.0
"START takes up to this time."
LEAVE_S = 0.5
RECEIVE_BYTES = 1 << 16
_BUFFER_BYTES = 1 << 20
SLOTS = 16
SAMPLE_BYTES = 4 * SLOTS
FRAME_S = 0.0135
RANGES_V = {"HIGH": 11e-3, "LOW": 5.5e-3}
BANDS_HZ = {"NARROW": (20, 450), "WIDE": (10, 850)}
FIRST_S = 6.0
"First samples come about 2 s after START."
SILENT_S = 1.0
"A server that has sent nothing for so long has stopped."
ZEROS = 8
"So many samples of exactly 0 V in a row were never measured: noise is 0 for a sample now and then, not for long."
_POLL_S = 2e-3


class TrignoCommands:
    """The command port of a server: one reply for each command. Every method raises DeviceError when it is lost."""

    def __init__(self, host: str, port: int) -> None:
        self.where = f"Trigno server at {host}:{port}"
        self._heard = b""
        self._socket = connect(host, port, self.where)
        self._socket.settimeout(REPLY_S)
        try:
            greeting = self._reply("the greeting")
        except DeviceError:
            self.close()
            raise
        if not greeting.startswith(GREETING):
            self.close()
            do = "Correct session.emg.host and session.emg.command_port."
            raise DeviceError(self.where, wanted=f'the greeting "{GREETING}"', found=repr(greeting[:60]), do=do)
        self.version = greeting.split()[-1]

    def ask(self, command: str) -> str:
        """The reply, without the blanks around it. DeviceError : the server is lost, or silent."""
        try:
            self._socket.sendall(command.encode("ascii") + END)
        except OSError as error:
            raise self._lost(command, error.strerror or str(error)) from error
        reply = self._reply(command)
        while reply.startswith("SENSOR") and reply.endswith(("PAIR COMPLETE", "PAIR INITIATED")):
            reply = self._reply(command)  # told unasked, because somebody pairs a sensor meanwhile
        return reply

    def order(self, command: str, wanted: str = "OK", do: str = "Restart the Trigno Control Utility.") -> None:
        """Give a command that must be obeyed. DeviceError : another reply than ``wanted``."""
        reply = self.ask(command)
        if not reply.startswith(wanted):
            raise DeviceError(self.where, wanted=f"{wanted} to {command}", found=reply, do=do)

    def leave(self) -> None:
        """End the stream and the conversation; a server that hangs is not waited for long."""
        self._socket.settimeout(LEAVE_S)
        self.ask("STOP")
        self.ask("QUIT")

    def close(self) -> None:
        self._socket.close()

    def _reply(self, command: str) -> str:
        # a reply may end with one newline too many
        while END not in (heard := self._heard.lstrip(b"\r\n")):
            try:
                data = self._socket.recv(RECEIVE_BYTES)
            except TimeoutError as error:
                raise self._lost(command, f"none within {self._socket.gettimeout():g} s") from error
            except OSError as error:
                raise self._lost(command, error.strerror or str(error)) from error
            if not data:
                raise self._lost(command, "a closed connection")
            self._heard += data
        reply, self._heard = heard.split(END, 1)
        return reply.decode("ascii", "replace").strip()

    def _lost(self, command: str, found: str) -> DeviceError:
        do = "Restart the Trigno Control Utility; check the network."
        return DeviceError(self.where, wanted=f"a reply to {command}", found=found, do=do)


def connect(host: str, port: int, where: str) -> socket.socket:
    """A connection by TCP. DeviceError when nobody answers."""
    try:
        connection = socket.create_connection((host, port), timeout=REPLY_S)
    except OSError as error:
        do = "Start the Trigno Control Utility on that computer, or correct session.emg.host and its ports."
        raise DeviceError(where, wanted="a connection", found=error.strerror or str(error), do=do) from error
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
    return connection


class Place(NamedTuple):
    """A muscle's channel: number of the sensor (1 to 16), and which of its EMG channels, from 1."""

    sensor: int
    channel: int


def places_of(channels: Mapping[str, str]) -> dict[str, Place]:
    """Muscle to place, from ``session.emg.channels``: "3" is sensor 3, "3.2" channel 2 of it. SettingError else."""
    places = {}
    for role, text in channels.items():
        if not (said := re.fullmatch(SENSOR, text)):
            wanted = 'the number of a Trigno sensor: "1" to "16", or "3.2" for channel 2 of sensor 3'
            do = "Read the number off the Trigno Control Utility."
            raise SettingError(f"session.emg.channels.{role}", wanted=wanted, found=repr(text), do=do)
        places[role] = Place(int(said[1]), int(said[2] or 1))
    return places


def open_trigno(settings: TrignoSettings, around: Around) -> TrignoSource:
    """The source of [session.emg]."""
    return TrignoSource(settings, around.clock)


class TrignoSource(SourceBase):
    """A `Source` of EMG, V. ``clock``: the session's, on which blocks arrive.

    The port runs at the highest native rate of all paired sensors: nothing is resampled to 2000 Hz by the server.
    """

    def __init__(self, settings: TrignoSettings, clock: Clock) -> None:
        self._settings, self._clock = settings, clock
        self._places = places_of(settings.channels)
        self._commands: TrignoCommands | None = None
        self._data: socket.socket | None = None
        self._columns: list[int] = []
        self._where = "Trigno server"
        self._forget()

    def _forget(self) -> None:
        self._bytes, self._next, self._lost, self._ended = b"", 0, 0, ""
        self._quiet_s: float | None = None
        "Since when nothing has come."
        self._zeros = _Zeros(len(self._places))

    def start(self) -> None:
        """Set the sensors up and wait for samples. DeviceError : another program has control, a sensor is not as asked,
        or no samples come."""
        self.close()
        self._forget()
        settings = self._settings
        commands = self._commands = TrignoCommands(settings.host, settings.command_port)
        self._where = commands.where
        try:
            self._set_up(commands)
            where = f"Trigno server, EMG port {settings.host}:{settings.emg_port}"
            self._data = connect(settings.host, settings.emg_port, where)
            self._data.setblocking(False)
            commands.order("START", do="Another program may control the server: end it.")
            self._wait_for_first()
        except BaseException:
            self.close()
            raise

    def read(self) -> list[Block]:
        """Samples that have come. DeviceError : not started, or the server has been silent too long."""
        data = self._received()
        now_s = self._clock.now_s()
        self._bytes += data
        if data:
            self._quiet_s = None
        elif len(self._bytes) < SAMPLE_BYTES:
            self._check_alive(now_s)
        if not (whole := len(self._bytes) - len(self._bytes) % SAMPLE_BYTES):
            return []
        rows = np.frombuffer(self._bytes[:whole], dtype="<f4").reshape(-1, SLOTS)[:, self._columns]
        self._bytes = self._bytes[whole:]
        samples = self._zeros.take(np.where(np.isfinite(rows), rows, np.nan).astype(np.float64))
        if not len(samples):
            return []
        first, self._next = self._next, self._next + len(samples)
        self._lost += int(np.isnan(samples).any(axis=1).sum())
        return [Block(samples, first, now_s)]

    def counts(self) -> StreamCounts:
        return StreamCounts(self._next - self._lost, self._lost)

    def close(self) -> None:
        if self._commands is not None:
            # the utility answers each, or is gone
            with contextlib.suppress(DeviceError):
                self._commands.leave()
            self._commands.close()
            self._commands = None
        if self._data is not None:
            self._data.close()
            self._data = None

    def _set_up(self, commands: TrignoCommands) -> None:
        """Choose byte order and rate, and learn what the sensors are."""
        if commands.ask("MASTER?") == "NO":
            do = "End the other program that is connected to the server, or send it MASTER from there."
            raise DeviceError(commands.where, wanted="to control the server", found="another program does", do=do)
        commands.order("BACKWARDS COMPATIBILITY OFF")
        commands.order("ENDIAN LITTLE")
        facts = {"device": "Delsys Trigno", "manufacturer": "Delsys", "model": "Trigno", "protocol": commands.version}
        for name in _ABOUT:
            facts[name] = commands.ask("ENDIANNESS?" if name == "byte order" else f"{name.upper()}?")
        for name, wanted, other in (
            ("byte order", "LITTLE", ("BIG",)), ("backwards compatibility", "NO", ("YES", "ON")),
        ):  # fmt: skip
            if (found := facts[name]).upper() in other:
                do = "Restart the Trigno Control Utility."
                raise DeviceError(commands.where, wanted=f"{wanted} as its {name}", found=found, do=do)
        _check_present(commands, self._places)
        starts = {}
        for role, place in self._places.items():
            facts |= {f"{role}, {name}": value for name, value in _sensor_facts(commands, role, place).items()}
            starts[role] = _slot(commands, role, place)
            if starts[role] in list(starts.values())[:-1]:
                found = f"slot {starts[role]} again"
                raise _at_sensor(commands, role, place, "a slot of its own for each muscle", found)
        self._columns = [slot - 1 for slot in starts.values()]
        facts |= {f"{role}, slot": str(slot) for role, slot in starts.items()}
        bands = {role: BANDS_HZ.get(facts[f"{role}, bandwidth"].upper().split(" ")[-1]) for role in self._places}
        facts |= {f"{role}, band": f"{band[0]} to {band[1]} Hz" for role, band in bands.items() if band}
        facts["serial"] = facts["base serial"]
        fs_hz = port_rate_hz(commands)
        self._info = StreamInfo(
            "emg", tuple(self._places), "V", fs_hz,
            range_max=min(_range_v(facts[f"{role}, range"]) for role in self._places),
            delay_s=self._settings.delay_s, facts=facts, frame=max(1, round(fs_hz * _frame_s(facts))),
        )  # fmt: skip

    def _wait_for_first(self) -> None:
        def came() -> bool:
            self._bytes += self._received()
            return bool(self._ended) or len(self._bytes) >= SAMPLE_BYTES

        awaited(self._clock, FIRST_S, _POLL_S, came)
        if len(self._bytes) < SAMPLE_BYTES:
            found = self._ended or f"none for {FIRST_S:g} s after START"
            do = "Switch off the start trigger of the utility; check session.emg.emg_port."
            raise DeviceError(self._where, wanted="first samples", found=found, do=do)

    def _received(self) -> bytes:
        if self._data is None:
            raise self._not_started()
        parts = []
        while not self._ended:
            try:
                part = self._data.recv(RECEIVE_BYTES)
            except BlockingIOError:
                break
            except OSError as error:
                self._ended = error.strerror or str(error)
                break
            if part:
                parts.append(part)
            else:
                self._ended = "a closed connection"
        return b"".join(parts)

    def _check_alive(self, now_s: float) -> None:
        if self._quiet_s is None:
            self._quiet_s = now_s
        if self._ended or now_s - self._quiet_s > SILENT_S:
            found = self._ended or f"nothing for {now_s - self._quiet_s:.1f} s"
            do = "Check that the Trigno Control Utility runs and that the base station is plugged in."
            raise DeviceError(self._where, wanted="samples", found=found, do=do)


class _Zeros:
    """Finds samples that are exactly 0 for ``ZEROS`` rows and more, and holds back the end of what may become such."""

    def __init__(self, columns: int) -> None:
        self._held = np.empty((0, columns))
        self._within = np.zeros(columns, dtype=bool)
        "Did the rows handed over end within a run of zeros?"

    def take(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """The rows that are certain, NaN where none was measured."""
        rows = np.concatenate([self._held, rows])
        keep = len(rows)
        gone = np.zeros(rows.shape, dtype=bool)
        for column, values in enumerate(rows.T):
            edges = np.flatnonzero(np.diff(np.concatenate([[False], values == 0, [False]])))
            for first, end in edges.reshape(-1, 2):
                if end - first >= ZEROS or (first == 0 and self._within[column]):
                    gone[first:end, column] = True
                elif end == len(rows):
                    keep = min(keep, first)
        self._held = rows[keep:]
        if keep:
            self._within = gone[keep - 1]
        return np.where(gone[:keep], np.nan, rows[:keep])


def port_rate_hz(commands: TrignoCommands) -> float:
    """Rate of the EMG port, Hz: the highest of all EMG channels of paired sensors. DeviceError where none tells a
    rate."""
    rates = []
    for sensor in range(1, SLOTS + 1):
        if commands.ask(f"SENSOR {sensor} PAIRED?") == "YES":
            count = commands.ask(f"SENSOR {sensor} EMGCHANNELCOUNT?")
            for channel in range(1, 1 + (int(count) if count.isdecimal() else 1)):
                rates.append(_number(commands.ask(f"SENSOR {sensor} CHANNEL {channel} RATE?")))
    rates = [rate for rate in rates if 0 < rate < math.inf]
    if not rates:
        do = "Choose a mode with EMG for the sensors in the Trigno Control Utility."
        raise DeviceError(commands.where, wanted="the rate of an EMG channel", found="none", do=do)
    return max(rates)


_ABOUT = ("base firmware", "base serial", "frame interval", "byte order", "backwards compatibility")
_OF_SENSOR = ("type", "mode", "serial", "firmware", "range", "bandwidth")
"""Facts by name, which are asked for in capitals."""


def _number(reply: str) -> float:
    """A number with a point or a comma; NaN for any other reply."""
    try:
        return float(reply.replace(",", "."))
    except ValueError:
        return math.nan


def _frame_s(facts: Mapping[str, str]) -> float:
    frame_s = _number(facts["frame interval"])
    return frame_s if 0 < frame_s < 1 else FRAME_S


def _range_v(reply: str) -> float:
    """Range from the reply to RANGE?, in any case, with or without the word before it."""
    return RANGES_V.get((reply.upper().split() or [""])[-1], RANGES_V["HIGH"])


def _slot(commands: TrignoCommands, role: str, place: Place) -> int:
    """Where a muscle's channel is in a sample, from 1. DeviceError where the server does not say a slot of 1 to 16."""
    reply = commands.ask(f"SENSOR {place.sensor} STARTINDEX?")
    said = reply.split()[-1] if reply.split() else ""
    slot = int(said) + place.channel - 1 if said.isascii() and said.isdecimal() else 0
    if said.startswith("0") or not 1 <= slot <= SLOTS:
        wanted = f"a slot from 1 to {SLOTS} for channel {place.channel}"
        raise _at_sensor(commands, role, place, wanted, f"STARTINDEX {reply!r}")
    return slot


def _at_sensor(
    commands: TrignoCommands, role: str, place: Place, wanted: str, found: str, do: str = "Restart"
) -> DeviceError:
    where = f"{commands.where}, sensor {place.sensor} ({role})"
    do = f"{do} the Trigno Control Utility, or correct session.emg.channels."
    return DeviceError(where, wanted=wanted, found=found, do=do)


def _check_present(commands: TrignoCommands, places: Mapping[str, Place]) -> None:
    """DeviceError that names every sensor that is not paired or sleeps."""
    faults = []
    for sensor in sorted({place.sensor for place in places.values()}):
        if commands.ask(f"SENSOR {sensor} PAIRED?") != "YES":
            faults.append(f"sensor {sensor} is not paired")
        elif commands.ask(f"SENSOR {sensor} ACTIVE?") == "NO":
            faults.append(f"sensor {sensor} is not active")
    if faults:
        names = ", ".join(f"{role} = {place.sensor}" for role, place in places.items())
        do = f"Pair it in the Trigno Control Utility, wake it up, or correct session.emg.channels ({names})."
        raise DeviceError(commands.where, wanted="paired and active sensors", found=", ".join(faults), do=do)


def _sensor_facts(commands: TrignoCommands, role: str, place: Place) -> dict[str, str]:
    """What a sensor says of itself. DeviceError where its channel is no EMG."""
    sensor, channel = place
    count = commands.ask(f"SENSOR {sensor} EMGCHANNELCOUNT?")
    units = commands.ask(f"SENSOR {sensor} CHANNEL {channel} UNITS?")
    if units != "V" or (count.isdecimal() and int(count) < channel):
        wanted, found = f"EMG in V on channel {channel}", f"unit {units}, {count} EMG channels"
        raise _at_sensor(commands, role, place, wanted, found, "Choose a mode with EMG in")
    facts = {name: commands.ask(f"SENSOR {sensor} {name.upper()}?") for name in _OF_SENSOR}
    facts |= {name: commands.ask(f"SENSOR {sensor} CHANNEL {channel} {name.upper()}?") for name in ("rate", "gain")}
    return {"sensor": str(sensor)} | facts
