"""What other programs and devices get of a session while it runs: streams of LSL, and a trigger on a serial port.

A session neither waits for them nor ends with them: one that fails is told, and the session goes on without it.
"""

from __future__ import annotations

import platform
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

import numpy as np

from emg2vsa import __version__
from emg2vsa.arrays import Floats
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.lsl.driver import load_pylsl
from emg2vsa.devices.lsl.outlets import SESSION_SOURCE, outlet
from emg2vsa.devices.streams import StreamInfo
from emg2vsa.devices.trigger import TriggerOut
from emg2vsa.errors import DeviceError
from emg2vsa.session import journal
from emg2vsa.session.journal import Line
from emg2vsa.session.presses import Presses
from emg2vsa.session.recorded_stream import Arrived
from emg2vsa.session_settings import TriggerMark

T = TypeVar("T")
_COMMANDS = {"start": "START", "stop": "STOP", "press": "press-begun"}
_MARKS: dict[str, TriggerMark] = {"START": "start", "STOP": "stop", "verdict": "verdict"}
"""Mark of the trigger, by what happened."""


class Outlets:
    """Streams "emg2vsa EMG", "... envelopes", "... force", "... markers" and "... verdicts" of the study's name.

    The samples are those that are recorded, as float32. Their stamps are their own times, delay taken off, on the clock
    of LSL. DeviceError : pylsl is not installed, or makes no stream.
    """

    def __init__(
        self, study: str, muscles: Sequence[str], emg: StreamInfo, force: StreamInfo, clock: Clock
    ) -> None:  # fmt: skip
        lsl = load_pylsl("session.lsl_outlets")
        # what comes between the two readings makes it smaller
        self._offset_s = max(lsl.local_clock() - clock.now_s() for _ in range(20))
        about = {"manufacturer": "emg2vsa", "model": __version__}
        try:
            self._outlets = {
                name: outlet(
                    lsl, f"emg2vsa {name}", kind, labels, unit, fs_hz,
                    f"{SESSION_SOURCE}{platform.node()}-{study}-{name}", form, **about,
                )
                for name, kind, labels, unit, fs_hz, form in (
                    ("EMG", "EMG", muscles, emg.unit, emg.fs_hz, "float32"),
                    ("envelopes", "Envelope", muscles, emg.unit, emg.fs_hz, "float32"),
                    ("force", "Force", ("force",), force.unit, force.fs_hz, "float32"),
                    ("markers", "Markers", ("marker",), "", 0.0, "string"),
                    ("verdicts", "Markers", ("verdict",), "", 0.0, "string"),
                )
            }  # fmt: skip
        except RuntimeError as error:
            do = "Check the network settings of this computer, or leave session.lsl_outlets out."
            raise DeviceError("session.lsl_outlets", wanted="streams of LSL", found=str(error), do=do) from error

    def samples(self, name: str, samples: Floats, newest_s: float) -> None:
        """Samples (n, channels), the last one of ``newest_s`` on the session's clock."""
        self._outlets[name].push_chunk(samples.astype(np.float32), newest_s + self._offset_s)

    def text(self, name: str, text: str, time_s: float) -> None:
        """A marker or a verdict of this time."""
        self._outlets[name].push_sample([text], time_s + self._offset_s)


class Plugs:
    """outlets, trigger : None where there is none. troubles : sentences for the operator, to be taken out."""

    def __init__(self, outlets: Outlets | None = None, trigger: TriggerOut | None = None) -> None:
        self._outlets, self._trigger = outlets, trigger
        self.troubles: deque[str] = deque()
        self._begun = 0, 0
        "Number and attempt of the press whose begin has been sent."

    def emg(self, arrived: Arrived, envelopes_v: Floats) -> None:
        """Samples and envelopes (n, muscles), V."""
        self._push(lambda sent: sent.samples("EMG", arrived.samples, arrived.newest_s))
        self._push(lambda sent: sent.samples("envelopes", envelopes_v, arrived.newest_s))

    def force(self, arrived: Arrived) -> None:
        """Samples (n, 1)."""
        self._push(lambda sent: sent.samples("force", arrived.samples, arrived.newest_s))

    def happened(self, line: Line, presses: Presses) -> tuple[journal.Triggered, float] | None:
        """Send what others are to know of a line of the journal; the mark of the trigger and its time, if one was."""
        match line.event:
            case journal.Commanded(command="start" | "stop" | "press" as command, press=press, attempt=attempt):
                if command == "press":
                    self._begun = press, attempt
                return self._send(_COMMANDS[command], line.time_s, press, attempt, presses)
            case journal.PressEnded(press=press, attempt=attempt, how="complete") as ended:
                if self._begun != (press, attempt):  # it was not told "press": before START, or in one turn
                    self._send("press-begun", ended.start_s, press, attempt, presses)
                self._send("press-ended", ended.stop_s, press, attempt, presses)
            case journal.Judged(press=press, attempt=attempt, verdict=verdict):
                return self._send("verdict", line.time_s, press, attempt, presses, verdict)
            case journal.Checked(item=journal.PLACED, specimen=specimen):
                self._push(partial(Outlets.text, name="markers", text=f"specimen {specimen}", time_s=line.time_s))
        return None

    def turn(self, now_s: float) -> None:
        """End a pulse when its time, s, has come."""
        self._pulse(lambda trigger: trigger.turn(now_s))

    def close(self) -> None:
        """Give the port back, and end the streams."""
        self._pulse(TriggerOut.close)
        self._outlets = self._trigger = None

    def _send(
        self, what: str, time_s: float, press: int, attempt: int, presses: Presses, verdict: str = ""
    ) -> tuple[journal.Triggered, float] | None:  # fmt: skip
        tried = presses.find(press, attempt) if press else None
        about = f" press={press} attempt={attempt} specimen={tried.press.specimen}" if tried else ""
        name = "verdicts" if verdict else "markers"
        self._push(partial(Outlets.text, name=name, text=f"{verdict or what}{about}", time_s=time_s))
        if (mark := _MARKS.get(what)) is None or (mark == "start" and tried is None):  # START of a contraction
            return None
        if (sent := self._pulse(lambda trigger: trigger.send(mark))) is None:
            return None
        return journal.Triggered(mark, sent[0], press, attempt), sent[1]

    def _push(self, push: Callable[[Outlets], None]) -> None:
        if self._outlets is None:
            return
        try:
            push(self._outlets)
        except Exception as error:  # whatever it is, a session does not end of it
            self._outlets = None
            self.troubles.append(f"The LSL streams have ended ({error}). The session goes on without them.")

    def _pulse(self, act: Callable[[TriggerOut], T]) -> T | None:
        if self._trigger is None:
            return None
        try:
            return act(self._trigger)
        except DeviceError as error:
            self._trigger = None
            self.troubles.append(f"{error} The session goes on without triggers.")
        return None
