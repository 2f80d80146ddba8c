"""``python -m emg2vsa.cli.reference``: write docs/reference/commands.md from the help of every command."""

from __future__ import annotations

from pathlib import Path

from emg2vsa.cli import PROGRAM

PATH = Path(__file__).parents[2] / "docs" / "reference" / "commands.md"


def markdown() -> str:
    """The whole page."""
    return PROGRAM.reference_page("study file, option, recording")


if __name__ == "__main__":
    PATH.write_text(markdown(), encoding="utf-8")
