"""``casr completion``: completion in the shell."""

from __future__ import annotations

import argparse

from casr.command_line import Commands
from casr.completion import add_completion, completion


def add_to(commands: Commands) -> None:
    add_completion(commands, "casr", run)


def run(arguments: argparse.Namespace) -> int:
    from casr.cli import PROGRAM

    print(completion(PROGRAM, arguments.shell))
    return 0
