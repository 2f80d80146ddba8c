"""A page in the browser that follows a run, with a stop button."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from emg2vsa.errors import SettingError
from emg2vsa.live.server import listening, serve
from emg2vsa.live.watch_routes import watch_routes


def watch(folder: Path, port: int, ready: Callable[[str], None]) -> None:
    """Serve the page of a run, or of the newest of a folder of runs, until Ctrl-C, which ends the page alone.

    port : 0 takes any free one. ready : told the whole address, which opens the page on this computer only.
    SettingError : ``folder`` is a file, or the port is taken.
    """
    if folder.exists() and not folder.is_dir():
        do = "Choose the folder of a run, or of runs."
        raise SettingError(folder, wanted="a folder", found="a file", do=do)
    try:
        with listening(port) as at:
            serve({"watch": watch_routes(folder)}, at, ready)
    except KeyboardInterrupt:
        pass
