"""A simulated press on disk, as the rig would have saved it, with the truth beside it."""

from __future__ import annotations

import json
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import tifffile

from casr.errors import FramesError
from emg2vsa.worlds.tactile.press import SimulatedPress
from emg2vsa.worlds.tactile.timeline import Timeline


def write_press(press: SimulatedPress, folder: Path, *, overwrite: bool = False) -> Path:
    """Write ``frames.tif``, ``force.csv``, ``camera.toml`` and ``truth.json`` into ``folder``, whole or not at all.

    Frames are written one by one, so memory does not grow with their number.

    Returns
    -------
    The folder.

    Raises
    ------
    FramesError : the folder is there and ``overwrite`` was not asked for, or it is no simulated press.
    """
    _check_free(folder, overwrite)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as temporary:
        new, old = Path(temporary, "new"), Path(temporary, "old")
        new.mkdir()
        _write_frames(press, new / "frames.tif")
        (new / "force.csv").write_text(_force_csv(press.timeline), encoding="utf-8")
        (new / "camera.toml").write_text(press.settings.camera.to_toml(), encoding="utf-8")
        (new / "truth.json").write_text(_truth_json(press), encoding="utf-8")
        replaced = folder.exists()
        if replaced:
            folder.rename(old)
        try:
            new.rename(folder)
        except OSError:
            if replaced:
                old.rename(folder)
            raise
    return folder


def _check_free(folder: Path, overwrite: bool) -> None:
    if not folder.exists():
        return
    if not overwrite:
        raise FramesError(
            folder, wanted="a new folder", found="an existing folder", do="Remove the folder, or ask to overwrite."
        )
    if not (folder / "truth.json").is_file():
        raise FramesError(
            folder,
            wanted="a simulated press to replace",
            found="something else, without truth.json",
            do="Choose another folder.",
        )


def _write_frames(press: SimulatedPress, path: Path) -> None:
    frames = press.frames
    with tifffile.TiffWriter(path) as tiff:
        for index in range(len(frames)):
            tiff.write(frames.read(index), photometric="minisblack", contiguous=True, metadata=None)


def _force_csv(timeline: Timeline) -> str:
    rows = zip(timeline.log_time_s, timeline.log_force_n, timeline.log_frame_index, strict=True)
    return "time_s,force_n,frame_index\n" + "".join(f"{time:.4f},{force:.6f},{frame}\n" for time, force, frame in rows)


def _truth_json(press: SimulatedPress) -> str:
    settings: dict[str, Any] = asdict(press.settings)
    return json.dumps({"settings": settings, "truth": press.truth.to_dict()}, indent=1) + "\n"
