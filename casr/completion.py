"""Completion of a program's commands, options and files in a shell, written by shtab from the parser itself."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from casr.command_line import Commands, Program, add_command, add_json, parsers_of, print_json

SHELLS = ("bash", "zsh", "tcsh")


def command_of(name: str) -> Callable[[Commands], None]:
    """Adds the command ``completion`` to the program ``name``, whose module ``<name>.cli`` holds it as ``PROGRAM``."""

    def add_to(commands: Commands) -> None:
        parser = add_command(
            commands,
            "completion",
            run,
            "Print the completion of commands, options and files for a shell.",
            f"bash: {name} completion bash > ~/.local/share/bash-completion/completions/{name}. zsh: write it as "
            f"_{name} into a folder of $fpath. Open a new shell afterwards.",
        )
        parser.add_argument("shell", choices=SHELLS)
        add_json(parser)

    def run(arguments: argparse.Namespace) -> int:
        script = completion(import_module(f"{name}.cli").PROGRAM, arguments.shell)
        print_json({"shell": arguments.shell, "script": script}) if arguments.json else print(script)
        return 0

    return add_to


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
