"""An emulated participant's EMG and force as streams of the Lab Streaming Layer."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.lsl.driver import load_pylsl
from emg2vsa.devices.lsl.outlets import outlet
from emg2vsa.worlds.far_ends.ports import Serving
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.sensors import EmgSampler, ForceSampler

PERIOD_S = 0.01
"Time from chunk to chunk."
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
        self._lsl = lsl = load_pylsl("LSL")
        self._clock, now_s = clock, clock.now_s()
        self.names = names[0] or EMG_STREAM, names[1] or FORCE_STREAM
        source = f"emg2vsa-emulated-{participant.person.name}"
        emg = EmgSampler(participant, tuple(labels), EMG_HZ, start_s=now_s)
        force = ForceSampler(participant, FORCE_HZ, start_s=now_s)
        sends = partial(outlet, lsl, manufacturer="emg2vsa", model="emulated participant")
        self._streams: tuple[tuple[EmgSampler | ForceSampler, Any], ...] = (
            (emg, sends(self.names[0], "EMG", tuple(labels.values()), "V", EMG_HZ, f"{source}-emg")),
            (force, sends(self.names[1], "Force", (force_label,), "N", FORCE_HZ, f"{source}-force")),
        )
        super().__init__(self._push, name="LSL outlets")

    def _close(self) -> None:
        self._streams = ()

    def _push(self) -> None:
        while not self._ended.wait(PERIOD_S):
            for sampler, stream in self._streams:
                now_s, stamp_s = self._clock.now_s(), self._lsl.local_clock()
                samples = sampler.take(sampler.due(now_s))
                if len(samples):
                    # the stamp is that of the last sample, which was measured a little before now
                    stream.push_chunk(samples.astype("f4"), stamp_s - (now_s - sampler.newest_s))
