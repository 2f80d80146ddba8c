"""A Trigno base station and its control utility up to the sockets: commands in, replies and frames out.

Behaviour after the SDK guide MAN-025-3-5 as its clients tell of it; the guide itself was not at hand. What no client
shows (START of a client that is not master, a second START) is a choice: CANNOT COMPLETE.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FRAME_S = 0.0135
SLOTS = 16
GREETING = "Delsys Trigno System Digital Protocol Version 3.6.0 "
END = "\r\n\r\n"
OK, INVALID, IMPOSSIBLE = "OK", "INVALID COMMAND", "CANNOT COMPLETE"
MOST_EMG, MOST_AUX = 26, 2
"Samples of a frame as the utility reports them, even where it sends 27."
UPSAMPLED, LEGACY, LEGACY_AUX = 27, 15, 2
AUX_PLACES, LEGACY_AUX_PLACES = 9, 3


@dataclass(frozen=True)
class Mode:
    """What a sensor measures: samples per frame of 13.5 ms, and the units of its further channels."""

    emg: int
    aux: int
    aux_units: tuple[str, ...]


_G, _TURN, _Q = ("g",) * 3, ("?/s",) * 3, ("Q",) * 4
MODES = {mode: Mode(26, 2, _G) for mode in range(40)} | {
    7: Mode(26, 2, _TURN), 66: Mode(24, 1, _Q), 67: Mode(20, 1, _Q), 134: Mode(32, 3, _G)
}  # fmt: skip
"""Modes of an Avanti sensor that clients or their users name."""


@dataclass
class Sensor:
    """A sensor in its slot."""

    serial: int
    paired: bool = True
    mode: int = 0

    @property
    def measures(self) -> Mode:
        return MODES[self.mode]


@dataclass
class TrignoBase:
    """State of the station. slots : numbers (1 to 16) of the slots that have a paired sensor."""

    slots: Iterable[int] = range(1, SLOTS + 1)
    backwards: bool = True
    upsample: bool = True
    big_endian: bool = False
    streaming: bool = False
    master: object | None = None
    sensors: dict[int, Sensor] = field(init=False)

    def __post_init__(self) -> None:
        paired = set(self.slots)
        self.sensors = {n: Sensor(70000 + n, n in paired) for n in range(1, SLOTS + 1)}

    def emg_samples(self, legacy: bool) -> int:
        """Samples per frame on the EMG port, or on the legacy one."""
        if self.backwards:
            return UPSAMPLED if self.upsample else LEGACY if legacy else MOST_EMG
        return max((s.measures.emg for s in self.sensors.values() if s.paired), default=MOST_EMG)

    def aux_samples(self, legacy: bool) -> int:
        """The same of the further channels."""
        if self.backwards or legacy:
            return LEGACY_AUX
        return max((s.measures.aux for s in self.sensors.values() if s.paired), default=MOST_AUX)

    def emg_bytes(self, emg_v: NDArray[np.float64], legacy: bool) -> bytes:
        """A frame's samples (n, 16), V, as the port writes them: thinned where it has fewer places."""
        wanted = self.emg_samples(legacy)
        if wanted != len(emg_v):
            emg_v = emg_v[np.arange(wanted) * len(emg_v) // wanted]
        return emg_v.astype(self._float).tobytes()

    def aux_bytes(self, legacy: bool) -> bytes:
        """A frame of the further channels: sensors that lie still."""
        values = np.zeros((self.aux_samples(legacy), SLOTS, LEGACY_AUX_PLACES if legacy else AUX_PLACES))
        for number, sensor in self.sensors.items():
            if sensor.paired:
                values[:, number - 1, 2] = 1.0  # g
        return values.astype(self._float).tobytes()

    @property
    def _float(self) -> str:
        return ">f4" if self.big_endian else "<f4"

    def reply(self, client: object, command: str) -> str:
        """Answer to one command of a client; START, STOP and QUIT take effect as ``streaming``."""
        for form, answer in _COMMANDS.items():
            if said := re.fullmatch(form, command):
                return answer(self, client, said)
        return INVALID

    def leave(self, client: object) -> None:
        """A command client has gone; when it was the master, the stream ends."""
        if client is self.master:
            self.master, self.streaming = None, False

    def _set(self, client: object, **state: bool) -> str:
        if client is not self.master or self.streaming:
            return IMPOSSIBLE
        for name, value in state.items():
            setattr(self, name, value)
        return OK

    def _take_over(self, client: object) -> str:
        self.master = client
        return "NEW MASTER"

    def _stop(self, client: object) -> str:
        if client is not self.master:
            return IMPOSSIBLE
        self.streaming = False
        return OK

    def _quit(self, client: object) -> str:
        self.leave(client)
        return "BYE"

    def _of_sensor(self, client: object, said: re.Match[str]) -> str:
        sensor, asked = self.sensors.get(int(said[1])), said[2]
        if sensor is None:
            return INVALID
        if asked in ("PAIRED?", "ACTIVE?"):
            return _yes(sensor.paired)
        if asked == "PAIR":
            if client is not self.master or self.streaming:
                return IMPOSSIBLE
            sensor.paired = True
            return f"SENSOR {said[1]} PAIR INITIATED"
        if not sensor.paired:
            return "INVALID SENSOR" if asked == "TYPE?" else IMPOSSIBLE
        if fact := _OF_SENSOR.get(asked):
            return fact(int(said[1]), sensor)
        if mode := re.fullmatch(r"SETMODE ?(\d+)", asked):
            if client is not self.master or self.streaming or int(mode[1]) not in MODES:
                return IMPOSSIBLE
            sensor.mode = int(mode[1])
            return f"SENSOR {said[1]} SET TO MODE {mode[1]}"
        if channel := re.fullmatch(r"CHANNEL (\d+) (RATE|SAMPLES|GAIN|UNITS)\?", asked):
            return _of_channel(sensor.measures, int(channel[1]), channel[2])
        return INVALID


def _of_channel(mode: Mode, channel: int, asked: str) -> str:
    if not 1 <= channel <= 1 + len(mode.aux_units):
        return INVALID
    samples = mode.emg if channel == 1 else mode.aux
    return {
        "RATE": f"{samples / FRAME_S:.15g}",
        "SAMPLES": str(samples),
        "GAIN": "300" if channel == 1 else "1",
        "UNITS": "V" if channel == 1 else mode.aux_units[channel - 2],
    }[asked]


def _yes(value: bool) -> str:
    return "YES" if value else "NO"


_OF_SENSOR: Mapping[str, Callable[[int, Sensor], str]] = {
    "TYPE?": lambda n, s: "O",
    "MODE?": lambda n, s: str(s.mode),
    "STARTINDEX?": lambda n, s: str(n),
    "CHANNELCOUNT?": lambda n, s: str(1 + len(s.measures.aux_units)),
    "EMGCHANNELCOUNT?": lambda n, s: "1",
    "AUXCHANNELCOUNT?": lambda n, s: str(len(s.measures.aux_units)),
    "SERIAL?": lambda n, s: str(s.serial),
    "FIRMWARE?": lambda n, s: "40.48",
    "RANGE?": lambda n, s: "HIGH",
    "BANDWIDTH?": lambda n, s: "NARROW",
}
_COMMANDS: Mapping[str, Callable[[TrignoBase, object, re.Match[str]], str]] = {
    "START": lambda base, client, said: base._set(client, streaming=True),
    "STOP": lambda base, client, said: base._stop(client),
    "QUIT": lambda base, client, said: base._quit(client),
    "MASTER": lambda base, client, said: base._take_over(client),
    r"MASTER\?": lambda base, client, said: _yes(client is base.master),
    # no trigger module is there: nothing to wait for
    "TRIGGER (START|STOP) (ON|OFF)": lambda base, client, said: OK if said[2] == "OFF" else IMPOSSIBLE,
    r"TRIGGER\?": lambda base, client, said: "START OFF STOP OFF",
    "BACKWARDS COMPATIBILITY (ON|OFF)": lambda base, client, said: base._set(client, backwards=said[1] == "ON"),
    r"BACKWARDS COMPATIBILITY\?": lambda base, client, said: _yes(base.backwards),
    "UPSAMPLE (ON|OFF)": lambda base, client, said: base._set(client, upsample=said[1] == "ON"),
    r"UPSAMPLING\?": lambda base, client, said: f"UPSAMPLING {'ON' if base.upsample else 'OFF'}",
    "ENDIAN (LITTLE|BIG)": lambda base, client, said: base._set(client, big_endian=said[1] == "BIG"),
    r"ENDIANNESS\?": lambda base, client, said: "BIG" if base.big_endian else "LITTLE",
    r"FRAME INTERVAL\?": lambda base, client, said: str(FRAME_S),
    r"MAX SAMPLES EMG\?": lambda base, client, said: str(MOST_EMG),
    r"MAX SAMPLES AUX\?": lambda base, client, said: str(MOST_AUX),
    r"BASE FIRMWARE\?": lambda base, client, said: "Firmware: 40.48\r\n",
    r"BASE SERIAL\?": lambda base, client, said: "BID: 12345\r\n",
    r"SENSOR (\d+) (.+)": lambda base, client, said: base._of_sensor(client, said),
}
