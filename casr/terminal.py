"""How much a program says beside its results, and in which colours; and what JSON cannot say."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from typing import Any, Literal, TextIO

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


def finite(value: Any) -> Any:
    """The same with null for every number that is not finite, and arrays for tuples."""
    if isinstance(value, float):
        return value if value - value == 0 else None
    if isinstance(value, Mapping):
        return {key: finite(item) for key, item in value.items()}
    return [finite(item) for item in value] if isinstance(value, (list, tuple)) else value
