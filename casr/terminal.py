"""How much a program says beside its results, and in which colours.

``-q`` and ``-v`` of the running command are kept here, as what prints a note stands far below the command line.
"""

from __future__ import annotations

import os
import sys
from typing import Literal, TextIO

Look = Literal["good", "doubtful", "bad"]
_COLOURS: dict[Look, int] = {"good": 32, "doubtful": 33, "bad": 31}


class Voice:
    """What the user asked to hear. quiet : no progress and no notes. verbose : reasons, and where an error arose.
    json : results, and errors too, for programs."""

    quiet = False
    verbose = False
    json = False


VOICE = Voice()


def note(text: str) -> None:
    """A line on the error stream that is neither a result nor an error; nothing with ``-q``."""
    if not VOICE.quiet:
        print(text, file=sys.stderr, flush=True)


def coloured(text: str, look: Look, stream: TextIO) -> str:
    """The text, in bold colour on a terminal. NO_COLOR forbids colour (no-color.org), FORCE_COLOR asks for it."""
    asked = bool(os.environ.get("FORCE_COLOR")) or (stream.isatty() and os.environ.get("TERM") != "dumb")
    if os.environ.get("NO_COLOR") or not asked:
        return text
    return f"\x1b[1;{_COLOURS[look]}m{text}\x1b[0m"
