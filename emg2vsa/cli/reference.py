"""``python -m emg2vsa.cli.reference``: write docs/reference/commands.md from the help of every command."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from emg2vsa.cli import parser

PATH = Path(__file__).parents[2] / "docs" / "reference" / "commands.md"
WIDTH = 100
"Columns of the help; a terminal's own width must not change the page."
HEAD = """# The commands

Written by `python -m emg2vsa.cli.reference`; do not edit. The same text is in `emg2vsa COMMAND --help`.

| exit status | meaning |
|---|---|
| 0 | done |
| 1 | done, but something is not good; the help of the command says what |
| 2 | unusable input (study file, option, recording), said in one line for each problem |
| 130 | stopped with Ctrl-C; what was finished is kept |

Results go to the standard output, progress and complaints to the error stream. With `--json` the standard output holds
one JSON value.
"""


def markdown() -> str:
    """The whole page."""
    return HEAD + "".join(f"\n## `{title}`\n\n```text\n{text}```\n" for title, text in _helps())


def _helps() -> Iterator[tuple[str, str]]:
    for one in _with_commands(parser()):
        one.formatter_class = partial(argparse.HelpFormatter, width=WIDTH)  # type: ignore[assignment]
        yield one.prog, one.format_help()


def _with_commands(whole: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """``whole``, then its commands, each followed by its own."""
    yield whole
    for action in whole._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _with_commands(command)


if __name__ == "__main__":
    PATH.write_text(markdown(), encoding="utf-8")
