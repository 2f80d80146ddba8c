"""EMG or force from a stream of the Lab Streaming Layer, through pylsl.

Samples carry the sender's time stamps, which are moved to the session's clock and not smoothed. LSL counts no samples:
`emg2vsa.session.sample_clock` finds those that are missing by the stamps.
"""

from __future__ import annotations

import contextlib
import ctypes
import threading
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.clock import Clock, awaited
from emg2vsa.devices.lsl import LslEmgSettings, LslForceSettings
from emg2vsa.devices.lsl.outlets import SESSION_SOURCE
from emg2vsa.devices.registry import Around
from emg2vsa.devices.streams import Block, SourceBase, StreamCounts, StreamInfo
from emg2vsa.errors import DeviceError, SettingError, install_extra

VOLTS = {"v": 1.0, "mv": 1e-3, "uv": 1e-6, "µv": 1e-6, "μv": 1e-6}
VOLTS |= {f"{part}volt{s}": VOLTS[f"{p}v"] for part, p in (("", ""), ("milli", "m"), ("micro", "u")) for s in ("", "s")}
NEWTONS = {"n": 1.0, "mn": 1e-3, "newton": 1.0, "newtons": 1.0}
RESOLVE_S, MOST_RESOLVE_S = 1.0, 5.0
"How long the network is asked for its streams; and for how long it is asked again when the stream is not there."
REPLY_S, FIRST_S = 5.0, 5.0
"Time for an answer of the sender, and for its first sample."
SILENT_S = 10.0
"A stream that has sent nothing for so long is lost; a sender that was started anew is found again sooner."
OFFSET_EVERY_S = 1.0
AGES_S = (-0.1, 5.0)
"Ages that a sample can have when it arrives; others come of stamps by a foreign clock."
STRANGE_S = 1.0
"Stamps with other ages for so long are no strays."
_POLL_S = 2e-3
_MOST_SAMPLES = 1 << 14


class Offset(NamedTuple):
    """What is to be added to a sender's time stamp for this computer's LSL clock, and its uncertainty, s."""

    offset_s: float
    uncertainty_s: float


def open_lsl(settings: LslEmgSettings | LslForceSettings, around: Around) -> LslSource:
    """The source of [session.emg] or [session.force]. DeviceError where LSL is not installed."""
    emg = isinstance(settings, LslEmgSettings)
    channels = settings.channels if isinstance(settings, LslEmgSettings) else {"force": settings.channel}
    kind = "emg" if emg else "force"
    return LslSource(kind, channels, around.clock, stream=settings.stream, delay_s=settings.delay_s)


