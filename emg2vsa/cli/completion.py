"""``emg2vsa completion``: completion in the shell."""

from __future__ import annotations

import argparse

from casr.command_line import Commands
from casr.completion import add_completion, completion


def add_to(commands: Commands) -> None:
    add_completion(commands, "emg2vsa", run)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli import PROGRAM

    print(completion(PROGRAM, arguments.shell))
    return 0
