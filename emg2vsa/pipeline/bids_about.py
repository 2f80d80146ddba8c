"""What no recording states of itself, as somebody who converts recordings says it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from emg2vsa.errors import SettingError
from emg2vsa.pipeline.bids_export import About


def about(task: str, mains_hz: float | None, electrode_mm: float | None, keys: Path | None) -> About:
    """keys : JSON file with more keys for every _emg.json. SettingError : a distance or a file that cannot be."""
    if electrode_mm is not None and not 0 < electrode_mm < 1000:
        found, do = f"{electrode_mm:g}", "Measure centre to centre."
        raise SettingError("--electrode-distance", wanted="millimetres above 0", found=found, do=do)
    return About(task, mains_hz, electrode_mm, {} if keys is None else _keys(keys))


def _keys(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        found = getattr(error, "strerror", None) or str(error)
        raise SettingError(path, wanted="a JSON object", found=found, do="Correct the file.") from error
    if not isinstance(content, dict):
        raise SettingError(path, wanted="a JSON object", found=type(content).__name__, do='Write {"Key": "value"}.')
    return content
