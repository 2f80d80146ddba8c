"""JSON and TOML files in the folder of a run."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any


def document(path: Path) -> dict[str, Any]:
    """Its content; empty where it is missing or no such thing."""
    try:
        text = path.read_text(encoding="utf-8")
        found = tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}
