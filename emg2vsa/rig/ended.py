"""How a run ended: always on disk, whatever the end was."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Literal

from emg2vsa.rig.append_file import AppendFile
from emg2vsa.rig.loop_timing import LoopTiming

How = Literal["completed", "stopped", "interrupted", "guard", "failed", "killed"]
_ROOM_BYTES = 8192


@dataclass(frozen=True)
class Ended:
    """The content of ended.json."""

    how: How
    "completed; stopped by request or signal; interrupted by Ctrl-C; by a guard; failed by an error of the program"
    cause: str
    "Name of the guard, or of what stopped the run; empty when it was completed."
    why: str
    phase: str
    repetition: int
    time_s: float
    "On the clock of the log."
    at: str
    "Date and time, ISO 8601."
    repetitions_done: int = 0
    rows: int = 0
    "In the log."
    retracted: bool = False
    "Read back: the motors were at the retracted position before they were switched off."
    deactivated: bool = False
    notes: tuple[str, ...] = ()
    "What else went wrong on the way out."
    timing: LoopTiming | None = field(default=None)


class EndedFile:
    """ended.json. Made at the start, saying that the run was killed, with room for the truth.

    So a killed run says so itself, and a full disk does not hide the cause. DeviceError as ``AppendFile``.
    """

    def __init__(self, path: Path, killed: Ended) -> None:
        self._file = AppendFile(path)
        self._file.append(_bytes(killed))

    def write(self, ended: Ended) -> None:
        """Replace what is said. DeviceError when the disk fails."""
        self._file.patch(0, _bytes(ended))

    def close(self) -> None:
        """Give the file back."""
        self._file.close()


def _bytes(ended: Ended) -> bytes:
    # blanks after the object are JSON still
    return json.dumps(asdict(ended), indent=2).encode().ljust(_ROOM_BYTES - 1) + b"\n"


class EndRun(Exception):
    """Raised inside a run to end it; never leaves ``execute``."""

    def __init__(self, how: How, cause: str, why: str) -> None:
        self.how, self.cause, self.why = how, cause, why
        super().__init__(how, cause, why)
