"""An emulated participant's EMG and force as streams of the Lab Streaming Layer."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from emg2vsa.devices.clock import WallClock
from emg2vsa.errors import DeviceError
from emg2vsa.worlds.far_ends.ports import Serving
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.sensors import EmgSampler, ForceSampler

PERIOD_S = 0.01
"From chunk to chunk."
EMG_HZ, FORCE_HZ = 2000.0, 1000.0
EMG_STREAM, FORCE_STREAM = "emulated EMG", "emulated force"


class LslOutlets(Serving):
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
    ) -> None:
        try:
            self._lsl: Any = import_module("pylsl")
        except (ImportError, RuntimeError) as error:
            raise DeviceError(
                "LSL", wanted="the package pylsl", found="none", do="Install it: pip install emg2vsa[lsl]."
            ) from error
        self._clock, now_s = clock, clock.now_s()
        self.names = names[0] or EMG_STREAM, names[1] or FORCE_STREAM
        source = f"emg2vsa-emulated-{participant.person.name}"
        emg = EmgSampler(participant, tuple(labels), EMG_HZ, start_s=now_s)
        force = ForceSampler(participant, FORCE_HZ, start_s=now_s)
        self._streams: tuple[tuple[EmgSampler | ForceSampler, Any], ...] = (
            (emg, self._outlet(self.names[0], "EMG", EMG_HZ, tuple(labels.values()), "V", source)),
            (force, self._outlet(self.names[1], "Force", FORCE_HZ, (force_label,), "N", source)),
        )
        super().__init__(self._push, name="LSL outlets")

    def _close(self) -> None:
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
