"""From tactile frames and force to the contact area spread rate (CASR) of a soft specimen.

In Python::

    import casr

    press = casr.score("press-001")       # a folder with frames, force.csv and camera.toml
    press.rate.value, press.interval      # mm2/N, and its total 95 % interval
"""

from __future__ import annotations

from importlib import import_module

__version__ = "0.2.0"

_NAMES = {
    "CasrError": "errors",
    "Score": "scored",
    "ScoreSettings": "scored",
    "StreamScorer": "stream",
    "find_presses": "frame_files",
    "frame_table": "press_tables",
    "open_frames": "frame_files",
    "read_camera": "frame_files",
    "score": "public",
    "simulate_press": "synthetic",
}
"""Public name to the module below this package that has it; loaded when it is first asked for."""
__all__ = ["__version__", *_NAMES]


def __getattr__(name: str) -> object:
    if name not in _NAMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_NAMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
