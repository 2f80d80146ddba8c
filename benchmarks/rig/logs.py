"""All rows of a log, for benchmarks and tests."""

from __future__ import annotations

import sys
from pathlib import Path

from emg2vsa.live.tails import LogTail
from emg2vsa.rig.record.run_log import Row


def read_log(path: Path) -> list[Row]:
    """All whole rows. RecordingError for anything else."""
    return LogTail(path, sys.maxsize).new_rows()
