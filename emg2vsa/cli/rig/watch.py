"""``emg2vsa rig watch``: a page in the browser that follows a run, with a stop button."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.arguments import add_port, web_pages

EPILOG = "Only this computer can open the page, and only with its whole address. Ctrl-C ends the page, not the run."


def add_to(commands: Commands) -> None:
    folder = "folder FOLDER  folder of a run, or a folder of runs, of which the newest is shown\n"
    summary = "Show a run in the browser while it runs, with a stop button."
    parser = add_command(commands, "watch", run, summary, EPILOG, folder)
    add_port(parser, 8420)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    with web_pages("rig watch"):
        from emg2vsa.live.watch_routes import watch
    folder: Path = arguments.folder.resolve()

    def ready(address: str) -> None:
        if arguments.json:  # one line: what reads it need not wait for the end
            print(json.dumps({"folder": str(folder), "address": address}), flush=True)
            return
        print(f"Watching {folder}" + ("" if folder.exists() else ", which is not there yet"))
        print(f"Open {address}\nCtrl-C ends the page, not the run.", flush=True)

    watch(folder, arguments.port, ready)
    if not arguments.json:
        print()
    return 0
