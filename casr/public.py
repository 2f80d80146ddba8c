"""What ``import casr`` offers in Python besides the classes themselves: one press from its files to its score."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

from casr.errors import SettingError
from casr.frame_files import open_frames
from casr.frames import FrameSequence
from casr.plugins import made_worlds
from casr.scored import Score, ScoreSettings
from casr.scoring import score as score_frames


def score(press: str | PathLike[str] | FrameSequence, settings: ScoreSettings | None = None, **files: Any) -> Score:
    """Contact area spread rate (CASR) of one press, with the contact area of every frame of the loading phase.

    Parameters
    ----------
    press : a press folder (frames, force.csv, camera.toml), a TIFF, AVI, MP4 or .npy file, or what `open_frames` gave.
    settings : how; the defaults are those of ``casr score``.
    files : ``force``, ``camera``, ``column``, ``force_rule`` of `open_frames`, where ``press`` is a path.

    `Score.rate`, `Score.interval` and `Score.area` are the answer; `frame_table` has a row a frame.
    Raises as `open_frames` and ``casr.scoring.score``: a `CasrError` that names file, frame and what to do; where
    trying again may do, such as with more memory, a `casr.errors.PassingError`.
    """
    if settings is not None and not isinstance(settings, ScoreSettings):
        do = "Make them so: casr.ScoreSettings(force_stop_n=3.0)."
        raise SettingError("score, settings", wanted="casr.ScoreSettings", found=type(settings).__name__, do=do)
    if isinstance(press, FrameSequence):
        if files:
            found = ", ".join(files)
            do = "Give them to open_frames."
            raise SettingError("score", wanted="no files beside frames that are open", found=found, do=do)
        return score_frames(press, settings)
    if not isinstance(press, (str, PathLike)):
        do = "Give the path of a press folder or of a file of frames."
        raise SettingError("score, press", wanted="a path or open frames", found=type(press).__name__, do=do)
    named: dict[str, Any] = {key: Path(value) if key in ("force", "camera") else value for key, value in files.items()}
    return score_frames(open_frames(Path(press), **named), settings)


def simulate_press(settings: Any = None) -> Any:
    """A rendered press with known contact area, flow and spread rate. settings : ``PressSettings`` of its world."""
    worlds = made_worlds()
    return worlds.simulate_press(worlds.PressSettings() if settings is None else settings)
