"""Where rendered presses come from: a package above this one, which is known here by its entry point alone."""

from __future__ import annotations

from typing import Any

from casr.plugins import plugins


def made_worlds() -> Any:
    """The module that renders presses, ``emg2vsa.worlds.tactile``."""
    (tactile,) = plugins("casr.worlds")
    return tactile.load()
