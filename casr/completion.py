"""Completion of a program's commands, options and files in a shell, written by shtab from the parser itself."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from casr.command_line import JSON, Commands, Program, add_command, answer, parsers_of

SHELLS = ("bash", "zsh", "tcsh")


def command_of(name: str, above: str = "") -> Callable[[Commands], None]:
    """Adds the command ``completion`` to the program ``name``, whose module ``<name>.cli`` holds it as ``PROGRAM``.

    above : the words before it, where it is a command of a group.
    """
    summary = "Print the completion of commands, options and files for a shell."
    epilog = f"""bash: {above or name} completion bash > ~/.local/share/bash-completion/completions/{name}. zsh: write
        it as _{name} into a folder of $fpath. Open a new shell afterwards."""

    def add_to(commands: Commands) -> None:
        add_command(commands, "completion", run, summary, epilog, f"shell {{{','.join(SHELLS)}}}\n{JSON}")

    def run(arguments: argparse.Namespace) -> int:
        script = completion(import_module(f"{name}.cli").PROGRAM, arguments.shell)
        answer(arguments.json, {"shell": arguments.shell, "script": script}, [script])
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
