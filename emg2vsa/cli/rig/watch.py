"""``emg2vsa rig watch``: a page in the browser that follows a run, with a stop button."""

from __future__ import annotations

import argparse
from pathlib import Path

from casr.command_line import Commands, add_command
from emg2vsa.cli.arguments import add_port, web_pages
from emg2vsa.errors import SettingError

_PORT = 8420


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "watch",
        run,
        "Show a run in the browser while it runs, with a stop button.",
        "Only this computer can open the page, and only with its whole address. Ctrl-C ends the page, not the run.",
    )
    parser.add_argument(
        "folder", type=Path, metavar="FOLDER", help="folder of a run, or a folder of runs, of which the newest is shown"
    )
    add_port(parser, _PORT)


def run(arguments: argparse.Namespace) -> int:
    folder: Path = arguments.folder.resolve()
    if folder.exists() and not folder.is_dir():
        do = "Choose the folder of a run, or of runs."
        raise SettingError(folder, wanted="a folder", found="a file", do=do)
    with web_pages("rig watch"):
        from emg2vsa.live.server import listening, serve
        from emg2vsa.live.watch_routes import watch_routes

    def ready(address: str) -> None:
        print(f"Watching {folder}" + ("" if folder.exists() else ", which is not there yet"))
        print(f"Open {address}\nCtrl-C ends the page, not the run.", flush=True)

    try:
        with listening(arguments.port) as at:
            serve({"watch": watch_routes(folder)}, at, ready)
    except KeyboardInterrupt:
        print()
    return 0