class LslSource(SourceBase):
    """A `Source` on a stream.

    Parameters
    ----------
    kind : of the source. channels : name in the session to label in the stream; without a label the only channel.
    stream : name of the stream; None for the only one of its type.
    """

    def __init__(
        self,
        kind: str,
        channels: Mapping[str, str | None],
        clock: Clock,
        *,
        stream: str | None = None,
        delay_s: float = 0.0,
    ) -> None:
        self._kind, self._channels, self._clock = kind, dict(channels), clock
        self._table, self._stream, self._delay_s = f"session.{kind}", stream, delay_s
        self._type = "EMG" if kind == "emg" else "Force"
        self._lsl = load_pylsl(f'{self._table}.kind = "lsl"')
        self._where = f"LSL stream {stream!r}" if stream else f"LSL stream of type {self._type}"
        self._inlet: Any = None
        self._columns: list[int] = []
        self._scales = np.ones(len(channels))
        self._samples = 0
        self._offset = Offset(0.0, 0.0)
        self._arrived_s = self._sound_s = 0.0
        self._first: tuple[Any, Any] | None = None
        self._ended = threading.Event()

    def start(self) -> None:
        """Find the stream, open it and wait for its first samples. DeviceError : none is found, or it is gone."""
        self.close()
        self._samples = 0
        found = self._resolved()
        # recover: a sender with a source id that was started anew is found again
        self._inlet = self._lsl.StreamInlet(found, max_buflen=360, recover=True)
        try:
            said = ElementTree.fromstring(self._inlet.info(REPLY_S).as_xml())
            self._info = self._described(found, said)
            self._inlet.open_stream(REPLY_S)
            self._set_offset(self._inlet)
            offset = f"{self._offset.offset_s:.6f} s ± {self._offset.uncertainty_s:.6f} s at the start"
            self._info.facts["clock offset"] = offset
            self._wait_for_first()
            # the sender's answer may take seconds, which `read` must not wait
            self._ended = threading.Event()
            threading.Thread(target=self._follow_offset, args=(self._inlet, self._ended), daemon=True).start()
        except self._lost as error:
            self.close()
            raise self._gone(str(error).rstrip(".")) from error
        except BaseException:
            self.close()
            raise

    def read(self) -> list[Block]:
        """Samples that have come, by the sender's stamps. DeviceError : not started, silent too long, or foreign
        stamps."""
        if self._inlet is None:
            raise self._not_started()
        now_s = self._clock.now_s()
        try:
            pulled, self._first = self._first or self._pulled(), None
        except self._lost as error:
            raise self._gone(str(error).rstrip(".")) from error
        if pulled is None:
            if now_s - self._arrived_s > SILENT_S:
                raise self._gone(f"nothing for {now_s - self._arrived_s:.0f} s")
            return []
        (rows, stamps), self._arrived_s = pulled, now_s
        samples = np.array(rows, dtype=np.float64)[:, self._columns] * self._scales
        ages_s = self._ages_s(stamps)
        if AGES_S[0] <= (age_s := float(np.median(ages_s))) <= AGES_S[1]:
            self._sound_s = now_s
        elif now_s - self._sound_s > STRANGE_S:
            raise self._foreign(age_s)
        stamps_s = self._clock.now_s() - ages_s
        first, self._samples = self._samples, self._samples + len(samples)
        return [Block(samples, first, float(stamps_s[-1]), stamps_s)]

    def counts(self) -> StreamCounts:
        return StreamCounts(self._samples)

    def close(self) -> None:
        self._ended.set()
        self._first = None
        if self._inlet is not None:
            self._inlet.close_stream()
            self._inlet = None

    @property
    def _lost(self) -> tuple[type[Exception], ...]:
        """What pylsl raises when a stream is gone or does not answer."""
        return (self._lsl.util.LostError, self._lsl.util.TimeoutError, self._lsl.util.InternalError)

    def _resolved(self) -> Any:
        """The stream that is meant; DeviceError where there is none, or several."""
        end_s = self._lsl.local_clock() + MOST_RESOLVE_S
        while True:
            streams = self._lsl.resolve_streams(RESOLVE_S)
            meant = [each for each in streams if self._is_meant(each)]
            if meant or self._lsl.local_clock() > end_s:
                break
        if len(meant) == 1:
            return meant[0]
        names = "; ".join(f"{each.name()!r} of type {each.type()} on {each.hostname()}" for each in meant or streams)
        found = f"{len(meant)} of them: {names}" if meant else f"none; the network has {names or 'no stream at all'}"
        do = "Start the sender and let its stream through the firewall"
        if meant:
            do = "Stop the other senders" if self._stream else f"Name one in {self._table}.stream"
        elif streams:
            do = f"Start the sender, or correct {self._table}.stream"
        raise DeviceError(f"{self._table}.stream", wanted=f"one {self._where}", found=found, do=f"{do}.")

    def _is_meant(self, stream: Any) -> bool:
        if self._stream is not None:
            return bool(stream.name() == self._stream)
        own = stream.source_id().startswith(SESSION_SOURCE)  # of this session, or of the next room's
        return bool(stream.type().lower() == self._type.lower()) and not own

    def _described(self, found: Any, said: ElementTree.Element) -> StreamInfo:
        fs_hz = float(found.nominal_srate())
        if fs_hz <= 0:
            do = "Let the sender state its sampling rate."
            raise DeviceError(self._where, wanted="a stream with a regular rate", found="an irregular one", do=do)
        if found.channel_format() == self._lsl.cf_string:
            raise DeviceError(self._where, wanted="numbers", found="text", do=f"Correct {self._table}.stream.")
        described = said.findall("desc/channels/channel")
        if described and len(described) != found.channel_count():
            do = "Let the sender describe each channel once (desc/channels/channel)."
            told = f"{len(described)} descriptions"
            raise DeviceError(self._where, wanted=f"{found.channel_count()} channels", found=told, do=do)
        labels = [each.findtext("label", "") for each in described] or [""] * found.channel_count()
        self._columns = [self._column(name, label, labels) for name, label in self._channels.items()]
        units = [described[column].findtext("unit", "") if described else "" for column in self._columns]
        self._scales = np.array([self._scale(name, unit) for name, unit in zip(self._channels, units, strict=True)])
        facts = {"device": f"LSL stream {found.name()}", "host": found.hostname(), "source id": found.source_id()}
        facts |= {key: text for key in ("manufacturer", "model") if (text := said.findtext(f"desc/{key}"))}
        facts |= {f"{name}, unit sent": unit for name, unit in zip(self._channels, units, strict=True)}
        unit = "V" if self._kind == "emg" else "N"
        return StreamInfo(self._kind, tuple(self._channels), unit, fs_hz, None, self._delay_s, facts, stamped=True)

    def _column(self, name: str, label: str | None, labels: Sequence[str]) -> int:
        wanted = f"one channel with the label {label!r}" if label else "one channel, or a label"
        matching = [place for place, each in enumerate(labels) if label in (None, each)]
        if len(matching) == 1:
            return matching[0]
        key = f"{self._table}.channels.{name}" if self._kind == "emg" else f"{self._table}.channel"
        found = ", ".join(repr(each) for each in labels)
        raise SettingError(key, wanted=wanted, found=found, do=f"Give a label of the {self._where}.")

    def _scale(self, name: str, unit: str) -> float:
        known = VOLTS if self._kind == "emg" else NEWTONS
        if (scale := known.get(unit.strip().lower())) is not None and unit.strip() != "MV" and unit.strip() != "MN":
            return scale
        wanted = "V, mV or uV" if self._kind == "emg" else "N or mN"
        do = "Let the sender state the unit of each channel (desc/channels/channel/unit)."
        raise DeviceError(f"{self._where}, {name}", wanted=f"the unit {wanted}", found=repr(unit), do=do)

    def _wait_for_first(self) -> None:
        self._first = awaited(self._clock, FIRST_S, _POLL_S, self._pulled)
        if self._first is None:
            raise self._gone(f"no sample for {FIRST_S:g} s")
        age_s = float(np.median(self._ages_s(self._first[1])))
        if not AGES_S[0] <= age_s <= AGES_S[1]:
            raise self._foreign(age_s)
        self._arrived_s = self._sound_s = self._clock.now_s()

    def _pulled(self) -> tuple[Any, Any] | None:
        """Rows and stamps that have come; None where none have."""
        rows, stamps = self._inlet.pull_chunk(0.0, _MOST_SAMPLES)
        return (rows, stamps) if len(stamps) else None

    def _ages_s(self, stamps: Sequence[float]) -> NDArray[np.float64]:
        return np.asarray(self._lsl.local_clock() - (np.array(stamps) + self._offset.offset_s), dtype=np.float64)

    def _foreign(self, age_s: float) -> DeviceError:
        wanted = f"time stamps of the LSL clock: samples {AGES_S[0]:g} to {AGES_S[1]:g} s old"
        do = "Let the sender stamp with local_clock() of LSL, or give no stamps."
        return DeviceError(self._where, wanted=wanted, found=f"samples {age_s:.3f} s old", do=do)

    def _follow_offset(self, inlet: Any, ended: threading.Event) -> None:
        while not ended.wait(OFFSET_EVERY_S):
            with contextlib.suppress(*self._lost):
                # the stream itself tells when it is gone; until then the last offset holds
                self._set_offset(inlet)

    def _set_offset(self, inlet: Any) -> None:
        remote_s, uncertainty_s, code = ctypes.c_double(), ctypes.c_double(), ctypes.c_int()
        function = self._lsl.lib.lib.lsl_time_correction_ex
        function.restype = ctypes.c_double
        offset_s = function(
            inlet.obj, ctypes.byref(remote_s), ctypes.byref(uncertainty_s), ctypes.c_double(REPLY_S),
            ctypes.byref(code),
        )  # fmt: skip
        self._lsl.util.handle_error(code)
        self._offset = Offset(float(offset_s), uncertainty_s.value)

    def _gone(self, found: str) -> DeviceError:
        do = "Start the sender again, and check the network."
        return DeviceError(self._where, wanted="samples", found=found, do=do)


def load_pylsl(key: str) -> Any:
    """The package pylsl, which a key wants. DeviceError when it, or the library under it, is not installed."""
    try:
        return import_module("pylsl")
    except (ImportError, RuntimeError) as error:
        do = f"Install it: {install_extra('lsl')}."
        found = "no pylsl" if isinstance(error, ImportError) else "pylsl without the library liblsl"
        raise DeviceError(key, wanted="the extra for LSL", found=found, do=do) from error
