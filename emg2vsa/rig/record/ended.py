"""How a run ended: always on disk, whatever the end was."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from typing import Literal

from emg2vsa.devices.clock import LoopTiming

How = Literal["completed", "rejected", "stopped", "interrupted", "guard", "failed", "killed"]
_ROOM_BYTES = 8192
LATE_SHARE = 0.01
"""Share of its turns that a good loop may begin late."""


@dataclass(frozen=True)
class Ended:
    """The content of ended.json."""

    how: How
    """completed; rejected: all presses done, but not all of them whole, or the probe not retracted; stopped by request
    or signal; interrupted by Ctrl-C; by a guard; failed by an error of the program"""
    cause: str
    "Name of the guard, or of what stopped the run; empty when it was completed."
    why: str
    phase: str
    repetition: int
    time_s: float
    "Time on the clock of the log."
    at: str
    "Date and time, ISO 8601."
    repetitions_done: int = 0
    rows: int = 0
    "Rows in the log."
    retracted: bool = False
    "Read back before the motors were switched off: they were at the retracted position, and no force was felt."
    deactivated: bool = False
    notes: tuple[str, ...] = ()
    "What else went wrong on the way out."
    peak_force_n: float | None = None
    "Largest force felt in the whole run, of all three axes together; None when none was."
    last_force_n: float | None = None
    "Force at the very end, of all three axes together; None where the sensor had gone."
    timing: LoopTiming | None = field(default=None)


def ended_bytes(ended: Ended) -> bytes:
    """ended.json, as long as any other. Blanks after the object are JSON still."""
    return json.dumps(asdict(ended), indent=2).encode().ljust(_ROOM_BYTES - 1) + b"\n"


def busy_loop(timing: LoopTiming) -> str:
    """What to say of a loop that was late too often; nothing of a good one."""
    if timing.late <= LATE_SHARE * timing.turns:
        return ""
    return (
        f"The control loop was late in {timing.late} of {timing.turns} turns, by up to {1e3 * timing.latest_s:.0f} ms: "
        "the computer was busy. Close other programs, or let this one run in real time (docs/how-to/engineer.md)."
    )


class EndRun(Exception):
    """Raised inside a run to end it; never leaves ``execute``."""

    def __init__(self, how: How, cause: str, why: str) -> None:
        self.how, self.cause, self.why = how, cause, why
        super().__init__(how, cause, why)
