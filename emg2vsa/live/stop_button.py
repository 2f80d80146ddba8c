"""The stop button's side of a request to stop; the executor looks for it in every turn."""

from __future__ import annotations

from pathlib import Path

from emg2vsa.atomic import write_text_atomic
from emg2vsa.rig.stop_requests import STOP_FILE

REASON = "STOP on the live page"


def request_stop(folder: Path) -> None:
    """Ask the run in ``folder`` to stop; a request that is there stays as it is. OSError when the disk refuses."""
    path = folder / STOP_FILE
    if not path.exists():
        write_text_atomic(path, f"{REASON}\n")


def stop_requested(folder: Path) -> bool:
    """Has the run in ``folder`` been asked to stop, by whomever?"""
    return (folder / STOP_FILE).exists()
