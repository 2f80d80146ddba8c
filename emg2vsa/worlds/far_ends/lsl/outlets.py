"""The emulated participant's EMG and force as streams of the Lab Streaming Layer."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from typing import Any, Self

from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.lsl.settings import LslEmgSettings, LslForceSettings
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.worlds.far_ends.table import Served, Table
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.sensors import EmgSampler, ForceSampler

PERIOD_S = 0.01
"From chunk to chunk."
EMG_STREAM, FORCE_STREAM = "emulated EMG", "emulated force"


@contextmanager
def served_streams(at: Table) -> Iterator[Served]:
    """Both streams, whichever of them the session takes. SettingError on a clock that is not LSL's."""
    if not isinstance(at.clock, WallClock):
        do = "Leave --speed out; LSL stamps samples with the computer's own clock."
        raise SettingError("--speed", wanted="1 with streams of LSL", found="another speed", do=do)
    emg = at.settings.emg if isinstance(at.settings.emg, LslEmgSettings) else None
    force = at.settings.force if isinstance(at.settings.force, LslForceSettings) else LslForceSettings()
    labels = emg.channels if emg else {muscle: muscle for muscle in at.participant.person.muscle_share}
    names = emg.stream if emg else None, force.stream
    outlets = LslOutlets(at.participant, labels, at.clock, force_label=force.channel or "force", names=names)
    with outlets:
        yield Served((f"LSL streams: {' and '.join(outlets.names)}",), {"lsl": {"streams": list(outlets.names)}})


class LslOutlets:
    """Streams of the types EMG (V) and Force (N), pushed in chunks within a with statement.

    labels : muscle to the label of its channel. names : of the streams. clock : of the participant; real time, for LSL
    stamps samples with the computer's own clock. DeviceError where pylsl is not installed.
    """

    def __init__(
        self,
        participant: EmulatedParticipant,
        labels: Mapping[str, str],
        clock: WallClock,
        *,
        force_label: str = "force",
        names: tuple[str | None, str | None] = (None, None),
        emg_hz: float = 2000.0,
        force_hz: float = 1000.0,
    ) -> None:
        try:
            self._lsl: Any = import_module("pylsl")
        except (ImportError, RuntimeError) as error:
            raise DeviceError(
                "LSL", wanted="the package pylsl", found="none", do="Install it: pip install emg2vsa[lsl]."
            ) from error
        self._clock = clock
        now_s = clock.now_s()
        self.names = names[0] or EMG_STREAM, names[1] or FORCE_STREAM
        source = f"emg2vsa-emulated-{participant.person.name}"
        self._streams: tuple[tuple[EmgSampler | ForceSampler, Any], ...] = (
            (
                EmgSampler(participant, tuple(labels), emg_hz, start_s=now_s),
                self._outlet(self.names[0], "EMG", emg_hz, tuple(labels.values()), "V", source),
            ),
            (
                ForceSampler(participant, force_hz, start_s=now_s),
                self._outlet(self.names[1], "Force", force_hz, (force_label,), "N", source),
            ),
        )
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._push, name="LSL outlets", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ended.set()
        self._thread.join()
        self._streams = ()

    def _outlet(self, name: str, kind: str, fs_hz: float, labels: tuple[str, ...], unit: str, source: str) -> Any:
        info = self._lsl.StreamInfo(name, kind, len(labels), fs_hz, "float32", f"{source}-{kind.lower()}")
        description = info.desc()
        description.append_child_value("manufacturer", "emg2vsa")
        description.append_child_value("model", "emulated participant")
        channels = description.append_child("channels")
        for label in labels:
            channel = channels.append_child("channel")
            for key, value in (("label", label), ("unit", unit), ("type", kind)):
                channel.append_child_value(key, value)
        return self._lsl.StreamOutlet(info)

    def _push(self) -> None:
        while not self._ended.wait(PERIOD_S):
            for sampler, outlet in self._streams:
                now_s, stamp_s = self._clock.now_s(), self._lsl.local_clock()
                samples = sampler.take(sampler.due(now_s))
                if len(samples):
                    # the stamp is that of the last sample, which was measured a little before now
                    outlet.push_chunk(samples.astype("f4"), stamp_s - (now_s - sampler.newest_s))
