"""From tactile frames and force to the contact area spread rate (CASR) of a soft specimen.

In Python::

    import casr

    press = casr.score("press-001")       # a folder with frames, force.csv and camera.toml
    press.rate.value, press.interval      # mm2/N, and its total 95 % interval
"""

from __future__ import annotations

from casr.lazy_names import lazy_names

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
    "simulate_press": "public",
}
"""Public name to the module below this package that has it; loaded when it is first asked for."""
__all__ = ["__version__", *_NAMES]

__getattr__, __dir__ = lazy_names(__name__, _NAMES)
