"""Names in the order people count: frame_2 before frame_10."""

from __future__ import annotations

import re
from pathlib import Path

_DIGITS = re.compile(r"([0-9]+)")


def natural_order(path: Path) -> tuple[list[str | int], str]:
    """Sort key: every run of digits in the name counts as a number, letters without case; equal ones by spelling."""
    parts = _DIGITS.split(path.name.casefold())
    # text and numbers take turns and text comes first, so like meets like
    return [int(part) if place % 2 else part for place, part in enumerate(parts)], path.name
