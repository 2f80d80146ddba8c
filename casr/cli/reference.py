"""``python -m casr.cli.reference``: write docs/reference/casr-commands.md from the help of every command."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from casr.cli import COMMANDS, parser

PATH = Path(__file__).parents[2] / "docs" / "reference" / "casr-commands.md"
WIDTH = 100
"Columns of the help; a terminal's own width must not change the page."
HEAD = """# The commands of casr

Written by `python -m casr.cli.reference`; do not edit. The same text is in `casr COMMAND --help`.

| exit status | meaning |
|---|---|
| 0 | done |
| 1 | done, but something is not good; the help of the command says what |
| 2 | unusable input (frames, force log, camera, option), said in one line |
| 130 | stopped with Ctrl-C; files that were finished are kept |

Results go to the standard output, notes and complaints to the error stream. With `--json` the standard output holds one
JSON value.
"""


def markdown() -> str:
    """The whole page."""
    return HEAD + "".join(f"\n## `{title}`\n\n```text\n{text}```\n" for title, text in _helps())


def _helps() -> Iterator[tuple[str, str]]:
    whole = parser()
    for one in (whole, *(_command(whole, name) for name in COMMANDS)):
        one.formatter_class = partial(argparse.HelpFormatter, width=WIDTH)  # type: ignore[assignment]
        yield one.prog, one.format_help()


def _command(whole: argparse.ArgumentParser, name: str) -> argparse.ArgumentParser:
    (commands,) = (action for action in whole._actions if isinstance(action, argparse._SubParsersAction))
    made: argparse.ArgumentParser = commands.choices[name]
    return made


if __name__ == "__main__":
    PATH.write_text(markdown(), encoding="utf-8")
