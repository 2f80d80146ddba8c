"""Completion of a program's commands, options and files in a shell, written by shtab from the parser itself."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from casr.command_line import Commands, Program, add_command, parsers_of

SHELLS = ("bash", "zsh", "tcsh")


def add_completion(commands: Commands, name: str, run: Any) -> None:
    """The command ``completion`` of the program ``name``."""
    parser = add_command(
        commands,
        "completion",
        run,
        "Print the completion of commands, options and files for a shell.",
        f"bash: {name} completion bash > ~/.local/share/bash-completion/completions/{name}. zsh: write it as _{name} "
        "into a folder of $fpath. Open a new shell afterwards.",
    )
    parser.add_argument("shell", choices=SHELLS)


def completion(program: Program, shell: str) -> str:
    """The script for one of `SHELLS`."""
    import shtab

    whole = program.parser()
    for parser in parsers_of(whole):
        for action in parser._actions:
            if action.type is Path:
                action.complete = shtab.DIRECTORY if action.metavar in ("DIR", "FOLDER") else shtab.FILE  # type: ignore[attr-defined]
            elif isinstance(action, argparse._SubParsersAction):
                action.metavar = None  # shtab takes it for a value to complete
    return str(shtab.complete(whole, shell))
