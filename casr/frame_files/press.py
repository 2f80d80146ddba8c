"""One press from disk: frames, and the force log and camera that belong to them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from casr.counts import count
from casr.errors import FramesError
from casr.frame_files.camera_file import read_camera
from casr.frame_files.folder import CAMERA_FILE, FORCE_FILE, FileFrames, folder_contents, open_file, open_folder
from casr.frame_files.force_log import ForceLog, read_force_log
from casr.frames import (
    ForceReadings,
    FrameSequence,
    TravelReadings,
    check_newtons,
    force_per_frame,
    frame_times_by_rows,
    note_on_spikes,
    spikes,
)
from casr.frames.force import first_of_frame
from casr.images import Grey


class CountedFrames:
    """Frames of files, the same to those who read them. The first is looked at when they are opened, and kept."""

    def __init__(self, frames: FileFrames) -> None:
        self.name, self.notes, self.shape, self._frames = frames.name, frames.notes, frames.shape, frames
        self._decoded = bytearray(len(frames))
        count("frames in folder", len(frames))
        self.first = self._decode(0)

    def __len__(self) -> int:
        return len(self._frames)

    def read(self, index: int) -> Grey:
        return self._decode(index) if index else self.first.copy()

    def _decode(self, index: int) -> Grey:
        frame = self._frames.read(index)
        count("frames decoded again" if self._decoded[index] else "frames decoded")
        self._decoded[index] = True
        return frame


def open_frames(
    path: Path | str,
    *,
    force: Path | None = None,
    camera: Path | None = None,
    column: str = "force_n",
    force_rule: str = "exposure",
) -> FrameSequence:
    """The frames of one press; opening decodes no more than the first.

    Parameters
    ----------
    path : a file of frames (.tif, .tiff, .avi, .mp4, .mkv, .npy); a folder of images (.png, .tif, .bmp, .jpg) in
        natural order of their names; or a press folder: ``frames.tif`` (or another format, or a folder ``frames`` of
        images) with ``force.csv`` and ``camera.toml`` beside.
    force : force log, see `read_force_log`; without it ``force.csv`` in the folder, if there is one.
    camera : camera file, see `read_camera`; without it ``camera.toml`` in the folder or, for all presses of a run, in
        the folder above it, if there is one.
    column : the force column to take from the log.
    force_rule : from the log to one force a frame, see `force_per_frame`.

    Raises
    ------
    FramesError : no frames or fewer than two, not readable, floats from 0 to 1 or 12 bits kept in 16; a force log
        that makes no sense, is not in newtons or belongs to other frames.
    CameraError : a camera file that makes no sense or belongs to frames of another size.
    """
    path = Path(path)
    in_folder = path.is_dir()
    frames = _counted(path, open_folder(path) if in_folder else open_file(path))
    notes = [*frames.notes, *(_ignored(path) if in_folder else [])]
    if in_folder:
        force, camera = force or _beside(path, FORCE_FILE), camera or camera_beside(path)
    forces = mean_n = readings = travel = None
    if force is not None:
        forces, mean_n, force_notes, readings, travel = _forces(Path(force), len(frames), column, force_rule)
        notes += force_notes
    seen_by = read_camera(camera) if camera is not None else None
    return FrameSequence(frames, seen_by, forces, tuple(notes), readings, mean_n, travel)


def _counted(path: Path, opened: FileFrames) -> CountedFrames:
    if len(opened) < 2:
        raise FramesError(
            path, wanted="a sequence of two frames or more", found="; ".join(("one frame", *opened.notes)),
            do="Give all frames of the press: the static frame before contact and those of the loading.",
        )  # fmt: skip
    frames = CountedFrames(opened)
    first = frames.first
    brightest = float(first.max())
    # 12 bits kept in 16 reach a grey level of 16 at most; floats from 0 to 1 and 8 bits kept in 16 reach 1
    if first.dtype != np.uint8 and 0 < brightest < 16:
        raise FramesError(
            path, wanted="grey levels that use the range, 0 to 255 as floats or 0 to 65535 in 16 bits",
            found=f"a brightest pixel of {brightest:.3g} of 255 in frame 0",
            do="Multiply floats from 0 to 1 by 255; shift 12 bits kept in 16 to the top, or save 8 bits.",
        )  # fmt: skip
    return frames


def _ignored(path: Path) -> list[str]:
    contents = folder_contents(path)
    names = sorted(item.name for item in contents.others if item.name not in (FORCE_FILE, CAMERA_FILE))
    if not contents.pages or not names:
        return []
    return [f"{len(names)} files beside the frames are not read: {', '.join(names[:3])}{', ...' * (len(names) > 3)}"]


def _beside(path: Path, name: str) -> Path | None:
    return path / name if (path / name).exists() else None


def camera_beside(press: Path) -> Path | None:
    """The rig writes one camera file for all presses of a run."""
    return _beside(press, CAMERA_FILE) or _beside(press.absolute().parent, CAMERA_FILE)


def _forces(
    path: Path, n_frames: int, column: str, rule: str
) -> tuple[NDArray[np.float64], NDArray[np.float64], list[str], ForceReadings | None, TravelReadings | None]:
    """(n_frames,) force of each frame by the rule and by the rule mean, N; notes; where frames can be shifted by
    them, the readings; and travel where the log has it."""
    log = read_force_log(path, column=column)
    wild = spikes(log.force_n)
    force_n = np.where(wild, np.nan, log.force_n)
    check_newtons(force_n, path)
    mean_n = forces = force_per_frame(force_n, log.frame_index, n_frames, rule="mean", where=path)
    if rule != "mean":
        forces = force_per_frame(
            force_n, log.frame_index, n_frames,
            time_s=log.time_s, frame_time_s=log.frame_time_s, rule=rule, where=path,
        )  # fmt: skip
    without = int(np.isnan(forces).sum())
    notes = [*log.notes, *note_on_spikes(wild, log.force_n, f"of {wild.size} rows of the force log")]
    notes += [f"{without} of {n_frames} frames have no force"] if without else []
    travel = None if log.travel_mm is None else TravelReadings(log.travel_mm, force_n, log.frame_index)
    return forces, mean_n, notes, _readings(log, force_n, n_frames) if rule == "exposure" else None, travel


def _readings(log: ForceLog, force_n: NDArray[np.float64], n_frames: int) -> ForceReadings | None:
    if log.time_s is None:
        return None
    known = np.isfinite(log.time_s + force_n)
    frame_s = frame_times_by_rows(log.time_s[known], log.frame_index[known], n_frames)
    if log.frame_time_s is not None and np.isfinite(log.frame_time_s).any():
        frame_s = first_of_frame(log.frame_index, n_frames, log.frame_time_s)
    return ForceReadings(log.time_s[known], force_n[known], frame_s) if known.any() else None
