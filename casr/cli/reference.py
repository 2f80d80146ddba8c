"""``python -m casr.cli.reference``: write docs/reference/casr-commands.md from the help of every command."""

from __future__ import annotations

from pathlib import Path

from casr.cli import PROGRAM

PATH = Path(__file__).parents[2] / "docs" / "reference" / "casr-commands.md"


def markdown() -> str:
    """The whole page."""
    return PROGRAM.reference_page("frames, force log, camera, option")


if __name__ == "__main__":
    PATH.write_text(markdown(), encoding="utf-8")
